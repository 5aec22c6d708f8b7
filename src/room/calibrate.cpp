#include "procam/room/calibrate_room.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/parallel.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "route.hpp"

namespace procam::room {

std::optional<Vec3> place(const RoomPoints& points, const RoomState& state, int index) {
  const RoomPoint& point = points.points[std::size_t(index)];
  const double w = state.inverse_depth[std::size_t(index)];
  const int position = points.maps[std::size_t(point.readings[0].map)].position;
  const auto bearing = state.lenses[std::size_t(points.positions[std::size_t(position)].camera)].unproject(
      point.readings[0].camera_pixel);
  if (!std::isfinite(w) || !bearing || !(bearing->z() > 0)) return std::nullopt;
  return state.rig_from_device[std::size_t(position)] * Vec3(*bearing / (bearing->z() * w));
}

RoomCalibration Route::run() {
  check_names();
  state_ = start();
  prepare();
  for (int round = 0; round < 3; ++round) {
    adjustment_->used = evenly_by_map(points_, adjustment_->used);
    adjustment_->solve(state_);
    reject();
  }
  fit_without_loss();
  check_fit();
  find_covariance();
  measure_parallax();
  measure_flatness();
  if (check_sheets()) check_stated_lenses();
  find_scale();
  measure_walls();
  refuse_uncertain();
  check_unstated_lenses();
  fill_rig();
  judge_regions();
  add_remarks();
  return std::move(result_);
}

void Route::check_names() const {
  const auto known = [](const std::vector<Device>& devices, const std::string& name) {
    return std::any_of(devices.begin(), devices.end(), [&](const Device& d) { return d.name == name; });
  };
  const auto require_known = [&](const std::vector<Device>& devices, const std::string& name,
                                 const char* what) {
    if (!known(devices, name))
      throw Error(ErrorKind::kInput, std::string(what) + " '" + name + "'",
                  "the session has none of that name",
                  "name one of: " + comma_list(devices, [](const Device& d) { return d.name; }));
  };
  for (const auto& [name, lens] : options_.cameras) require_known(points_.cameras, name, "known camera");
  for (const auto& [name, sheet] : options_.projectors) require_known(points_.projectors, name, "projector");
  for (const auto& [name, sheet] : options_.camera_sheets) {
    require_known(points_.cameras, name, "camera");
    require(sheet.focal_px.value > 0 && sheet.focal_px.sigma > 0,
            "calibrate_room: a camera's stated focal length needs a value and a deviation above zero");
  }
  require(!options_.distances.empty() || !options_.targets.empty(), "calibrate_room: no known distance");
  for (const KnownDistance& distance : options_.distances) {
    require(distance.length > 0 && distance.sigma >= 0 &&
                (distance.points.size() == 2) != (distance.devices.size() == 2),
            "calibrate_room: a known distance needs a length, and two points or two devices");
    for (const std::string& name : distance.devices)
      if (!known(points_.cameras, name)) require_known(points_.projectors, name, "device");
  }
}

RoomState Route::start() const {
  const RoomPoints part =
      part_of(points_, evenly_by_map(points_, std::vector<char>(points_.points.size(), 1)));
  if (part.points.size() == points_.points.size()) return start_with(points_);
  RoomState state;
  try {
    state = start_with(part);
  } catch (const Error&) {
    return start_with(points_);  // devices that share few points may need them all
  }
  state.inverse_depth.resize(points_.points.size());
  Adjustment depths(points_, {});
  parallel_for(int(points_.points.size()), options_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      if (depths.start_depth(state, i)) depths.refine_depth(state, i);
  });
  return state;
}

RoomState Route::start_with(const RoomPoints& points) const {
  if (plan_.cameras_known) return start_room(points, plan_, options_.threads).state;
  std::optional<Started> best;
  std::optional<Error> problem;
  // As far as two deviations of what is known of each focal length.
  constexpr double kStride = 0.15;
  std::vector<double> reach(points_.cameras.size(), 0);
  for (std::size_t c = 0; c < reach.size(); ++c)
    if (plan_.guess[c]) reach[c] = std::clamp(2 * plan_.guess[c]->focal_sigma, 0.0, 5 * kStride);
  const int steps =
      std::max(2, int(std::ceil(*std::max_element(reach.begin(), reach.end()) / kStride - 1e-9)));
  for (int step = -steps; step <= steps; ++step) {
    LensPlan plan = plan_;
    for (std::size_t c = 0; c < points_.cameras.size(); ++c)
      if (plan.guess[c])
        plan.lenses[c].intrinsics.fx = plan.lenses[c].intrinsics.fy *= std::exp(reach[c] * step / steps);
    try {
      Started trial = start_room(points, plan, options_.threads);
      if (!best || trial.merit < best->merit) best = std::move(trial);
    } catch (const Error& error) {
      problem = error;
    }
  }
  if (!best) throw *problem;
  return best->state;
}

void Route::prepare() {
  // A known lens of stated deviation has begun where it is stated.
  std::vector<char> uncertain = known_lenses(false);
  for (std::size_t lens = 0; lens < uncertain.size(); ++lens)
    uncertain[lens] = uncertain[lens] && plan_.free[lens][0];
  if (any(uncertain)) {
    std::vector<char> usable;
    for (const double w : state_.inverse_depth) usable.push_back(std::isfinite(w));
    state_ = along_focal_length(points_, plan_, uncertain, state_, usable, options_.threads);
  }
  AdjustOptions options;
  options.free = plan_.free;
  options.known = knowledge_at(plan_, state_);
  options.threads = options_.threads;
  options.max_iterations = 60;
  adjustment_.emplace(points_, options);
  for (int i = 0; i < int(points_.points.size()); ++i) {
    if (!std::isfinite(state_.inverse_depth[std::size_t(i)])) adjustment_->start_depth(state_, i);
    adjustment_->used[std::size_t(i)] = !held_out(i) && adjustment_->fit(state_, i).freedom > 0;
  }
}

void Route::reject() {
  const double scale = adjustment_->scatter(state_);
  for (int i = 0; i < int(points_.points.size()); ++i) {
    if (held_out(i)) continue;
    if (!adjustment_->used[std::size_t(i)]) {  // rejected by an earlier fit
      if (!std::isfinite(state_.inverse_depth[std::size_t(i)])) adjustment_->start_depth(state_, i);
      adjustment_->refine_depth(state_, i);
    }
    const PointFit fit = adjustment_->fit(state_, i);
    const double limit = options_.outlier_sigmas * scale;
    adjustment_->used[std::size_t(i)] = fit.freedom > 0 && fit.square < limit * limit * fit.freedom;
  }
}

void Route::fit_without_loss() {
  AdjustOptions options;
  options.free = plan_.free;
  options.known = knowledge_at(plan_, state_);
  options.threads = options_.threads;
  options.robust_sigmas = 0;
  const std::vector<char> used = adjustment_->used;
  adjustment_.emplace(points_, options);
  adjustment_->used = used;
  adjustment_->solve(state_);
  double square = 0;
  int freedom = 0;
  double pixels = 0;
  int rows = 0;
  for (int i = 0; i < int(points_.points.size()); ++i) {
    if (held_out(i)) continue;
    const PointFit fit = adjustment_->fit(state_, i);
    if (!adjustment_->used[std::size_t(i)]) {
      ++result_.outliers;
      continue;
    }
    ++result_.points;
    square += fit.square;
    freedom += fit.freedom;
    pixels += fit.square * mean_variance(i);
    rows += fit.freedom;
  }
  result_.scatter = freedom > 0 ? std::sqrt(square / freedom) : 0;
  result_.rms_px = rows > 0 ? std::sqrt(pixels / rows) : 0;
}

double Route::mean_variance(int point) const {
  double sum = 0;
  for (const LightReading& reading : points_.points[std::size_t(point)].readings)
    sum += reading.sigma.squaredNorm() / 2;
  return sum / double(points_.points[std::size_t(point)].readings.size());
}

void Route::check_fit() const {
  refuse_if_turned_only(points_, plan_);
  const int all = result_.points + result_.outliers;
  const bool few = result_.points < all / 3;
  if (result_.points >= 50 && !few && result_.rms_px < options_.max_rms_px) return;
  throw Error(
      ErrorKind::kNotConverged, "the room's light",
      few ? "no rig explains it: " + std::to_string(result_.outliers) + " of " + std::to_string(all) +
                " points are off"
          : "no rig explains it: it is off by " + px(result_.rms_px) + " of the projector (RMS)",
      "check that the camera's lens is the one of these captures (zoom, resolution), that --projector-size is the "
      "display's own, and that the projectors did not move between the views");
}

void Route::find_covariance() {
  layout_ = adjustment_->layout(state_);
  covariance_ = adjustment_->covariance(state_, layout_, std::max(1e-6, result_.scatter));
}

RoomCalibration calibrate_room(const RoomPoints& points, const RoomOptions& options) {
  require(!points.points.empty() && !points.maps.empty(), "calibrate_room: no points");
  constexpr std::size_t kFewest = 100;
  if (points.points.size() < kFewest)
    throw Error(
        ErrorKind::kNotEnoughData, "the room's light",
        std::to_string(points.points.size()) + " points are read, " + std::to_string(kFewest) + " are needed",
        "darken the room, raise the camera's exposure, and see that it looks at the projected picture");
  return options.camera_sheets.empty() ? Route(points, options).run()
                                       : calibrate_with_sheets(points, options);
}

}  // namespace procam::room
