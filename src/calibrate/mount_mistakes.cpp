#include "mount_mistakes.hpp"

#include <functional>

#include "mount_start.hpp"

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
      {"millimetres", "write metres",
       [](const Pose& pose) { return Pose(pose.rotation, 0.001 * pose.translation); }},
      {"centimetres", "write metres",
       [](const Pose& pose) { return Pose(pose.rotation, 0.01 * pose.translation); }}};
  return all;
}

}  // namespace

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
