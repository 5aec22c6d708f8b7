#pragma once
/// People before the projector of a running show.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "procam/people/skeleton_source.hpp"
#include "procam/show/run.hpp"
#include "procam/track/pose_sender.hpp"
#include "room_people.hpp"

namespace procam::show {

/// Reports once when the frame goes dark for people's sake, and when it is lit again.
class BlackoutLog {
 public:
  explicit BlackoutLog(std::function<void(const std::string&)> say) : say_(std::move(say)) {}
  void add(const people::MaskResult& done) {
    if (done.reason == dark_for_) return;
    say_(done.blanked ? std::string("the picture is dark: ") + done.reason : "the picture is lit again");
    dark_for_ = done.reason;
  }

 private:
  std::function<void(const std::string&)> say_;
  std::string dark_for_;
};

/// Skeletons from a socket: heads kept dark, contents informed. Used by one thread.
class ShowPeople {
 public:
  /// Throws Error for a source, a sensor's pose or a destination that makes no sense.
  ShowPeople(const PeopleInput& input, const Rig& rig, const RigProjector& projector,
             std::function<void(const std::string&)> say);

  /// Takes what has arrived and informs the contents.
  void take(const Projection& projection);
  /// The same, and blackens heads: ProjectionOptions::over.
  void draw_over(const Projection& projection, double light_time, ImageView<std::uint8_t> frame);
  PeopleCounts counts() const;

 private:
  struct Destination {
    std::string surface;
    std::unique_ptr<track::PoseSender> sender;
  };
  RoomPeople people_;
  std::vector<Destination> destinations_;
  std::unique_ptr<people::SkeletonSource> source_;
  BlackoutLog log_;
  std::vector<people::SkeletonFrame> arrived_;
  std::uint64_t frames_ = 0, sent_ = 0;
};

}  // namespace procam::show
