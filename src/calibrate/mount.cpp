#include "procam/calibrate/mount.hpp"

#include <algorithm>
#include <cmath>

#include "mount_analysis.hpp"
#include "mount_mistakes.hpp"
#include "mount_plane_names.hpp"
#include "mount_remarks.hpp"
#include "mount_start.hpp"
#include "procam/core/base/words.hpp"

namespace procam::calibrate {

BaseMotion parse_base_motion(const std::string& text) {
  if (text == "auto") return BaseMotion::kAuto;
  if (text == "planar") return BaseMotion::kPlanar;
  if (text == "full") return BaseMotion::kFull;
  throw Error(ErrorKind::kInput, "'" + text + "'", "it is no kind of motion", "give auto, planar or full");
}

namespace mount {
namespace {

constexpr double kMinScale = 0.002;  ///< a smaller one is not looked for
/// Of a solve: noise, outliers and changes are found near the minimum, the result is at it.
constexpr double kRoughly = 1e-6, kExactly = 1e-9;

void update_noise(Model& model, const Equations& equations) {
  if (!model.options->estimate_noise) return;
  const std::array<double, kGroups> factors = variance_factors(equations);
  const double root = std::sqrt(model.noise.correlation);
  const auto scale = [](double& sigma, double factor, double low, double high) {
    sigma = std::clamp(sigma * std::clamp(factor, 0.2, 5.0), low, high);
  };
  Noise& noise = model.noise;
  // An arm and a head are about as exact as the sightings, and these tell little about the least noise that both have:
  // it is as stated or larger.
  const bool stated = model.options->carrier != MountCarrier::kBase;
  const double least_turn = stated ? model.options->rotation_sigma : 1e-5,
               least_position = stated ? model.options->position_sigma : 1e-5;
  scale(noise.turn, root * factors[kBaseTurn], least_turn, 0.5);
  scale(noise.position, (model.axes ? 1 : root) * factors[kBasePosition], least_position, 1);
  if (model.planar) {
    // A localiser in the plane reports both as constants.
    scale(noise.tilt, root * factors[kBaseTilt], 1e-3, 0.5);
    scale(noise.height, root * factors[kBaseHeight], 1e-3, 1);
  }
  if (model.coarse) return;
  scale(noise.sighting, factors[kSighting], 0.05, 100);
  // An image has one to four planes: the path could follow each, and its noise would seem to vanish.
  scale(noise.plane, factors[kPlane], 1, 100);
  scale(noise.motion, factors[kMotion], 1, 100);
  if (model.planar) {
    scale(noise.floor, factors[kFloorHeight], 1e-5, 0.05);
    scale(noise.floor_tilt, factors[kFloorTilt], 1e-5, 0.1);
  }
  noise.correlation = correlation_of(equations.linear, model);
}

void insert(Model& model, const FoundEvent& event) {
  const bool bump = event.kind == MountEvent::Kind::kRigBumped;
  std::vector<Epoch>& epochs = bump ? model.mounts : model.frames;
  const std::size_t before = model.epoch(epochs, event.time);
  Epoch after = epochs[before];
  after.from = event.time;
  const PoseManifold manifold({0, 1, 2, 3, 4, 5},
                              bump ? PoseManifold::Side::kMount : PoseManifold::Side::kRight);
  const PoseBlock from = after.pose;
  manifold.Plus(from.data(), event.increment.data(), after.pose.data());
  epochs.insert(epochs.begin() + std::ptrdiff_t(before) + 1, after);
}

void insert(Model& model, const FoundScale& found) {
  model.estimates_scale = true;
  model.scale += found.increment;
}

/// Noise that is larger or slower than assumed looks like changes: a found one has to stand up to what is left with it.
bool is_confirmed(const Model& model, Model extended, double chi2) {
  MountProblem again(extended, true);
  again.solve(kRoughly);
  const Equations after(again.linearise());
  const std::array<double, kGroups> factors = variance_factors(after);
  const double variance = std::pow(std::max({1.0, factors[kBaseTurn], factors[kBasePosition]}), 2) *
                          std::max(1.0, correlation_of(after.linear, model) / model.noise.correlation);
  return chi2 >= variance * model.options->event_chi2;
}

/// The most significant of a scale and a change, inserted into the model; false: there is none. A wrong scale looks like
/// many changes, a change like a small scale.
bool extend(Model& model, const MountProblem& problem, const Equations& equations,
            std::vector<FoundEvent>& found) {
  const auto confirmed = [&](const auto& unknown) {
    Model extended = model;
    insert(extended, unknown);
    if (!is_confirmed(model, extended, unknown.chi2)) return false;
    insert(model, unknown);
    return true;
  };
  const auto event = find_event(model, problem, equations);
  const FoundScale scale = find_scale(model, problem, equations);
  const double least = std::max(event ? event->chi2 : 0, model.options->event_chi2);
  if (scale.chi2 >= least && std::abs(scale.increment) > kMinScale && confirmed(scale)) return true;
  if (!event || int(found.size()) >= kMaxEvents || !confirmed(*event)) return false;
  found.push_back(*event);
  return true;
}

/// Rejects by chi-square; returns how many changed.
int reject(Model& model, const Linear& linear) {
  int changed = 0;
  const auto judge = [&](std::vector<char>& use, const std::vector<int>& rows) {
    for (std::size_t i = 0; i < use.size(); ++i) {
      if (use[i] == 0 || rows[i] < 0) continue;
      if (linear.residuals.segment<6>(rows[i]).squaredNorm() < kRejectChi2) continue;
      use[i] = 0;
      ++changed;
    }
  };
  judge(model.use_base, linear.base_row);
  judge(model.use_sighting, linear.sighting_row);
  return changed;
}

/// Of the left increments of the mount, the axes, and the left increment of world_from_base.
MatX joint_covariance(const Model& model, const MountInformation& information) {
  const Eigen::Index n = information.covariance.rows(), all = n + information.world_covariance.rows();
  MatX covariance = MatX::Zero(all, all), to_left = MatX::Identity(all, all);
  covariance.topLeftCorner(n, n) = information.covariance;
  to_left.topLeftCorner<6, 6>() = left_by_directions(pose_of(model.mounts.back().pose.data()));
  if (model.world) {
    covariance.topRightCorner(n, 6) = information.directions_with_world;
    covariance.bottomLeftCorner(6, n) = information.directions_with_world.transpose();
    covariance.bottomRightCorner<6, 6>() = information.world_covariance;
    to_left.bottomRightCorner<6, 6>() = adjoint(pose_of(model.world->data()));
  }
  covariance = to_left * covariance * to_left.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

/// How often and where a plane was seen.
void add_sightings(MountPlane& plane, const Model& model, int number, const Linear& linear) {
  const Pose world_from_path = pose_of(model.frames[0].pose.data()),
             plane_from_world = plane.world_from_plane.inverse();
  for (std::size_t i = 0; i < model.marker_of.size(); ++i) {
    if (model.marker_of[i] != number || linear.sighting_row[i] < 0) continue;
    const MarkerSighting& seen = model.data->sightings[i];
    const Pose mount = pose_of(model.mounts[model.epoch(model.mounts, seen.time)].pose.data());
    const Vec3 origin = seen.marker_from_rig.pose.inverse().translation;
    const Vec2 at =
        (plane_from_world * (world_from_path * (model.path(seen.time) * (mount * origin)))).head<2>();
    plane.low = plane.sightings == 0 ? at : Vec2(plane.low.cwiseMin(at));
    plane.high = plane.sightings == 0 ? at : Vec2(plane.high.cwiseMax(at));
    ++plane.sightings;
  }
}

MountResult result_of(const Model& model, const Equations& equations) {
  const MountOptions& options = *model.options;
  const MountInformation information = mount_information(equations, options.estimate_time_offset);
  require_observable(information, model);
  MountResult result;
  result.carrier = options.carrier;
  const Pose mount = pose_of(model.mounts.back().pose.data());
  if (model.axes) result.axes = PanTiltAxes{(*model.axes)[0], (*model.axes)[1]};
  if (model.world) result.world_from_base = PoseWithCovariance{pose_of(model.world->data()), Mat6::Zero()};
  result.joint_covariance = joint_covariance(model, information);
  result.base_from_rig = {mount, result.joint_covariance.topLeftCorner<6, 6>()};
  if (model.world) result.world_from_base->covariance = result.joint_covariance.bottomRightCorner<6, 6>();
  const std::vector<bool> unobservable = unobservable_directions(information.data, options.max_sigma);
  const std::vector<double> of_data = direction_sigmas(information.data);
  const std::vector<std::string> names = direction_names(options.carrier);
  for (std::size_t i = 0; i < of_data.size(); ++i) {
    const auto row = Eigen::Index(i);
    result.directions.push_back(
        {names[i], std::sqrt(information.covariance(row, row)), of_data[i], !unobservable[i]});
  }
  result.time_offset = model.offset;
  result.time_offset_sigma = information.offset_sigma;
  result.scale = model.scale;
  result.scale_sigma = information.scale_sigma;
  if (information.sensor_covariance.size() > 0) {
    const auto& [scale, x, y, z] = model.sensor;
    result.plane_sensor = MountResult::PlaneSensor{scale, Vec3(x, y, z), information.sensor_covariance};
  }
  const Pose world_from_plane = pose_of(model.frames[0].pose.data());
  for (std::size_t m = 0; m < model.markers.size(); ++m) {
    if (information.marker_covariance[m].size() == 0) continue;
    const Pose pose = world_from_plane * pose_of(model.markers[m].data());
    if (model.is_plane[m]) {
      MountPlane plane{model.marker_names[m], pose, information.marker_covariance[m]};
      add_sightings(plane, model, int(m), equations.linear);
      result.planes.push_back(plane);
      continue;
    }
    const Mat6 to_left = adjoint(pose);
    result.markers.push_back(
        {model.marker_names[m], {pose, to_left * information.marker_covariance[m] * to_left.transpose()}});
  }
  result.planar = model.planar;
  for (std::size_t k = 0; k < model.knots.size(); ++k)
    result.path.push_back(
        {model.knot_time(k) + model.offset, world_from_plane * pose_of(model.knots[k].data())});
  result.position_sigma = model.noise.position;
  result.rotation_sigma = model.noise.turn;
  result.correlation = model.noise.correlation;
  result.sighting_factor = model.noise.sighting;
  result.plane_factor = model.noise.plane;
  result.floor_sigma = model.noise.floor;
  result.floor_tilt_sigma = model.noise.floor_tilt;
  for (std::size_t i = 0; i < model.use_base.size(); ++i)
    if (model.use_base[i] == 0) result.rejected_base_poses.push_back(i);
  result.base_poses_used = model.use_base.size() - result.rejected_base_poses.size();
  for (std::size_t i = 0; i < model.use_sighting.size(); ++i) {
    if (model.use_sighting[i] == 0)
      result.rejected_sightings.push_back(i);
    else
      ++(equations.linear.sighting_row[i] >= 0 ? result.sightings_used : result.sightings_outside);
  }
  return result;
}

}  // namespace
}  // namespace mount

namespace mount {
namespace {

/// A stated time offset against the one that the drive shows.
void check_stated_offset(Model model, const MountOptions& options, Diagnostics& diagnostics) {
  if (options.estimate_time_offset || options.stations) return;
  MountOptions open = options;
  open.estimate_time_offset = true;
  model.options = &open;
  MountProblem problem(model, false);
  problem.solve(kRoughly);
  const Equations equations(problem.linearise());
  const MountResult found = result_of(model, equations);
  constexpr double kDisagrees = 5, kLittle = 0.003;  // sigmas; seconds
  const double off = found.time_offset - options.time_offset;
  if (!(std::abs(off) > std::max(kLittle, kDisagrees * found.time_offset_sigma))) return;
  diagnostics.fail(
      "time_offset_disagrees",
      "the stamps of both logs are stated to be " + format("%.0f", 1e3 * options.time_offset) +
          " ms apart, and the motion puts them " +
          format("%.1f +- %.1f", 1e3 * found.time_offset, 1e3 * found.time_offset_sigma) +
          " ms apart: let the offset be estimated, or give this one (one clock is not enough, a stamp must be the "
          "moment of measurement)");
}

MountResult calibrate_started(const MountData& started, const MountOptions& options) {
  Model model = start_model(started, options);
  std::vector<FoundEvent> found;
  // Coarse and robust, until large events and outliers are known; then fine and robust, for noise and small events.
  constexpr int kCoarseRounds = 2, kRounds = 5;
  for (int round = 0; round < kRounds;) {
    model.coarse = round < kCoarseRounds;
    MountProblem problem(model, true);
    problem.solve(kRoughly);
    const Equations equations(problem.linearise());
    const bool looks = options.find_events && (round == 0 || round == kCoarseRounds + 1);
    if (looks && extend(model, problem, equations, found)) continue;
    update_noise(model, equations);
    if (round == kCoarseRounds - 1) reject(model, MountProblem(model, false).linearise());
    require_agreement(model);
    ++round;
  }
  // Then without the outliers.
  std::optional<Equations> last;
  constexpr int kFinalRounds = 3;
  for (int round = 0; round < kFinalRounds; ++round) {
    MountProblem problem(model, false);
    if (round > 0) problem.solve(kRoughly);
    Linear linear = problem.linearise();
    const int changed = reject(model, linear);
    require_agreement(model);
    if (changed == 0 && round > 0) {
      last.emplace(std::move(linear));
      if (round + 1 < kFinalRounds) update_noise(model, *last);
    }
  }
  require_time_offset(model);
  MountProblem problem(model, false);
  problem.solve(kExactly);
  const Equations equations(problem.linearise());
  MountResult result = result_of(model, equations);

  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  std::size_t bumps = 0, jumps = 0;
  for (const FoundEvent& event : found) {
    const bool bump = event.kind == MountEvent::Kind::kRigBumped;
    const std::vector<Epoch>& epochs = bump ? model.mounts : model.frames;
    const std::size_t i = ++(bump ? bumps : jumps);
    const Pose before = pose_of(epochs[i - 1].pose.data()), after = pose_of(epochs[i].pose.data());
    result.events.push_back({event.kind, event.time + (bump ? model.offset : 0), after * before.inverse(),
                             event.chi2, event.other_chi2});
  }
  remark(result, options, mount_information(equations, options.estimate_time_offset));
  check_stated_offset(model, options, result.diagnostics);
  return result;
}

}  // namespace
}  // namespace mount

MountResult calibrate_mount(const MountData& data, const MountOptions& given) {
  MountOptions options = given;
  if (options.stations) options.estimate_time_offset = false;
  MountData started = mount::with_start_poses(data, options);
  mount::check_poses(started, options);
  const bool unnamed = mount::has_unnamed_planes(started);
  if (unnamed) started = mount::with_plane_names(started, options);
  mount::check_sightings(started, options);
  mount::require_unmistaken(started, options);
  MountResult result = mount::calibrate_started(started, options);
  if (!unnamed) return result;
  return mount::calibrate_started(mount::with_joined_planes(std::move(started), result), options);
}

}  // namespace procam::calibrate
