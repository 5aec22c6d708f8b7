#include "procam/room/calibrate_room.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "adjust.hpp"
#include "lens_check.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "start.hpp"
#include "target.hpp"

namespace procam::room {
namespace {

constexpr int kHeldOutEvery = 10;
constexpr int kGroupColumns = 10, kGroupRows = 8;

/// The point in the rig's frame, by the state's own length.
std::optional<Vec3> place(const RoomPoints& points, const RoomState& state, int index) {
  const RoomPoint& point = points.points[std::size_t(index)];
  const double w = state.inverse_depth[std::size_t(index)];
  const int position = points.maps[std::size_t(point.readings[0].map)].position;
  const auto bearing = state.lenses[std::size_t(points.positions[std::size_t(position)].camera)].unproject(
      point.readings[0].camera_pixel);
  if (!std::isfinite(w) || !bearing || !(bearing->z() > 0)) return std::nullopt;
  return state.rig_from_device[std::size_t(position)] * Vec3(*bearing / (bearing->z() * w));
}

class Route {
 public:
  Route(const RoomPoints& points, const RoomOptions& options)
      : points_(points), options_(options), plan_(plan_lenses(points, options)) {}

  RoomCalibration run() {
    check_names();
    state_ = start();
    prepare();
    for (int round = 0; round < 3; ++round) {
      adjustment_->solve(state_);
      reject();
    }
    fit_without_loss();
    check_fit();
    find_covariance();
    measure_parallax();
    measure_flatness();
    check_stated_lenses();
    find_scale();
    measure_walls();
    refuse_uncertain();
    check_unstated_lenses();
    fill_rig();
    judge_regions();
    add_remarks();
    return std::move(result_);
  }

 private:
  int positions() const { return int(points_.positions.size()); }
  bool held_out(int point) const { return point % kHeldOutEvery == kHeldOutEvery / 2; }

  void check_names() const {
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
    for (const auto& [name, sheet] : options_.projectors)
      require_known(points_.projectors, name, "projector");
    require(!options_.distances.empty() || !options_.targets.empty(), "calibrate_room: no known distance");
    for (const KnownDistance& distance : options_.distances) {
      require(distance.length > 0 && distance.sigma >= 0 &&
                  (distance.points.size() == 2) != (distance.devices.size() == 2),
              "calibrate_room: a known distance needs a length, and two points or two devices");
      for (const std::string& name : distance.devices)
        if (!known(points_.cameras, name)) require_known(points_.projectors, name, "device");
    }
  }

  /// With cameras whose lens is not known: by the focal length that explains the light best.
  RoomState start() const {
    if (plan_.cameras_known) return start_room(points_, plan_, options_.threads).state;
    std::optional<Started> best;
    std::optional<Error> problem;
    for (int step = -5; step <= 5; ++step) {
      LensPlan plan = plan_;
      for (std::size_t c = 0; c < points_.cameras.size(); ++c)
        if (plan.guess[c])
          plan.lenses[c].intrinsics.fx = plan.lenses[c].intrinsics.fy *= std::exp(0.15 * step);
      try {
        Started trial = start_room(points_, plan, options_.threads);
        if (!best || trial.merit < best->merit) best = std::move(trial);
      } catch (const Error& error) {
        problem = error;
      }
    }
    if (!best) throw *problem;
    return best->state;
  }

  void prepare() {
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

  void reject() {
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

  void fit_without_loss() {
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

  double mean_variance(int point) const {
    double sum = 0;
    for (const LightReading& reading : points_.points[std::size_t(point)].readings)
      sum += reading.sigma.squaredNorm() / 2;
    return sum / double(points_.points[std::size_t(point)].readings.size());
  }

  void check_fit() const {
    const int all = result_.points + result_.outliers;
    const bool few = result_.points < all / 3;
    if (result_.points >= 50 && !few && result_.rms_px < options_.max_rms_px) return;
    refuse_if_turned_only(points_, plan_);
    throw Error(
        ErrorKind::kNotConverged, "the room's light",
        few ? "no rig explains it: " + std::to_string(result_.outliers) + " of " + std::to_string(all) +
                  " points are off"
            : "no rig explains it: it is off by " + px(result_.rms_px) + " of the projector (RMS)",
        "check that the camera's lens is the one of these captures (zoom, resolution), that --projector-size is the "
        "display's own, and that the projectors did not move between the views");
  }

  std::vector<int> groups() const {
    std::vector<int> group;
    for (const RoomPoint& point : points_.points) {
      const LightReading& anchor = point.readings[0];
      const int position = points_.maps[std::size_t(anchor.map)].position;
      const ImageSize size =
          points_.cameras[std::size_t(points_.positions[std::size_t(position)].camera)].size;
      const int column = std::clamp(int(kGroupColumns * anchor.camera_pixel.x() / size.width), 0,
                                    kGroupColumns - 1),
                row = std::clamp(int(kGroupRows * anchor.camera_pixel.y() / size.height), 0, kGroupRows - 1);
      group.push_back((anchor.map * kGroupRows + row) * kGroupColumns + column);
    }
    return group;
  }

  void measure_parallax() {
    std::vector<double> angles;
    for (int i = 0; i < int(points_.points.size()); ++i) {
      if (!adjustment_->used[std::size_t(i)]) continue;
      const std::optional<Vec3> at = place(points_, state_, i);
      if (!at) continue;
      std::vector<Vec3> from;
      for (const LightReading& reading : points_.points[std::size_t(i)].readings) {
        const MapDevices& map = points_.maps[std::size_t(reading.map)];
        for (const int pose : {map.position, positions() + map.projector})
          from.push_back((state_.rig_from_device[std::size_t(pose)].translation - *at).normalized());
      }
      double largest = 0;
      for (const Vec3& a : from)
        largest = std::max(largest, std::atan2(a.cross(from[0]).norm(), a.dot(from[0])));
      angles.push_back(largest);
    }
    result_.parallax = median_or(angles, 0.0);
  }

  void find_covariance() {
    layout_ = adjustment_->layout(state_);
    covariance_ =
        adjustment_->covariance(state_, layout_, groups(), group_count(), std::max(1e-6, result_.scatter));
  }
  int group_count() const { return int(points_.maps.size()) * kGroupColumns * kGroupRows; }

  // ---- known lenses

  std::vector<char> known_lenses(bool unstated) const {
    std::vector<char> chosen(plan_.lenses.size(), 0);
    for (std::size_t lens = 0; lens < chosen.size(); ++lens)
      chosen[lens] = !plan_.guess[lens] && (plan_.unstated[lens] != 0) == unstated;
    return chosen;
  }
  static bool any(const std::vector<char>& chosen) {
    return std::find(chosen.begin(), chosen.end(), 1) != chosen.end();
  }
  PointsInUse in_use() const { return {adjustment_->used, groups(), group_count(), result_.scatter}; }

  std::string disagreement_words(const LensDisagreement& disagrees) const {
    const Camera& known = plan_.lenses[std::size_t(disagrees.lens)];
    const double corner = known.intrinsics.normalized_from_pixel(Vec2(-0.5, -0.5)).squaredNorm();
    const int i = disagrees.parameter;
    const double unit = i < 4 ? 1 : known.intrinsics.fx * std::pow(corner, i == 5 ? 1.5 : 2.5);
    return "camera '" + points_.cameras[std::size_t(disagrees.lens)].name +
           "': the light of the room puts its " +
           (i == 0   ? "focal length "
            : i == 2 ? "principal point (x) "
            : i == 3 ? "principal point (y) "
                     : "distortion in the corner ") +
           fixed(disagrees.off * unit, 1) + " px (+-" + significant(disagrees.sigma * unit, 2) +
           ") from the known lens";
  }

  /// The light of several positions tells a camera's lens as well, though less exactly than a board: does it agree?
  void check_stated_lenses() {
    const std::vector<char> stated = known_lenses(false);
    if (positions() < 2 || result_.planar || !any(stated)) return;
    const FreedRig rig =
        free_lenses(points_, widened(plan_, stated), stated, state_, in_use(), options_.threads);
    if (const auto disagrees = disagreement(plan_, rig, stated))
      result_.diagnostics.fail(
          "known_lens_disagrees",
          disagreement_words(*disagrees) +
              "; check that --known-camera is this camera at this zoom, focus and resolution");
  }

  /// A lens of which nothing is stated: kept where the light agrees, else estimated. What the light leaves open is part
  /// of the covariance.
  void check_unstated_lenses() {
    const std::vector<char> unstated = known_lenses(true);
    if (!any(unstated)) return;
    const double by_given = result_.wall_sigma;
    const LensPlan wide = widened(plan_, unstated);
    const bool trusted = positions() > 1 && !result_.planar;
    const FreedRig rig = trusted ? free_lenses(points_, wide, unstated, state_, in_use(), options_.threads)
                                 : open_lenses(points_, wide, state_, in_use(), options_.threads);
    const auto disagrees = trusted ? disagreement(plan_, rig, unstated) : std::nullopt;
    if (disagrees) {
      const std::string words = disagreement_words(*disagrees);
      plan_ = wide;
      state_ = rig.state;
      result_.outliers = result_.points = 0;
      reject();
      fit_without_loss();
      check_fit();
      find_covariance();
      result_.diagnostics.warn("known_lens_disagrees",
                               words +
                                   ", of which no deviation is stated: the light's own estimate is in use; "
                                   "calibrate the camera by calibrate-camera for a more certain result");
    } else {
      covariance_ =
          trusted ? kept_covariance(rig, state_) : considered_covariance(wide, rig, layout_, covariance_);
      layout_ = rig.layout;
    }
    find_scale();
    measure_walls();
    if (disagrees) return refuse_uncertain();
    constexpr double kMaterial = 2;
    if (!(result_.wall_sigma > kMaterial * by_given)) return;
    const std::string words =
        "no deviation is stated of a known camera's lens, and the light determines it no better: taken as a data "
        "sheet's (10 % of the focal length), it leaves the walls uncertain by " +
        mm(result_.wall_sigma) + ", as an exact lens by " + mm(by_given) +
        "; give a calibrate-camera result, or --lens-sigma";
    if (result_.wall_sigma_share < options_.max_wall_sigma)
      result_.diagnostics.note("lens_unchecked", words);
    else
      result_.diagnostics.warn("lens_unchecked", words);
  }

  /// Is this position where the rig has its camera?
  bool is_in_rig(int position) const {
    return first_position(
               points_.cameras[std::size_t(points_.positions[std::size_t(position)].camera)].name) ==
           position;
  }

  // ---- scale

  /// A known distance by the state's own length, the points' depths at their minimum.
  std::optional<double> modelled(const KnownDistance& distance, RoomState& state) const {
    if (!distance.devices.empty())
      return (pose_of(distance.devices[0], state).translation -
              pose_of(distance.devices[1], state).translation)
          .norm();
    Vec3 at[2];
    for (int k = 0; k < 2; ++k) {
      const int point = distance.points[std::size_t(k)];
      if (!std::isfinite(state.inverse_depth[std::size_t(point)])) adjustment_->start_depth(state, point);
      if (!adjustment_->refine_depth(state, point)) return std::nullopt;
      const std::optional<Vec3> found = place(points_, state, point);
      if (!found) return std::nullopt;
      at[k] = *found;
    }
    return (at[0] - at[1]).norm();
  }

  const Pose& pose_of(const std::string& name, const RoomState& state) const {
    for (std::size_t p = 0; p < points_.projectors.size(); ++p)
      if (points_.projectors[p].name == name) return state.rig_from_device[std::size_t(positions()) + p];
    return state.rig_from_device[std::size_t(first_position(name))];
  }
  int first_position(const std::string& camera) const {
    for (int i = 0; i < positions(); ++i)
      if (points_.cameras[std::size_t(points_.positions[std::size_t(i)].camera)].name == camera) return i;
    return 0;
  }

  /// Something of known length, by the state's own length.
  struct KnownLength {
    double length = 0, relative_variance = 0;
    std::function<std::optional<double>(RoomState&)> modelled;
  };

  KnownLength known_length(const KnownDistance& distance) const {
    RoomState state = state_;
    const std::optional<double> here = modelled(distance, state);
    if (!here || !(*here > 1e-6))
      throw Error(ErrorKind::kDegenerate, "the known distance",
                  "its two ends are in one place, or have no depth",
                  "measure between two points of the walls that are far apart");
    double variance = std::pow(distance.sigma / distance.length, 2);
    for (const int point : distance.points) {  // the light's own noise at the point
      RoomState other = state;
      const auto gradient = adjustment_->depth_gradient(state, layout_, point, false);
      if (!gradient) continue;
      other.inverse_depth[std::size_t(point)] *= 1 + 1e-4;
      const double by = (distance_between(distance, other) / *here - 1) / 1e-4;
      variance += std::pow(by * gradient->noise * result_.scatter, 2);
    }
    return {distance.length, variance, [&](RoomState& moved) { return modelled(distance, moved); }};
  }

  KnownLength known_length(const KnownTarget& target) const {
    const std::optional<SeenTarget> seen = see_target(points_, state_, target);
    if (!seen)
      throw Error(ErrorKind::kNotEnoughData, target.name,
                  "fewer than two camera positions see the same points of it",
                  "let it stand still where two camera positions or more see it");
    double sigma = 0;
    for (const KnownTarget::View& view : target.views) sigma = std::max(sigma, view.sigma);
    // Points of a marker that stood still meet to their noise, the rig's own error included.
    constexpr double kMovedPx = 2, kMovedSigmas = 8;
    if (seen->rms_px > std::max(kMovedPx, kMovedSigmas * sigma))
      throw Error(ErrorKind::kInput, target.name,
                  "the camera positions see it " + px(seen->rms_px) + " apart: it moved between the views",
                  "let it stand still from the first view to the last");
    const Points3 places = seen->places;
    return {extent(places), size_variance(points_, state_, target),
            [this, &target](RoomState& moved) -> std::optional<double> {
              const std::optional<SeenTarget> other = see_target(points_, moved, target);
              return other ? std::optional<double>(extent(other->points)) : std::nullopt;
            }};
  }

  /// log(scale) = value + by_parameters . (change of the parameters) + noise.
  void find_scale() {
    scale_by_parameters_ = VecX::Zero(layout_.size);
    double weights = 0, sum = 0;
    std::vector<std::pair<double, double>> logs;
    std::vector<KnownLength> lengths;
    for (const KnownDistance& distance : options_.distances) lengths.push_back(known_length(distance));
    for (const KnownTarget& target : options_.targets) lengths.push_back(known_length(target));
    for (const KnownLength& known : lengths) {
      RoomState state = state_;
      const double here = *known.modelled(state);
      const double variance = std::max(known.relative_variance, 1e-16);
      const double value = std::log(known.length / here), weight = 1 / variance;
      logs.emplace_back(value, variance);
      weights += weight;
      sum += weight * value;
      for (int i = 0; i < layout_.size; ++i) {
        const double step = 0.1 * std::sqrt(std::max(covariance_(i, i), 1e-24));
        VecX move = VecX::Zero(layout_.size);
        move[i] = step;
        RoomState up = adjustment_->moved(state, layout_, move),
                  down = adjustment_->moved(state, layout_, -move);
        const auto above = known.modelled(up), below = known.modelled(down);
        if (above && below)
          scale_by_parameters_[i] -= weight * (std::log(*above) - std::log(*below)) / (2 * step);
      }
    }
    scale_by_parameters_ /= weights;
    scale_variance_ = 1 / weights;
    scale_ = std::exp(sum / weights);
    double disagreement = 0;
    for (const auto& [value, variance] : logs) disagreement += std::pow(value - sum / weights, 2) / variance;
    const double freedom = double(logs.size()) - 1;
    if (freedom > 0 && disagreement > 9 + 4 * freedom) {
      if (result_.diagnostics.find("distances_disagree") == nullptr)
        result_.diagnostics.warn("distances_disagree",
                                 "the known distances disagree by " +
                                     fixed(std::sqrt(disagreement / freedom), 1) +
                                     " of their standard deviations; measure them again");
      scale_variance_ *= disagreement / freedom;
    }
  }

  double distance_between(const KnownDistance& distance, const RoomState& state) const {
    return (*place(points_, state, distance.points[0]) - *place(points_, state, distance.points[1])).norm();
  }

  // ---- judgement

  void measure_walls() {
    result_.walls = {};
    std::vector<double> sigma, share, distances;
    for (int i = 0; i < int(points_.points.size()); ++i) {
      if (!adjustment_->used[std::size_t(i)]) continue;
      // As the rig will measure it: by its own camera and projector.
      const bool in_rig =
          is_in_rig(points_.maps[std::size_t(points_.points[std::size_t(i)].readings[0].map)].position);
      const auto gradient = adjustment_->depth_gradient(state_, layout_, i, in_rig);
      const std::optional<Vec3> at = place(points_, state_, i);
      if (!gradient || !at) continue;
      const VecX total = gradient->by_parameters + scale_by_parameters_;
      const double relative = std::sqrt(std::max(0.0, total.dot(covariance_ * total)) + scale_variance_);
      const double deviation = relative * scale_ / state_.inverse_depth[std::size_t(i)];
      result_.walls.points.push_back(scale_ * *at);
      result_.walls.sigma.push_back(deviation);
      if (!in_rig) continue;
      share.push_back(relative);
      distances.push_back(scale_ * at->norm());
      sigma.push_back(deviation);
    }
    result_.wall_sigma = median_or(sigma, 0.0);
    result_.wall_sigma_95 = sigma.empty() ? 0 : quantile(sigma, 0.95);
    result_.wall_sigma_share = share.empty() ? 1 : quantile(share, 0.95);
    result_.distance = median_or(distances, 0.0);
  }

  void refuse_uncertain() const {
    // The light of one position leaves a number of the lens to its priors, and their shape is a guess.
    const double limit =
        points_.positions.size() == 1 ? 0.5 * options_.max_wall_sigma : options_.max_wall_sigma;
    if (!(result_.wall_sigma_share < limit))
      refuse_room(points_, plan_,
                  "the walls would be uncertain by " + percent(std::min(result_.wall_sigma_share, 9.99)) +
                      " of their distance (limit " + percent(limit) + ")",
                  result_.parallax);
  }

  void measure_flatness() {
    Points3 places;
    for (int i = 0; i < int(points_.points.size()); ++i)
      if (adjustment_->used[std::size_t(i)])
        if (const std::optional<Vec3> at = place(points_, state_, i)) places.push_back(*at);
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : places) mean += p;
    mean /= double(std::max<std::size_t>(1, places.size()));
    Mat3 sum = Mat3::Zero();
    for (const Vec3& p : places) sum += (p - mean) * (p - mean).transpose();
    const Vec3 values = Eigen::SelfAdjointEigenSolver<Mat3>(sum, Eigen::EigenvaluesOnly).eigenvalues();
    constexpr double kFlat = 0.004;  // extent across over extent along
    result_.planar = values[0] < kFlat * kFlat * values[2];
  }

  // ---- the rig

  void fill_rig() {
    Rig& rig = result_.rig;
    std::vector<std::string> names;
    std::vector<Eigen::Index> rows;
    const auto name_lens = [&](const Device& device, std::size_t lens) {
      const std::vector<std::string> all = parameter_names(state_.lenses[lens]);
      for (std::size_t i = 0; i < all.size(); ++i)
        if (layout_.lens[lens][i] >= 0)
          names.push_back(device.name + "." + all[i]), rows.push_back(layout_.lens[lens][i]);
    };
    const auto name_pose = [&](const Device& device, std::size_t pose) {
      if (layout_.pose[pose] < 0) return;
      const std::vector<std::string> all = pose_increment_names("rig_from_" + device.name);
      for (std::size_t i = 0; i < all.size(); ++i)
        names.push_back(all[i]), rows.push_back(layout_.pose[pose] + Eigen::Index(i));
    };
    const auto scaled = [&](std::size_t pose) {
      Pose out = state_.rig_from_device[pose];
      out.translation *= scale_;
      return out;
    };
    for (std::size_t c = 0; c < points_.cameras.size(); ++c) {
      const auto pose = std::size_t(first_position(points_.cameras[c].name));
      rig.cameras.push_back({points_.cameras[c].name, state_.lenses[c], scaled(pose)});
      name_lens(points_.cameras[c], c);
      name_pose(points_.cameras[c], pose);
    }
    for (std::size_t p = 0; p < points_.projectors.size(); ++p) {
      const std::size_t lens = points_.cameras.size() + p, pose = std::size_t(positions()) + p;
      rig.projectors.push_back({points_.projectors[p].name, {state_.lenses[lens]}, scaled(pose)});
      name_lens(points_.projectors[p], lens);
      name_pose(points_.projectors[p], pose);
    }
    for (int i = 0; i < positions(); ++i)
      result_.positions.push_back(
          {points_.cameras[std::size_t(points_.positions[std::size_t(i)].camera)].name,
           points_.positions[std::size_t(i)].view, scaled(std::size_t(i))});

    // Translations grow with the scale, which depends on all parameters and on the distance's own error.
    MatX by = MatX::Identity(layout_.size, layout_.size);
    VecX by_noise = VecX::Zero(layout_.size);
    for (std::size_t pose = 0; pose < layout_.pose.size(); ++pose) {
      if (layout_.pose[pose] < 0) continue;
      const Eigen::Index at = layout_.pose[pose] + 3;
      const Vec3 t = scale_ * state_.rig_from_device[pose].translation;
      by.block<3, 3>(at, at) = scale_ * Mat3::Identity();
      by.middleRows<3>(at) += t * scale_by_parameters_.transpose();
      by_noise.segment<3>(at) = t;
    }
    const MatX all = by * covariance_ * by.transpose() + scale_variance_ * by_noise * by_noise.transpose();
    rig.covariance.names = names;
    rig.covariance.matrix.resize(Eigen::Index(rows.size()), Eigen::Index(rows.size()));
    for (std::size_t r = 0; r < rows.size(); ++r)
      for (std::size_t c = 0; c < rows.size(); ++c)
        rig.covariance.matrix(Eigen::Index(r), Eigen::Index(c)) =
            0.5 * (all(rows[r], rows[c]) + all(rows[c], rows[r]));
    rig.quality.views_used = positions();
    for (const Device& projector : points_.projectors) rig.quality.rms_px[projector.name] = result_.rms_px;
  }

  void judge_regions() {
    constexpr int kRegions = 3;
    std::vector<double> sums(points_.maps.size() * kRegions * kRegions);
    std::vector<int> rows(sums.size()), tally(sums.size());
    double total = 0;
    int total_rows = 0;
    const double limit = options_.outlier_sigmas * result_.scatter;
    for (int i = 0; i < int(points_.points.size()); ++i) {
      if (!held_out(i)) continue;
      if (!std::isfinite(state_.inverse_depth[std::size_t(i)])) adjustment_->start_depth(state_, i);
      if (!adjustment_->refine_depth(state_, i)) continue;
      const PointFit fit = adjustment_->fit(state_, i);
      if (fit.freedom < 1 || fit.square > limit * limit * fit.freedom) continue;  // an outlier of the light
      const LightReading& anchor = points_.points[std::size_t(i)].readings[0];
      const int position = points_.maps[std::size_t(anchor.map)].position;
      const ImageSize size =
          points_.cameras[std::size_t(points_.positions[std::size_t(position)].camera)].size;
      const int column = std::clamp(int(kRegions * anchor.camera_pixel.x() / size.width), 0, kRegions - 1),
                row = std::clamp(int(kRegions * anchor.camera_pixel.y() / size.height), 0, kRegions - 1);
      const std::size_t at = std::size_t((anchor.map * kRegions + row) * kRegions + column);
      sums[at] += fit.square * mean_variance(i);
      rows[at] += fit.freedom;
      ++tally[at];
      total += fit.square * mean_variance(i);
      total_rows += fit.freedom;
    }
    result_.held_out_px = total_rows > 0 ? std::sqrt(total / total_rows) : 0;
    for (std::size_t at = 0; at < sums.size(); ++at) {
      if (tally[at] == 0) continue;
      const MapDevices& map = points_.maps[at / (kRegions * kRegions)];
      const CameraPosition& position = points_.positions[std::size_t(map.position)];
      result_.regions.push_back({points_.cameras[std::size_t(position.camera)].name, position.view,
                                 points_.projectors[std::size_t(map.projector)].name, int(at % kRegions),
                                 int(at / kRegions % kRegions), tally[at], std::sqrt(sums[at] / rows[at])});
    }
    for (const Device& projector : points_.projectors)
      result_.rig.quality.holdout_px[projector.name] = result_.held_out_px;
  }

  void add_remarks() {
    Diagnostics& remarks = result_.diagnostics;
    for (const RigProjector& projector : result_.rig.projectors) {
      const Intrinsics& k = projector.projector.inverse_camera.intrinsics;
      const double sigma = result_.rig.covariance.sigma(projector.name + ".fx") / k.fx;
      constexpr double kSquare = 0.03;
      if (std::abs(k.fx / k.fy - 1) > kSquare && std::abs(k.fx / k.fy - 1) > 5 * sigma)
        remarks.fail(
            "pixels_not_square",
            "projector '" + projector.name + "': its pixels are " + fixed(k.fy / k.fx, 3) +
                " times as wide as high; check --projector-size against the display's own resolution, and turn the "
                "projector's keystone correction off");
    }
    if (result_.planar)
      remarks.note(
          "planar_room",
          "the room is one plane: of the projector's lens it determines two numbers; square pixels and the given or "
          "usual lens shift are assumed for the others, and a known lens of a camera is not checked");
    if (positions() == 1)
      remarks.note(
          "one_position",
          "one camera position: of the projector's lens it determines two numbers; square pixels and the "
          "data sheet are "
          "assumed for the others. A second view from another place of the camera needs no assumption");
    if (!plan_.cameras_known)
      remarks.note(
          "lens_estimated",
          "the lens of a camera is estimated from the room; a calibrated lens (--known-camera) is more certain");
    constexpr double kDisagreePx = 0.12,
                     kDisagree = 2;  // well beyond what light in focus leaves, and beyond its own noise
    if (result_.rms_px > kDisagreePx && result_.scatter > kDisagree)
      remarks.fail(
          "light_disagrees",
          "no rig explains the light to its noise: it is off by " + px(result_.rms_px) + ", " +
              fixed(result_.scatter, 1) +
              " times its own deviation; check the camera's lens, and that neither projectors nor the room moved");
    const int all = result_.points + result_.outliers;
    if (result_.outliers > all / 5)
      remarks.warn("many_outliers", std::to_string(result_.outliers) + " of " + std::to_string(all) +
                                        " points are off by more than " + fixed(options_.outlier_sigmas, 0) +
                                        " standard deviations: look for glossy or moving things");
  }

  const RoomPoints& points_;
  const RoomOptions& options_;
  LensPlan plan_;
  RoomState state_;
  std::optional<Adjustment> adjustment_;
  Layout layout_;
  MatX covariance_;
  VecX scale_by_parameters_;
  double scale_ = 1, scale_variance_ = 0;
  RoomCalibration result_;
};

}  // namespace

RoomCalibration calibrate_room(const RoomPoints& points, const RoomOptions& options) {
  require(!points.points.empty() && !points.maps.empty(), "calibrate_room: no points");
  constexpr std::size_t kFewest = 100;
  if (points.points.size() < kFewest)
    throw Error(
        ErrorKind::kNotEnoughData, "the room's light",
        std::to_string(points.points.size()) + " points are read, " + std::to_string(kFewest) + " are needed",
        "darken the room, raise the camera's exposure, and see that it looks at the projected picture");
  return Route(points, options).run();
}

}  // namespace procam::room
