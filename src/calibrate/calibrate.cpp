#include "procam/calibrate/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/calibrate/uncertainty.hpp"
#include "shape.hpp"
#include "start.hpp"

namespace procam::calibrate {
namespace {

/// The share of residuals that the noise model must account for. A bent board pushes a tenth of its corners
/// far out, again and again in the same place: that is what the board does, not a blunder, so the noise must
/// not be read from the good half alone. Blunders may still be a tenth.
constexpr double kNoiseQuantile = 0.9;
const double kQuantileOfChi2 = -2 * std::log(1 - kNoiseQuantile);  ///< of |r|^2, two unit normal coordinates

std::string px(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f px", value);
  return text;
}

std::string times(double factor) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f times", factor);
  return text;
}

void report(const Options& options, const std::string& step, double share) {
  if (options.progress) options.progress(step, share);
}

void require_consistent(const Correspondences& data) {
  require(!data.devices.empty() && data.devices.front().kind == DeviceKind::kCamera,
          "calibrate: the first device must be a camera");
  const int num_points = int(points_in_board(data.board).size());
  for (const View& view : data.views) {
    require(view.observations.size() == data.devices.size(),
            "calibrate: view '" + view.name + "' must have one list of observations a device");
    for (const auto& observations : view.observations)
      for (const Observation& o : observations)
        require(
            o.point >= 0 && o.point < num_points && o.pixel.allFinite() && o.covariance.allFinite() &&
                o.covariance.determinant() > 0,
            "calibrate: view '" + view.name + "' has an observation that is not finite or not of this board");
    for (const LightPoint& light : view.light_points) {
      const auto is_a = [&](int device, DeviceKind kind) {
        return device >= 0 && device < int(data.devices.size()) &&
               data.devices[std::size_t(device)].kind == kind;
      };
      require(
          is_a(light.projector, DeviceKind::kProjector) && is_a(light.camera, DeviceKind::kCamera) &&
              light.projector_pixel.allFinite() && light.camera_pixel.allFinite() &&
              light.camera_covariance.allFinite() && light.camera_covariance.determinant() > 0,
          "calibrate: view '" + view.name + "' has a light point that is not finite or of no such devices");
    }
  }
}

struct Solution {
  BundleResult bundle;
  UsedMask used;
  BundleOptions options;  ///< with the noise that the residuals showed

  const BundleState& state() const { return bundle.state; }
};

/// Squared length of a residual in the metric of its covariance.
double squared_sigmas(const Vec2& residual, const Mat2& covariance) {
  return residual.dot(covariance.llt().solve(residual));
}

/// The noise model under which the 90 % quantile of the residuals is as long as it should be: a scale below
/// one when the detector is too modest, a floor when it promises more than the model keeps.
ResidualNoise estimate_noise(const std::vector<std::pair<Vec2, Mat2>>& residuals) {
  const auto quantile_under = [&](const ResidualNoise& noise) {
    std::vector<double> squares;
    squares.reserve(residuals.size());
    for (const auto& [residual, covariance] : residuals)
      squares.push_back(squared_sigmas(residual, noise.covariance(covariance)));
    const auto at = squares.begin() + long(kNoiseQuantile * double(squares.size() - 1));
    std::nth_element(squares.begin(), at, squares.end());
    return *at;
  };
  ResidualNoise noise;
  if (residuals.size() < 8) return noise;  // too few to say anything
  const double as_promised = quantile_under(noise);
  if (as_promised <= kQuantileOfChi2) {
    // Perfect data would send the scale to zero and the problem's conditioning with it.
    noise.scale = std::max(std::sqrt(as_promised / kQuantileOfChi2), 1e-6);
    return noise;
  }
  double low = 0, high = 1e-3;
  while (quantile_under({1, high}) > kQuantileOfChi2 && high < 1e4) high *= 2;
  for (int i = 0; i < 40; ++i) {
    noise.floor_px = 0.5 * (low + high);
    (quantile_under(noise) > kQuantileOfChi2 ? low : high) = noise.floor_px;
  }
  return noise;
}

constexpr double kRoughly = 1e-6;

Solution solve(const Correspondences& data, const BundleState& start, const BundleOptions& bundle_options,
               const UsedMask& start_mask, const Options& options) {
  Solution solution;
  solution.used = start_mask;
  solution.bundle.state = start;
  solution.options = bundle_options;
  solution.options.max_iterations = options.max_iterations;
  // Noise and outliers follow from the residuals and the residuals from them: a handful of rounds settles
  // both, and the last of them converges to the end.
  constexpr int kRounds = 6;
  const double tolerance = solution.options.tolerance;
  bool settled = false;
  for (int round = 0; round < kRounds; ++round) {
    report(options, "bundle adjustment", 0.2 + 0.05 * round);
    const bool last = settled || round + 1 == kRounds;
    solution.options.tolerance = last ? tolerance : kRoughly;
    solution.bundle = bundle_adjust(data, solution.used, solution.state(), solution.options);
    if (last) break;

    std::vector<ResidualNoise> noise;
    UsedMask used = start_mask;
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      std::vector<std::pair<Vec2, Mat2>> residuals;
      std::vector<char*> verdicts;
      for (std::size_t v = 0; v < data.views.size(); ++v)
        for (const Measurement& m : measurements_of(data, int(v), int(d))) {
          char& verdict = used[v][d][std::size_t(m.index)];
          if (!verdict) continue;
          const auto residual = reprojection_residual(solution.state(), m);
          const auto covariance = believed_covariance(solution.state(), m);
          verdict = residual && covariance;
          if (!verdict) continue;
          residuals.emplace_back(*residual, *covariance);
          verdicts.push_back(&verdict);
        }
      noise.push_back(estimate_noise(residuals));
      for (std::size_t i = 0; i < residuals.size(); ++i)
        *verdicts[i] = squared_sigmas(residuals[i].first, noise.back().covariance(residuals[i].second)) <=
                       options.outlier_sigmas * options.outlier_sigmas;
    }
    settled = used == solution.used;
    for (std::size_t d = 0; d < noise.size(); ++d) {
      const ResidualNoise& before = solution.options.noise[d];
      settled = settled && std::abs(noise[d].scale - before.scale) < 0.01 * before.scale &&
                std::abs(noise[d].floor_px - before.floor_px) <= 0.01 * before.floor_px + 1e-6;
    }
    solution.used = used;
    solution.options.noise = noise;
  }
  if (!solution.bundle.converged)
    throw Error(ErrorKind::kNotConverged, "bundle adjustment", solution.bundle.report,
                "look for a view of another board or swapped frames, or allow more iterations");
  return solution;
}

/// RMS over the used measurements of one device, all views or one.
double rms_of(const Correspondences& data, const BundleState& state, const UsedMask& used, int device,
              int only_view = -1) {
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (only_view >= 0 && int(v) != only_view) continue;
    for (const Measurement& m : measurements_of(data, int(v), device)) {
      if (!used[v][std::size_t(device)][std::size_t(m.index)]) continue;
      const auto r = reprojection_residual(state, m);
      if (!r) continue;
      sum += r->squaredNorm();
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

/// Error of each device on a view that the solve did not see, its board pose taken from device 0 alone.
void hold_out(const Correspondences& data, const UsedMask& everything, const Solution& full, int view,
              ViewResult& result) {
  UsedMask without = full.used, only = full.used;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if (int(v) == view) std::fill(without[v][d].begin(), without[v][d].end(), char(0));
      if (int(v) != view || d > 0) std::fill(only[v][d].begin(), only[v][d].end(), char(0));
    }
  BundleOptions options = full.options;
  BundleState state = bundle_adjust(data, without, full.state(), options).state;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    options.held[d] = parameter_names(state.lenses[d]);
    options.hold_pose[d] = true;
  }
  options.board_sigma = 0;
  state = bundle_adjust(data, only, state, options).state;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    result.holdout_px.push_back(rms_of(data, state, full.used, int(d), view));
    result.holdout_all_px.push_back(rms_of(data, state, everything, int(d), view));
  }
}

/// The board as printed, or as the views see it.
struct ShapedSolution {
  Correspondences data;  ///< the order of symmetric boards settled
  Solution solution;
  EstimatedShape shape;
  std::vector<int> turned;  ///< views whose order the shape settled
};

/// How much better views must be predicted before 3 numbers a board point are worth their freedom.
constexpr double kShapeGain = 0.95;
constexpr int kViewsForShape = 4;

ShapedSolution solve_with_shape(const Correspondences& data, const Start& start, const Options& options) {
  ShapedSolution flat{data, solve(data, start.state, start.bundle_options, start.used, options), {}, {}};
  const int views = int(std::count(start.view_used.begin(), start.view_used.end(), true));
  // Where the detectors' own covariances explain every residual, nothing is left for a shape to explain.
  bool unexplained = false;
  for (const ResidualNoise& noise : flat.solution.options.noise) unexplained |= noise.floor_px > 0;
  const bool worth_it = views >= kViewsForShape && unexplained;
  if (options.board_shape == BoardShape::kFlat || (options.board_shape == BoardShape::kAuto && !worth_it))
    return flat;

  report(options, "the board's shape", 0.5);
  ShapedSolution free{data, {}, {}, {}};
  BundleState state = flat.solution.state();
  free.turned = settle_order_by_shape(free.data, flat.solution.used, state, flat.solution.options);
  BundleOptions with_shape = flat.solution.options;
  with_shape.board_sigma = board_sigma(points_in_board(data.board));
  free.solution = solve(free.data, state, with_shape, start.used, options);
  free.shape = measure_shape(points_in_board(data.board), free.solution.state().points_in_board);

  UsedMask judged = free.solution.used;
  for (std::size_t v = 0; v < judged.size(); ++v)
    for (std::size_t d = 0; d < judged[v].size(); ++d)
      for (std::size_t i = 0; i < judged[v][d].size(); ++i)
        judged[v][d][i] = judged[v][d][i] || flat.solution.used[v][d][i];
  const auto flat_error =
      predicted_holdout(data, flat.solution.used, judged, flat.solution.state(), flat.solution.options);
  const auto free_error =
      predicted_holdout(free.data, free.solution.used, judged, free.solution.state(), free.solution.options);
  const bool better = flat_error && free_error && *free_error < kShapeGain * *flat_error;
  ShapedSolution& chosen = better || options.board_shape == BoardShape::kFree ? free : flat;
  chosen.shape.holdout_flat_px = flat_error.value_or(0);
  chosen.shape.holdout_free_px = free_error.value_or(0);
  return chosen;
}

/// Covariance of the devices alone, poses as rig_from_device: xi' = -Ad(rig_from_device) xi for the inverse.
NamedCovariance rig_covariance(const NamedCovariance& all, const Correspondences& data,
                               const BundleState& state) {
  std::vector<std::string> names, renamed;
  std::vector<std::pair<Eigen::Index, Mat6>> turns;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const std::string& device = data.devices[d].name;
    for (const std::string& parameter : parameter_names(state.lenses[d]))
      if (all.index_of(device + "." + parameter)) {
        names.push_back(device + "." + parameter);
        renamed.push_back(names.back());
      }
    const std::vector<std::string> pose = pose_increment_names(device + "_from_rig");
    if (!all.index_of(pose.front())) continue;
    turns.emplace_back(Eigen::Index(names.size()), -adjoint(state.device_from_rig[d].inverse()));
    names.insert(names.end(), pose.begin(), pose.end());
    const std::vector<std::string> inverse_pose = pose_increment_names("rig_from_" + device);
    renamed.insert(renamed.end(), inverse_pose.begin(), inverse_pose.end());
  }
  MatX turn = MatX::Identity(Eigen::Index(names.size()), Eigen::Index(names.size()));
  for (const auto& [at, block] : turns) turn.block<6, 6>(at, at) = block;
  const MatX turned = turn * all.block(names) * turn.transpose();
  return {renamed, 0.5 * (turned + turned.transpose())};
}

CalibrationResult describe(const Correspondences& data, const Start& start, const Solution& solution,
                           const BundleCovariance& covariance) {
  const BundleState& state = solution.bundle.state;
  CalibrationResult result;
  result.devices = data.devices;
  result.noise = solution.options.noise;
  result.iterations = solution.bundle.iterations;
  result.converged = solution.bundle.converged;
  result.diagnostics = data.diagnostics;
  result.diagnostics.append(start.diagnostics);

  double joint_sum = 0, joint_sum_all = 0;
  std::size_t joint_count = 0, joint_count_all = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    ViewResult view;
    view.name = data.views[v].name;
    view.rig_from_board = state.rig_from_board[v];
    view.rig_from_board_covariance = covariance.rig_from_board[v];
    view.used = start.view_used[v];
    view.note = start.notes[v];
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      view.rms_px.push_back(rms_of(data, state, solution.used, int(d), int(v)));
      const std::vector<Measurement> measurements = measurements_of(data, int(v), int(d));
      int dropped = 0;
      for (const Measurement& m : measurements) {
        if (!view.used) break;
        Residual residual;
        residual.view = int(v);
        residual.device = int(d);
        residual.point = m.observation != nullptr ? m.observation->point : -1;
        residual.pixel = m.pixel();
        residual.used = solution.used[v][d][std::size_t(m.index)];
        if (const auto r = reprojection_residual(state, m)) {
          residual.residual = *r;
          joint_sum_all += r->squaredNorm();
          ++joint_count_all;
          if (!residual.used) residual.reason = px(r->norm()) + " from its projection";
        } else {
          residual.reason = "behind the lens or beyond its distortion's fold";
        }
        if (residual.used) {
          joint_sum += residual.residual.squaredNorm();
          ++joint_count;
        } else {
          ++dropped;
        }
        result.residuals.push_back(residual);
      }
      if (dropped > 0)
        result.diagnostics.note("outliers", "view " + view.name + ": " + std::to_string(dropped) + " of " +
                                                std::to_string(measurements.size()) + " points of " +
                                                data.devices[d].name + " left out as outliers");
      if (dropped > int(measurements.size()) / 4)
        result.diagnostics.warn(
            "view_disagrees",
            "view " + view.name + " disagrees with the others in " + data.devices[d].name +
                ": the board moved between frames, or its frames belong to another view; capture it again");
    }
    result.views.push_back(view);
  }
  result.joint_rms_px = joint_count > 0 ? std::sqrt(joint_sum / double(joint_count)) : 0;
  result.joint_rms_all_px = joint_count_all > 0 ? std::sqrt(joint_sum_all / double(joint_count_all)) : 0;

  Rig& rig = result.rig;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const Device& device = data.devices[d];
    const Pose rig_from_device = state.device_from_rig[d].inverse();
    if (device.kind == DeviceKind::kCamera)
      rig.cameras.push_back({device.name, state.lenses[d], rig_from_device});
    else
      rig.projectors.push_back({device.name, Projector{state.lenses[d]}, rig_from_device});
    result.rms_px.push_back(rms_of(data, state, solution.used, int(d)));
    result.rms_all_px.push_back(rms_of(data, state, start.used, int(d)));
    rig.quality.rms_px[device.name] = result.rms_px.back();
  }
  rig.quality.views_used = int(std::count(start.view_used.begin(), start.view_used.end(), true));
  return result;
}

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", 1e3 * metres);
  return text;
}

void tell_shape(const ShapedSolution& shaped, CalibrationResult& result) {
  const EstimatedShape& shape = shaped.shape;
  result.shape = shape;
  for (const int v : shaped.turned)
    if (shape.free) {
      std::string& note = result.views[std::size_t(v)].note;
      note +=
          (note.empty() ? "" : "; ") + std::string("order turned by 180 degrees, as the board's shape asked");
    }
  if (shape.free)
    result.diagnostics.note("board_shape",
                            "the board is not flat: its points lie " + millimetres(shape.in_plane_rms) +
                                " along and " + millimetres(shape.out_of_plane_rms) +
                                " off its plane (rms), at most " + millimetres(shape.largest) +
                                "; allowing for it takes the error on views left out from " +
                                px(shape.holdout_flat_px) + " to " + px(shape.holdout_free_px));
}

/// A board that is bent by more than a few sigmas of what a printed sheet does is no board to calibrate with.
constexpr double kLargestBend = 5;

Gate shape_gate(const Correspondences& data, const EstimatedShape& shape) {
  const double limit = kLargestBend * board_sigma(points_in_board(data.board));
  const bool passed = shape.largest <= limit;
  return {
      "board's shape", passed,
      "largest offset " + millimetres(shape.largest) +
          (passed ? ""
                  : ", limit " + millimetres(limit) +
                        ": mount the sheet on a stiff flat plate, and check the square's size both ways")};
}

CalibrationResult run(const Correspondences& given, const std::optional<Camera>& known_camera,
                      const Options& options) {
  require_consistent(given);
  Correspondences ordered = given;
  const Start start = find_start(ordered, known_camera, options);  // settles the order of symmetric boards
  const ShapedSolution shaped = solve_with_shape(ordered, start, options);
  const Correspondences& data = shaped.data;
  const Solution& solution = shaped.solution;
  report(options, "covariance", 0.75);
  const BundleCovariance formal = bundle_covariance(data, solution.used, solution.state(), solution.options);
  const HonestCovariance honest =
      honest_covariance(formal.devices, jackknife(data, solution.used, solution.state(), solution.options),
                        int(std::count(start.view_used.begin(), start.view_used.end(), true)));
  CalibrationResult result = describe(data, start, solution, formal);
  result.rig.covariance = rig_covariance(honest.devices, data, solution.state());
  result.variance_ratio = honest.variance_ratio;
  if (honest.inflated)
    result.diagnostics.note(
        "sigmas_from_views",
        "the views scatter " + times(std::sqrt(honest.variance_ratio)) +
            " as far as their noise explains; the sigmas are those of the views (jackknife)");
  tell_shape(shaped, result);

  if (options.holdout) {
    result.holdout_px.assign(data.devices.size(), 0);
    result.holdout_all_px.assign(data.devices.size(), 0);
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      ViewResult& view = result.views[v];
      if (!view.used) continue;
      report(options, "leaving out view " + data.views[v].name,
             0.8 + 0.2 * double(v) / double(data.views.size()));
      hold_out(data, start.used, solution, int(v), view);
      for (std::size_t d = 0; d < data.devices.size(); ++d) {
        result.holdout_px[d] += view.holdout_px[d] / result.rig.quality.views_used;
        result.holdout_all_px[d] += view.holdout_all_px[d] / result.rig.quality.views_used;
      }
    }
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      result.rig.quality.holdout_px[data.devices[d].name] = result.holdout_px[d];
  }

  result.rig.quality.gates = check_rig(result.rig);
  int behind = 0;  // the board's printed side faces away from the camera: a mirrored order of corners
  for (const ViewResult& view : result.views)
    if (view.used && view.rig_from_board.rotate(Vec3::UnitZ()).dot(view.rig_from_board.translation) <= 0)
      ++behind;
  result.rig.quality.gates.push_back(
      {"boards face the camera", behind == 0,
       behind == 0 ? "all"
                   : std::to_string(behind) +
                         " seen from behind: the order of their corners is mirrored; do not flip images"});
  if (shaped.shape.free) result.rig.quality.gates.push_back(shape_gate(data, shaped.shape));
  for (const Gate& gate : result.rig.quality.gates)
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  report(options, "done", 1);
  return result;
}

}  // namespace

CalibrationResult calibrate_camera(const Correspondences& given, const Options& options) {
  require_consistent(given);
  Correspondences cameras;
  cameras.board = given.board;
  cameras.diagnostics = given.diagnostics;
  for (const View& view : given.views) cameras.views.push_back({view.name, {}});
  for (std::size_t d = 0; d < given.devices.size(); ++d) {
    if (given.devices[d].kind != DeviceKind::kCamera) continue;
    cameras.devices.push_back(given.devices[d]);
    for (std::size_t v = 0; v < given.views.size(); ++v)
      cameras.views[v].observations.push_back(given.views[v].observations[d]);
  }
  return run(cameras, std::nullopt, options);
}

CalibrationResult calibrate_projector(const Correspondences& data, const Camera& known_camera,
                                      const Options& options) {
  require_consistent(data);
  require(known_camera.size == data.devices.front().size,
          "calibrate_projector: the known camera has another image size");
  return run(data, known_camera, options);
}

CalibrationResult calibrate_rig(const Correspondences& data, const Options& options) {
  return run(data, std::nullopt, options);
}

}  // namespace procam::calibrate
