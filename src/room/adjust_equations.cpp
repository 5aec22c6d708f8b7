/// The equations of a room's points: projections with derivatives, rows of one point, and its depth.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "adjust_rows.hpp"
#include "procam/core/base/dual.hpp"

namespace procam::room {
namespace {

/// (a, b, 1) of a pixel.
std::optional<Vec3> ray_of(const Camera& lens, const Vec2& pixel) {
  const std::optional<Vec3> bearing = lens.unproject(pixel);
  if (!bearing || !(bearing->z() > 1e-6)) return std::nullopt;
  return Vec3(*bearing / bearing->z());
}

}  // namespace

std::optional<ProjectedPoint> project_point(const Camera& lens, const Vec3& point) {
  return std::visit(
      [&](const auto& model) -> std::optional<ProjectedPoint> {
        using Model = std::decay_t<decltype(model)>;
        constexpr int kN = Model::kNumCoefficients, kK = Intrinsics::kNumParameters;
        using D = Dual<3 + kN>;
        std::array<D, std::size_t(kN) + 1> c;
        for (int i = 0; i < kN; ++i) c[std::size_t(i)] = D(model.coefficients[std::size_t(i)], 3 + i);
        const Vec3T<D> p(D(point.x(), 0), D(point.y(), 1), D(point.z(), 2));
        const auto distorted = Model::distort(static_cast<const D*>(c.data()), p);
        if (!distorted) return std::nullopt;
        const D &x = distorted->x(), &y = distorted->y();
        const Intrinsics& k = lens.intrinsics;
        ProjectedPoint out;
        out.pixel = k.pixel_from_normalized(Vec2(x.a, y.a));
        if (!is_finite(out.pixel)) return std::nullopt;
        Eigen::Matrix<double, 2, 3 + kN> by;
        by << (k.fx * x.v + k.skew * y.v).transpose(), k.fy * y.v.transpose();
        out.by_point = by.template leftCols<3>();
        out.by_lens.resize(2, kK + kN);
        out.by_lens.leftCols(kK) << x.a, 0, 1, 0, y.a, 0, y.a, 0, 1, 0;
        out.by_lens.rightCols(kN) = by.template rightCols<kN>();
        return out;
      },
      lens.distortion);
}

namespace {

/// A pixel and its derivative as the point moves along `direction`.
struct ProjectedLine {
  Vec2 pixel, along;
};
std::optional<ProjectedLine> project_along(const Camera& lens, const Vec3& point, const Vec3& direction) {
  return std::visit(
      [&](const auto& model) -> std::optional<ProjectedLine> {
        using Model = std::decay_t<decltype(model)>;
        using D = Dual<1>;
        std::array<D, std::size_t(Model::kNumCoefficients) + 1> c;
        for (std::size_t i = 0; i < model.coefficients.size(); ++i) c[i] = D(model.coefficients[i]);
        const auto moving = [&](int i) { return D(point[i], D::Gradient(direction[i])); };
        const auto distorted =
            Model::distort(static_cast<const D*>(c.data()), Vec3T<D>(moving(0), moving(1), moving(2)));
        if (!distorted) return std::nullopt;
        const D &x = distorted->x(), &y = distorted->y();
        const Intrinsics& k = lens.intrinsics;
        const ProjectedLine out{k.pixel_from_normalized(Vec2(x.a, y.a)),
                                Vec2(k.fx * x.v[0] + k.skew * y.v[0], k.fy * y.v[0])};
        if (!is_finite(out.pixel)) return std::nullopt;
        return out;
      },
      lens.distortion);
}

/// How the ray moves with the lens while its pixel stays: pi(lens, d) = pixel.
std::optional<RayByLens> ray_by_lens(const Camera& lens, const Vec3& d) {
  const std::optional<ProjectedPoint> at = project_point(lens, d);
  if (!at) return std::nullopt;
  RayByLens out;
  out.setZero(3, at->by_lens.cols());
  out.topRows<2>() = -at->by_point.leftCols<2>().inverse() * at->by_lens;
  return out;
}

DeviceTerm device_term(const RoomState& state, int pose, int lens, const Mat2& weight,
                       const ProjectedPoint& projected) {
  const Mat23 by_rig =
      weight * projected.by_point * state.rig_from_device[std::size_t(pose)].rotation_matrix().transpose();
  return {pose, lens, by_rig, weight, projected};
}

Vec3 in_device(const AnchoredPoint& point, const Pose& rig_from_device) {
  return rig_from_device.rotation.conjugate() * Vec3(point.u - point.w * rig_from_device.translation);
}

}  // namespace

bool Adjustment::active(const RoomState& state, int point, int reading) const {
  const RoomPoint& p = points_.points[std::size_t(point)];
  const MapDevices& map = points_.maps[std::size_t(p.readings[std::size_t(reading)].map)];
  return state.solved[std::size_t(map.position)] && state.solved[std::size_t(projector_pose(map.projector))];
}

std::optional<AnchoredPoint> Adjustment::anchored_point(const RoomState& state, const Layout* layout,
                                                        int point) const {
  const LightReading& reading = points_.points[std::size_t(point)].readings[0];
  AnchoredPoint out;
  out.position = points_.maps[std::size_t(reading.map)].position;
  out.lens = camera_lens(out.position);
  out.w = state.inverse_depth[std::size_t(point)];
  if (!(std::abs(out.w) < 1e4) || !state.solved[std::size_t(out.position)]) return std::nullopt;
  const Camera& lens = state.lenses[std::size_t(out.lens)];
  const std::optional<Vec3> d = ray_of(lens, reading.camera_pixel);
  if (!d) return std::nullopt;
  const Pose& rig_from_anchor = state.rig_from_device[std::size_t(out.position)];
  out.rotation = rig_from_anchor.rotation_matrix();
  out.translation = rig_from_anchor.translation;
  out.u = out.rotation * *d + out.w * out.translation;
  if (layout == nullptr) return out;
  const std::vector<int>& columns = layout->lens[std::size_t(out.lens)];
  if (std::none_of(columns.begin(), columns.end(), [](int column) { return column >= 0; })) return out;
  const std::optional<RayByLens> by_lens = ray_by_lens(lens, *d);
  if (!by_lens) return std::nullopt;
  out.ray_by_lens = *by_lens;
  return out;
}

std::optional<Adjustment::DepthRows> Adjustment::depth_rows(const RoomState& state, int point) const {
  const std::optional<AnchoredPoint> anchored = anchored_point(state, nullptr, point);
  if (!anchored) return std::nullopt;
  const RoomPoint& p = points_.points[std::size_t(point)];
  const auto image = [&](int pose, int lens) {
    const Pose& place = state.rig_from_device[std::size_t(pose)];
    return project_along(state.lenses[std::size_t(lens)], in_device(*anchored, place),
                         place.rotation.conjugate() * Vec3(anchored->translation - place.translation));
  };
  DepthRows out;
  for (int r = 0; r < int(p.readings.size()); ++r) {
    if (!active(state, point, r)) continue;
    const LightReading& reading = p.readings[std::size_t(r)];
    const MapDevices& map = points_.maps[std::size_t(reading.map)];
    const auto light = image(projector_pose(map.projector), projector_lens(map.projector));
    if (!light) return std::nullopt;
    Vec2 residual = reading.projector_pixel - light->pixel, by_depth = -light->along;
    if (map.position != anchored->position) {
      const auto seen = image(map.position, camera_lens(map.position));
      if (!seen) return std::nullopt;
      residual += reading.projector_by_camera * (seen->pixel - reading.camera_pixel);
      by_depth += reading.projector_by_camera * seen->along;
    }
    out.add(by_depth.cwiseQuotient(reading.sigma), residual.cwiseQuotient(reading.sigma));
  }
  if (out.count == 0 || !std::isfinite(out.square) || !std::isfinite(out.curvature)) return std::nullopt;
  return out;
}

bool Adjustment::linearise(const RoomState& state, const Layout& layout, int point, Rows& rows,
                           bool only_anchor) const {
  rows.start();
  const std::optional<AnchoredPoint> anchored = anchored_point(state, &layout, point);
  if (!anchored) return false;
  const RoomPoint& p = points_.points[std::size_t(point)];
  for (int r = 0; r < (only_anchor ? 1 : int(p.readings.size())); ++r) {
    if (!active(state, point, r)) continue;
    const LightReading& reading = p.readings[std::size_t(r)];
    const MapDevices& map = points_.maps[std::size_t(reading.map)];
    ReadingRows& row = rows.next();
    row.region = region(reading);
    const Mat2 whiten = reading.sigma.cwiseInverse().asDiagonal();
    const int projector = projector_pose(map.projector), glass = projector_lens(map.projector);
    const auto light = project_point(state.lenses[std::size_t(glass)],
                                     in_device(*anchored, state.rig_from_device[std::size_t(projector)]));
    if (!light) return false;
    Vec2 residual = reading.projector_pixel - light->pixel;
    row.add(*anchored, state, layout, device_term(state, projector, glass, -whiten, *light));
    if (map.position != anchored->position) {
      const int lens = camera_lens(map.position);
      const auto image =
          project_point(state.lenses[std::size_t(lens)],
                        in_device(*anchored, state.rig_from_device[std::size_t(map.position)]));
      if (!image) return false;
      residual += reading.projector_by_camera * (image->pixel - reading.camera_pixel);
      const Mat2 weight = whiten * reading.projector_by_camera;
      row.add(*anchored, state, layout, device_term(state, map.position, lens, weight, *image));
    }
    row.residual = whiten * residual;
    if (!row.residual.allFinite() || !row.by_depth.allFinite()) return false;
  }
  return rows.count > 0;
}

PointFit Adjustment::fit(const RoomState& state, int point) const {
  const std::optional<DepthRows> rows = depth_rows(state, point);
  return rows ? PointFit{rows->square, 2 * rows->count - 1} : PointFit{};
}

bool Adjustment::refine_depth(RoomState& state, int point) const {
  double& w = state.inverse_depth[std::size_t(point)];
  for (int iteration = 0; iteration < 10; ++iteration) {
    const std::optional<DepthRows> rows = depth_rows(state, point);
    if (!rows || !(rows->curvature > 0)) break;
    const double step = -rows->slope / rows->curvature;
    w += step;
    if (!(w > 0)) break;
    if (std::abs(step) < 1e-9 * w) return true;
  }
  if (w > 0 && std::isfinite(w) && depth_rows(state, point)) return true;
  w = std::numeric_limits<double>::quiet_NaN();
  return false;
}

bool Adjustment::start_depth(RoomState& state, int point) const {
  const RoomPoint& p = points_.points[std::size_t(point)];
  double& w = state.inverse_depth[std::size_t(point)];
  w = std::numeric_limits<double>::quiet_NaN();
  const int anchor = points_.maps[std::size_t(p.readings[0].map)].position;
  if (!state.solved[std::size_t(anchor)]) return false;
  const std::optional<Vec3> d =
      ray_of(state.lenses[std::size_t(camera_lens(anchor))], p.readings[0].camera_pixel);
  if (!d) return false;
  const Pose& rig_from_anchor = state.rig_from_device[std::size_t(anchor)];
  // (R d + w t) is along the other device's ray e: the cross product with e is zero, linear in w.
  double over = 0, under = 0;
  const auto meet = [&](int pose, const Camera& lens, const Vec2& pixel) {
    const std::optional<Vec3> bearing = lens.unproject(pixel);
    if (!bearing) return;
    const Pose device_from_anchor = state.rig_from_device[std::size_t(pose)].inverse() * rig_from_anchor;
    const Vec3 a = bearing->cross(device_from_anchor.rotation * *d),
               b = bearing->cross(device_from_anchor.translation);
    over -= a.dot(b);
    under += b.squaredNorm();
  };
  for (int r = 0; r < int(p.readings.size()); ++r) {
    const LightReading& reading = p.readings[std::size_t(r)];
    const MapDevices& map = points_.maps[std::size_t(reading.map)];
    const int projector = projector_pose(map.projector);
    if (state.solved[std::size_t(projector)])
      meet(projector, state.lenses[std::size_t(projector_lens(map.projector))], reading.projector_pixel);
    if (map.position != anchor && state.solved[std::size_t(map.position)])
      meet(map.position, state.lenses[std::size_t(camera_lens(map.position))], reading.camera_pixel);
  }
  if (!(under > 0)) return false;
  const double start = over / under;
  if (!(start > 0) || !std::isfinite(start)) return false;
  w = start;
  return true;
}

}  // namespace procam::room
