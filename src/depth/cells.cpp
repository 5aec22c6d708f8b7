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

/// The cell's own plane, its noise, and its sums for regions, into a cell of which nothing is known.
void fill(const Sums& s, const RayTable::CellRays& rays, double fx, double one_fxth, double q0,
          const DepthNoise& noise, Cell& cell) {
  cell.n = int(s.n);
  if (cell.n < kLeastReadings) return;
  const double one_nth = 1 / s.n;
  const double mx = s.x * one_nth, my = s.y * one_nth, mp = s.p * one_nth;
  const double cxx = s.xx - s.x * mx, cxy = s.xy - s.x * my, cyy = s.yy - s.y * my;
  const double cxp = s.xp - s.x * mp, cyp = s.yp - s.y * mp, cpp = s.pp - s.p * mp;
  const double det = cxx * cyy - cxy * cxy;
  // Readings in one row or column only have no slope across it.
  if (!(det > 1e-3 * s.n * s.n)) return;
  const double one_detth = 1 / det;
  const double gx = (cyy * cxp - cxy * cyp) * one_detth, gy = (cxx * cyp - cxy * cxp) * one_detth;
  const double residual = std::max(0.0, cpp - gx * cxp - gy * cyp);
  const double raw = q0 + mp, z = 1 / raw;
  const double sigma = noise.sigma(z) * raw * raw, w = 1 / (sigma * sigma);
  // Noise is of z, and E[1 / (z + e)] = (1 + sigma^2 / z^2) / z: a bias of what a wall's sigma is at four
  // metres.
  const double excess = sigma * sigma * z, q = raw - excess;
  cell.u = float(rays.u + mx * one_fxth);
  cell.v = float(rays.v + my * one_fxth);
  cell.q = float(q);
  cell.gu = float(gx * fx);
  cell.gv = float(gy * fx);
  cell.vu = float(cxx * one_nth * one_fxth * one_fxth);
  cell.vv = float(cyy * one_nth * one_fxth * one_fxth);
  cell.sigma = float(sigma);
  cell.shared = float(noise.shared_sigma(z) * raw * raw);
  cell.error = float(residual * w);
  cell.flat = residual * w < kFlatVariance * (s.n - 3);
  // About the cell's middle first, then moved: small differences stay exact.
  const double u = rays.u, v = rays.v, su = s.x * one_fxth, sv = s.y * one_fxth;
  Moments& m = cell.moments;
  m.n = s.n;
  m.w = w * s.n;
  m.wu = w * (su + s.n * u);
  m.wv = w * (sv + s.n * v);
  m.wuu = w * (s.xx * one_fxth * one_fxth + 2 * u * su + s.n * u * u);
  m.wuv = w * (s.xy * one_fxth * one_fxth + u * sv + v * su + s.n * u * v);
  m.wvv = w * (s.yy * one_fxth * one_fxth + 2 * v * sv + s.n * v * v);
  q0 -= excess;
  const double sq = s.p + s.n * q0;
  m.wq = w * sq;
  m.wuq = w * (s.xp * one_fxth + q0 * su + u * sq);
  m.wvq = w * (s.yp * one_fxth + q0 * sv + v * sq);
  m.wqq = w * (s.pp + 2 * q0 * s.p + s.n * q0 * q0);
}

}  // namespace

InverseRows::InverseRows(const DepthImage& image, const RayTable& rays, const PlaneOptions& options)
    : image_(image),
      rays_(rays),
      nearest_(float(options.nearest)),
      farthest_(float(options.farthest)),
      stride_(rays.columns() * kCell),
      rows_(std::size_t(stride_) * kCell) {}

void InverseRows::read(int row) {
  const int width = rays_.size().width, whole = width / kCell * kCell, rest = width - whole;
  const PixelKernels& kernels = pixel_kernels();
  y0_ = row * kCell;
  u_ = v_ = {};
  if (width >= kCell && y0_ + kCell <= rays_.size().height) {
    u_ = {rays_.u_from(0, y0_), rays_.u_from(0, y0_ + 1) - rays_.u_from(0, y0_)};
    v_ = {rays_.v_from(0, y0_), rays_.v_from(0, y0_ + 1) - rays_.v_from(0, y0_)};
    v_step_ = rays_.v_from(kCell - 1, y0_) == v_.begin ? 0 : kCell;
  }
  const auto invert = [&](int y, const auto* in, const auto& kernel) {
    float* const out = rows_.data() + std::size_t(y - y0_) * std::size_t(stride_);
    kernel(in, whole, out);
    if (rest == 0) return;
    std::array<std::decay_t<decltype(*in)>, kCell> last{};
    std::copy_n(in + whole, rest, last.begin());
    kernel(last.data(), kCell, out + whole);
  };
  for (int y = y0_; y < y0_ + kCell; ++y) {
    float* const out = rows_.data() + std::size_t(y - y0_) * std::size_t(stride_);
    if (y >= rays_.size().height) {
      std::fill_n(out, stride_, 0.0f);
      continue;
    }
    if (image_.units.data) {
      const auto unit = float(image_.metres_per_unit);
      invert(y, image_.units.row(y), [&](const std::uint16_t* in, int count, float* to) {
        kernels.invert_units(in, count, unit, nearest_, farthest_, to);
      });
    } else {
      invert(y, image_.metres.row(y), [&](const float* in, int count, float* to) {
        kernels.invert_metres(in, count, nearest_, farthest_, to);
      });
    }
  }
  for (int column = 0; column < rays_.columns(); ++column) {
    if (rays_.cell(column, row).whole) continue;  // else a pixel without a ray has no reading
    const int x0 = column * kCell;
    for (int y = y0_; y < std::min(y0_ + kCell, rays_.size().height); ++y)
      for (int x = x0; x < std::min(x0 + kCell, width); ++x)
        if (std::isnan(rays_.u(x, y)))
          rows_[std::size_t(y - y0_) * std::size_t(stride_) + std::size_t(x)] = 0;
  }
}

CellInput InverseRows::cell(int column) const {
  const int x0 = column * kCell, y1 = std::min(y0_ + kCell, rays_.size().height);
  const CellRows q{rows_.data() + x0, stride_};
  if (x0 + kCell <= rays_.size().width && u_.begin)
    return {q, {u_.begin + x0, u_.stride}, {v_.begin + column * v_step_, v_.stride}};
  constexpr std::ptrdiff_t kPixels = std::ptrdiff_t(kCell) * kCell;
  for (int y = y0_; y < y1; ++y)
    for (int x = x0; x < std::min(x0 + kCell, rays_.size().width); ++x) {
      const std::ptrdiff_t at = std::ptrdiff_t(y - y0_) * kCell + (x - x0);
      cut_[std::size_t(at)] = rays_.u(x, y);
      cut_[std::size_t(kPixels + at)] = rays_.v(x, y);
    }
  return {q, {cut_.data(), kCell}, {cut_.data() + kPixels, kCell}};
}

CellGrid cell_grid(const DepthImage& image, const RayTable& rays, const PlaneOptions& options) {
  CellGrid grid{rays.columns(), rays.rows(), {}};
  grid.cells.reserve(std::size_t(grid.columns) * std::size_t(grid.rows));
  const double focal = rays.camera().intrinsics.fx, one_focalth = 1 / focal;
  const PixelKernels& kernels = pixel_kernels();
  InverseRows inverse(image, rays, options);
  for (int row = 0; row < grid.rows; ++row) {
    inverse.read(row);
    for (int column = 0; column < grid.columns; ++column) {
      const RayTable::CellRays& cell_rays = rays.cell(column, row);
      Cell& cell = grid.cells.emplace_back();  // in the order of their indices
      const CellInput input = inverse.cell(column);
      SumsAbout about{float(focal), float(cell_rays.u), float(cell_rays.v), 0};
      about.q0 = input.q.begin[(kCell / 2) * input.q.stride + kCell / 2];
      Sums sums{kCell * kCell, cell_rays.sx, cell_rays.sy, cell_rays.sxx, cell_rays.sxy, cell_rays.syy};
      if (!(cell_rays.whole && about.q0 > 0 && kernels.sum_whole(input, about, sums))) {
        for (int y = 0; about.q0 <= 0 && y < kCell; ++y)
          for (int x = 0; about.q0 <= 0 && x < kCell; ++x) about.q0 = input.q.begin[y * input.q.stride + x];
        if (about.q0 <= 0) continue;
        kernels.sum_some(input, about, sums);
      }
      fill(sums, cell_rays, focal, one_focalth, double(about.q0), options.noise, cell);
      cell.column = std::uint16_t(column);
    }
  }
  return grid;
}

}  // namespace procam::depth::internal
