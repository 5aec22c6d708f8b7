#include "residual_blocks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "believed_covariance.hpp"
#include "procam/calibrate/costs/flexed.hpp"
#include "procam/calibrate/costs/image_change.hpp"
#include "procam/calibrate/costs/light_point.hpp"
#include "procam/calibrate/costs/reprojection.hpp"
#include "procam/calibrate/costs/shared_corner.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/dual.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::calibrate {
namespace {

std::optional<Vec3> point_in_rig(const BundleState& state, const Measurement& m) {
  if (m.light != nullptr) return place_in_rig(state, m.view, *m.light);
  return state.rig_from_board[std::size_t(m.view)] *
         state.point_in(std::size_t(m.view), std::size_t(m.observation->point));
}

/// Derivative of a device's pixel by the sheet's two coordinates at a point in the rig's frame.
std::optional<Mat2> pixel_by_sheet(const BundleState& state, int device, std::size_t view,
                                   const Vec3& point) {
  const Pose& rig_from_board = state.rig_from_board[view];
  const Camera lens = state.lens_in(view, std::size_t(device));
  const Pose& device_from_rig = state.device_from_rig[std::size_t(device)];
  using D = Dual<2>;
  const Vec3 in_device = device_from_rig * point;
  const Vec2 slope = state.sheet_in(view).slope((rig_from_board.inverse() * point).head<2>());
  Vec3T<D> moved(D(in_device.x()), D(in_device.y()), D(in_device.z()));
  for (int axis = 0; axis < 2; ++axis) {
    const Vec3 along =
        device_from_rig.rotate(rig_from_board.rotate(Vec3(Vec3::Unit(axis) + slope[axis] * Vec3::UnitZ())));
    for (int i = 0; i < 3; ++i) moved[i].v[axis] = along[i];
  }
  const Intrinsics& k = lens.intrinsics;
  return std::visit(
      [&](const auto& model) -> std::optional<Mat2> {
        using Model = std::decay_t<decltype(model)>;
        std::array<D, std::size_t(Model::kNumCoefficients)> coefficients;
        std::copy(model.coefficients.begin(), model.coefficients.end(), coefficients.begin());
        const auto pixel = project<Model>(IntrinsicsT<D>{k.fx, k.fy, k.cx, k.cy, k.skew},
                                          static_cast<const D*>(coefficients.data()), moved);
        if (!pixel) return std::nullopt;
        Mat2 derivative;
        derivative << pixel->x().v.transpose(), pixel->y().v.transpose();
        return derivative;
      },
      lens.distortion);
}

/// Derivative of a device's pixel by the camera's, over the sheet.
std::optional<Mat2> carry_over(const BundleState& state, const Measurement& m, const Vec3& point_in_rig) {
  const auto lit = pixel_by_sheet(state, m.device, std::size_t(m.view), point_in_rig),
             seen = pixel_by_sheet(state, m.camera(), std::size_t(m.view), point_in_rig);
  if (!lit || !seen || !(std::abs(seen->determinant()) > 1e-12)) return std::nullopt;
  return Mat2(*lit * seen->inverse());
}

std::optional<Vec2> residual_in(const BundleState& state, int view, int device, const Vec3& point_in_rig,
                                const Vec2& pixel) {
  const std::optional<Vec2> projected =
      state.lens_in(std::size_t(view), std::size_t(device))
          .project(state.device_from_rig[std::size_t(device)] * point_in_rig);
  if (!projected) return std::nullopt;
  return Vec2(*projected - pixel);
}

/// What is left of C_p without J C_c J^T: at least a hundredth of C_p in every direction, since both are
/// estimates.
Mat2 without_corner(const Mat2& of_light, const Mat2& of_corner, const Mat2& carry) {
  const Mat2 lower = cholesky_lower(of_light), whiten = lower.inverse();
  const SymmetricEigen2 eigen =
      symmetric_eigen(Mat2::Identity() - whiten * carry * of_corner * carry.transpose() * whiten.transpose());
  const Mat2 root = lower * eigen.vectors;
  return root * eigen.values.cwiseMax(0.01).asDiagonal() * root.transpose();
}

/// carry_of where the measurement's residual or its covariance has a use for it.
std::optional<Mat2> needed_carry(const BundleState& state, const Measurement& m, const Vec3& point) {
  if (m.light == nullptr && !read_at_corner(m)) return std::nullopt;
  return carry_over(state, m, point);
}

std::optional<Vec2> residual_with(const BundleState& state, const Measurement& m, const Vec3& point,
                                  const std::optional<Mat2>& carry) {
  const auto lit = residual_in(state, m.view, m.device, point, m.pixel());
  if (!lit || !read_at_corner(m)) return lit;
  const auto seen = residual_in(state, m.view, m.camera(), point, m.corner->pixel);
  if (!seen || !carry) return std::nullopt;
  return Vec2(*lit - *carry * *seen);
}

std::optional<Mat2> covariance_with(const Measurement& m, const std::optional<Mat2>& carry) {
  if (m.observation != nullptr && !read_at_corner(m)) return m.observation->covariance;
  if (!carry) return std::nullopt;
  const Mat2 covariance = m.light != nullptr
                              ? Mat2(*carry * m.light->camera_covariance * carry->transpose())
                              : without_corner(m.observation->covariance, m.corner->covariance, *carry);
  if (!covariance.allFinite() || !(covariance.determinant() > 0)) return std::nullopt;
  return covariance;
}

std::unique_ptr<ceres::CostFunction> without_variation(const BundleState& state, const Measurement& m,
                                                       const Mat2& sqrt_information,
                                                       const std::optional<Mat2>& carry) {
  const Distortion& model = state.lenses[std::size_t(m.device)].distortion;
  if (m.observation != nullptr) {
    auto cost = reprojection_cost(model, m.pixel(), sqrt_information);
    if (!read_at_corner(m)) return cost;
    return std::make_unique<SharedCornerCost>(
        reprojection_cost(state.lenses[std::size_t(m.camera())].distortion, m.corner->pixel,
                          -sqrt_information * *carry),
        std::move(cost));
  }
  return std::visit(
      [&](const auto& camera_model, const auto& projector_model) -> std::unique_ptr<ceres::CostFunction> {
        return std::make_unique<LightPointCost>(camera_model, projector_model, m.light->camera_pixel,
                                                m.light->projector_pixel, sqrt_information,
                                                state.sheet.centre);
      },
      state.lenses[std::size_t(m.light->camera)].distortion, model);
}

}  // namespace

OwnOfView own_of_view(const BundleOptions& options, std::size_t devices) {
  OwnOfView own;
  if (options.variation.flex > 0) own.flex_at = std::exchange(own.size, own.size + 3);
  if (options.variation.of_image())
    own.images_at = std::exchange(own.size, own.size + 3 * Eigen::Index(devices));
  return own;
}

void move_view(BundleState& state, const BundleOptions& options, std::size_t view, const VecX& step) {
  Pose& pose = state.rig_from_board[view];
  pose = (se3_exp<double>(Vec6(step.head<6>())) * pose).normalized();
  const OwnOfView own = own_of_view(options, state.lenses.size());
  if (own.flex_at >= 0) state.flex[view] += step.segment<3>(own.flex_at);
  if (own.images_at < 0) return;
  for (std::size_t d = 0; d < state.lenses.size(); ++d)
    state.image_changes[view][d] += step.segment<3>(own.images_at + 3 * Eigen::Index(d));
}

Vec3 image_change_weights(const ViewVariation& variation, ImageSize image) {
  constexpr double kHeld = 1e-8, kHeldPx = 1e-5;
  constexpr double kOffCentre = 0.03;  // of the image's width
  const double of_shift =
      1 / std::max(kHeldPx, std::hypot(variation.shift_px, kOffCentre * image.width * variation.focus));
  return {1 / std::max(kHeld, variation.focus), of_shift, of_shift};
}

OwnPrior own_prior(const BundleState& state, const BundleOptions& options, std::size_t view) {
  const OwnOfView own = own_of_view(options, state.lenses.size());
  OwnPrior prior{MatX::Zero(own.size - 6, own.size - 6), VecX::Zero(own.size - 6)};
  if (own.flex_at >= 0) {
    prior.whitening.block<3, 3>(own.flex_at - 6, own.flex_at - 6) = flex_whitening(options.variation.flex);
    prior.value.segment<3>(own.flex_at - 6) = state.flex[view];
  }
  for (std::size_t d = 0; own.images_at >= 0 && d < state.lenses.size(); ++d) {
    const Eigen::Index at = own.images_at - 6 + 3 * Eigen::Index(d);
    prior.whitening.diagonal().segment<3>(at) = image_change_weights(options.variation, state.lenses[d].size);
    prior.value.segment<3>(at) = state.image_changes[view][d];
  }
  return prior;
}

int changed_camera(const BundleState& state, const Measurement& m) {
  if (state.image_changes.empty()) return -1;
  if (m.light != nullptr || read_at_corner(m)) return m.camera();
  return m.of_camera ? m.device : -1;
}

std::unique_ptr<ceres::CostFunction> reprojection_cost(const Distortion& model, const Vec2& pixel,
                                                       const Mat2& sqrt_information) {
  return std::visit(
      [&](const auto& lens_model) -> std::unique_ptr<ceres::CostFunction> {
        return std::make_unique<ReprojectionCost<std::decay_t<decltype(lens_model)>>>(pixel,
                                                                                      sqrt_information);
      },
      model);
}

BentSheet flat_sheet(const Points3& printed) {
  Vec2 middle = Vec2::Zero();
  for (const Vec3& p : printed) middle += p.head<2>() / double(printed.size());
  return {Vec3::Zero(), middle};
}

const std::vector<LensPrior>& priors_of(const BundleOptions& options, std::size_t device) {
  static const std::vector<LensPrior> none;
  return options.priors.empty() ? none : options.priors[device];
}

int pose_group(const BundleOptions& options, std::size_t view) {
  const int named = int(options.pose_groups.size());
  if (int(view) < named) return options.pose_groups[view];
  const auto largest = std::max_element(options.pose_groups.begin(), options.pose_groups.end());
  return (named == 0 ? 0 : *largest + 1) + int(view) - named;
}

std::vector<double> view_weights(const UsedMask& used, const BundleOptions& options) {
  std::vector<double> weights(used.size(), 1);
  if (options.pose_groups.empty()) return weights;
  std::map<int, int> members;
  const auto takes_part = [&](std::size_t v) {
    return std::any_of(used[v].begin(), used[v].end(), [](const std::vector<char>& of_device) {
      return std::find(of_device.begin(), of_device.end(), char(1)) != of_device.end();
    });
  };
  for (std::size_t v = 0; v < used.size(); ++v) members[pose_group(options, v)] += takes_part(v);
  for (std::size_t v = 0; v < used.size(); ++v)
    weights[v] = 1.0 / std::max(1, members[pose_group(options, v)]);
  return weights;
}

std::optional<Mat2> carry_of(const BundleState& state, const Measurement& m) {
  const auto point = point_in_rig(state, m);
  if (!point) return std::nullopt;
  return carry_over(state, m, *point);
}

bool read_at_corner(const Measurement& m) {
  return m.observation != nullptr && m.observation->correlated_with_camera && m.corner != nullptr;
}

std::optional<Vec3> place_in_rig(const BundleState& state, int view, const LightPoint& light) {
  const auto bearing =
      state.lens_in(std::size_t(view), std::size_t(light.camera)).unproject(light.camera_pixel);
  if (!bearing) return std::nullopt;
  const Pose& rig_from_board = state.rig_from_board[std::size_t(view)];
  const Pose camera_from_board = state.device_from_rig[std::size_t(light.camera)] * rig_from_board;
  const auto in_board =
      intersect(camera_from_board.inverse() * Ray{Vec3::Zero(), *bearing}, state.sheet_in(std::size_t(view)));
  if (!in_board) return std::nullopt;
  return rig_from_board * *in_board;
}

std::vector<Measurement> measurements_of(const Correspondences& data, int view, int device) {
  std::vector<Measurement> all;
  const View& of = data.views[std::size_t(view)];
  const bool read_by_cameras = data.devices[std::size_t(device)].kind == DeviceKind::kProjector;
  const bool of_camera = !read_by_cameras;
  std::vector<const Observation*> corners;  // of one camera, by point
  int camera = -1;
  for (const Observation& o : of.observations[std::size_t(device)]) {
    if (read_by_cameras && o.camera != camera) {
      camera = o.camera;
      corners.clear();
      for (const Observation& corner : of.observations[std::size_t(camera)]) {
        if (std::size_t(corner.point) >= corners.size())
          corners.resize(std::size_t(corner.point) + 1, nullptr);
        corners[std::size_t(corner.point)] = &corner;
      }
    }
    const bool seen = std::size_t(o.point) < corners.size();
    all.push_back({view, device, int(all.size()), &o, nullptr, seen ? corners[std::size_t(o.point)] : nullptr,
                   of_camera});
  }
  for (const LightPoint& light : of.light_points)
    if (light.projector == device)
      all.push_back({view, device, int(all.size()), nullptr, &light, nullptr, of_camera});
  return all;
}

UsedMask use_all(const Correspondences& data) {
  UsedMask used(data.views.size());
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      used[v].emplace_back(measurements_of(data, int(v), int(d)).size(), char(1));
  return used;
}

std::optional<JudgedResidual> judged_residual(const BundleState& state, const Measurement& m) {
  const auto point = point_in_rig(state, m);
  if (!point) return std::nullopt;
  const auto carry = needed_carry(state, m, *point);
  const auto residual = residual_with(state, m, *point, carry);
  const auto covariance = covariance_with(m, carry);
  if (!residual || !covariance) return std::nullopt;
  return JudgedResidual{*residual, *covariance};
}

std::optional<Vec2> reprojection_residual(const BundleState& state, const Measurement& m) {
  const auto point = point_in_rig(state, m);
  if (!point) return std::nullopt;
  const auto carry = read_at_corner(m) ? needed_carry(state, m, *point) : std::nullopt;
  return residual_with(state, m, *point, carry);
}

std::optional<Mat2> believed_covariance(const BundleState& state, const Measurement& m) {
  const auto point = point_in_rig(state, m);
  if (!point) return std::nullopt;
  return covariance_with(m, needed_carry(state, m, *point));
}

std::unique_ptr<ceres::CostFunction> measurement_cost(const BundleState& state, const Measurement& m,
                                                      const ResidualNoise& noise) {
  const auto point = point_in_rig(state, m);
  if (!point) return nullptr;
  const auto carry = needed_carry(state, m, *point);
  const auto covariance = covariance_with(m, carry);
  if (!covariance) return nullptr;
  // Whiten: with covariance = C C^T (Cholesky), L = C^-1.
  const Mat2 sqrt_information = cholesky_lower(noise.covariance(*covariance)).inverse();
  auto cost = without_variation(state, m, sqrt_information, carry);
  if (!state.flex.empty())
    cost = std::make_unique<FlexedCost>(
        std::move(cost), m.light != nullptr ? FlexedCost::Last::kCurvature : FlexedCost::Last::kPoint,
        state.sheet.centre);
  if (changed_camera(state, m) >= 0) cost = std::make_unique<ImageChangeCost>(std::move(cost));
  return cost;
}

std::vector<int> held_parameters(const Camera& lens, const std::vector<std::string>& held) {
  const std::vector<std::string> names = parameter_names(lens);
  std::vector<int> positions;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::count(held.begin(), held.end(), names[i]) > 0) positions.push_back(int(i));
  return positions;
}

}  // namespace procam::calibrate
