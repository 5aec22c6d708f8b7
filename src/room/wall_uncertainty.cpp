/// The uncertainty of a room's walls as the rig will measure them, and what it depends on: parallax and flatness.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "route.hpp"

namespace procam::room {

void Route::measure_parallax() {
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

bool Route::is_in_rig(int position) const {
  return first_position(points_.cameras[std::size_t(points_.positions[std::size_t(position)].camera)].name) ==
         position;
}

void Route::measure_walls() {
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

void Route::refuse_uncertain(const std::string& contradicted) {
  // The light of one position leaves a number of the lens to its priors, and their shape is a guess.
  const double limit =
      points_.positions.size() == 1 ? 0.5 * options_.max_wall_sigma : options_.max_wall_sigma;
  const bool is_certain = result_.wall_sigma_share < limit;
  const std::string seen = "the walls would be uncertain by " +
                           percent(std::min(result_.wall_sigma_share, 9.99)) + " of their distance (limit " +
                           percent(limit) + ")",
                    check = "check that --known-camera is this camera at this zoom, focus and resolution";
  if (!doubt_.empty()) {
    const std::string words = doubt_ + ", more than both state and too little to be certain: ";
    if (is_certain)
      result_.diagnostics.warn("known_lens_doubtful", words + "the deviations hold it; " + check);
    else
      result_.diagnostics.fail("known_lens_doubtful", words + seen + " with the lens open; " + check);
    return;
  }
  if (is_certain) return;
  const double by_scale = std::sqrt(scale_variance_);
  if (by_scale > 0.7 * result_.wall_sigma_share)
    throw Error(ErrorKind::kDegenerate, "the known length",
                "it is uncertain by " + percent(std::min(by_scale, 9.99)) +
                    " of itself, and so are the walls (limit " + percent(limit) + ")",
                "measure a longer one, check its unit, and state its standard deviation (1.25m+-2mm)");
  if (!contradicted.empty())
    throw Error(ErrorKind::kDegenerate, "the known lens", contradicted + "; with it open, " + seen,
                check + "; if it is, capture one more view from another place of the camera");
  refuse_room(points_, plan_, seen, result_.parallax);
}

void Route::measure_flatness() {
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

}  // namespace procam::room
