#include "mount_start.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mount_start_planes.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

namespace procam::calibrate::mount {
namespace {

constexpr std::size_t kMinSightings = 20;
constexpr std::size_t kMinAtStations = 6;
constexpr double kKnotSpacing = 0.05;  // s: at 1 m/s^2 a straight step is 0.3 mm off its curve
constexpr double kMargin = 0.1;        // s: of knots about the base poses, as the solve moves the time offset
constexpr std::size_t kMaxKnots = 40000;      // a drive of half an hour
constexpr double kMinRotation = 5 * kDegree;  // between two sightings, to start from

Vec3 upright(const Pose& world_from_base) {
  return world_from_base.rotate(Vec3::UnitZ());
}

/// world_from_plane: the frame in which the base moves with z = 0, next to the world's own.
Pose plane_of(const std::vector<BasePose>& base) {
  Vec3 normal = Vec3::Zero();
  for (const BasePose& pose : base) normal += upright(pose.world_from_base);
  normal.normalize();
  std::vector<double> heights;
  for (const BasePose& pose : base) heights.push_back(normal.dot(pose.world_from_base.translation));
  return {rotation_between(Vec3::UnitZ(), normal), normal * median(heights)};
}

/// Off the plane: height and tilt of each pose, and what neighbours differ by, which is noise alone.
bool is_planar(const std::vector<BasePose>& base, const Pose& world_from_plane) {
  const Pose plane_from_world = world_from_plane.inverse();
  std::vector<double> heights, tilts, height_steps, tilt_steps;
  Pose before;
  for (std::size_t i = 0; i < base.size(); ++i) {
    const Pose pose = plane_from_world * base[i].world_from_base;
    const double tilt = upright(pose).head<2>().norm();
    heights.push_back(std::abs(pose.translation.z()));
    tilts.push_back(tilt);
    if (i > 0) {
      height_steps.push_back(std::abs(pose.translation.z() - before.translation.z()));
      tilt_steps.push_back((upright(pose) - upright(before)).head<2>().norm());
    }
    before = pose;
  }
  // White noise: the step of neighbours is sqrt(2) of it. An even floor is within the constants.
  constexpr double kSlack = 2, kFloor = 0.004, kTilt = 0.3 * kDegree;
  return median(heights) < kSlack * median(height_steps) / std::sqrt(2) + kFloor &&
         median(tilts) < kSlack * median(tilt_steps) / std::sqrt(2) + kTilt;
}

/// Mean of the poses near a time, or on the way between the two next to it.
Pose smoothed(const std::vector<BasePose>& base, double time) {
  const auto after = std::lower_bound(base.begin(), base.end(), time,
                                      [](const BasePose& pose, double t) { return pose.time < t; });
  const BasePose& right = after == base.end() ? base.back() : *after;
  const BasePose& left = after == base.begin() ? base.front() : *(after - 1);
  const double span = right.time - left.time;
  const double alpha = span > 0 ? std::clamp((time - left.time) / span, 0.0, 1.0) : 0;
  const Pose middle = between_knots(left.world_from_base, right.world_from_base, alpha).pose;
  constexpr double kWindow = 0.15;
  Vec6 sum = Vec6::Zero();
  double count = 0;
  const auto add = [&](const BasePose& pose) {
    sum += se3_log(middle.inverse() * pose.world_from_base);
    count += 1;
  };
  for (auto p = after; p != base.end() && p->time <= time + kWindow; ++p) add(*p);
  for (auto p = after; p != base.begin() && (p - 1)->time >= time - kWindow; --p) add(*(p - 1));
  return count < 4 ? middle : middle * se3_exp(Vec6(sum / count));
}

struct Pair {
  std::size_t first, second;
  Pose rig_from_later;
};

/// Sightings of one marker 0.7 and 2.5 s apart, at most `max_pairs`.
std::vector<Pair> pairs_of(const Model& model, std::size_t max_pairs) {
  std::vector<std::vector<std::size_t>> by_marker(model.markers.size());
  for (std::size_t i = 0; i < model.data->sightings.size(); ++i)
    if (model.use_sighting[i] && !model.data->sightings[i].is_plane)
      by_marker[std::size_t(model.marker_of[i])].push_back(i);
  std::vector<Pair> pairs;
  const auto& sightings = model.data->sightings;
  const auto add = [&](std::size_t a, std::size_t b) {
    pairs.push_back({a, b, sightings[a].marker_from_rig.pose.inverse() * sightings[b].marker_from_rig.pose});
  };
  for (std::vector<std::size_t>& seen : by_marker) {
    std::sort(seen.begin(), seen.end(),
              [&](std::size_t a, std::size_t b) { return sightings[a].time < sightings[b].time; });
    if (!model.stations.empty()) {
      for (std::size_t a = 0; a < seen.size(); ++a)
        for (std::size_t b = a + 1; b < seen.size(); ++b) add(seen[a], seen[b]);
      continue;
    }
    for (const double lag : {0.7, 2.5})
      for (std::size_t a = 0, b = 0; a < seen.size(); ++a) {
        while (b < seen.size() && sightings[seen[b]].time < sightings[seen[a]].time + lag) ++b;
        if (b == seen.size()) break;
        if (sightings[seen[b]].time > sightings[seen[a]].time + 2 * lag) continue;
        add(seen[a], seen[b]);
      }
  }
  if (pairs.size() > max_pairs) {
    std::vector<Pair> thinned;
    for (std::size_t i = 0; i < max_pairs; ++i) thinned.push_back(pairs[i * pairs.size() / max_pairs]);
    return thinned;
  }
  return pairs;
}

double angle_of(const Pose& pose) {
  return so3_log(pose.rotation).norm();
}

Pose base_step(const Model& model, const Pair& pair, double later = 0) {
  const auto at = [&](std::size_t i) { return model.path(model.data->sightings[i].time + later); };
  return at(pair.first).inverse() * at(pair.second);
}

/// The offset at which base and rig rotate by the same angles (Furgale et al. 2013).
void start_offset(Model& model, const std::vector<Pair>& pairs) {
  const MountOptions& options = *model.options;
  if (!options.estimate_time_offset || pairs.empty()) return;
  constexpr double kStep = 0.02, kClip = 0.05;  // s, rad
  double best = std::numeric_limits<double>::infinity(), chosen = 0;
  const int steps = int(std::ceil(options.max_time_offset / kStep));
  for (int s = -steps; s <= steps; ++s) {
    const double later = s * kStep;
    double cost = 1e-9 * std::abs(s);  // of equal ones the nearest
    for (const Pair& pair : pairs) {
      const double difference = angle_of(base_step(model, pair, later)) - angle_of(pair.rig_from_later);
      cost += std::min(difference * difference, kClip * kClip);
    }
    if (cost < best) {
      best = cost;
      chosen = later;
    }
  }
  model.offset += chosen;
  model.start -= chosen;
}

/// Steps of the base and of the rig that belong together.
struct HandEyePairs {
  std::vector<Pose> base, rig;
  Mat3 correlation = Mat3::Zero();  ///< of their rotation vectors
};

[[noreturn]] void refuse_without_turn(const MountOptions& options, double largest) {
  const std::string most = fixed(largest / kDegree, 1) +
                           (options.stations ? " degrees at most): " : " degrees within 2.5 s at most): ");
  if (options.carrier == MountCarrier::kFlange)
    throw Error(ErrorKind::kDegenerate, "mount",
                "the flange does not turn while it sees a marker (" + most +
                    "x, y and z of the rig on the flange are unobservable",
                "turn the flange about two axes or more, each by 30 degrees, or give --prior");
  if (options.carrier == MountCarrier::kHead)
    throw Error(ErrorKind::kDegenerate, "mount",
                "the head does not turn while it sees a marker (" + most +
                    "its axes and the rig's pose on it are unobservable",
                "move pan and tilt, each by 20 degrees or more, while a marker is seen");
  throw Error(ErrorKind::kDegenerate, "mount",
              "the base does not turn while it sees a marker (" + most +
                  "x, y and yaw of the rig on the base are unobservable",
              "drive curves of 90 degrees or more in both directions past the markers, or give --prior");
}

/// Without outliers. Throws Error(kDegenerate) where the base does not turn.
HandEyePairs turning_pairs(const Model& model, const std::vector<Pair>& pairs) {
  HandEyePairs turning;
  double largest = 0;
  for (const Pair& pair : pairs) {
    const Pose step = base_step(model, pair);
    constexpr double kAgree = 0.06;
    if (std::abs(angle_of(step) - angle_of(pair.rig_from_later)) > kAgree) continue;  // an outlier
    turning.base.push_back(step);
    turning.rig.push_back(pair.rig_from_later);
    largest = std::max(largest, std::min(angle_of(step), angle_of(pair.rig_from_later)));
    turning.correlation += so3_log(step.rotation) * so3_log(pair.rig_from_later.rotation).transpose();
  }
  if (turning.base.empty() || largest < kMinRotation) refuse_without_turn(*model.options, largest);
  return turning;
}

/// The translation, and with `angle` the rotation about the axis that is z in the frames `to_axis` and `rig_to_axis`: linear least squares
/// (Guo et al. 2012). Without `angle` the rotation is known.
void solve_hand_eye(const HandEyePairs& pairs, const std::vector<double>& weight, bool angle,
                    const Mat3& to_axis, const Mat3& rig_to_axis, Pose& base_from_rig) {
  const auto n = Eigen::Index(pairs.base.size());
  const Mat3 rotation = base_from_rig.rotation_matrix();
  MatX rows = MatX::Zero(3 * n, 5);
  VecX right(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pose &base = pairs.base[std::size_t(i)], &rig = pairs.rig[std::size_t(i)];
    const double w = weight[std::size_t(i)];
    rows.block<3, 3>(3 * i, 0) = w * (base.rotation_matrix() - Mat3::Identity());
    if (angle) {
      const Vec3 u = rig_to_axis * rig.translation;
      rows.block<3, 1>(3 * i, 3) = -w * to_axis.transpose() * Vec3(u.x(), u.y(), 0);
      rows.block<3, 1>(3 * i, 4) = -w * to_axis.transpose() * Vec3(-u.y(), u.x(), 0);
      right.segment<3>(3 * i) = w * (to_axis.transpose() * Vec3(0, 0, u.z()) - base.translation);
    } else {
      right.segment<3>(3 * i) = w * (rotation * rig.translation - base.translation);
    }
  }
  const VecX solved = rows.completeOrthogonalDecomposition().solve(right);
  const Mat3 turned =
      angle ? Mat3(to_axis.transpose() *
                   so3_exp(Vec3(0, 0, std::atan2(solved[4], solved[3]))).toRotationMatrix() * rig_to_axis)
            : rotation;
  base_from_rig = {turned, solved.head<3>()};
}

/// A X = X B over the pairs: rotation from the axes (Park and Martin 1994); where all rotations have one axis, the
/// rotation about it with the translation as Guo et al. 2012.
Pose hand_eye(const Model& model, const std::vector<Pair>& pairs) {
  const HandEyePairs turning = turning_pairs(model, pairs);
  const Eigen::JacobiSVD<Mat3> svd(turning.correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Vec3 values = svd.singularValues();
  constexpr double kOneAxis = 0.03;
  const bool one_axis = values[1] < kOneAxis * values[0] || model.planar;
  const Vec3 axis_base = model.planar ? Vec3::UnitZ() : Vec3(svd.matrixU().col(0));
  Vec3 axis_rig = turning.correlation.transpose() * axis_base;
  axis_rig.normalize();
  const Mat3 to_axis = rotation_between(axis_base, Vec3::UnitZ()).toRotationMatrix(),
             rig_to_axis = rotation_between(axis_rig, Vec3::UnitZ()).toRotationMatrix();
  Pose base_from_rig(Mat3(svd.matrixU() * sign * svd.matrixV().transpose()), Vec3::Zero());

  // Three rounds with the angle about a single axis, then with the rotation known. Rows are weighted by what the round before
  // found.
  std::vector<double> weight(turning.base.size(), 1);
  for (int round = 0; round < 6; ++round) {
    solve_hand_eye(turning, weight, one_axis && round < 3, to_axis, rig_to_axis, base_from_rig);
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const Vec3 error =
          turning.base[i] * base_from_rig.translation - base_from_rig * turning.rig[i].translation;
      constexpr double kUsual = 0.03;  // m
      weight[i] = 1 / (1 + std::pow(error.norm() / kUsual, 2));
    }
  }
  return base_from_rig;
}

/// The pose in the middle of the others.
Pose middle_of(const std::vector<Pose>& candidates) {
  constexpr std::size_t kEnough = 40;
  const std::size_t stride = 1 + candidates.size() / kEnough;
  double best = std::numeric_limits<double>::infinity();
  Pose middle;
  for (std::size_t i = 0; i < candidates.size(); i += stride) {
    double sum = 0;
    for (std::size_t j = 0; j < candidates.size(); j += stride)
      sum += std::min(1.0, (candidates[i].translation - candidates[j].translation).norm() +
                               candidates[i].rotation.angularDistance(candidates[j].rotation));
    if (sum < best) {
      best = sum;
      middle = candidates[i];
    }
  }
  return middle;
}

void start_markers(Model& model, const Pose& mount) {
  const auto& sightings = model.data->sightings;
  for (std::size_t m = 0; m < model.markers.size(); ++m) {
    std::vector<Pose> candidates;
    for (std::size_t i = 0; i < sightings.size(); ++i)
      if (model.use_sighting[i] && model.marker_of[i] == int(m) && model.at(sightings[i].time))
        candidates.push_back(model.path(sightings[i].time) * mount *
                             sightings[i].marker_from_rig.pose.inverse());
    if (model.is_plane[m]) move_within_plane(candidates);
    model.markers[m] = block_of(middle_of(candidates));
  }
}

/// world_from_base of an arm or a head, from its markers of known pose: the one in the middle of the others.
void start_world(Model& model) {
  if (model.options->carrier == MountCarrier::kBase || model.options->markers.empty()) return;
  std::vector<Pose> candidates;
  for (const MountMarker& known : model.options->markers) {
    const auto name = std::lower_bound(model.marker_names.begin(), model.marker_names.end(), known.name);
    if (name == model.marker_names.end() || *name != known.name) continue;
    const PoseBlock& marker = model.markers[std::size_t(name - model.marker_names.begin())];
    candidates.push_back(known.world_from_marker.pose * pose_of(marker.data()).inverse());
  }
  if (candidates.empty())
    throw Error(ErrorKind::kDegenerate, "markers of known pose",
                "none of the " + std::to_string(model.options->markers.size()) +
                    " is seen: all six directions of world_from_base are unobservable",
                "show the rig one of them, or leave out --markers");
  model.world = block_of(middle_of(candidates));
}

/// Markers of known pose, and the height that they give the rig.
void start_known(Model& model, Pose& mount) {
  const Pose plane_from_world = pose_of(model.frames[0].pose.data()).inverse();
  std::vector<double> heights;
  for (const MountMarker& known : model.options->markers)
    for (std::size_t i = 0; i < model.data->sightings.size(); ++i) {
      const MarkerSighting& seen = model.data->sightings[i];
      if (seen.marker == known.name && model.at(seen.time))
        heights.push_back((model.path(seen.time).inverse() * plane_from_world * known.world_from_marker.pose *
                           seen.marker_from_rig.pose)
                              .translation.z());
    }
  if (!heights.empty()) mount.translation.z() = median(heights);
}

void start_knots(Model& model) {
  const std::vector<BasePose>& base = model.data->base;
  if (model.options->stations) {
    for (const BasePose& pose : base) {
      model.stations.push_back(pose.time - model.offset);
      model.knots.push_back(block_of(pose_of(model.frames[0].pose.data()).inverse() * pose.world_from_base));
    }
    return;
  }
  const double first = base.front().time - kMargin;
  model.start = first - model.offset;
  const double duration = base.back().time + kMargin - first;
  const std::size_t count = std::size_t(std::ceil(duration / kKnotSpacing)) + 1;
  if (count > kMaxKnots)
    throw Error(ErrorKind::kInput, "poses of the base", "they last " + fixed(duration, 0) + " s",
                "give a recording of half an hour at most");
  model.spacing = duration / double(count - 1);
  const Pose plane_from_world = pose_of(model.frames[0].pose.data()).inverse();
  for (std::size_t k = 0; k < count; ++k) {
    const Pose pose = plane_from_world * smoothed(base, first + double(k) * model.spacing);
    model.knots.push_back(block_of(model.planar ? in_plane(pose) : pose));
  }
}

void start_names(Model& model) {
  const MountData& data = *model.data;
  for (const MarkerSighting& seen : data.sightings) model.marker_names.push_back(seen.marker);
  std::sort(model.marker_names.begin(), model.marker_names.end());
  model.marker_names.erase(std::unique(model.marker_names.begin(), model.marker_names.end()),
                           model.marker_names.end());
  model.markers.assign(model.marker_names.size(), block_of(Pose()));
  model.is_plane.assign(model.marker_names.size(), 0);
  for (const MarkerSighting& seen : data.sightings)
    model.marker_of.push_back(
        int(std::lower_bound(model.marker_names.begin(), model.marker_names.end(), seen.marker) -
            model.marker_names.begin()));
  for (std::size_t i = 0; i < data.sightings.size(); ++i)
    if (data.sightings[i].is_plane) model.is_plane[std::size_t(model.marker_of[i])] = 1;
  model.use_base.assign(data.base.size(), 1);
  model.use_sighting.assign(data.sightings.size(), 1);
}

}  // namespace

MountData with_start_poses(const MountData& data, const MountOptions& options) {
  MountData started = data;
  if (options.carrier != MountCarrier::kHead) return started;
  started.base.clear();
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  for (const HeadAngles& angles : data.angles) {
    started.base.push_back({angles.time, head_from_tilt({}, angles.pan, angles.tilt)});
    for (const int i : {0, 1}) {
      const double angle = i == 0 ? angles.pan : angles.tilt;
      low[i] = std::min(low[i], angle);
      high[i] = std::max(high[i], angle);
    }
  }
  for (const int i : {0, 1})
    if (!(high[i] - low[i] > kMinRotation))
      throw Error(
          ErrorKind::kDegenerate, "mount",
          std::string(i == 0 ? "pan" : "tilt") + " moves by " +
              fixed(std::max(0.0, high[i] - low[i]) / kDegree, 1) +
              " degrees only: that axis, i.e. the axis offset and the axis angle, and the rig's pose against "
              "it are unobservable",
          "move pan and tilt, each by 20 degrees or more, while a marker is seen; the angles of a log are degrees");
  return started;
}

namespace {

/// Without the pose of the rig, the markers and the world.
Model model_with_path(const MountData& data, const MountOptions& options) {
  Model model;
  model.data = &data;
  model.options = &options;
  const Pose world_from_plane = plane_of(data.base);
  model.planar = options.carrier == MountCarrier::kBase &&
                 (options.motion == BaseMotion::kPlanar ||
                  (options.motion == BaseMotion::kAuto && is_planar(data.base, world_from_plane)));
  model.frames = {
      {-std::numeric_limits<double>::infinity(), block_of(model.planar ? world_from_plane : Pose())}};
  model.noise.position = model.noise.height = options.position_sigma;
  model.noise.turn = model.noise.tilt = options.rotation_sigma;
  model.noise.floor = options.floor_sigma;
  model.noise.floor_tilt = options.floor_tilt_sigma;

  model.offset = options.time_offset;
  if (options.carrier == MountCarrier::kHead) model.axes = {0, kPi / 2};
  start_knots(model);
  start_names(model);
  return model;
}

}  // namespace

double start_misfit(const MountData& data, const MountOptions& options) {
  Model model = model_with_path(data, options);
  const std::vector<Pair> pairs = pairs_of(model, 600);
  start_offset(model, pairs);
  std::vector<double> misfits;
  try {
    const HandEyePairs turning = turning_pairs(model, pairs);
    const Pose mount = hand_eye(model, pairs);
    for (std::size_t i = 0; i < turning.base.size(); ++i)
      misfits.push_back((turning.base[i] * mount.translation - mount * turning.rig[i].translation).norm());
  } catch (const Error&) {
  }
  constexpr double kTurnAlike = 0.5;
  if (double(misfits.size()) < kTurnAlike * double(pairs.size()) || misfits.empty())
    return std::numeric_limits<double>::infinity();
  return median(std::move(misfits));
}

namespace {

/// Of two clocks, or of two units.
std::string times_of(const MountData& data) {
  if (data.sightings.empty()) return "";
  const auto [first, last] =
      std::minmax_element(data.sightings.begin(), data.sightings.end(),
                          [](const auto& one, const auto& other) { return one.time < other.time; });
  return ": poses from " + fixed(data.base.front().time, 2) + " to " + fixed(data.base.back().time, 2) +
         " s, sightings from " + fixed(first->time, 2) + " to " + fixed(last->time, 2) + " s";
}

}  // namespace

Model start_model(const MountData& data, const MountOptions& options) {
  Model model = model_with_path(data, options);
  const std::size_t needed = options.stations ? kMinAtStations : kMinSightings;
  std::size_t inside = 0;
  for (const MarkerSighting& seen : data.sightings) inside += model.at(seen.time) ? 1 : 0;
  if (inside < needed)
    throw Error(ErrorKind::kNotEnoughData, "sightings",
                std::to_string(inside) + " of " + std::to_string(data.sightings.size()) +
                    " are within the times of the base poses, and at least " + std::to_string(needed) +
                    " are needed" + times_of(data),
                "record both on one drive and one clock, in seconds, or give the clocks' difference as "
                "--time-offset");
  if (options.floor && !model.planar)
    throw Error(ErrorKind::kInput, "the floor", "the base does not move in a plane",
                "leave out --floor, or state --motion planar for a robot on a floor");
  const std::vector<Pair> pairs = pairs_of(model, 600);
  start_offset(model, pairs);
  const bool planes_alone =
      std::all_of(model.is_plane.begin(), model.is_plane.end(), [](char is) { return is != 0; });
  Pose mount = options.prior  ? options.prior->pose
               : planes_alone ? mount_from_planes(model)
                              : hand_eye(model, pairs);
  if (options.height) mount.translation.z() = options.height->value;
  if (!options.height && !options.prior && options.carrier == MountCarrier::kBase) start_known(model, mount);
  model.mounts = {{-std::numeric_limits<double>::infinity(), block_of(mount)}};
  start_markers(model, mount);
  start_world(model);
  return model;
}

}  // namespace procam::calibrate::mount
