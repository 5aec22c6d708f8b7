#pragma once
/// A depth image in cells of 8 x 8 pixels: what the rest is computed from.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pixels.hpp"
#include "procam/depth/planes.hpp"

namespace procam::depth::internal {

/// Weighted sums over readings: rays r = (u, v, 1), inverse depths q. They add.
struct Moments {
  double w = 0, wu = 0, wv = 0, wuu = 0, wuv = 0, wvv = 0;  ///< sum of w r r^T
  double wq = 0, wuq = 0, wvq = 0, wqq = 0;                 ///< sums of w r q and w q^2
  double n = 0;                                             ///< readings

  Moments& operator+=(const Moments& o) {
    w += o.w, wu += o.wu, wv += o.wv, wuu += o.wuu, wuv += o.wuv, wvv += o.wvv;
    wq += o.wq, wuq += o.wuq, wvq += o.wvq, wqq += o.wqq, n += o.n;
    return *this;
  }
  Mat3 normal_matrix() const {
    Mat3 a;
    a << wuu, wuv, wu, wuv, wvv, wv, wu, wv, w;
    return a;
  }
};

/// Standard deviation of the readings' rays (u, v) in the direction in which it is the least.
inline double narrow_extent(const Moments& m) {
  const double u = m.wu / m.w, v = m.wv / m.w;
  const double uu = m.wuu / m.w - u * u, uv = m.wuv / m.w - u * v, vv = m.wvv / m.w - v * v;
  return std::sqrt(std::max(0.5 * (uu + vv - std::sqrt((uu - vv) * (uu - vv) + 4 * uv * uv)), 1e-12));
}

/// A plane as t of 1/z = t . (u, v, 1).
struct InverseDepthPlane {
  Vec3 t = Vec3::Zero();
  double error = 0;  ///< weighted sum of squared residuals

  double at(double u, double v) const { return t.x() * u + t.y() * v + t.z(); }
};
/// Weighted least squares. All zero when the readings do not determine a plane.
inline InverseDepthPlane fit(const Moments& m) {
  InverseDepthPlane out;
  if (!(m.w > 0)) return out;
  // Slopes about the mean, in closed form; the rest follows from it.
  const double u = m.wu / m.w, v = m.wv / m.w, q = m.wq / m.w;
  const double cuu = m.wuu - m.wu * u, cuv = m.wuv - m.wu * v, cvv = m.wvv - m.wv * v;
  const double cuq = m.wuq - m.wu * q, cvq = m.wvq - m.wv * q, cqq = m.wqq - m.wq * q;
  const double det = cuu * cvv - cuv * cuv;
  if (!(det > 1e-12 * cuu * cvv) || !(cuu > 0)) return out;
  const double gu = (cvv * cuq - cuv * cvq) / det, gv = (cuu * cvq - cuv * cuq) / det;
  out.t = Vec3(gu, gv, q - gu * u - gv * v);
  out.error = std::max(0.0, cqq - gu * cuq - gv * cvq);
  return out;
}

/// All but the moments lies in one line of the cache.
struct alignas(64) Cell {
  int n = 0;          ///< readings
  bool flat = false;  ///< a plane fits it, and most of its pixels have a reading
  std::uint16_t column = 0;
  float u = 0, v = 0;      ///< mean ray of its readings
  float q = 0;             ///< its own plane there
  float gu = 0, gv = 0;    ///< the slopes of its own plane
  float vu = 0, vv = 0;    ///< variance of u, v
  float sigma = 0;         ///< of one reading of inverse depth
  float shared = 0;        ///< of what its readings may be off together, as measured
  float shared_model = 0;  ///< the same by the noise model
  float error = 0;         ///< sum of squared residuals of its own plane, in units of sigma^2
  Moments moments;         ///< weight 1 / sigma^2
};

struct CellGrid {
  int columns = 0, rows = 0;
  std::vector<Cell> cells;
  double noise_ratio = 0;  ///< as in Planes
  double farthest = 0;     ///< reading, metres
  /// The image shows that the errors of cells' means average (white noise): Cell::shared is what was
  /// measured.
  bool averages = false;

  int index(int column, int row) const { return row * columns + column; }
  const Cell& at(int column, int row) const { return cells[std::size_t(index(column, row))]; }
};

/// Inverse depths of the rows of pixels of one row of cells, 0 where there is no reading: worked out when
/// they are needed, which is sooner done than fetching them from memory.
class InverseRows {
 public:
  InverseRows(const DepthImage& image, const RayTable& rays, const PlaneOptions& options);

  void read(int row);
  float at(int x, int y) const { return rows_[std::size_t(y - y0_) * std::size_t(stride_) + std::size_t(x)]; }
  /// The least inverse depth of the row of cells that was read, of two of its rows of pixels.
  float least() const;
  /// The pixels of a cell of the row that was read. What lies outside of the image has no reading.
  CellInput cell(int column) const;

 private:
  const DepthImage& image_;
  const RayTable& rays_;
  float nearest_, farthest_;
  int stride_, y0_ = 0;
  std::vector<float> rows_;
  // Rays of the row of cells that was read, from its first pixel; empty for a row that is cut.
  CellRows u_, v_;
  std::ptrdiff_t v_step_ = 0;  ///< from one cell's v to the next one's
  mutable std::array<float, std::size_t(2) * RayTable::kCell * RayTable::kCell>
      cut_{};  ///< rays of a cut cell
};

/// Sigmas and weights are by the noise model. Where the readings vary clearly more than it predicts
/// (noise_ratio), they are by what was measured.
CellGrid cell_grid(const DepthImage& image, const RayTable& rays, const PlaneOptions& options);

/// Do a cell's mean and slopes agree with a plane, within noise?
inline bool agrees(const Cell& cell, const Vec3& t) {
  // Three sigmas of the mean and of each slope. What the readings share bends a cell by half of it.
  constexpr float kGate = 3 * 3;
  const float own = cell.sigma * cell.sigma / float(cell.n), shared = cell.shared * cell.shared;
  const float a = float(t.x()), b = float(t.y());
  const float mean = cell.q - (a * cell.u + b * cell.v + float(t.z()));
  const float du = cell.gu - a, dv = cell.gv - b, slope_gate = kGate * (own + 0.25f * shared);
  return mean * mean < kGate * (own + shared) && du * du * cell.vu < slope_gate &&
         dv * dv * cell.vv < slope_gate;
}

}  // namespace procam::depth::internal
