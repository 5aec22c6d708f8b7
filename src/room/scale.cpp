/// The scale of a room, from distances and targets of known length.
#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "route.hpp"
#include "target.hpp"

namespace procam::room {

std::optional<double> Route::modelled(const KnownDistance& distance, RoomState& state) const {
  if (!distance.devices.empty())
    return (pose_of(distance.devices[0], state).translation - pose_of(distance.devices[1], state).translation)
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

const Pose& Route::pose_of(const std::string& name, const RoomState& state) const {
  for (std::size_t p = 0; p < points_.projectors.size(); ++p)
    if (points_.projectors[p].name == name) return state.rig_from_device[std::size_t(positions()) + p];
  return state.rig_from_device[std::size_t(first_position(name))];
}

int Route::first_position(const std::string& camera) const {
  for (int i = 0; i < positions(); ++i)
    if (points_.cameras[std::size_t(points_.positions[std::size_t(i)].camera)].name == camera) return i;
  return 0;
}

Route::KnownLength Route::known_length(const KnownDistance& distance) const {
  RoomState state = state_;
  const std::optional<double> here = modelled(distance, state);
  constexpr double kNoParallax = 1 * kDegree;
  if (result_.parallax < kNoParallax)
    refuse_room(points_, plan_, "a known distance between points of the walls gives no scale",
                result_.parallax);
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

Route::KnownLength Route::known_length(const KnownTarget& target) const {
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

void Route::find_scale() {
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
      result_.diagnostics.warn("distances_disagree", "the known distances disagree by " +
                                                         fixed(std::sqrt(disagreement / freedom), 1) +
                                                         " of their standard deviations; measure them again");
    scale_variance_ *= disagreement / freedom;
  }
}

double Route::distance_between(const KnownDistance& distance, const RoomState& state) const {
  return (*place(points_, state, distance.points[0]) - *place(points_, state, distance.points[1])).norm();
}

}  // namespace procam::room
