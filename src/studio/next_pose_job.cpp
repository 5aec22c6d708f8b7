#include "next_pose_job.hpp"

#include <exception>
#include <utility>

#include "procam/analyze/advice.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/core/base/words.hpp"
#include "procam/session/reader.hpp"

namespace procam::studio {
namespace {

constexpr double kWall = 2;  // metres
struct AdviceStopped {};

/// That with the largest predicted error on a surface that the camera locates: errors of the camera are those of all.
std::size_t worst_projector(const Rig& rig) {
  std::size_t worst = 0;
  double largest = -1;
  for (std::size_t i = 0; i < rig.projectors.size(); ++i) {
    const double mm = analyze::predicted_light_errors(rig, kWall, rig.projectors[i].name)
                          .of(analyze::SurfaceLocated::kByCamera)
                          .rms_mm;
    if (mm > largest) largest = mm, worst = i;
  }
  return worst;
}

}  // namespace

NextPoseJob::~NextPoseJob() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void NextPoseJob::start(const std::filesystem::path& session, const Board& board) {
  if (running_) return;
  if (thread_.joinable()) thread_.join();
  running_ = true;
  thread_ = std::thread([this, session, board] {
    Result result;
    try {
      const auto go_on = [this] {
        if (stopping_) throw AdviceStopped();
      };
      const session::SessionContents contents =
          session::read(session::open(session), [&](const std::string&, int, int) { go_on(); });
      calibrate::Options options;
      options.progress = [&](const std::string&, double) { go_on(); };
      const calibrate::CalibrationResult solved = calibrate::calibrate_rig(contents.correspondences, options);
      const std::size_t worst = worst_projector(solved.rig);
      if (const auto next = analyze::advise_next_view(solved, kWall, solved.rig.projectors[worst].name)) {
        const RigCamera& camera = solved.rig.camera();
        const RigProjector& shown = solved.rig.projectors[worst];
        result.pose =
            GuidedPose{camera.rig_from_camera.inverse() * next->rig_from_board, camera.camera,
                       next->words + "; the predicted error at 2 m then falls from " +
                           fixed(next->now.externally.rms_mm, 1) + " to " +
                           fixed(next->then.externally.rms_mm, 1) + " mm",
                       worst,
                       outline_in_frame(board, shown.rig_from_projector.inverse() * next->rig_from_board,
                                        shown.projector)};
      }
    } catch (const AdviceStopped&) {   // the studio ends
    } catch (const std::exception&) {  // not solvable yet: the next pose is that of the list
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    result_ = std::move(result);
    running_ = false;
  });
}

std::optional<NextPoseJob::Result> NextPoseJob::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(result_, std::nullopt);
}

}  // namespace procam::studio
