#include "mount_mistakes.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>

#include "mount_start.hpp"
#include "mount_start_planes.hpp"

namespace procam::calibrate::mount {
namespace {

struct Mistake {
  const char *words, *remedy;
  std::function<Pose(const Pose&)> correct;
};

const std::vector<Mistake>& mistakes() {
  static const std::vector<Mistake> all{
      {"inverted", "write them in the other direction (docs/mount.md)",
       [](const Pose& pose) { return pose.inverse(); }},
      {"quaternions in the order w x y z", "write x y z w",
       [](const Pose& pose) {
         const Eigen::Quaterniond& q = pose.rotation;
         return Pose(Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()), pose.translation);
       }},
      {"of another handedness (y or the yaw has the other sign, or x and y are exchanged)",
       "write a right-handed frame with z upwards, and the pose of the base in the world, not its inverse",
       [](const Pose& pose) { return Pose(pose.rotation.conjugate(), pose.translation); }},
      {"millimetres", "write metres",
       [](const Pose& pose) { return Pose(pose.rotation, 0.001 * pose.translation); }},
      {"centimetres", "write metres",
       [](const Pose& pose) { return Pose(pose.rotation, 0.01 * pose.translation); }}};
  return all;
}

constexpr std::size_t kMinBasePoses = 20, kMinStations = 5;

}  // namespace

void check_poses(const MountData& data, const MountOptions& options) {
  require(options.position_sigma > 0 && options.rotation_sigma > 0 && options.acceleration > 0 &&
              options.turn_acceleration > 0 && options.max_sigma > 0 && options.max_time_offset > 0 &&
              options.station_time > 0 && options.floor_sigma > 0 && options.floor_tilt_sigma > 0 &&
              options.plane_sensor.scale_sigma >= 0 && options.plane_sensor.turn_sigma >= 0 &&
              std::isfinite(options.time_offset),
          "calibrate_mount: an option's sigma is not positive");
  require(!options.height || (std::isfinite(options.height->value) && options.height->sigma > 0),
          "calibrate_mount: the height needs a positive sigma");
  require(!options.prior || (options.prior->pose.is_finite() &&
                             Eigen::LLT<Mat6>(options.prior->covariance).info() == Eigen::Success),
          "calibrate_mount: the prior needs a positive definite covariance");
  const std::size_t needed = options.stations ? kMinStations : kMinBasePoses;
  if (data.base.size() < needed)
    throw Error(ErrorKind::kNotEnoughData, "poses of the base",
                "there are " + std::to_string(data.base.size()) + ", and at least " + std::to_string(needed) +
                    " are needed",
                options.stations ? "move to ten stations or more, each with the rig turned another way"
                                 : "record a motion of 30 s or more");
  for (std::size_t i = 0; i < data.base.size(); ++i) {
    require(std::isfinite(data.base[i].time) && data.base[i].world_from_base.is_finite(),
            "calibrate_mount: a base pose is not finite");
    if (i > 0 && !(data.base[i].time > data.base[i - 1].time))
      throw Error(ErrorKind::kInput, "pose " + std::to_string(i + 1) + " of the base",
                  "its time is not after that of the pose before", "sort the poses by time, one a time");
  }
  for (const MarkerSighting& seen : data.sightings)
    require(std::isfinite(seen.time) && seen.marker_from_rig.pose.is_finite() &&
                seen.marker_from_rig.covariance.allFinite() && (seen.is_plane || !seen.marker.empty()),
            "calibrate_mount: a sighting is not finite, or of a marker without a name");
}

void check_sightings(const MountData& data, const MountOptions& options) {
  check_planes(data, options);
  for (const MarkerSighting& seen : data.sightings) {
    if (Eigen::LLT<Mat6>(seen.marker_from_rig.covariance).info() != Eigen::Success)
      throw Error(ErrorKind::kInput, "a sighting of " + seen.marker,
                  "its covariance is not positive definite, as that of a measurement is",
                  "give the covariance of locate-projector as it is");
  }
}

void require_unmistaken(const MountData& data, const MountOptions& options) {
  if (options.carrier == MountCarrier::kHead) return;
  constexpr double kFits = 0.1, kBetter = 0.25;  // metres; of the misfit as it is
  const double as_it_is = start_misfit(data, options);
  if (as_it_is < kFits) return;
  double least = std::min(kFits, kBetter * as_it_is);
  const Mistake* found = nullptr;
  bool is_of_base = false;
  for (const bool of_base : {true, false})
    for (const Mistake& mistake : mistakes()) {
      MountData corrected = data;
      for (BasePose& pose : corrected.base)
        if (of_base) pose.world_from_base = mistake.correct(pose.world_from_base);
      for (MarkerSighting& seen : corrected.sightings)
        if (!of_base) seen.marker_from_rig.pose = mistake.correct(seen.marker_from_rig.pose);
      const double misfit = start_misfit(corrected, options);
      if (misfit < least) least = misfit, found = &mistake, is_of_base = of_base;
    }
  if (found == nullptr) return;
  const std::string what = !is_of_base                                ? "the sightings"
                           : options.carrier == MountCarrier::kFlange ? "the poses of the arm"
                                                                      : "the poses of the base";
  throw Error(ErrorKind::kInput, "poses and sightings",
              "they are of one motion only if " + what + " are " + found->words, found->remedy);
}

}  // namespace procam::calibrate::mount
