#pragma once
/// A calibration of the project's session in a thread of its own: rig.json and report.html, progress and an end on request.
#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/rig/rig.hpp"
#include "project.hpp"

namespace procam::studio {

struct CalibrationOutcome {
  std::optional<Rig> rig;  ///< nullopt: it failed
  std::optional<Error> error;
  bool passed = false;             ///< all quality checks
  double predicted_mm = 0;         ///< on a wall at kStatedDistance, rms
  std::vector<std::string> lines;  ///< for people
};

/// The distance of the wall for which errors are stated, metres.
inline constexpr double kStatedDistance = 2;

class CalibrationJob {
 public:
  CalibrationJob() = default;
  ~CalibrationJob();
  CalibrationJob(const CalibrationJob&) = delete;
  CalibrationJob& operator=(const CalibrationJob&) = delete;

  void start(const Project& project, const std::optional<Rig>& truth);
  void stop() { stopping_ = true; }
  bool is_running() const { return running_; }
  /// "reading view_03" and percent.
  std::pair<std::string, int> progress() const;
  /// Once, after the end.
  std::optional<CalibrationOutcome> take();

 private:
  CalibrationOutcome work(const Project& project, const std::optional<Rig>& truth);
  void report(const std::string& doing, double share);

  std::atomic<bool> running_{false}, stopping_{false};
  mutable std::mutex mutex_;
  std::string doing_;
  double share_ = 0;
  std::optional<CalibrationOutcome> outcome_;
  std::thread thread_;
};

/// "rig checks passed" and the errors, for a rig of an earlier run.
CalibrationOutcome judge_stored(const Rig& rig, double accept_mm);

}  // namespace procam::studio
