#include "procam/analyze/light_error.hpp"

#include <cmath>

#include "light_chain.hpp"

namespace procam::analyze {
namespace {

Points2 picture_grid(ImageSize size) {
  Points2 pixels;
  for (int j = 0; j <= 12; ++j)
    for (int i = 0; i <= 16; ++i)
      pixels.emplace_back((size.width - 1) * i / 16.0, (size.height - 1) * j / 12.0);
  return pixels;
}

Plane wall_across(const Pose& rig_from_projector, double distance) {
  return rig_from_projector * Plane{-Vec3::UnitZ(), distance};
}

}  // namespace

LightError predicted_light_error(const Rig& rig, double distance, const std::string& projector) {
  require(distance > 0, "predicted_light_error: distance must be positive");
  const RigProjector& device = rig.projector(projector);
  const MatX covariance = calibration_covariance(rig.covariance, device);
  const LightPath path = light_path(device, wall_across(device.rig_from_projector, distance));

  LightError error{distance, 0, 0, 0, device.name};
  double sum = 0;
  int count = 0;
  for (const Vec2& pixel : picture_grid(device.projector.size())) {
    const auto on_wall = landing_place(path, pixel);
    const auto chain = on_wall ? chain_derivatives(path, *on_wall) : std::nullopt;
    if (!chain) continue;
    MatX by_all(2, covariance.cols());
    by_all << chain->by_lens, chain->by_rig;
    const double variance = (by_all * covariance * by_all.transpose()).trace();
    sum += variance;
    error.worst_mm = std::max(error.worst_mm, 1e3 * std::sqrt(variance));
    ++count;
  }
  if (count > 0) error.rms_mm = 1e3 * std::sqrt(sum / count);
  return error;
}

LightError true_light_error(const Rig& estimated, const Rig& truth, double distance,
                            const std::string& projector) {
  require(distance > 0, "true_light_error: distance must be positive");
  const RigProjector &a = estimated.projector(projector), &b = truth.projector(projector);
  if (a.projector.size() != b.projector.size())
    throw Error(ErrorKind::kInput, "the true rig", "its projector has another size than the estimated one",
                "compare rigs of the same session");
  const Plane wall = wall_across(b.rig_from_projector, distance);
  LightError error{distance, 0, 0, 0, a.name};
  double sum = 0, sum2 = 0;
  int count = 0;
  for (const Vec2& pixel : picture_grid(b.projector.size())) {
    const auto ray_a = a.projector.emit(pixel), ray_b = b.projector.emit(pixel);
    if (!ray_a || !ray_b) continue;
    const auto at_a = intersect(a.rig_from_projector * *ray_a, wall),
               at_b = intersect(b.rig_from_projector * *ray_b, wall);
    if (!at_a || !at_b) continue;
    const double mm = 1e3 * (*at_a - *at_b).norm();
    sum += mm;
    sum2 += mm * mm;
    error.worst_mm = std::max(error.worst_mm, mm);
    ++count;
  }
  if (count > 0) error.mean_mm = sum / count, error.rms_mm = std::sqrt(sum2 / count);
  return error;
}

}  // namespace procam::analyze
