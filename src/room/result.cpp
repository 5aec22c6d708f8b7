/// The result of a room's calibration: the rig with its covariance, errors by region, remarks.
#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "route.hpp"

namespace procam::room {

void Route::fill_rig() {
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
    result_.positions.push_back({points_.cameras[std::size_t(points_.positions[std::size_t(i)].camera)].name,
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

void Route::judge_regions() {
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
    const ImageSize size = points_.cameras[std::size_t(points_.positions[std::size_t(position)].camera)].size;
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

void Route::add_remarks() {
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
  // A rig that explains most of the light may be far off where the views contradict each other.
  constexpr double kManyOutliers = 0.15;
  if (result_.outliers > kManyOutliers * all)
    remarks.fail(
        "many_outliers",
        std::to_string(result_.outliers) + " of " + std::to_string(all) + " points are off by more than " +
            fixed(options_.outlier_sigmas, 0) +
            " standard deviations: a projector was moved or a camera zoomed between the views, a view is of another "
            "place, or things are glossy or move; capture the views again with everything at rest");
}

}  // namespace procam::room
