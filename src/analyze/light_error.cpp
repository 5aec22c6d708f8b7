#include "procam/analyze/light_error.hpp"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "procam/core/dual.hpp"
#include "procam/core/se3.hpp"

namespace procam::analyze {
namespace {

constexpr int kMostLensParameters = Intrinsics::kNumParameters + 8;  ///< the largest model: rational
constexpr int kVariables = 2 + kMostLensParameters + 6;              ///< wall coordinates, lens, pose

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

/// Of lens and pose, in the order of the derivatives below.
MatX projector_covariance(const Rig& rig, const RigProjector& device) {
  if (!rig.covariance.index_of(device.name + ".fx"))
    throw Error(ErrorKind::kInput, "rig projector '" + device.name + "'",
                "the rig carries no covariance of it", "calibrate it with procam, or state its sigmas");
  std::vector<std::string> names;
  for (const std::string& name : parameter_names(device.projector.inverse_camera))
    names.push_back(device.name + "." + name);
  for (const std::string& name : pose_increment_names("rig_from_" + device.name)) names.push_back(name);
  return rig.covariance.block(names);
}

std::optional<LandedLight> land(const RigProjector& device, const MatX& covariance, const Plane& wall,
                                const Vec2& pixel) {
  const Camera& lens = device.projector.inverse_camera;
  const auto ray = device.projector.emit(pixel);
  if (!ray) return std::nullopt;
  const auto landed = intersect(device.rig_from_projector * *ray, wall);
  if (!landed) return std::nullopt;

  using D = Dual<kVariables>;
  LandedLight light{*landed, {}, Mat2::Zero()};
  light.axes.col(0) = wall.normal.unitOrthogonal();
  light.axes.col(1) = wall.normal.cross(light.axes.col(0));
  const VecX parameters = parameters_of(lens);
  const int num_lens = int(parameters.size());
  Vec3T<D> point;  // X0 + E a, then moved by the inverse of the pose's left increment
  for (int i = 0; i < 3; ++i) {
    point[i] = D((*landed)[i]);
    point[i].v[0] = light.axes(i, 0);
    point[i].v[1] = light.axes(i, 1);
  }
  Eigen::Matrix<D, 6, 1> xi;
  for (int i = 0; i < 6; ++i) xi[i] = D(0.0, 2 + num_lens + i);
  const PoseT<D> projector_from_rig =
      device.rig_from_projector.inverse().cast<D>() * se3_exp<D>(Eigen::Matrix<D, 6, 1>(-xi));
  std::vector<D> lens_parameters;
  for (int i = 0; i < num_lens; ++i) lens_parameters.emplace_back(parameters[i], 2 + i);

  const std::optional<Vec2T<D>> projected = std::visit(
      [&](const auto& model) {
        return project<std::decay_t<decltype(model)>>(IntrinsicsT<D>::from_array(lens_parameters.data()),
                                                      lens_parameters.data() + Intrinsics::kNumParameters,
                                                      Vec3T<D>(projector_from_rig * point));
      },
      lens.distortion);
  if (!projected) return std::nullopt;
  Eigen::Matrix<double, 2, kVariables> derivative;
  derivative << projected->x().v.transpose(), projected->y().v.transpose();
  const MatX by_parameters = -derivative.leftCols<2>().inverse() * derivative.middleCols(2, num_lens + 6);
  light.covariance = by_parameters * covariance * by_parameters.transpose();
  return light;
}

}  // namespace

std::optional<LandedLight> landed_light(const Rig& rig, const Plane& wall_in_rig, const Vec2& pixel,
                                        const std::string& projector) {
  const RigProjector& device = rig.projector(projector);
  return land(device, projector_covariance(rig, device), wall_in_rig, pixel);
}

LightError predicted_light_error(const Rig& rig, double distance, const std::string& projector) {
  require(distance > 0, "predicted_light_error: distance must be positive");
  const RigProjector& device = rig.projector(projector);
  const MatX covariance = projector_covariance(rig, device);
  const Plane wall = wall_across(device.rig_from_projector, distance);

  LightError error{distance, 0, 0, 0, device.name};
  double sum = 0;
  int count = 0;
  for (const Vec2& pixel : picture_grid(device.projector.size())) {
    const auto landed = land(device, covariance, wall, pixel);
    if (!landed) continue;
    sum += landed->covariance.trace();
    error.worst_mm = std::max(error.worst_mm, 1e3 * std::sqrt(landed->covariance.trace()));
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
