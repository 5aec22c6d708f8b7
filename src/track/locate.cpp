#include "procam/track/locate.hpp"

#include <algorithm>
#include <cmath>

#include "marker_equations.hpp"
#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/planar_pose.hpp"

namespace procam::track {
namespace {

using internal::Problem;
using internal::Sighting;
using internal::State;

std::string ids_of(const std::vector<Sighting>& sightings) {
  std::string text;
  for (const Sighting& s : sightings) text += (text.empty() ? "" : ", ") + std::to_string(s.seen->id);
  return text;
}

std::vector<Sighting> match(const MarkerDetections& detections, const MarkerMap& map) {
  std::vector<Sighting> sightings;
  for (const SeenMarker& marker : detections.markers)
    if (const PlacedMarker* placed = map.find(marker.id)) sightings.push_back({&marker, placed});
  if (!sightings.empty()) return sightings;
  std::string seen;
  for (const SeenMarker& marker : detections.markers)
    seen += (seen.empty() ? "" : ", ") + std::to_string(marker.id);
  throw Error(
      ErrorKind::kNotEnoughData, "markers in the image",
      seen.empty() ? "no marker of the dictionary is found"
                   : "those found (" + seen + ") are not among the given ones",
      "check dictionary and id, focus and light, and that a white rim of one cell is round the marker");
}

/// Both poses of each marker taken alone, as the camera's pose in the world.
std::vector<Pose> candidates(const std::vector<Sighting>& sightings, const Camera& camera) {
  std::vector<Pose> poses;
  for (const Sighting& s : sightings) {
    Points2 on_plane, normalised;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto bearing = camera.unproject(s.seen->corners[i]);
      if (!bearing || !(bearing->z() > 0)) break;
      on_plane.push_back(marker_corners()[i] * s.placed->size);
      normalised.push_back(bearing->head<2>() / bearing->z());
    }
    if (normalised.size() < 4) continue;
    try {
      for (const PlanarPoseSolution& solution : planar_pose(on_plane, normalised).solutions)
        poses.push_back(solution.camera_from_plane * s.placed->world_from_marker.inverse());
    } catch (const Error&) {  // corners on one line: this marker starts nothing
    }
  }
  return poses;
}

/// How far a marker's corners may lie from the fit: noise, the map's sigmas as pixels, and the option.
double tolerance(const Sighting& s, const Camera& camera, const MarkerMap& map, const Pose& camera_from_world,
                 double outlier_px) {
  const double depth = std::max(0.1, (camera_from_world * s.placed->world_from_marker.translation).z());
  const double scale = std::max(camera.intrinsics.fx, camera.intrinsics.fy) / depth;
  const double placed = scale * std::hypot(map.position_sigma, 0.5 * s.placed->size * map.angle_sigma);
  return outlier_px + 3 * std::sqrt(s.seen->covariance.diagonal().maxCoeff() + placed * placed);
}

struct Vote {
  Pose camera_from_world;
  std::vector<bool> agrees;
  std::size_t count = 0;
  double error = 0;  ///< of those that agree, summed
};

/// Pulls a candidate towards the markers that agree with it; who that is sharpens from round to round
/// (Geman-McClure weights with a falling scale).
Vote vote(Problem problem, const MarkerMap& map, Pose pose, const LocateOptions& options) {
  const std::vector<Sighting>& all = problem.sightings;
  problem.corners_only = true;
  const auto limits = [&] {
    std::vector<double> px;
    for (const Sighting& s : all) px.push_back(tolerance(s, problem.camera, map, pose, options.outlier_px));
    return px;
  };
  for (const double widen : {20.0, 8.0, 3.0, 1.0, 1.0}) {
    const std::vector<double> px = limits();
    problem.weights.clear();
    for (std::size_t m = 0; m < all.size(); ++m) {
      const double u = corner_error(problem.camera, all[m], pose) / (widen * px[m]);
      problem.weights.push_back(1 / ((1 + u * u) * (1 + u * u)));
    }
    const auto state = solve(problem, pose);
    if (!state) break;
    pose = state->camera_from_world;
  }
  Vote out{pose, {}, 0, 0};
  const std::vector<double> px = limits();
  for (std::size_t m = 0; m < all.size(); ++m) {
    const double error = corner_error(problem.camera, all[m], pose);
    out.agrees.push_back(error < px[m]);
    if (out.agrees.back()) ++out.count, out.error += error;
  }
  return out;
}

/// The markers that agree with each other, as a majority of those seen.
std::vector<bool> majority(const Problem& problem, const MarkerMap& map, const std::vector<Pose>& starts,
                           const LocateOptions& options) {
  const std::size_t seen = problem.sightings.size();
  if (seen == 1) return {true};
  std::optional<Vote> best;
  for (const Pose& start : starts) {
    const Vote next = vote(problem, map, start, options);
    if (!best || next.count > best->count || (next.count == best->count && next.error < best->error))
      best = next;
  }
  if (best && best->count >= 2 && 2 * best->count > seen) return best->agrees;
  throw Error(ErrorKind::kDegenerate, "markers " + ids_of(problem.sightings),
              "they contradict the map, and no majority of them agrees: one was moved, or the map holds a "
              "wrong size, place or orientation",
              "measure them again, or locate with one marker at a time to see which one is off");
}

bool distinct(const State& a, const State& b) {
  return se3_log(a.camera_from_world * b.camera_from_world.inverse()).norm() > 1e-4;
}

/// All local minima that the starts lead to, best first.
std::vector<State> minima(const Problem& problem, const std::vector<Pose>& starts) {
  Problem coarse = problem;
  coarse.corners_only = true;
  std::vector<State> found;
  const auto add = [](std::vector<State>& list, const std::optional<State>& state) {
    if (!state) return;
    for (const State& other : list)
      if (!distinct(other, *state)) return;
    list.push_back(*state);
  };
  std::vector<State> rough;
  for (const Pose& start : starts) add(rough, solve(coarse, start));
  for (const State& start : rough) add(found, solve(problem, start.camera_from_world));
  std::sort(found.begin(), found.end(), [](const State& a, const State& b) { return a.cost < b.cost; });
  return found;
}

/// How firmly the stated variances are believed, in degrees of freedom: two residuals of one small marker do
/// not show that they are twice as large (the mean of a scaled inverse chi-square prior).
constexpr double kBelief = 8;

Mat6 covariance_of(const State& state, double scale) {
  const Mat6 covariance = scale * Cholesky(state.information).inverse();
  return 0.5 * (covariance + covariance.transpose());
}

/// What to do about two poses, for the view at hand.
std::string against_second_pose(const Problem& problem, const Pose& camera_from_world) {
  double steepest = 0;
  std::string coarse;
  for (const Sighting& s : problem.sightings) {
    const Pose camera_from_marker = camera_from_world * s.placed->world_from_marker;
    const double cosine =
        camera_from_marker.rotate(Vec3::UnitZ()).dot(camera_from_marker.translation.normalized());
    steepest = std::max(steepest, std::acos(std::clamp(cosine, -1.0, 1.0)));
    if (s.seen->coarse) coarse += (coarse.empty() ? "" : ", ") + std::to_string(s.seen->id);
  }
  std::string next;
  if (!coarse.empty())
    next = "marker " + coarse +
           " is too small or blurred for its edges (marker_coarse): go closer, focus, or print it larger";
  else if (steepest < 20 * kDegree)
    next = "look at the marker from the side (20 to 60 degrees; now " + fixed(steepest / kDegree, 0) +
           ") or from closer";
  else
    next = "go closer or print the marker larger (the view from the side, " + fixed(steepest / kDegree, 0) +
           " degrees, is good)";
  return next + ", or add a marker in another plane";
}

/// The second pose and its odds, where the covariance of the first does not already span both.
void weigh_second(const std::vector<State>& states, double scale, const Problem& problem,
                  const LocateOptions& options, LocateResult& result) {
  if (states.size() < 2) return;
  const Vec6 between = se3_log(states[1].camera_from_world * states[0].camera_from_world.inverse());
  constexpr double kFiveSigmas2 = 25;
  if (between.dot(states[0].information * between) < kFiveSigmas2 * scale) return;
  result.other_chi2 = (states[1].cost - states[0].cost) / scale;
  const double ratio = std::exp(-0.5 * result.other_chi2);
  result.other = states[1].camera_from_world;
  result.other_covariance = covariance_of(states[1], scale);
  result.other_odds = ratio / (1 + ratio);
  const double degrees = between.head<3>().norm() / kDegree;
  const std::string next = against_second_pose(problem, states[0].camera_from_world);
  if (result.other_odds > options.largest_odds)
    throw Error(ErrorKind::kDegenerate, "pose from the markers",
                "a second pose, turned by " + fixed(degrees, 1) + " degrees, fits almost as well (odds " +
                    fixed(100 * result.other_odds, 1) +
                    " %): a plane seen from afar looks the same tilted either "
                    "way",
                next);
  if (result.other_odds > 1e-3)
    result.diagnostics.warn("second_pose", "a second pose, turned by " + fixed(degrees, 1) +
                                               " degrees, has odds of " + fixed(100 * result.other_odds, 2) +
                                               " %; to exclude it " + next);
}

/// All sightings, those that agree in the order of the problem's.
void list_markers(const Problem& problem, const std::vector<Sighting>& all, const std::vector<bool>& agrees,
                  const State& best, LocateResult& result) {
  for (std::size_t m = 0, used = 0; m < all.size(); ++m) {
    LocatedMarker marker{all[m].seen->id, agrees[m], 0,
                         corner_error(problem.camera, all[m], best.camera_from_world), ""};
    const std::string name = "marker " + std::to_string(marker.id);
    if (agrees[m]) {
      marker.edge_rms_px = edge_error(problem, best, used++);
      if (all[m].seen->coarse)
        result.diagnostics.warn("marker_coarse", name +
                                                     " is too small or blurred for its edges: its corners "
                                                     "alone are used; go closer, focus, or print it larger");
    } else {
      marker.reason = "its corners lie " + fixed(marker.error_px, 1) + " px from where the others put it";
      result.diagnostics.warn("marker_left_out",
                              name + " is rejected: " + marker.reason +
                                  "; it was moved, or its place or size in the map is wrong");
    }
    result.markers.push_back(marker);
  }
}

/// Residuals against their sigmas. A sheet or a map that is slightly off gives a few times; a wrong camera more.
void judge_fit(const MarkerMap& map, LocateResult& result) {
  constexpr double kSurprising = 2, kWrongCamera = 8;
  const double factor = std::sqrt(result.chi2_per_dof);
  const std::string misfit = "the edges miss the fit by " + fixed(factor, 1) + " times what the image" +
                             (map.markers.size() > 1 ? " and the map's sigmas promise" : " promises");
  if (factor > kWrongCamera)
    result.diagnostics.fail(
        "map_disagrees",
        misfit +
            ": the pose and its sigmas are not usable. The image is rotated, cropped or zoomed (digital zoom), or "
            "the rig has another camera or lens; give an image as the rig's camera takes it, and that camera's rig. "
            "Otherwise check the markers' sizes and the map, and flatten the sheets");
  else if (factor > kSurprising)
    result.diagnostics.warn("map_disagrees", misfit +
                                                 ": a curled sheet, another lens, a size or place that is "
                                                 "off; the stated sigmas are enlarged");
}

}  // namespace

LocateResult locate(const MarkerDetections& detections, const Camera& camera, const MarkerMap& map,
                    const LocateOptions& options) {
  require(detections.image_size == camera.size, "locate: the image's size is not the camera's");
  require(map.position_sigma >= 0 && map.angle_sigma >= 0, "locate: the map's sigmas are negative");
  for (const PlacedMarker& placed : map.markers)
    require(placed.size > 0, "locate: a marker's size is not positive");

  Problem problem;
  problem.camera = camera;
  problem.sightings = match(detections, map);
  problem.map_sigma << Vec3::Constant(map.angle_sigma), Vec3::Constant(map.position_sigma);
  // The frame of a single marker is the world itself: it cannot be misplaced.
  if (map.markers.size() == 1) problem.map_sigma.setZero();

  const std::vector<Sighting> all = problem.sightings;
  std::vector<Pose> starts = candidates(all, camera);
  const std::vector<bool> agrees = majority(problem, map, starts, options);
  problem.sightings.clear();
  for (std::size_t m = 0; m < all.size(); ++m)
    if (agrees[m]) problem.sightings.push_back(all[m]);
  starts = candidates(problem.sightings, camera);

  const std::vector<State> states = minima(problem, starts);
  if (states.empty())
    throw Error(ErrorKind::kNotConverged, "pose from the markers " + ids_of(problem.sightings),
                "no pose explains their edges", "check that the rig's camera is the one that took the image");
  const State& best = states.front();

  LocateResult result;
  result.camera_from_world = best.camera_from_world;
  const int freedom = problem.freedom();
  result.chi2_per_dof = best.cost / freedom;
  const double scale = std::max(1.0, (best.cost + kBelief) / (freedom + kBelief));
  weigh_second(states, scale, problem, options, result);
  result.covariance = covariance_of(best, scale);
  result.jacobian_lens = sensitivity_to_lens(problem, best);

  list_markers(problem, all, agrees, best, result);
  judge_fit(map, result);
  return result;
}

Chain projector_chain(const Rig& rig, const RigProjector& projector, const RigCamera& camera,
                      const LocateResult& seen) {
  const std::vector<std::string> of_lens = parameter_names(camera.camera);
  std::vector<std::string> names;
  for (const std::string& parameter : of_lens) names.push_back(camera.name + "." + parameter);
  const auto lens = Eigen::Index(names.size());
  for (const std::string& device : {camera.name, projector.name})
    for (const std::string& name : pose_increment_names("rig_from_" + device)) names.push_back(name);
  const MatX covariance = rig.covariance.block(names);
  require(seen.jacobian_lens.rows() == 6 && seen.jacobian_lens.cols() == lens,
          "projector_chain: the camera is not the one that located the markers");

  // Increments to first order: of projector_from_camera Ad(projector_from_rig) (xi_camera - xi_projector), of
  // camera_from_world by_lens * lens, and of their product the first plus Ad(projector_from_camera) the
  // second.
  const Pose projector_from_rig = projector.rig_from_projector.inverse();
  const Pose projector_from_camera = projector_from_rig * camera.rig_from_camera;
  const Mat6 to_projector = adjoint(projector_from_rig), onwards = adjoint(projector_from_camera);
  MatX by_rig = MatX::Zero(6, lens + 12), by_lens = MatX::Zero(6, lens + 12);
  by_rig.middleCols<6>(lens) = to_projector;
  by_rig.rightCols<6>() = -to_projector;
  by_lens.leftCols(lens) = seen.jacobian_lens;
  const MatX by_all = by_rig + onwards * by_lens;
  const auto through = [&](const MatX& by) {
    const Mat6 spread = by * covariance * by.transpose();
    return Mat6(0.5 * (spread + spread.transpose()));
  };

  Chain chain;
  chain.links = {{projector.name, camera.name, {projector_from_camera, through(by_rig)}},
                 {camera.name, "world", {seen.camera_from_world, seen.covariance + through(by_lens)}}};
  chain.total = {projector.name,
                 "world",
                 {projector_from_camera * seen.camera_from_world,
                  onwards * seen.covariance * onwards.transpose() + through(by_all)}};
  return chain;
}

}  // namespace procam::track
