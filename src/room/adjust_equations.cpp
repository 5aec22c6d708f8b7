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

AnchoredPoint anchored_point(int position, const Pose& rig_from_anchor, const Vec3& d, double w) {
  AnchoredPoint point;
  point.position = position;
  point.w = w;
  point.rotation = rig_from_anchor.rotation_matrix();
  point.translation = rig_from_anchor.translation;
  point.u = point.rotation * d + w * point.translation;
  return point;
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

}  // namespace

bool Adjustment::active(const RoomState& state, int point, int reading) const {
  const RoomPoint& p = points_.points[std::size_t(point)];
  const MapDevices& map = points_.maps[std::size_t(p.readings[std::size_t(reading)].map)];
  return state.solved[std::size_t(map.position)] && state.solved[std::size_t(projector_pose(map.projector))];
}

void Adjustment::take_columns(const Layout& layout, int anchor,
                              const std::vector<const LightReading*>& readings, Rows& rows) const {
  rows.columns.clear();
  rows.local.assign(std::size_t(layout.size), -1);
  const auto take = [&](int column) {
    if (column < 0 || rows.local[std::size_t(column)] >= 0) return;
    rows.local[std::size_t(column)] = int(rows.columns.size());
    rows.columns.push_back(column);
  };
  const auto take_pose = [&](int pose) {
    if (layout.pose[std::size_t(pose)] >= 0)
      for (int i = 0; i < 6; ++i) take(layout.pose[std::size_t(pose)] + i);
  };
  const auto take_lens = [&](int lens) {
    for (const int column : layout.lens[std::size_t(lens)]) take(column);
  };
  take_pose(anchor);
  take_lens(camera_lens(anchor));
  for (const LightReading* reading : readings) {
    const MapDevices& map = points_.maps[std::size_t(reading->map)];
    take_pose(map.position);
    take_lens(camera_lens(map.position));
    take_pose(projector_pose(map.projector));
    take_lens(projector_lens(map.projector));
  }
  rows.by_parameters.setZero(rows.count, Eigen::Index(rows.columns.size()));
}

bool Adjustment::linearise(const RoomState& state, const Layout* layout, int point, Rows& rows,
                           bool only_anchor) const {
  const RoomPoint& p = points_.points[std::size_t(point)];
  const int anchor = points_.maps[std::size_t(p.readings[0].map)].position;
  const double w = state.inverse_depth[std::size_t(point)];
  if (!std::isfinite(w) || !state.solved[std::size_t(anchor)]) return false;
  const Camera& anchor_lens = state.lenses[std::size_t(camera_lens(anchor))];
  const std::optional<Vec3> d = ray_of(anchor_lens, p.readings[0].camera_pixel);
  if (!d || !(std::abs(w) < 1e4)) return false;
  AnchoredPoint anchored = anchored_point(anchor, state.rig_from_device[std::size_t(anchor)], *d, w);

  std::vector<const LightReading*> in_use;
  for (int r = 0; r < (only_anchor ? 1 : int(p.readings.size())); ++r)
    if (active(state, point, r)) in_use.push_back(&p.readings[std::size_t(r)]);
  if (in_use.empty()) return false;
  rows.count = 2 * int(in_use.size());
  rows.residual.resize(rows.count);
  rows.by_depth.setZero(rows.count);
  rows.columns.clear();
  if (layout != nullptr) {
    take_columns(*layout, anchor, in_use, rows);
    const std::vector<int>& columns = layout->lens[std::size_t(camera_lens(anchor))];
    if (std::any_of(columns.begin(), columns.end(), [](int c) { return c >= 0; })) {
      const std::optional<RayByLens> by_lens = ray_by_lens(anchor_lens, *d);
      if (!by_lens) return false;
      anchored.ray_by_lens = *by_lens;
      anchored.lens_columns = &columns;
    }
  }

  for (std::size_t k = 0; k < in_use.size(); ++k) {
    const LightReading& reading = *in_use[k];
    const MapDevices& map = points_.maps[std::size_t(reading.map)];
    const int row = 2 * int(k);
    const Mat2 whiten = reading.sigma.cwiseInverse().asDiagonal();
    const auto place_in = [&](int pose) {
      const Pose& place = state.rig_from_device[std::size_t(pose)];
      return Vec3(place.rotation.conjugate() * (anchored.u - w * place.translation));
    };
    const int projector = projector_pose(map.projector), glass = projector_lens(map.projector);
    const auto light = project_point(state.lenses[std::size_t(glass)], place_in(projector));
    if (!light) return false;
    Vec2 residual = reading.projector_pixel - light->pixel;
    rows.add(row, anchored, state, layout, device_term(state, projector, glass, -whiten, *light));
    if (map.position != anchor) {
      const int lens = camera_lens(map.position);
      const auto image = project_point(state.lenses[std::size_t(lens)], place_in(map.position));
      if (!image) return false;
      residual += reading.projector_by_camera * (image->pixel - reading.camera_pixel);
      const Mat2 weight = whiten * reading.projector_by_camera;
      rows.add(row, anchored, state, layout, device_term(state, map.position, lens, weight, *image));
    }
    rows.residual.segment<2>(row) = whiten * residual;
  }
  return rows.residual.allFinite() && rows.by_depth.allFinite();
}

PointFit Adjustment::fit(const RoomState& state, int point) const {
  Rows rows;
  if (!linearise(state, nullptr, point, rows)) return {};
  return {rows.residual.squaredNorm(), rows.count - 1};
}

bool Adjustment::refine_depth(RoomState& state, int point) const {
  double& w = state.inverse_depth[std::size_t(point)];
  Rows rows;
  for (int iteration = 0; iteration < 10; ++iteration) {
    if (!linearise(state, nullptr, point, rows)) break;
    const double curvature = rows.by_depth.squaredNorm();
    if (!(curvature > 0)) break;
    const double step = -rows.by_depth.dot(rows.residual) / curvature;
    w += step;
    if (!(w > 0)) break;
    if (std::abs(step) < 1e-9 * w) return true;
  }
  if (w > 0 && std::isfinite(w) && linearise(state, nullptr, point, rows)) return true;
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
