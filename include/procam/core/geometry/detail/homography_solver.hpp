#pragma once
/// The engine of homography_fit.hpp and homography_robust.hpp: normalised columns of points, their moments,
/// and the 8 x 8 normal equations, solved through their blocks.
///
/// Both planes are moved to their weighted centroids and scaled to unit spread (Hartley 1997). The origin is
/// then inside the convex hull of the source points, so a homography that keeps all of them on one side of
/// the horizon has a positive denominator there: h33 = 1 is always possible, and h = (h11 h12 h13 h21 h22 h23
/// h31 h32) is a sound chart, which it is not in pixel coordinates.
///
/// With s = (x, y, 1), t = (x, y), q = 1 / (1 + h31 x + h32 y) and (a, b) the mapped point, the residual's
/// Jacobian rows are q [s, 0, -a t] and q [0, s, -b t], hence
///
///   J^T W J = [M 0 A; 0 M B; A^T B^T C],  M = sum w q^2 s s^T, A = -sum w q^2 a s t^T, B = -sum w q^2 b s
///   t^T,
///                                         C = sum w q^2 (a^2 + b^2) t t^T:
///
/// 19 moments, one 3 x 3 and one 2 x 2 inverse. The DLT's normal equations have the same form with q = 1 and
/// the measured (u, v) in the place of (a, b).
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::detail {

using Vec8 = Eigen::Matrix<double, 8, 1>;
using Mat8 = Eigen::Matrix<double, 8, 8>;
using Mat32 = Eigen::Matrix<double, 3, 2>;
/// Points are worked on two at a time: one SSE2 register a quantity.
inline constexpr int kLanes = 2;
using Lane = Eigen::Array<double, kLanes, 1>;

/// x, y, u, v, weight of all pairs as columns, moved and scaled; padded to whole lanes with weight zero.
struct NormalisedPairs {
  Eigen::Array<double, Eigen::Dynamic, 5> columns;
  Vec2 source_centre, destination_centre;
  double source_scale = 0.0, destination_scale = 0.0;  ///< normalised = scale * (p - centre)
  double weight_sum = 0.0;
  int used = 0;  ///< pairs with positive weight

  Lane lane(Eigen::Index i, int column) const {
    return Eigen::Map<const Lane, Eigen::Aligned16>(columns.data() + column * columns.rows() + i);
  }
  bool usable() const {
    return used >= 4 && std::isfinite(source_scale) && std::isfinite(destination_scale) &&
           source_scale > 0.0 && destination_scale > 0.0;
  }
};

/// `weights` empty means all one. Not usable() when coordinates are not finite or all points coincide.
inline NormalisedPairs normalise(const Points2& source, const Points2& destination,
                                 const std::vector<double>& weights) {
  const int count = int(source.size());
  const int padded = (count + kLanes - 1) / kLanes * kLanes;
  NormalisedPairs pairs;
  pairs.columns.resize(padded, 5);
  double* x = pairs.columns.data();
  double* y = x + padded;
  double* u = y + padded;
  double* v = u + padded;
  double* w = v + padded;

  // Sums about the first pair in use: a point among the others, so the spread below loses nothing to
  // cancellation.
  const auto is_used = [&](int i) { return weights.empty() || weights[i] > 0.0; };
  int first = 0;
  while (first < count && !is_used(first)) ++first;
  if (first == count) return pairs;
  const Eigen::Array2d source_first = source[first], destination_first = destination[first];
  Eigen::Array2d sum_s(0, 0), sum_ss(0, 0), sum_d(0, 0), sum_dd(0, 0);
  if (weights.empty()) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Array2d s = source[i].array() - source_first,
                           d = destination[i].array() - destination_first;
      sum_s += s, sum_ss += s * s, sum_d += d, sum_dd += d * d;
    }
    pairs.used = count;
    pairs.weight_sum = count;
  } else {
    for (int i = first; i < count; ++i) {
      if (!is_used(i)) continue;  // its coordinates may be anything
      const Eigen::Array2d s = source[i].array() - source_first,
                           d = destination[i].array() - destination_first;
      sum_s += weights[i] * s, sum_ss += weights[i] * s * s, sum_d += weights[i] * d,
          sum_dd += weights[i] * d * d;
      ++pairs.used;
      pairs.weight_sum += weights[i];
    }
  }
  const double total = pairs.weight_sum;
  sum_s /= total, sum_d /= total;
  // Unit variance a coordinate keeps all moments near one.
  const double source_spread = (sum_ss / total - sum_s * sum_s).sum();
  const double destination_spread = (sum_dd / total - sum_d * sum_d).sum();
  pairs.source_centre = source_first + sum_s;
  pairs.destination_centre = destination_first + sum_d;
  pairs.source_scale = std::sqrt(2.0 / source_spread);
  pairs.destination_scale = std::sqrt(2.0 / destination_spread);

  const Vec2 sc = pairs.source_centre, dc = pairs.destination_centre;
  const double ks = pairs.source_scale, kd = pairs.destination_scale;
  const auto write = [&](int i, double weight) {
    x[i] = (source[i].x() - sc.x()) * ks;
    y[i] = (source[i].y() - sc.y()) * ks;
    u[i] = (destination[i].x() - dc.x()) * kd;
    v[i] = (destination[i].y() - dc.y()) * kd;
    w[i] = weight;
  };
  const auto write_unused = [&](int i) { x[i] = y[i] = u[i] = v[i] = w[i] = 0.0; };
  if (weights.empty())
    for (int i = 0; i < count; ++i) write(i, 1.0);
  else
    for (int i = 0; i < count; ++i) is_used(i) ? write(i, weights[i]) : write_unused(i);
  for (int i = count; i < padded; ++i) write_unused(i);
  return pairs;
}

/// The blocks of J^T W J and the gradient J^T W r (r = mapped - measured).
struct NormalEquations {
  Mat3 m = Mat3::Zero();
  Mat32 a = Mat32::Zero(), b = Mat32::Zero();
  Mat2 c = Mat2::Zero();
  Vec8 gradient = Vec8::Zero();
  double cost = 0.0;                  ///< sum w |r|^2
  double smallest_denominator = 1.0;  ///< over the points in use; not positive: across the horizon

  Mat8 matrix() const {
    Mat8 full;
    full << m, Mat3::Zero(), a, Mat3::Zero(), m, b, a.transpose(), b.transpose(), c;
    return full;
  }
};

/// The inverse of the blocks: M^-1, K = [M^-1 A; M^-1 B], and the Schur complement of C inverted.
struct BlockInverse {
  Mat3 m;
  Mat32 ka, kb;
  Mat2 s;
  bool regular = false;

  BlockInverse() = default;
  BlockInverse(const NormalEquations& n, double damping) {
    Mat3 block = n.m;
    block.diagonal() *= 1.0 + damping;
    const double determinant = block.determinant();
    m = block.inverse();
    ka = m * n.a;
    kb = m * n.b;
    Mat2 schur = n.c;
    schur.diagonal() *= 1.0 + damping;
    schur -= n.a.transpose() * ka + n.b.transpose() * kb;
    const double schur_determinant = schur.determinant();
    s = schur.inverse();
    // Relative to the blocks themselves: what is left after rounding is no information.
    constexpr double kRounding = 1e-13;
    regular = determinant > kRounding * block.diagonal().prod() &&
              schur_determinant > kRounding * kRounding * n.c.diagonal().prod();
  }

  Vec8 solve(const Vec8& g) const {
    const Vec3 ya = m * g.head<3>(), yb = m * g.segment<3>(3);
    const Vec2 z = s * (g.tail<2>() - ka.transpose() * g.head<3>() - kb.transpose() * g.segment<3>(3));
    Vec8 x;
    x << ya - ka * z, yb - kb * z, z;
    return x;
  }

  Mat8 matrix() const {
    const Mat32 as = ka * s, bs = kb * s;
    Mat8 full;
    full << m + as * ka.transpose(), as * kb.transpose(), -as,  //
        bs * ka.transpose(), m + bs * kb.transpose(), -bs,      //
        -as.transpose(), -bs.transpose(), s;
    return full;
  }
};

/// The DLT's normal equations at h = 0 with the scale fixed by h33 = 1: minus the solution's gradient.
inline NormalEquations dlt_equations(const NormalisedPairs& pairs) {
  Lane w0 = Lane::Zero(), wxx = w0, wxy = w0, wyy = w0, wx = w0, wy = w0;
  Lane ux = w0, uy = w0, uxx = w0, uxy = w0, uyy = w0, vx = w0, vy = w0, vxx = w0, vxy = w0, vyy = w0;
  Lane px = w0, py = w0, pxx = w0, pxy = w0, pyy = w0;
  for (Eigen::Index i = 0; i < pairs.columns.rows(); i += kLanes) {
    const Lane x = pairs.lane(i, 0), y = pairs.lane(i, 1), u = pairs.lane(i, 2), v = pairs.lane(i, 3);
    const Lane w = pairs.lane(i, 4);
    const Lane ax = w * x, ay = w * y, axx = ax * x, axy = ax * y, ayy = ay * y, p = u * u + v * v;
    w0 += w, wx += ax, wy += ay, wxx += axx, wxy += axy, wyy += ayy;
    ux += u * ax, uy += u * ay, uxx += u * axx, uxy += u * axy, uyy += u * ayy;
    vx += v * ax, vy += v * ay, vxx += v * axx, vxy += v * axy, vyy += v * ayy;
    px += p * ax, py += p * ay, pxx += p * axx, pxy += p * axy, pyy += p * ayy;
  }
  NormalEquations n;
  n.m << wxx.sum(), wxy.sum(), wx.sum(), wxy.sum(), wyy.sum(), wy.sum(), wx.sum(), wy.sum(), w0.sum();
  n.a << -uxx.sum(), -uxy.sum(), -uxy.sum(), -uyy.sum(), -ux.sum(), -uy.sum();
  n.b << -vxx.sum(), -vxy.sum(), -vxy.sum(), -vyy.sum(), -vx.sum(), -vy.sum();
  n.c << pxx.sum(), pxy.sum(), pxy.sum(), pyy.sum();
  // The centroid is the origin, so sum w u = sum w v = 0.
  n.gradient << -ux.sum(), -uy.sum(), 0.0, -vx.sum(), -vy.sum(), 0.0, px.sum(), py.sum();
  return n;
}

/// Cost and gradient of the geometric error at h; the blocks too if asked (a frozen J^T W J needs only the
/// gradient). Runs over short stretches, first the gradient, then the moments in two groups: each keeps its
/// sums in registers.
template <bool kWithBlocks>
NormalEquations geometric_equations(const NormalisedPairs& pairs, const Vec8& h) {
  constexpr Eigen::Index kStretch = 64 * kLanes;
  Eigen::Array<double, kWithBlocks ? kStretch : 1, 4> kept;  // w q^2, then that times a, b, a^2 + b^2
  double* const kept_k = kept.data();
  double* const kept_a = kept_k + kept.rows();
  double* const kept_b = kept_a + kept.rows();
  double* const kept_p = kept_b + kept.rows();
  const auto at = [](double* p) { return Eigen::Map<Lane, Eigen::Aligned16>(p); };

  const Lane zero = Lane::Zero();
  Lane m0 = zero, mx = zero, my = zero, mxx = zero, mxy = zero, myy = zero, cxx = zero, cxy = zero,
       cyy = zero;
  Lane ax = zero, ay = zero, axx = zero, axy = zero, ayy = zero, bx = zero, by = zero, bxx = zero, bxy = zero,
       byy = zero;
  Lane g0 = zero, g1 = zero, g2 = zero, g3 = zero, g4 = zero, g5 = zero, g6 = zero, g7 = zero;
  Lane cost = zero, smallest = Lane::Ones();
  const Eigen::Index rows = pairs.columns.rows();
  for (Eigen::Index begin = 0; begin < rows; begin += kStretch) {
    const Eigen::Index end = std::min(begin + kStretch, rows);
    for (Eigen::Index i = begin; i < end; i += kLanes) {
      const Lane x = pairs.lane(i, 0), y = pairs.lane(i, 1), w = pairs.lane(i, 4);
      const Lane denominator = h[6] * x + h[7] * y + 1.0;  // 1 at unused points, which sit at the origin
      const Lane q = Lane::Ones() / denominator;
      const Lane a = (h[0] * x + h[1] * y + h[2]) * q, b = (h[3] * x + h[4] * y + h[5]) * q;
      const Lane ra = a - pairs.lane(i, 2), rb = b - pairs.lane(i, 3);
      const Lane wq = w * q, wa = wq * ra, wb = wq * rb, wc = a * wa + b * wb;
      smallest = smallest.min(denominator);
      cost += w * (ra * ra + rb * rb);
      g0 += wa * x, g1 += wa * y, g2 += wa, g3 += wb * x, g4 += wb * y, g5 += wb, g6 -= wc * x, g7 -= wc * y;
      if constexpr (kWithBlocks) {
        const Lane k = wq * q;
        const Lane ka = a * k, kb = b * k;
        at(kept_k + (i - begin)) = k;
        at(kept_a + (i - begin)) = ka;
        at(kept_b + (i - begin)) = kb;
        at(kept_p + (i - begin)) = a * ka + b * kb;
      }
    }
    if constexpr (kWithBlocks) {
      for (Eigen::Index i = begin; i < end; i += kLanes) {
        const Lane x = pairs.lane(i, 0), y = pairs.lane(i, 1), k = at(kept_k + (i - begin));
        const Lane p = at(kept_p + (i - begin)), kx = k * x, ky = k * y;
        m0 += k, mx += kx, my += ky, mxx += kx * x, mxy += kx * y, myy += ky * y;
        const Lane px = p * x, py = p * y;
        cxx += px * x, cxy += px * y, cyy += py * y;
      }
      for (Eigen::Index i = begin; i < end; i += kLanes) {
        const Lane x = pairs.lane(i, 0), y = pairs.lane(i, 1);
        const Lane ka = at(kept_a + (i - begin)), kb = at(kept_b + (i - begin));
        const Lane kax = ka * x, kay = ka * y, kbx = kb * x, kby = kb * y;
        ax -= kax, ay -= kay, axx -= kax * x, axy -= kax * y, ayy -= kay * y;
        bx -= kbx, by -= kby, bxx -= kbx * x, bxy -= kbx * y, byy -= kby * y;
      }
    }
  }
  NormalEquations n;
  n.gradient << g0.sum(), g1.sum(), g2.sum(), g3.sum(), g4.sum(), g5.sum(), g6.sum(), g7.sum();
  n.cost = cost.sum();
  n.smallest_denominator = smallest.minCoeff();
  if constexpr (kWithBlocks) {
    n.m << mxx.sum(), mxy.sum(), mx.sum(), mxy.sum(), myy.sum(), my.sum(), mx.sum(), my.sum(), m0.sum();
    n.a << axx.sum(), axy.sum(), axy.sum(), ayy.sum(), ax.sum(), ay.sum();
    n.b << bxx.sum(), bxy.sum(), bxy.sum(), byy.sum(), bx.sum(), by.sum();
    n.c << cxx.sum(), cxy.sum(), cxy.sum(), cyy.sum();
  }
  return n;
}

/// The minimum of sum w |mapped - measured|^2 in normalised coordinates.
struct GeometricMinimum {
  enum class Status { kOk, kSingular, kHorizon, kNotConverged };
  Status status = Status::kSingular;
  Vec8 h = Vec8::Zero();
  NormalEquations equations;  ///< with blocks, at the last linearisation
  BlockInverse inverse;       ///< of those blocks, undamped
};

/// The minimum of the algebraic error, or nullopt when the normal equations are singular.
inline std::optional<Vec8> solve_dlt(const NormalisedPairs& pairs) {
  const NormalEquations n = dlt_equations(pairs);
  const BlockInverse inverse(n, 0.0);
  if (!inverse.regular) return std::nullopt;
  return Vec8(-inverse.solve(n.gradient));
}

/// Gauss-Newton from the DLT; a step that raises the cost or crosses the horizon is damped
/// (Levenberg-Marquardt). While steps are small J^T W J is kept (it changes by a fraction of the order of the
/// step) and only the gradient is renewed. Gauss-Newton's step shrinks by a factor of its own size each time,
/// so the step after one of size |d| that drops the cost by `promise` would drop it by about promise |d|^2:
/// when that is below `tolerance` of the cost, the step is taken without looking back.
inline GeometricMinimum minimise_geometric(const NormalisedPairs& pairs, int max_iterations,
                                           double tolerance) {
  using Status = GeometricMinimum::Status;
  GeometricMinimum best;
  const std::optional<Vec8> start = solve_dlt(pairs);
  if (!start) return best;
  best.h = *start;
  best.equations = geometric_equations<true>(pairs, best.h);
  if (!(best.equations.smallest_denominator > 0.0)) {
    best.status = Status::kHorizon;
    return best;
  }
  constexpr double kSmallStep = 1e-2;
  // Below this the cost is the rounding of coordinates of order one and cannot fall further.
  const double rounding = pairs.weight_sum * 1e-28;
  double cost = best.equations.cost, damping = 0.0;
  Vec8 gradient = best.equations.gradient;
  best.inverse = BlockInverse(best.equations, damping);
  for (int iteration = 0; iteration < max_iterations && best.inverse.regular; ++iteration) {
    const Vec8 step = -best.inverse.solve(gradient);
    const double promise = -step.dot(gradient), squared_step = step.squaredNorm();
    if (damping == 0.0 && promise * std::min(squared_step, 1.0) <= tolerance * cost + rounding &&
        squared_step < kSmallStep * kSmallStep) {
      best.h += step;
      best.status = Status::kOk;
      return best;
    }
    const bool renew = damping > 0.0 || squared_step > kSmallStep * kSmallStep || iteration % 4 == 3;
    const Vec8 next = best.h + step;
    const NormalEquations trial =
        renew ? geometric_equations<true>(pairs, next) : geometric_equations<false>(pairs, next);
    if (trial.smallest_denominator > 0.0 && trial.cost <= cost) {
      best.h = next;
      cost = trial.cost;
      gradient = trial.gradient;
      damping = damping < 1e-4 ? 0.0 : damping * 0.1;
      if (!renew) continue;
      best.equations = trial;
    } else {
      damping = damping == 0.0 ? 1e-3 : damping * 10.0;
      if (damping > 1e12) break;
      best.equations = geometric_equations<true>(pairs, best.h);
      gradient = best.equations.gradient;
    }
    best.inverse = BlockInverse(best.equations, damping);
  }
  best.status = best.inverse.regular ? Status::kNotConverged : Status::kSingular;
  return best;
}

/// The normalised parameters as a matrix between the original planes, positive denominators at the points.
inline Mat3 denormalise(const NormalisedPairs& pairs, const Vec8& h) {
  const double k = pairs.source_scale, inverse_scale = 1.0 / pairs.destination_scale;
  Mat3 normalised_from_source, matrix;
  normalised_from_source << k, 0.0, -k * pairs.source_centre.x(), 0.0, k, -k * pairs.source_centre.y(), 0.0,
      0.0, 1.0;
  matrix << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0;
  matrix *= normalised_from_source;
  matrix.row(0) = matrix.row(0) * inverse_scale + pairs.destination_centre.x() * matrix.row(2);
  matrix.row(1) = matrix.row(1) * inverse_scale + pairs.destination_centre.y() * matrix.row(2);
  return matrix;
}

}  // namespace procam::detail
