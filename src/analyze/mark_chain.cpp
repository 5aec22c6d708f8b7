#include "mark_chain.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/geometry/plane.hpp"

namespace procam::analyze {
namespace {

using RowsOfPose = Eigen::Matrix<double, 2, 6>;

/// A ray's place on the surface, and what moves it.
struct PlaceOfRay {
  Vec2 on_surface;
  RowsOfPose by_device;  ///< left increment of rig_from_device; of rig_from_surface: the negative
  Mat23 by_direction;    ///< of the bearing in the device's frame
};

std::optional<PlaceOfRay> place_of(const Vec3& bearing, const Pose& rig_from_device,
                                   const Pose& rig_from_surface) {
  const Pose surface_from_rig = rig_from_surface.inverse();
  const Ray in_rig = rig_from_device * Ray{Vec3::Zero(), bearing};
  const Ray in_surface = surface_from_rig * in_rig;
  const std::optional<Vec3> hit = intersect(in_surface, Plane{});
  if (!hit || in_surface.origin.z() == 0) return std::nullopt;
  const Vec3& d = in_surface.direction;
  Mat23 slide;
  slide << 1, 0, -d.x() / d.z(), 0, 1, -d.y() / d.z();
  const double length = -in_surface.origin.z() / d.z();
  const Mat23 from_rig = slide * surface_from_rig.rotation_matrix();
  Eigen::Matrix<double, 3, 6> by_increment;
  by_increment << -hat(Vec3(in_rig.at(length))), Mat3::Identity();
  return PlaceOfRay{hit->head<2>(), from_rig * by_increment,
                    length * from_rig * rig_from_device.rotation_matrix()};
}

/// Left Jacobian of SE(3) to second order: exp(a + d) ~ exp(J d) exp(a). A bump of some degrees needs no
/// more.
Mat6 increment_jacobian(const Vec6& a) {
  Mat6 j = Mat6::Identity();
  const Mat3 turn = 0.5 * hat(Vec3(a.head<3>()));
  j.topLeftCorner<3, 3>() += turn;
  j.bottomRightCorner<3, 3>() += turn;
  j.bottomLeftCorner<3, 3>() = 0.5 * hat(Vec3(a.tail<3>()));
  return j;
}

std::vector<std::string> lens_names(const std::string& device, const Camera& lens) {
  std::vector<std::string> names;
  for (const std::string& name : parameter_names(lens)) names.push_back(device + "." + name);
  return names;
}

/// Adds the derivatives by some parameters to their columns; -1 where a parameter was held fixed.
void add_columns(const MatX& derivatives, const std::vector<Eigen::Index>& columns, Eigen::Ref<MatX> rows) {
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (columns[k] >= 0) rows.col(columns[k]) += derivatives.col(Eigen::Index(k));
}

}  // namespace

std::vector<std::optional<MarkChain::Bearing>> MarkChain::bearings(const Camera& lens,
                                                                   const Points2& pixels) {
  const VecX parameters = parameters_of(lens);
  std::vector<std::optional<Bearing>> result;
  for (const Vec2& pixel : pixels) {
    const auto direction = lens.unproject(pixel);
    result.emplace_back();
    if (!direction) continue;
    Bearing& bearing = result.back().emplace();
    bearing.direction = *direction;
    bearing.by_lens.resize(3, parameters.size());
  }
  // Central differences: their error is that of the step squared, and unproject()'s digits over the step.
  const auto fill = [&](const Camera& up, const Camera& down, double step, const Vec2& pixel_step,
                        const auto& column_of) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!result[i]) continue;
      const auto a = up.unproject(pixels[i] + pixel_step), b = down.unproject(pixels[i] - pixel_step);
      if (!a || !b) {  // at the very rim of what the lens can see
        result[i].reset();
        continue;
      }
      column_of(*result[i]) = (*a - *b) / (2 * step);
    }
  };
  for (Eigen::Index k = 0; k < parameters.size(); ++k) {
    VecX up = parameters, down = parameters;
    const double step = 1e-6 * std::max(1.0, std::abs(parameters[k]));
    up[k] += step, down[k] -= step;
    fill(with_parameters(lens, up), with_parameters(lens, down), step, Vec2::Zero(),
         [&](Bearing& bearing) { return bearing.by_lens.col(k); });
  }
  constexpr double kPixelStep = 1e-3;
  for (int axis = 0; axis < 2; ++axis)
    fill(lens, lens, kPixelStep, kPixelStep * Vec2::Unit(axis),
         [&](Bearing& bearing) { return bearing.by_pixel.col(axis); });
  return result;
}

MarkChain::MarkChain(const Rig& rig, const RigCamera& camera, const RigProjector& projector,
                     const StatedSurface& surface, const std::vector<LightPoint>& marks)
    : rig_from_camera_(camera.rig_from_camera),
      rig_from_projector_(projector.rig_from_projector),
      rig_from_plane_(surface.tangents.empty()
                          ? std::vector<Pose>(marks.size(), surface.rig_from_surface.pose)
                          : surface.tangents),
      surface_by_camera_(surface.jacobian_camera) {
  require(rig_from_plane_.size() == marks.size(), "verify: a curved surface needs one tangent plane a mark");
  Points2 seen, shown;
  for (const LightPoint& mark : marks) {
    seen.push_back(mark.camera_pixel);
    shown.push_back(mark.projector_pixel);
    pixel_noise_.push_back(mark.camera_covariance);
  }
  seen_ = bearings(camera.camera, seen);
  shown_ = bearings(projector.projector.inverse_camera, shown);

  const std::vector<std::string> place = pose_increment_names("rig_from_" + projector.name);
  for (const std::string& name : rig.covariance.names)
    if (std::find(place.begin(), place.end(), name) == place.end()) rig_names_.push_back(name);
  projector_place_ = Eigen::Index(rig_names_.size());
  rig_names_.insert(rig_names_.end(), place.begin(), place.end());
  const NamedCovariance all{rig_names_, rig.covariance.block(rig_names_)};
  const auto columns_of = [&](const std::vector<std::string>& names) {
    std::vector<Eigen::Index> columns;
    for (const std::string& name : names) columns.push_back(all.index_of(name).value_or(-1));
    return columns;
  };
  camera_columns_ = columns_of(lens_names(camera.name, camera.camera));
  for (const Eigen::Index column : columns_of(pose_increment_names("rig_from_" + camera.name)))
    camera_columns_.push_back(column);
  projector_lens_ = columns_of(lens_names(projector.name, projector.projector.inverse_camera));
  require(
      surface_by_camera_.size() == 0 || (surface_by_camera_.rows() == 6 &&
                                         surface_by_camera_.cols() == Eigen::Index(camera_columns_.size())),
      "verify: the surface's jacobian_camera is not 6 x (camera parameters + 6)");
  const auto known = Eigen::Index(rig_names_.size());
  stated_ = MatX::Zero(known + 6, known + 6);
  stated_.topLeftCorner(known, known) = all.matrix;
  stated_.bottomRightCorner<6, 6>() = surface.rig_from_surface.covariance;
}

std::optional<Vec2> MarkChain::intended(std::size_t mark, const Moved& moved) const {
  if (!shown_[mark]) return std::nullopt;
  const auto light = place_of(shown_[mark]->direction, se3_exp(moved.projector) * rig_from_projector_,
                              se3_exp(moved.surface) * rig_from_plane_[mark]);
  if (!light) return std::nullopt;
  return light->on_surface;
}

std::optional<Vec2> MarkChain::error(std::size_t mark, const Moved& moved) const {
  const auto light = intended(mark, moved);
  if (!light || !seen_[mark]) return std::nullopt;
  const auto sight =
      place_of(seen_[mark]->direction, rig_from_camera_, se3_exp(moved.surface) * rig_from_plane_[mark]);
  if (!sight) return std::nullopt;
  return Vec2(sight->on_surface - *light);
}

std::string MarkChain::flaw(std::size_t mark) const {
  if (!shown_[mark]) return "the projector's lens has no ray for its pixel";
  if (!seen_[mark]) return "the camera's lens has no ray for its pixel";
  if (!intended(mark)) return "its light cannot reach the surface as it is stated";
  return error(mark) ? "" : "the camera cannot see the surface there as it is stated";
}

std::optional<LinearMarks> MarkChain::linearise(const std::vector<std::size_t>& marks,
                                                const Moved& moved) const {
  const Pose rig_from_projector = se3_exp(moved.projector) * rig_from_projector_,
             moved_surface = se3_exp(moved.surface);
  const Mat6 of_projector = increment_jacobian(moved.projector),
             of_surface = increment_jacobian(moved.surface);
  const auto rows = Eigen::Index(2 * marks.size());
  LinearMarks linear{VecX(rows), MatX::Zero(rows, stated_.rows()), {}};
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const Pose rig_from_surface = moved_surface * rig_from_plane_[marks[i]];
    const Bearing &seen = *seen_[marks[i]], &shown = *shown_[marks[i]];
    const auto sight = place_of(seen.direction, rig_from_camera_, rig_from_surface),
               light = place_of(shown.direction, rig_from_projector, rig_from_surface);
    if (!sight || !light) return std::nullopt;
    const Vec3 lit = rig_from_surface * Vec3(light->on_surface.x(), light->on_surface.y(), 0);
    const auto towards_light =
        place_of((rig_from_camera_.inverse() * lit).normalized(), rig_from_camera_, rig_from_surface);
    if (!towards_light) return std::nullopt;
    const auto row = Eigen::Index(2 * i);
    linear.error.segment<2>(row) = sight->on_surface - light->on_surface;
    auto here = linear.by_state.middleRows(row, 2);
    const RowsOfPose by_surface = (light->by_device - towards_light->by_device) * of_surface;
    here.rightCols<6>() = by_surface;
    here.middleCols<6>(projector_place_) -= light->by_device * of_projector;
    add_columns(-light->by_direction * shown.by_lens, projector_lens_, here);
    MatX by_camera(2, Eigen::Index(camera_columns_.size()));
    by_camera << towards_light->by_direction * seen.by_lens, towards_light->by_device;
    if (surface_by_camera_.size() > 0) by_camera += by_surface * surface_by_camera_;
    add_columns(by_camera, camera_columns_, here);
    const Mat2 by_pixel = towards_light->by_direction * seen.by_pixel;
    linear.noise.push_back(by_pixel * pixel_noise_[marks[i]] * by_pixel.transpose());
  }
  return linear;
}

}  // namespace procam::analyze
