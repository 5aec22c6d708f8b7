#include "mount_remarks.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"

namespace procam::calibrate::mount {

namespace {

struct Words {
  std::string carrier, motion;  ///< "the base", "drive"
  std::string source, poses;    ///< "the localiser", "base poses"
  std::string jumped, lost;     ///< what a jump and what many wrong poses may be
};
Words words_of(MountCarrier carrier) {
  switch (carrier) {
    case MountCarrier::kFlange:
      return {"the flange",
              "motion of the arm",
              "the arm",
              "arm poses",
              "the arm's foot moved, or its controller changed the frame",
              "check that the log and the images are of one run"};
    case MountCarrier::kHead:
      return {"the head",
              "motion of the head",
              "the head",
              "angles",
              "the pan motor lost steps, or the head's foot moved",
              "check that the log and the images are of one run"};
    default:
      return {"the base",
              "drive",
              "the localiser",
              "base poses",
              "a jump on the map, or wheel slip",
              "the localiser loses itself; check its map"};
  }
}

/// What would make the missing directions observable.
std::string remedy(const std::vector<bool>& missing, MountCarrier carrier) {
  if (carrier == MountCarrier::kFlange)
    return "turn the flange about two axes or more, each by 30 degrees, while it sees the markers, or give an earlier "
           "pose of the rig with its covariance as --prior";
  if (carrier == MountCarrier::kHead)
    return "move pan and tilt, each by 20 degrees or more and also both together, while a marker is seen";
  const bool height_alone = missing[5] && std::count(missing.begin(), missing.end(), true) == 1;
  const bool yaw_alone = missing[2] && !missing[0] && !missing[1] && !missing[3] && !missing[4];
  if (height_alone)
    return "measure the height of the rig's origin (the first camera's centre) above the base's origin "
           "and give it, e.g. --height 0.85m+-5mm, or give the poses of markers on the wall (--markers), or let "
           "a depth sensor see the floor (--floor 0mm+-1mm)";
  const std::string height = missing[5] ? ", and measure the height: --height 0.85m+-5mm" : "";
  if (yaw_alone) return "drive straight for a metre or more, not only turns on the spot" + height;
  return "drive curves in both directions and at changing speed past markers near and far (on one circle at one "
         "speed a time offset looks like a moved rig), or give an earlier pose of the rig "
         "with its covariance as --prior" +
         height;
}

}  // namespace

std::vector<std::string> direction_names(MountCarrier carrier) {
  switch (carrier) {
    case MountCarrier::kFlange:
      return {"roll", "pitch", "yaw", "x", "y", "z"};
    case MountCarrier::kHead:
      return {"roll", "pitch", "tilt zero", "x", "y", "z", "axis offset", "axis angle"};
    default:
      return {"roll", "pitch", "yaw", "x", "y", "height"};
  }
}

void require_observable(const MountInformation& information, const Model& model) {
  const MountOptions& options = *model.options;
  const std::vector<bool> missing = unobservable_directions(information.posterior, options.max_sigma);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < missing.size(); ++i)
    if (missing[i]) names.push_back(direction_names(options.carrier)[i]);
  if (names.empty()) return;
  if (names == std::vector<std::string>{"height"} && options.height)
    throw Error(ErrorKind::kDegenerate, "mount",
                "the standard deviation of the given height, " + mm(options.height->sigma, 0) +
                    ", is too large: this drive cannot observe the height, and the limit is " +
                    mm(options.max_sigma, 0),
                "measure the height of the rig's origin (the first camera's centre) above the base's origin "
                "more precisely, e.g. --height 0.85m+-5mm");
  throw Error(ErrorKind::kDegenerate, "mount",
              "this " + words_of(options.carrier).motion + " cannot observe " + and_list(names) +
                  " of the rig on " + words_of(options.carrier).carrier +
                  (model.planar ? ": the base moves in a plane" : ""),
              remedy(missing, options.carrier));
}

void require_time_offset(const Model& model) {
  const Words words = words_of(model.options->carrier);
  const MountOptions& options = *model.options;
  constexpr double kAtLimit = 0.98;
  if (options.estimate_time_offset &&
      std::abs(model.offset - options.time_offset) > kAtLimit * options.max_time_offset)
    throw Error(
        ErrorKind::kDegenerate, "mount",
        "the difference of the clocks of " + words.poses + " and sightings is not found within " +
            fixed(options.max_time_offset, 1) + " s of the stated one",
        "state it roughly (--time-offset), or that there is none (--same-clock); else drive longer, with more "
        "sightings, and change speed and direction");
}

void require_agreement(const Model& model) {
  const Words words = words_of(model.options->carrier);
  const auto require_most = [&](const std::vector<char>& use, const std::string& what) {
    const auto rejected = std::count(use.begin(), use.end(), 0);
    if (2 * std::size_t(rejected) <= use.size()) return;
    throw Error(ErrorKind::kDegenerate, "mount",
                std::to_string(rejected) + " of " + std::to_string(use.size()) + " " + what +
                    " contradict the others",
                "check that poses and sightings are of one " + words.motion +
                    ", that no clock was set during it, and that frames, units and markers are those stated");
  };
  require_most(model.use_base, words.poses);
  require_most(model.use_sighting, "sightings");
}

namespace {

void remark_on_rejected(const MountResult& result, Diagnostics& diagnostics) {
  const Words words = words_of(result.carrier);
  const auto share = [&](const char* code, const std::string& what, std::size_t rejected, std::size_t used,
                         const std::string& next) {
    if (rejected == 0) return;
    const std::string text = std::to_string(rejected) + " of " + std::to_string(rejected + used) + " " +
                             what + " contradict the others and are rejected";
    constexpr double kMany = 0.05;
    if (double(rejected) > kMany * double(rejected + used))
      diagnostics.warn(code, text + "; " + next);
    else
      diagnostics.note(code, text);
  };
  share("sightings_rejected", "sightings", result.rejected_sightings.size(), result.sightings_used,
        "a marker moved, two have one id, or flat views were taken for their mirror image");
  share("base_poses_rejected", words.poses, result.rejected_base_poses.size(), result.base_poses_used,
        words.lost);
}

void remark_on_event(const MountEvent& event, MountCarrier carrier, Diagnostics& diagnostics) {
  const Words words = words_of(carrier);
  const Vec6 change = se3_log(event.change);
  const std::string size = mm(event.change.translation.norm(), 1) + " and " +
                           fixed(change.head<3>().norm() / kDegree, 2) + " degrees";
  if (event.kind == MountEvent::Kind::kRigBumped)
    diagnostics.warn("rig_bumped",
                     "the rig moved on " + words.carrier +
                         (carrier == MountCarrier::kHead ? ", or the tilt motor lost steps," : "") + " at " +
                         fixed(event.time, 2) + " s by " + size +
                         "; the mount is that of the time after. Fix the rig and repeat the " + words.motion);
  else
    diagnostics.warn("localiser_jumped",
                     "the " + words.poses + " moved at " + fixed(event.time, 2) + " s by " + size + ": " +
                         words.jumped + "; the solve allows for it" +
                         (carrier == MountCarrier::kBase
                              ? ""
                              : ". Where " + words.source + " stands is that of the time before"));
  constexpr double kClear = 0.7;
  if (event.other_chi2 > kClear * event.chi2)
    diagnostics.warn("event_unclear",
                     "at " + fixed(event.time, 2) + " s a moved rig and a jump of " + words.source +
                         " explain the " + words.motion + " nearly equally well (chi-square " +
                         fixed(event.chi2, 0) + " and " + fixed(event.other_chi2, 0) +
                         "), as does a clock that was set; repeat it with more turns after this time");
}

/// Lengths that disagree: the mount is in the metres of the sightings, and it is as wrong as they may be.
void remark_on_scale(const MountResult& result, Diagnostics& diagnostics) {
  constexpr double kSure = 5, kLargest = 0.005;  // sigmas; metres on the mount
  const double off = result.scale - 1;
  if (!(result.scale_sigma > 0) || std::abs(off) < kSure * result.scale_sigma) return;
  const Words words = words_of(result.carrier);
  if (result.scale < 0) {
    diagnostics.fail("mirrored",
                     "the " + words.poses +
                         " fit only when they are mirrored: their frame is left-handed. Write a right-handed "
                         "one (y, and the x and z of the quaternion, of the other sign)");
    return;
  }
  double square = 0;
  for (const Eigen::Index i : {0, 1, 2})
    if (result.directions[std::size_t(3 + i)].observable)
      square += std::pow(result.base_from_rig.pose.translation[i], 2);
  const double effect = std::abs(off) * std::sqrt(square);
  const bool by_planes = result.markers.empty();
  const std::string text =
      "lengths by " + words.source + " are " +
      format("%+.2f +- %.2f %%", 100 * off, 100 * result.scale_sigma) + " off those by the " +
      (by_planes ? "planes" : "markers") + ", and the mount may be " + mm(effect, 1) +
      " off: " + (by_planes ? "check the depth sensor's scale" : "measure the markers' black squares") +
      (result.carrier == MountCarrier::kBase ? ", or correct the odometry's wheels" : "");
  if (effect > kLargest)
    diagnostics.fail("lengths_disagree", text);
  else
    diagnostics.warn("lengths_disagree", text);
}

/// Without markers the metres are those of the localiser.
void remark_on_plane_sensor(const MountResult& result, const MountOptions& options,
                            Diagnostics& diagnostics) {
  if (!result.plane_sensor) return;
  constexpr double kSure = 5, kUnusual = 3, kLargest = 0.005;  // sigmas; metres on the mount
  const MountResult::PlaneSensor& sensor = *result.plane_sensor;
  const Vec4 sigma = sensor.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Eigen::Index axis = 0;
  const double turn = sensor.turn.cwiseAbs().maxCoeff(&axis);
  if (turn > kUnusual * options.plane_sensor.turn_sigma && turn > kSure * sigma[1 + axis])
    diagnostics.warn(
        "plane_sensor_off",
        "the sensor of planes is turned by " + fixed(sensor.turn.norm() / kDegree, 2) +
            " degrees against the rig's camera, and the mount allows for it. Calibrate the rig again");
  const double off = sensor.scale - 1;
  if (std::abs(off) < kUnusual * options.plane_sensor.scale_sigma || std::abs(off) < kSure * sigma[0]) return;
  const std::string text =
      "the distances of planes are " + format("%+.2f +- %.2f %%", 100 * off, 100 * sigma[0]) + " off ";
  if (!result.markers.empty()) {
    diagnostics.warn("plane_sensor_off",
                     text +
                         "those of the markers, and the mount allows for it. Check the depth "
                         "sensor's calibration");
    return;
  }
  const double effect = std::abs(off) * result.base_from_rig.pose.translation.norm();
  const std::string rest =
      text +
      "those of the localiser, and the mount allows for it. If the localiser's metres are "
      "wrong and not the sensor's, the mount is " +
      mm(effect, 1) + " off: check the depth sensor's scale, and the odometry's wheels";
  if (effect > kLargest)
    diagnostics.fail("lengths_disagree", rest);
  else
    diagnostics.warn("lengths_disagree", rest);
}

/// A planar drive of a left-handed localiser is that of a right-handed one seen from below.
void remark_on_side(const MountResult& result, Diagnostics& diagnostics) {
  if (result.carrier != MountCarrier::kBase) return;
  const Vec3 up_in_image = result.base_from_rig.pose.rotation * -Vec3::UnitY();
  constexpr double kUpsideDown = -0.5;
  if (up_in_image.z() < kUpsideDown)
    diagnostics.warn(
        "rig_upside_down",
        "the rig's camera hangs upside down on the base. If it does not, the localiser's frame is left-handed (y and "
        "yaw of the other sign) or has z downwards; write a right-handed one with z upwards");
}

void remark_on_changes(const MountResult& result, Diagnostics& diagnostics) {
  if (int(result.events.size()) < kMaxEvents) return;
  const Words words = words_of(result.carrier);
  diagnostics.fail(
      "too_many_changes",
      "the recording contradicts itself: it would take " + std::to_string(kMaxEvents) +
          " changes or more to explain it. Check that no clock was set meanwhile, that no two "
          "markers have one id, " +
          (result.carrier == MountCarrier::kBase
               ? "that the localiser does not drift (odometry instead of the map), that known markers are in "
                 "its world, "
               : "") +
          "and the scale of the " + words.poses + "; do not use this mount");
}

/// An arm and a head have a known noise; more is an error that lasts.
void remark_on_carrier(const MountResult& result, const MountOptions& options, Diagnostics& diagnostics) {
  constexpr double kNoisier = 3;
  if (result.carrier == MountCarrier::kBase) return;
  const Words words = words_of(result.carrier);
  const double worst = std::max(result.rotation_sigma / options.rotation_sigma,
                                result.position_sigma / options.position_sigma);
  if (worst < kNoisier) return;
  diagnostics.warn(
      "poses_noisier",
      "the " + words.poses + " scatter " + fixed(worst, 1) + " times as much as stated (--noise): " +
          (result.carrier == MountCarrier::kHead
               ? "a wrong gear ratio or sign, pan and tilt exchanged, play in the axes, or a clock "
                 "that was set"
               : "the arm's kinematic errors, wrong units, or a clock that was set"));
}

void remark_on_noise(const MountResult& result, const MountOptions& options, Diagnostics& diagnostics) {
  if (result.correlation > 1)
    diagnostics.note("correlated_localiser", "the errors of " + words_of(result.carrier).source +
                                                 " are correlated in time; their variance counts " +
                                                 fixed(result.correlation, 1) + " times");
  constexpr double kNoisier = 2;
  if (result.sighting_factor > kNoisier)
    diagnostics.warn("sightings_noisier",
                     "the sightings scatter " + fixed(result.sighting_factor, 1) +
                         " times as much as their covariances state; the sigmas allow for it. "
                         "Check the camera's calibration and that the markers are flat");
  if (result.plane_factor > kNoisier)
    diagnostics.warn("planes_noisier", "the planes scatter " + fixed(result.plane_factor, 1) +
                                           " times as much as their covariances state; the sigmas allow for "
                                           "it. Check the depth sensor's scale and that the walls are flat");
  constexpr double kWeakOffset = 0.02;
  if (options.estimate_time_offset && result.time_offset_sigma > kWeakOffset)
    diagnostics.warn("time_offset_weak", "the time offset is known to " +
                                             fixed(1000 * result.time_offset_sigma, 0) +
                                             " ms only; change speed and direction more often");
}

/// What was stated against the drive alone, where the drive determines it.
void remark_on_statements(const MountResult& result, const MountOptions& options,
                          const MountInformation& information, Diagnostics& diagnostics) {
  constexpr double kDisagrees = 4.5;
  if (options.height && information.data(5, 5) > 0) {
    const double off =
        (result.base_from_rig.pose.translation.z() - options.height->value) / options.height->sigma;
    if (std::abs(off) > kDisagrees)
      diagnostics.warn("statement_disagrees", "the drive puts the rig at a height of " +
                                                  mm(result.base_from_rig.pose.translation.z(), 1) +
                                                  ", the statement at " + mm(options.height->value, 1) +
                                                  ": " + fixed(std::abs(off), 1) + " sigmas apart");
  }
  if (options.prior) {
    const Vec6 error = se3_log(result.base_from_rig.pose * options.prior->pose.inverse());
    const double chi2 = error.dot(options.prior->covariance.llt().solve(error));
    if (chi2 > kRejectChi2)
      diagnostics.warn("statement_disagrees",
                       "the earlier pose of the rig contradicts the " + words_of(result.carrier).motion +
                           " (chi-square " + fixed(chi2, 0) +
                           " of 6); the rig has moved since, or its covariance is too small");
  }
}

}  // namespace

void remark(MountResult& result, const MountOptions& options, const MountInformation& information) {
  Diagnostics& diagnostics = result.diagnostics;
  if (const auto names = result.unobservable(); !names.empty())
    diagnostics.note("stated_not_observed", "the " + words_of(result.carrier).motion + " cannot observe " +
                                                and_list(names) + " of the mount; " +
                                                (names.size() == 1 ? "it is" : "they are") +
                                                " as stated, with the stated sigma");
  remark_on_rejected(result, diagnostics);
  for (const MountEvent& event : result.events) remark_on_event(event, result.carrier, diagnostics);
  remark_on_scale(result, diagnostics);
  remark_on_plane_sensor(result, options, diagnostics);
  remark_on_side(result, diagnostics);
  remark_on_changes(result, diagnostics);
  remark_on_noise(result, options, diagnostics);
  remark_on_carrier(result, options, diagnostics);
  remark_on_statements(result, options, information, diagnostics);
}

}  // namespace procam::calibrate::mount
