#pragma once
/// A depth image in cells of 8 x 8 pixels: what the rest is computed from.
#include <vector>

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

/// A plane as t of 1/z = t . (u, v, 1).
struct InverseDepthPlane {
  Vec3 t = Vec3::Zero();
  double error = 0;  ///< weighted sum of squared residuals

  double at(double u, double v) const { return t.x() * u + t.y() * v + t.z(); }
};
/// Weighted least squares. All zero when the readings do not determine a plane.
InverseDepthPlane fit(const Moments& moments);

struct Cell {
  int n = 0;             ///< readings
  bool flat = false;     ///< a plane fits it, and most of its pixels have a reading
  float u = 0, v = 0;    ///< mean ray of its readings
  float q = 0;           ///< its own plane there
  float gu = 0, gv = 0;  ///< the slopes of its own plane
  float vu = 0, vv = 0;  ///< variance of u, v
  float sigma = 0;       ///< of one reading of inverse depth
  float shared = 0;      ///< of what its readings may be off together
  float error = 0;       ///< sum of squared residuals of its own plane, in units of sigma^2
  Moments moments;       ///< weight 1 / sigma^2
};

struct CellGrid {
  int columns = 0, rows = 0;
  std::vector<Cell> cells;
  ImageF inverse_depth;  ///< 1 / z; 0 where there is no reading

  int index(int column, int row) const { return row * columns + column; }
  const Cell& at(int column, int row) const { return cells[std::size_t(index(column, row))]; }
};

CellGrid cell_grid(const DepthImage& image, const RayTable& rays, const PlaneOptions& options);

/// Do a cell's mean and slopes agree with a plane, within noise?
bool agrees(const Cell& cell, const Vec3& t);

}  // namespace procam::depth::internal
