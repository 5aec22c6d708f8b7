#pragma once
/// The pose of the board that reduces the predicted error on the wall most (analyze::advise_next_view()), from the views
/// captured so far, in a thread of its own.
#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include "pose_guide.hpp"

namespace procam::studio {

class NextPoseJob {
 public:
  /// Views below which nothing can be solved.
  static constexpr int kFewestViews = 3;

  NextPoseJob() = default;
  ~NextPoseJob();
  NextPoseJob(const NextPoseJob&) = delete;
  NextPoseJob& operator=(const NextPoseJob&) = delete;

  void start(const std::filesystem::path& session, const Board& board);
  bool is_running() const { return running_; }
  struct Result {
    std::optional<GuidedPose>
        pose;  ///< nullopt: the views determine no rig yet, or no pose reduces the error
  };
  /// Once, after the end.
  std::optional<Result> take();

 private:
  std::atomic<bool> running_{false}, stopping_{false};
  std::mutex mutex_;
  std::optional<Result> result_;
  std::thread thread_;
};

}  // namespace procam::studio
