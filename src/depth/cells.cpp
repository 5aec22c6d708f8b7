#include "cells.hpp"

#include <algorithm>
#include <array>

namespace procam::depth::internal {
namespace {

constexpr int kCell = RayTable::kCell;
/// A cell's residual variance, in sigma^2, beyond which it holds an edge or something round. White noise of
/// 61 degrees of freedom stays below 1.7 in 9999 of 10000; sensors may be twice as noisy as their model.
constexpr double kFlatVariance = 4;
/// Readings that a cell needs for slopes of its own.
constexpr int kLeastReadings = 24;

/// Rows of readings into rows of inverse depths, 0 where there is none.
void invert_row(const DepthImage& image, int y, float nearest, float farthest, int width, float* out) {
  if (image.units.data) {
    const std::uint16_t* in = image.units.row(y);
    const auto unit = float(image.metres_per_unit);
    for (int x = 0; x < width; ++x) {
      const float z = unit * float(in[x]);
      const float q = 1.0f / std::max(z, 1e-6f);
      out[x] = z >= nearest && z <= farthest ? q : 0.0f;
    }
  } else {
    const float* in = image.metres.row(y);
    for (int x = 0; x < width; ++x) {
      const float z = in[x];
      const bool good = z >= nearest && z <= farthest;  // false for NaN
      out[x] = good ? 1.0f / (good ? z : 1.0f) : 0.0f;
    }
  }
}

/// Sums over a cell's readings of p = q - q0 and of x, y, pixels about the cell's middle.
struct Sums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, p = 0, xp = 0, yp = 0, pp = 0;
};

/// Of a whole cell with all its readings: only the sums with p are new.
Sums sums_of_whole(const float* q, std::ptrdiff_t stride, int x0, int y0, const RayTable& rays,
                   const RayTable::CellRays& cell, float q0) {
  using Lane = std::array<float, kCell>;
  Lane p_sum{}, xp_sum{}, yp_sum{}, pp_sum{};
  const auto fx = float(rays.camera().intrinsics.fx), u0 = float(cell.u), v0 = float(cell.v);
  for (int row = 0; row < kCell; ++row, q += stride) {
    const float *const u = rays.u_from(x0, y0 + row), *const v = rays.v_from(x0, y0 + row);
    for (std::size_t i = 0; i < kCell; ++i) {
      const float p = q[i] - q0;
      p_sum[i] += p;
      pp_sum[i] += p * p;
      xp_sum[i] += p * (fx * (u[i] - u0));
      yp_sum[i] += p * (fx * (v[i] - v0));
    }
  }
  Sums s{kCell * kCell, cell.sx, cell.sy, cell.sxx, cell.sxy, cell.syy};
  for (std::size_t i = 0; i < kCell; ++i) {
    s.p += double(p_sum[i]);
    s.pp += double(pp_sum[i]);
    s.xp += double(xp_sum[i]);
    s.yp += double(yp_sum[i]);
  }
  return s;
}

Sums sums_of_part(const ImageF& inverse, const RayTable& rays, const RayTable::CellRays& cell, int x0, int y0,
                  float q0) {
  Sums s;
  const double fx = rays.camera().intrinsics.fx;
  for (int y = y0; y < std::min(y0 + kCell, inverse.height()); ++y)
    for (int x = x0; x < std::min(x0 + kCell, inverse.width()); ++x) {
      const float q = inverse.at(x, y);
      if (q <= 0) continue;
      const double p = double(q) - double(q0), dx = fx * (rays.u(x, y) - cell.u),
                   dy = fx * (rays.v(x, y) - cell.v);
      s.n += 1;
      s.x += dx, s.y += dy, s.xx += dx * dx, s.xy += dx * dy, s.yy += dy * dy;
      s.p += p, s.xp += dx * p, s.yp += dy * p, s.pp += p * p;
    }
  return s;
}

/// The cell's own plane, its noise, and its sums for regions.
Cell cell_of(const Sums& s, const RayTable::CellRays& rays, double fx, double q0, const DepthNoise& noise) {
  Cell cell;
  cell.n = int(s.n);
  if (cell.n < kLeastReadings) return cell;
  const double mx = s.x / s.n, my = s.y / s.n, mp = s.p / s.n;
  const double cxx = s.xx - s.n * mx * mx, cxy = s.xy - s.n * mx * my, cyy = s.yy - s.n * my * my;
  const double cxp = s.xp - s.n * mx * mp, cyp = s.yp - s.n * my * mp, cpp = s.pp - s.n * mp * mp;
  const double det = cxx * cyy - cxy * cxy;
  // Readings in one row or column only have no slope across it.
  if (!(det > 1e-3 * s.n * s.n)) return cell;
  const double gx = (cyy * cxp - cxy * cyp) / det, gy = (cxx * cyp - cxy * cxp) / det;
  const double residual = std::max(0.0, cpp - gx * cxp - gy * cyp);
  const double raw = q0 + mp, sigma = noise.sigma(1 / raw) * raw * raw, w = 1 / (sigma * sigma);
  // Noise is of z, and E[1 / (z + e)] = (1 + sigma^2 / z^2) / z: a bias of what a wall's sigma is at four
  // metres.
  const double excess = sigma * sigma / raw, q = raw - excess;
  cell.u = float(rays.u + mx / fx);
  cell.v = float(rays.v + my / fx);
  cell.q = float(q);
  cell.gu = float(gx * fx);
  cell.gv = float(gy * fx);
  cell.vu = float(cxx / (s.n * fx * fx));
  cell.vv = float(cyy / (s.n * fx * fx));
  cell.sigma = float(sigma);
  cell.shared = float(noise.shared_sigma(1 / q) * q * q);
  cell.error = float(residual * w);
  cell.flat = residual * w < kFlatVariance * (s.n - 3);
  // About the cell's middle first, then moved: small differences stay exact.
  const double u = rays.u, v = rays.v, su = s.x / fx, sv = s.y / fx;
  Moments& m = cell.moments;
  m.n = s.n;
  m.w = w * s.n;
  m.wu = w * (su + s.n * u);
  m.wv = w * (sv + s.n * v);
  m.wuu = w * (s.xx / (fx * fx) + 2 * u * su + s.n * u * u);
  m.wuv = w * (s.xy / (fx * fx) + u * sv + v * su + s.n * u * v);
  m.wvv = w * (s.yy / (fx * fx) + 2 * v * sv + s.n * v * v);
  q0 -= excess;
  const double sq = s.p + s.n * q0;
  m.wq = w * sq;
  m.wuq = w * (s.xp / fx + q0 * su + u * sq);
  m.wvq = w * (s.yp / fx + q0 * sv + v * sq);
  m.wqq = w * (s.pp + 2 * q0 * s.p + s.n * q0 * q0);
  return cell;
}

}  // namespace

InverseDepthPlane fit(const Moments& m) {
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

CellGrid cell_grid(const DepthImage& image, const RayTable& rays, const PlaneOptions& options) {
  CellGrid grid{rays.columns(), rays.rows(), {}, ImageF(rays.size())};
  grid.cells.resize(std::size_t(grid.columns) * std::size_t(grid.rows));
  const int width = rays.size().width, height = rays.size().height;
  const double fx = rays.camera().intrinsics.fx;
  for (int row = 0; row < grid.rows; ++row) {
    const int y0 = row * kCell;
    for (int y = y0; y < std::min(y0 + kCell, height); ++y)
      invert_row(image, y, float(options.nearest), float(options.farthest), width, grid.inverse_depth.row(y));
    for (int column = 0; column < grid.columns; ++column) {
      const int x0 = column * kCell;
      const RayTable::CellRays& cell_rays = rays.cell(column, row);
      if (!cell_rays.whole) {  // a pixel without a ray has no reading
        for (int y = y0; y < std::min(y0 + kCell, height); ++y)
          for (int x = x0; x < std::min(x0 + kCell, width); ++x)
            if (std::isnan(rays.u(x, y))) grid.inverse_depth.at(x, y) = 0;
      }
      const float* const q = grid.inverse_depth.row(y0) + x0;
      bool full = cell_rays.whole;
      float q0 = 0;
      if (full) {
        std::array<float, kCell> least;
        least.fill(1e9f);
        for (int y = 0; y < kCell; ++y)
          for (std::size_t i = 0; i < kCell; ++i)
            least[i] = std::min(least[i], q[std::ptrdiff_t(y) * width + std::ptrdiff_t(i)]);
        full = *std::min_element(least.begin(), least.end()) > 0;
        q0 = q[(kCell / 2) * width + kCell / 2];
      }
      if (!full) {
        for (int y = y0; q0 <= 0 && y < std::min(y0 + kCell, height); ++y)
          for (int x = x0; q0 <= 0 && x < std::min(x0 + kCell, width); ++x) q0 = grid.inverse_depth.at(x, y);
        if (q0 <= 0) continue;
      }
      const Sums sums = full ? sums_of_whole(q, width, x0, y0, rays, cell_rays, q0)
                             : sums_of_part(grid.inverse_depth, rays, cell_rays, x0, y0, q0);
      grid.cells[std::size_t(grid.index(column, row))] =
          cell_of(sums, cell_rays, fx, double(q0), options.noise);
    }
  }
  return grid;
}

bool agrees(const Cell& cell, const Vec3& t) {
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
