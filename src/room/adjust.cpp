#include "adjust.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "procam/core/base/dual.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::room {
namespace {

constexpr double kScaleSigma = 1e-7;  // of the fixed distance: exact, and the system stays well conditioned
constexpr int kParts = 64;            // of the points; sums over them do not depend on the threads

/// (a, b, 1) of a pixel.
std::optional<Vec3> ray_of(const Camera& lens, const Vec2& pixel) {
  const std::optional<Vec3> bearing = lens.unproject(pixel);
  if (!bearing || !(bearing->z() > 1e-6)) return std::nullopt;
  return Vec3(*bearing / bearing->z());
}

struct Group {
  int offset = 0, size = 0;  ///< in the system
};

/// The step of Levenberg and Marquardt, the parameters scaled to a unit diagonal.
VecX damped_step(const Normal& system, double damping) {
  const VecX diagonal = system.information.diagonal().cwiseMax(1e-12);
  const VecX unit = diagonal.cwiseSqrt().cwiseInverse();
  MatX scaled = unit.asDiagonal() * system.information * unit.asDiagonal();
  scaled.diagonal().array() += damping;
  return -(unit.asDiagonal() * scaled.ldlt().solve(unit.asDiagonal() * system.gradient));
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

using RayByLens = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 16>;

/// A point on the ray d of its anchor, z = 1, and its inverse depth w along it: U = R d + w t, the anchor's pose being
/// (R, t), is w times the point in the rig's frame.
struct AnchoredPoint {
  int position = 0;  ///< the anchor's
  double w = 0;
  Vec3 u;
  Mat3 rotation;
  Vec3 translation;
  /// d by the anchor's lens, whose columns these are; no columns: the lens is fixed.
  RayByLens ray_by_lens;
  const std::vector<int>* lens_columns = nullptr;
};

/// What one device adds to a reading's derivatives.
struct DeviceTerm {
  int pose, lens;
  Mat23 by_rig_direction;  ///< the weighted derivative by U
  Mat2 weight;
  const ProjectedPoint& projected;
};

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

/// A point's equations: columns of the parameters in use, the depth's column, the residuals; whitened.
struct Adjustment::Rows {
  std::vector<int> columns;  ///< in the system
  MatX by_parameters;
  VecX by_depth, residual;
  int count = 0;
  std::vector<int> local;  ///< by system column; -1: not in use

  /// `layout` null: the depth's column alone.
  void add(int row, const AnchoredPoint& point, const RoomState& state, const Layout* layout,
           const DeviceTerm& term) {
    const Pose& place = state.rig_from_device[std::size_t(term.pose)];
    by_depth.segment<2>(row) += term.by_rig_direction * (point.translation - place.translation);
    if (layout == nullptr) return;
    const Mat23 rotated = term.by_rig_direction * hat(point.u);
    add_pose(row, layout->pose[std::size_t(point.position)], -rotated, point.w * term.by_rig_direction);
    add_pose(row, layout->pose[std::size_t(term.pose)], rotated, -point.w * term.by_rig_direction);
    if (point.lens_columns != nullptr) {
      const Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 16> by_lens =
          term.by_rig_direction * point.rotation * point.ray_by_lens;
      for (std::size_t i = 0; i < point.lens_columns->size(); ++i)
        if ((*point.lens_columns)[i] >= 0)
          by_parameters.block<2, 1>(row, local[std::size_t((*point.lens_columns)[i])]) +=
              by_lens.col(Eigen::Index(i));
    }
    const std::vector<int>& own = layout->lens[std::size_t(term.lens)];
    for (std::size_t i = 0; i < own.size(); ++i)
      if (own[i] >= 0)
        by_parameters.block<2, 1>(row, local[std::size_t(own[i])]) +=
            term.weight * term.projected.by_lens.col(Eigen::Index(i));
  }

 private:
  void add_pose(int row, int first, const Mat23& rotation, const Mat23& translation) {
    if (first < 0) return;
    const int at = local[std::size_t(first)];
    by_parameters.block<2, 3>(row, at) += rotation;
    by_parameters.block<2, 3>(row, at + 3) += translation;
  }
};

Adjustment::Adjustment(const RoomPoints& points, const AdjustOptions& options)
    : used(points.points.size(), 1), points_(points), options_(options) {}

bool Adjustment::active(const RoomState& state, int point, int reading) const {
  const RoomPoint& p = points_.points[std::size_t(point)];
  const MapDevices& map = points_.maps[std::size_t(p.readings[std::size_t(reading)].map)];
  return state.solved[std::size_t(map.position)] && state.solved[std::size_t(projector_pose(map.projector))];
}

Layout Adjustment::layout(const RoomState& state) const {
  Layout out;
  out.lens.resize(state.lenses.size());
  for (std::size_t l = 0; l < state.lenses.size(); ++l) {
    bool in_use = false;
    for (std::size_t p = 0; p < points_.positions.size(); ++p)
      in_use |= state.solved[p] && std::size_t(camera_lens(int(p))) == l;
    for (std::size_t p = 0; p < points_.projectors.size(); ++p)
      in_use |= state.solved[std::size_t(projector_pose(int(p)))] && std::size_t(projector_lens(int(p))) == l;
    out.lens[l].assign(options_.free[l].size(), -1);
    for (std::size_t i = 0; in_use && i < out.lens[l].size(); ++i)
      if (options_.free[l][i]) out.lens[l][i] = out.size++;
  }
  out.pose.assign(state.rig_from_device.size(), -1);
  double farthest = 0;
  const auto first =
      std::size_t(std::find(state.solved.begin(), state.solved.end(), 1) - state.solved.begin());
  for (std::size_t i = first + 1; i < out.pose.size(); ++i) {
    if (!state.solved[i]) continue;
    out.pose[i] = out.size;
    out.size += 6;
    const double distance = state.rig_from_device[i].translation.norm();
    if (distance > farthest) farthest = distance, out.scale_pose = int(i);
  }
  return out;
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

double Adjustment::prior_cost(const RoomState& state, const Layout& layout, Normal* normal) const {
  double cost = 0;
  for (const LensKnowledge& known : options_.known) {
    const VecX values = parameters_of(state.lenses[std::size_t(known.lens)]);
    double off = -known.value;
    bool free = false;
    for (const auto& [index, weight] : known.terms) {
      off += weight * values[index];
      free |= layout.lens[std::size_t(known.lens)][std::size_t(index)] >= 0;
    }
    if (!free) continue;
    off /= known.sigma;
    cost += off * off;
    if (normal == nullptr) continue;
    for (const auto& [i, weight_i] : known.terms) {
      const int row = layout.lens[std::size_t(known.lens)][std::size_t(i)];
      if (row < 0) continue;
      normal->gradient[row] += weight_i / known.sigma * off;
      for (const auto& [j, weight_j] : known.terms)
        if (const int column = layout.lens[std::size_t(known.lens)][std::size_t(j)]; column >= 0)
          normal->prior(row, column) += weight_i * weight_j / (known.sigma * known.sigma);
    }
  }
  if (layout.scale_pose >= 0 && normal != nullptr) {
    const Vec3& t = state.rig_from_device[std::size_t(layout.scale_pose)].translation;
    const int first = layout.pose[std::size_t(layout.scale_pose)] + 3;
    const double sigma = kScaleSigma * t.norm();
    const Vec3 along = t.normalized() / sigma;
    normal->prior.block<3, 3>(first, first) += along * along.transpose();
  }
  return cost;
}

Normal Adjustment::normal(const RoomState& state, const Layout& layout, double loss_square) const {
  const int count = int(points_.points.size());
  std::vector<Normal> parts(kParts);
  parallel_each(kParts, options_.threads, [&](int part) {
    Normal& sum = parts[std::size_t(part)];
    sum.information = MatX::Zero(layout.size, layout.size);
    sum.gradient = VecX::Zero(layout.size);
    Rows rows;
    for (int i = int(long(count) * part / kParts); i < int(long(count) * (part + 1) / kParts); ++i) {
      if (!used[std::size_t(i)] || !linearise(state, &layout, i, rows)) continue;
      const double square = rows.residual.squaredNorm();
      const double weight = loss_square > 0 ? std::pow(loss_square / (loss_square + square), 2) : 1;
      sum.cost += loss_square > 0 ? loss_square * square / (loss_square + square) : square;
      const double by_depth = rows.by_depth.squaredNorm();
      if (!(by_depth > 0)) continue;
      const VecX cross = rows.by_parameters.transpose() * rows.by_depth;
      const MatX local = weight * (rows.by_parameters.transpose() * rows.by_parameters -
                                   cross * cross.transpose() / by_depth);
      const VecX gradient = weight * (rows.by_parameters.transpose() * rows.residual -
                                      cross * (rows.by_depth.dot(rows.residual) / by_depth));
      for (int r = 0; r < int(rows.columns.size()); ++r) {
        sum.gradient[rows.columns[std::size_t(r)]] += gradient[r];
        for (int c = 0; c < int(rows.columns.size()); ++c)
          sum.information(rows.columns[std::size_t(r)], rows.columns[std::size_t(c)]) += local(r, c);
      }
    }
  });
  Normal out;
  out.information = MatX::Zero(layout.size, layout.size);
  out.gradient = VecX::Zero(layout.size);
  out.prior = MatX::Zero(layout.size, layout.size);
  for (const Normal& part : parts) {
    out.information += part.information;
    out.gradient += part.gradient;
    out.cost += part.cost;
  }
  out.cost += prior_cost(state, layout, &out);
  out.information += out.prior;
  return out;
}

double Adjustment::cost(const RoomState& state, const Layout& layout, double loss_square) const {
  const int count = int(points_.points.size());
  std::vector<double> parts(kParts);
  parallel_each(kParts, options_.threads, [&](int part) {
    Rows rows;
    for (int i = int(long(count) * part / kParts); i < int(long(count) * (part + 1) / kParts); ++i) {
      if (!used[std::size_t(i)] || !std::isfinite(state.inverse_depth[std::size_t(i)])) continue;
      const bool seen = linearise(state, nullptr, i, rows);
      // A point that a device cannot see costs as much as any outlier: it never scores zero.
      const double square = seen ? rows.residual.squaredNorm() : 1e12;
      parts[std::size_t(part)] += loss_square > 0 ? loss_square * square / (loss_square + square) : square;
    }
  });
  double sum = prior_cost(state, layout, nullptr);
  for (const double part : parts) sum += part;
  return sum;
}

double Adjustment::scatter(const RoomState& state) const {
  std::vector<double> values;
  for (int i = 0; i < int(points_.points.size()); ++i) {
    if (!used[std::size_t(i)]) continue;
    const PointFit point = fit(state, i);
    if (point.freedom < 1) continue;
    const double k = point.freedom;
    values.push_back(point.square / (k * std::pow(1 - 2 / (9 * k), 3)));  // over the median of chi-square
  }
  return values.empty() ? 1 : std::sqrt(median(values));
}

std::optional<Adjustment::DepthGradient> Adjustment::depth_gradient(const RoomState& state,
                                                                    const Layout& layout, int point,
                                                                    bool only_anchor) const {
  Rows rows;
  if (!linearise(state, &layout, point, rows, only_anchor)) return std::nullopt;
  const double w = state.inverse_depth[std::size_t(point)], by_depth = rows.by_depth.squaredNorm();
  if (!(by_depth > 0) || !(w > 0)) return std::nullopt;
  DepthGradient out{VecX::Zero(layout.size), 1 / (std::sqrt(by_depth) * w)};
  const VecX cross =
      rows.by_parameters.transpose() * rows.by_depth;  // dw = -cross / by_depth, dlog z = -dw / w
  for (int c = 0; c < int(rows.columns.size()); ++c)
    out.by_parameters[rows.columns[std::size_t(c)]] = cross[c] / (by_depth * w);
  return out;
}

RoomState Adjustment::moved(const RoomState& state, const Layout& layout, const VecX& step) const {
  RoomState out = state;
  for (std::size_t l = 0; l < layout.lens.size(); ++l) {
    VecX values = parameters_of(out.lenses[l]);
    for (std::size_t i = 0; i < layout.lens[l].size(); ++i)
      if (layout.lens[l][i] >= 0) values[Eigen::Index(i)] += step[layout.lens[l][i]];
    out.lenses[l] = with_parameters(out.lenses[l], values);
  }
  for (std::size_t p = 0; p < layout.pose.size(); ++p)
    if (layout.pose[p] >= 0)
      out.rig_from_device[p] =
          (se3_exp<double>(Vec6(step.segment<6>(layout.pose[p]))) * out.rig_from_device[p]).normalized();
  return out;
}

void Adjustment::settle_depths(RoomState& state) const {
  parallel_for(int(points_.points.size()), options_.threads, [&](int begin, int end) {
    Rows rows;
    for (int i = begin; i < end; ++i) {
      if (!used[std::size_t(i)] || !std::isfinite(state.inverse_depth[std::size_t(i)])) continue;
      for (int k = 0; k < 2; ++k) {
        if (!linearise(state, nullptr, i, rows)) break;
        const double curvature = rows.by_depth.squaredNorm();
        if (!(curvature > 0)) break;
        double& w = state.inverse_depth[std::size_t(i)];
        const double to = w - rows.by_depth.dot(rows.residual) / curvature;
        w = std::clamp(to, 0.3 * w, 3 * w);
      }
    }
  });
}

double Adjustment::solve(RoomState& state) const {
  const Layout layout = this->layout(state);
  double scale = std::max(scatter(state), 1e-6);
  const auto loss_of = [&](double s) {
    return options_.robust_sigmas > 0 ? std::pow(options_.robust_sigmas * s, 2) : 0;
  };
  double loss = loss_of(scale), damping = 1e-3;
  double current = cost(state, layout, loss);
  int still = 0;
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    const Normal system = normal(state, layout, loss);
    bool improved = false;
    for (int attempt = 0; attempt < 8 && !improved; ++attempt) {
      const VecX step = damped_step(system, damping);
      if (!step.allFinite()) {
        damping *= 10;
        continue;
      }
      RoomState next = moved(state, layout, step);
      settle_depths(next);
      const double trial = cost(next, layout, loss);
      if (trial < current) {
        improved = true;
        still = trial > current * (1 - 1e-7) ? still + 1 : 0;
        current = trial;
        state = std::move(next);
        damping = std::max(damping * 0.2, 1e-12);
      } else {
        damping *= 8;
      }
    }
    const double now = std::max(scatter(state), 1e-6);
    if (!improved || still >= 2) {
      if (std::abs(now / scale - 1) < 0.02 || !(options_.robust_sigmas > 0)) break;
      still = 0;
      damping = 1e-4;
    }
    if (options_.robust_sigmas > 0 && now < scale) {
      scale = now;
      loss = loss_of(scale);
      current = cost(state, layout, loss);
    } else if (!improved) {
      break;
    }
  }
  return scatter(state);
}

MatX Adjustment::covariance(const RoomState& state, const Layout& layout, const std::vector<int>& group,
                            int groups, double scale) const {
  const Normal system = normal(state, layout, 0);
  const MatX data = (system.information - system.prior) / (scale * scale);
  const MatX bread = data + system.prior;
  const VecX unit = bread.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX inverse = unit.asDiagonal() *
                       MatX(unit.asDiagonal() * bread * unit.asDiagonal())
                           .ldlt()
                           .solve(MatX::Identity(layout.size, layout.size)) *
                       unit.asDiagonal();
  // What each group of neighbouring points pulls: errors that neighbours share do not average out.
  MatX pulls = MatX::Zero(layout.size, groups);
  Rows rows;
  for (int i = 0; i < int(points_.points.size()); ++i) {
    if (!used[std::size_t(i)] || group[std::size_t(i)] < 0 || !linearise(state, &layout, i, rows)) continue;
    const double by_depth = rows.by_depth.squaredNorm();
    if (!(by_depth > 0)) continue;
    const VecX cross = rows.by_parameters.transpose() * rows.by_depth;
    const VecX gradient = rows.by_parameters.transpose() * rows.residual -
                          cross * (rows.by_depth.dot(rows.residual) / by_depth);
    for (int r = 0; r < int(rows.columns.size()); ++r)
      pulls(rows.columns[std::size_t(r)], group[std::size_t(i)]) += gradient[r] / (scale * scale);
  }
  // The fit has taken part of the pull away: as many groups' worth as it has parameters.
  const double left = std::max(1.0, double(groups) - layout.size);
  const MatX meat = pulls * pulls.transpose() * (groups / left) + system.prior;
  const MatX robust = inverse * meat * inverse;
  // By parameter the larger of both, correlations as the robust one has them.
  VecX stretch = VecX::Ones(layout.size);
  for (int i = 0; i < layout.size; ++i)
    if (robust(i, i) > 0) stretch[i] = std::sqrt(std::max(1.0, inverse(i, i) / robust(i, i)));
  return stretch.asDiagonal() * robust * stretch.asDiagonal();
}

}  // namespace procam::room
