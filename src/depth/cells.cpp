#include "cells.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace procam::depth::internal {
namespace {

constexpr int kCell = RayTable::kCell;
/// A cell's residual variance, in sigma^2, beyond which it holds an edge or something round. White noise of
/// 61 degrees of freedom stays below 1.7 in 9999 of 10000; sensors may be twice as noisy as their model.
constexpr double kFlatVariance = 4;
/// Readings that a cell needs for slopes of its own.
constexpr int kMinCellReadings = 24;

/// A focal length and its inverse.
struct Focal {
  double fx, one_fxth;
};

/// The cell's own plane, its noise, and its sums about the inverse depth q0 for regions, into a cell of which nothing is
/// known.
void fill(const Sums& s, const RayTable::CellRays& rays, const Focal& focal, double q0,
          const DepthNoise& noise, Cell& cell) {
  const auto [fx, one_fxth] = focal;
  cell.n = int(s.n);
  if (cell.n < kMinCellReadings) return;
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
  cell.shared = cell.shared_model = float(noise.correlated_sigma(z) * raw * raw);
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

/// The ratio of measured to predicted noise (Planes::noise_ratio): 0 where fewer than 30 cells show it.
double noise_ratio_of(const CellGrid& grid) {
  constexpr int kWhole = 40;           // readings: fewer, and an edge is near
  constexpr std::size_t kFewest = 30;  // cells
  // Of 61 degrees of freedom the lower quartile of the mean square is at 0.874 (chi-square).
  constexpr double kLowerQuartile = 0.874;
  std::vector<float> squares;
  squares.reserve(grid.cells.size());
  for (const Cell& cell : grid.cells)
    if (cell.n >= kWhole) squares.push_back(cell.error / float(cell.n - 3));
  if (squares.size() < kFewest) return 0;
  return std::sqrt(double(at_rank(squares, squares.size() / 4)) / kLowerQuartile);
}

/// What means of cells err by, over what they may share by the noise model (DepthNoise::correlated_sigma()
/// without its floor): from three flat cells in a row, whose inverse depths lie on a line where they show one
/// plane. With r what the middle one is off that line, r^2 has 3/2 of one mean's variance. The lower quartile
/// over the image, since triples across an edge only add large ones. 1 where too few triples say more.
double shared_ratio_of(const CellGrid& grid, double shared) {
  constexpr int kGap = 6;                    // cells: bands of quantised depth are narrower than twice that
  constexpr std::size_t kFewest = 60;        // triples
  constexpr double kLowerQuartile = 0.1015;  // of chi-square with one degree of freedom
  if (!(shared > 0)) return 1;
  std::vector<float> squares;
  squares.reserve(grid.cells.size() / 2);
  const auto add = [&](const Cell& a, const Cell& b, const Cell& c, float share) {
    if (!a.flat || !b.flat || !c.flat) return;
    const float off = b.q - a.q - share * (c.q - a.q), expected = float(shared) * b.sigma;
    const float square = off * off / (1.5f * expected * expected);
    if (square < 16) squares.push_back(square);  // beyond four sigmas it is no plane
  };
  for (int row = 0; row < grid.rows; row += 2)
    for (int column = 0; column < grid.columns; column += 2) {
      const Cell& b = grid.at(column, row);
      if (!b.flat) continue;
      if (column >= kGap && column + kGap < grid.columns) {
        const Cell &a = grid.at(column - kGap, row), &c = grid.at(column + kGap, row);
        add(a, b, c, (b.u - a.u) / (c.u - a.u));
      }
      if (row >= kGap && row + kGap < grid.rows) {
        const Cell &a = grid.at(column, row - kGap), &c = grid.at(column, row + kGap);
        add(a, b, c, (b.v - a.v) / (c.v - a.v));
      }
    }
  if (squares.size() < kFewest) return 1;
  return std::sqrt(double(at_rank(squares, squares.size() / 4)) / kLowerQuartile);
}

/// Cells as if the sensor's noise were `ratio` times its model; what they share is left as it is.
void scale_noise(double ratio, CellGrid& grid) {
  const double by_squareth = 1 / (ratio * ratio);
  for (Cell& cell : grid.cells) {
    if (cell.n < kMinCellReadings) continue;
    Moments& m = cell.moments;
    // The bias of 1 / z is by the noise that there is.
    const double more = (ratio * ratio - 1) * double(cell.sigma) * double(cell.sigma) / double(cell.q);
    cell.q -= float(more);
    m.wqq += more * (more * m.w - 2 * m.wq);
    m.wuq -= more * m.wu;
    m.wvq -= more * m.wv;
    m.wq -= more * m.w;
    cell.sigma *= float(ratio);
    cell.error *= float(by_squareth);
    cell.flat = double(cell.error) < kFlatVariance * (cell.n - 3);
    for (double* const sum : {&m.w, &m.wu, &m.wv, &m.wuu, &m.wuv, &m.wvv, &m.wq, &m.wuq, &m.wvq, &m.wqq})
      *sum *= by_squareth;
  }
}

/// What cells share is this share of the model's; the floor stays, which is of the sensor's calibration.
void share_less(const DepthNoise& noise, double share, CellGrid& grid) {
  for (Cell& cell : grid.cells) {
    if (cell.n < kMinCellReadings) continue;
    const double q = double(cell.q);
    cell.shared = float(
        std::hypot(share * noise.correlated_share * noise.sigma(1 / q), noise.correlated_floor) * q * q);
  }
}

/// The noise by what this image shows, where that is clearly something else than the model.
void measure_noise(const DepthNoise& noise, CellGrid& grid) {
  grid.noise_ratio = noise_ratio_of(grid);
  // Real structured light shows 0.6 to 1.7. Noise that is clearly below averages; twice what was measured
  // leaves room for what spans more than three cells. Quantised readings form bands whose means agree within
  // the band; they vary less within a cell than the model predicts.
  constexpr double kAverages = 0.45, kMargin = 2, kQuantised = 0.8;
  const double shared_ratio = shared_ratio_of(grid, noise.correlated_share);
  grid.averages = shared_ratio < kAverages && grid.noise_ratio > kQuantised;
  if (grid.averages) share_less(noise, kMargin * shared_ratio, grid);
  // Sensors of one kind differ by this much; beyond, cells of true planes would not count as flat.
  constexpr double kNoisier = 1.2, kNoisiest = 4;
  if (grid.noise_ratio > kNoisier) scale_noise(std::min(grid.noise_ratio, kNoisiest), grid);
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

float InverseRows::least() const {
  constexpr float kNone = std::numeric_limits<float>::max();
  std::array<float, 2 * kCell> least;  // independent, which compilers turn into vectors
  least.fill(kNone);
  const std::size_t row = std::size_t(stride_);
  for (std::size_t y = 0; y < kCell; y += kCell / 2)
    for (std::size_t x = 0; x + least.size() <= row; x += least.size())
      for (std::size_t i = 0; i < least.size(); ++i) {
        const float q = rows_[y * row + x + i], known = q > 0 ? q : kNone;
        least[i] = known < least[i] ? known : least[i];
      }
  return *std::min_element(least.begin(), least.end());
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
  float min_q = std::numeric_limits<float>::max();
  for (int row = 0; row < grid.rows; ++row) {
    inverse.read(row);
    min_q = std::min(min_q, inverse.least());
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
      fill(sums, cell_rays, {focal, one_focalth}, double(about.q0), options.noise, cell);
      cell.column = std::uint16_t(column);
    }
  }
  measure_noise(options.noise, grid);
  grid.farthest = 1 / double(min_q);
  return grid;
}

}  // namespace procam::depth::internal
