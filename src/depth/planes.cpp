#include "procam/depth/planes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "cells.hpp"
#include "plane_estimate.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/se3.hpp"
#include "regions.hpp"

namespace procam::depth {
namespace {

using namespace internal;
constexpr int kCell = RayTable::kCell;
/// Readings of a cell: fewer, and an edge is near.
constexpr int kFewestOfClear = 40;

/// Are some of a cell's readings missing because they are beyond the farthest that the sensor gives? The mean
/// of the rest is too near, at 2.5 sigmas by 0.02 of them. Only where the noise averages: quantised readings
/// of something far have few values, of which one is the farthest.
bool is_cut(const CellGrid& grid, const Cell& cell) {
  const double z = 1 / double(cell.q);
  return grid.averages && cell.n < kCell * kCell && z + 2.5 * double(cell.sigma) * z * z > grid.farthest;
}

/// The cells of a region whose readings are not cut, and of them those that have only the region's own around
/// them, so that no edge of another surface reaches into them.
struct CellsOfRegion {
  std::vector<int> whole, clear;
};
CellsOfRegion cells_of(const CellGrid& grid, const std::vector<char>& alone, const Region& region) {
  CellsOfRegion out;
  for (const int at : region.cells) {
    const Cell& cell = grid.cells[std::size_t(at)];
    if (is_cut(grid, cell)) continue;
    out.whole.push_back(at);
    // Noise that averages is no less random where some readings are lost. Else lost readings are those out of
    // range or of a border.
    if (alone[std::size_t(at)] && cell.n >= (grid.averages ? kFewestOfClear : kCell * kCell - 1))
      out.clear.push_back(at);
  }
  return out;
}

/// Cells that another surface reaches into in spite of all: their means lie beyond three and a half robust
/// sigmas (of the median) of what the region's cells scatter. They are skipped, and the plane fitted again.
void drop_outliers(const CellGrid& grid, int least, std::vector<int>& cells, Moments& moments,
                   InverseDepthPlane& plane) {
  for (int round = 0; round < 3; ++round) {
    std::vector<float> off;
    off.reserve(cells.size());
    for (const int at : cells) {
      const Cell& cell = grid.cells[std::size_t(at)];
      const double r = double(cell.q) - plane.at(double(cell.u), double(cell.v));
      off.push_back(std::abs(float(r)) * std::sqrt(float(cell.n)) / cell.sigma);
    }
    const float gate = 3.5f * std::max(1.4826f * median(off), 1.0f);
    std::vector<int> kept;
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (off[i] < gate) kept.push_back(cells[i]);
    if (kept.size() == cells.size() || int(kept.size()) < std::max(least * 2 / 3, 4)) return;
    cells = std::move(kept);
    refit(grid, cells, moments, plane);
  }
}

/// Variance found over variance assumed: of readings, or, where neighbours share more than chance, what the
/// means of cells and of blocks of 4 x 4 of them show (batch means).
double noise_factor(const CellGrid& grid, const std::vector<int>& cells, const Moments& moments,
                    const InverseDepthPlane& plane) {
  const double of_readings = plane.error / std::max(moments.n - 3, 1.0);
  double factor = of_readings;
  struct Mean {
    double n = 0, sum = 0;
  };
  const auto judge = [&](double error, double count) {
    const double freedom = count - 3;
    if (freedom < 3) return;
    const double of_means = error / freedom;
    // Three sigmas of a mean square of this many: below, it is chance.
    if (of_means > of_readings * (1 + 3 * std::sqrt(2 / freedom))) factor = std::max(factor, of_means);
  };
  constexpr int kBlock = 4;
  const int columns = grid.columns / kBlock + 1;
  std::vector<Mean> blocks(std::size_t(columns) * std::size_t(grid.rows / kBlock + 1));
  double error = 0;
  for (const int at : cells) {
    const Cell& cell = grid.cells[std::size_t(at)];
    const double r = (double(cell.q) - plane.at(double(cell.u), double(cell.v))) / double(cell.sigma);
    error += cell.n * r * r;
    Mean& mean = blocks[std::size_t((at / grid.columns / kBlock) * columns + at % grid.columns / kBlock)];
    mean.n += cell.n;
    mean.sum += cell.n * r;
  }
  judge(error, double(cells.size()));
  error = 0;
  double count = 0;
  for (const Mean& mean : blocks)
    if (mean.n > 0) {
      error += mean.sum * mean.sum / mean.n;
      count += 1;
    }
  judge(error, count);
  return factor;
}

/// How far a narrow surface's cells may be off because of its borders, in sigmas of what readings share.
/// Chosen so that simulated rooms (docs/depth.md) have 95 % of small planes in their 95 % region.
constexpr double kAtBorder = 0.7;

/// Plane and covariance from t of 1/z = t . r, and from t's covariance.
PlaneEstimate estimate_of(const Vec3& t, const Mat3& covariance) {
  const double length = t.norm();
  const Vec3 direction = t / length;
  PlaneEstimate out;
  out.plane.normal = -direction;
  out.plane.offset = 1 / length;
  Eigen::Matrix<double, 4, 3> j;
  j.topRows<3>() = -(Mat3::Identity() - direction * direction.transpose()) / length;
  j.row(3) = -direction.transpose() / (length * length);
  out.covariance = j * covariance * j.transpose();
  return out;
}

/// What rounding to the image's unit adds to the covariance of t: an error of variance unit^2 / 12 in depth,
/// shared by all readings of one value, since sensors have steps of their own, each rounded the same way
/// every time. With s_i the sum of w r dq/dz over the readings of value i, and A the normal matrix:
///   A^-1 (unit^2 / 12 sum_i s_i s_i^T) A^-1
Mat3 rounding_covariance(const DepthImage& image, const RayTable& rays, const PlaneOptions& options,
                         const CellGrid& grid, const std::vector<int>& cells,
                         const Mat3& inverse_normal_matrix) {
  if (!image.units.data) return Mat3::Zero();
  const double unit = image.metres_per_unit;
  const int least = std::max(int(std::ceil(options.nearest / unit)), 1),
            most = int(std::min(options.farthest / unit, 65535.0));
  // One row of each cell stands for its eight.
  struct Row {
    const std::uint16_t* units;
    const float *u, *v;
    int count;
  };
  const auto row_of = [&](int at) {
    const int x0 = at % grid.columns * kCell;
    const int y = std::min(at / grid.columns * kCell + kCell / 2, image.units.height - 1);
    return Row{image.units.row(y) + x0, rays.u_from(x0, y), rays.v_from(x0, y),
               std::min(kCell, image.units.width - x0)};
  };
  int low = most, high = least;
  for (const int at : cells) {
    const Row row = row_of(at);
    for (int i = 0; i < row.count; ++i) {
      const int value = row.units[i];
      low = std::min(low, value < least ? most : value);
      high = std::max(high, value > most ? least : value);
    }
  }
  if (low > high) return Mat3::Zero();
  struct Sum {
    float u = 0, v = 0, one = 0;
  };
  std::vector<Sum> sums(std::size_t(high - low) + 1);
  for (const int at : cells) {
    const Row row = row_of(at);
    const Cell& cell = grid.cells[std::size_t(at)];
    const float w = kCell * cell.q * cell.q / (cell.sigma * cell.sigma);
    for (int i = 0; i < row.count; ++i) {
      const int value = row.units[i];
      if (value < low || value > high || std::isnan(row.u[i])) continue;
      Sum& sum = sums[std::size_t(value - low)];
      sum.u += w * row.u[i], sum.v += w * row.v[i], sum.one += w;
    }
  }
  Mat3 middle = Mat3::Zero();
  for (const Sum& sum : sums) {
    if (!(sum.one > 0)) continue;
    const Vec3 s(double(sum.u), double(sum.v), double(sum.one));
    middle.noalias() += s * s.transpose();
  }
  return unit * unit / 12 * inverse_normal_matrix * middle * inverse_normal_matrix;
}

/// Square metres that a pixel covers on a plane: z^3 / (offset fx fy).
double pixel_area(double z, double offset, const Intrinsics& k) {
  return z * z * z / (offset * k.fx * k.fy);
}

/// How far structure in the residuals may rotate the plane, radians. Where noise averages, cells differ from
/// the plane by their own noise. What they differ by beyond it comes from something else: readings of a
/// neighbour at the border, a step, a curve. It rotates the plane at most by its RMS over the region's extent
/// in the narrower direction.
double structured_rotation(const CellGrid& grid, const std::vector<int>& cells, const Moments& moments,
                           const InverseDepthPlane& plane) {
  double within = 0;
  for (const int at : cells) within += double(grid.cells[std::size_t(at)].error);
  const double between = (plane.error - within) / (3.0 * double(cells.size() - 1));
  const Cell& cell = grid.cells[std::size_t(cells.front())];
  const double rms = double(cell.sigma) * std::sqrt(3 * std::max(between - 1, 0.0) / cell.n);
  return rms / (narrow_extent(moments) * plane.t.norm());
}

/// The larger standard deviation of the normal, radians.
double normal_sigma(const PlaneEstimate& estimate) {
  const Mat2 c = turn_covariance(estimate).topLeftCorner<2, 2>();
  const double half = 0.5 * c.trace();
  return std::sqrt(half + std::sqrt(std::max(half * half - c.determinant(), 0.0)));
}

/// Where the noise averages, the uncertainty of a normal is known: a plane whose normal is not determined to
/// 5 degrees at two sigmas is rejected.
constexpr double kLargestNormalSigma = 2.5 * kDegree;
/// And what structure may rotate it by, at three sigmas of the same.
constexpr double kLargestStructuredRotation = 3 * kLargestNormalSigma;

/// A plane fitted to some cells of a region.
struct CellsFit {
  std::vector<int> cells;
  Moments moments;
  InverseDepthPlane plane;
  double noise_factor = 1;
  PlaneEstimate estimate;
};

/// Nothing where the cells do not determine a plane.
std::optional<CellsFit> fit_cells(const DepthImage& image, const CellGrid& grid, std::vector<int> cells,
                                  bool are_clear, const RayTable& rays, const PlaneOptions& options) {
  if (int(cells.size()) < options.min_cells) return std::nullopt;
  CellsFit out{std::move(cells), {}, {}, 1, {}};
  refit(grid, out.cells, out.moments, out.plane);
  drop_outliers(grid, options.min_cells, out.cells, out.moments, out.plane);
  if (!(out.plane.t.norm() > 1e-9)) return std::nullopt;
  if (grid.averages &&
      structured_rotation(grid, out.cells, out.moments, out.plane) > kLargestStructuredRotation)
    return std::nullopt;
  out.noise_factor = noise_factor(grid, out.cells, out.moments, out.plane);
  if (!are_clear) {
    // What reaches into a cell at the border moves its mean by a part of what the gates let through.
    const Cell& cell = grid.cells[std::size_t(out.cells.front())];
    const double ratio = kAtBorder * double(cell.shared / cell.sigma);
    out.noise_factor = std::max(out.noise_factor, 1 + cell.n * ratio * ratio);
  }
  const Eigen::LDLT<Mat3> solver(out.moments.normal_matrix());
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  const Mat3 inverse = solver.solve(Mat3::Identity());
  out.estimate =
      estimate_of(out.plane.t, out.noise_factor * inverse +
                                   rounding_covariance(image, rays, options, grid, out.cells, inverse));
  if (!out.estimate.covariance.allFinite()) return std::nullopt;
  if (grid.averages && normal_sigma(out.estimate) > kLargestNormalSigma) return std::nullopt;
  return out;
}

std::optional<DetectedPlane> plane_of(const DepthImage& image, const CellGrid& grid,
                                      const std::vector<char>& alone, const Region& region,
                                      const RayTable& rays, const PlaneOptions& options) {
  if (region.cells.empty()) return std::nullopt;  // taken by a curve
  const CellsOfRegion of_region = cells_of(grid, alone, region);
  std::optional<CellsFit> fit = fit_cells(image, grid, of_region.clear, true, rays, options);
  if (!fit) fit = fit_cells(image, grid, of_region.whole, false, rays, options);
  if (!fit) return std::nullopt;
  const auto& [core, moments, plane, factor, estimate] = *fit;
  DetectedPlane out;
  out.noise_factor = factor;
  out.estimate = estimate;
  const double offset = out.estimate.plane.offset;
  double squares = 0, noise_squares = 0, count = 0;
  // Where steps are part of it, all cells tell how flat it is.
  for (const int at : core) {
    const Cell& cell = grid.cells[std::size_t(at)];
    const double q = double(cell.q), off = q - plane.at(double(cell.u), double(cell.v));
    const double sigma2 = double(cell.sigma) * double(cell.sigma);
    const double to_metres = offset / q;  // of a residual of inverse depth, across the plane
    squares += (double(cell.error) * sigma2 + cell.n * off * off) * to_metres * to_metres;
    noise_squares += cell.n * sigma2 * to_metres * to_metres;
    count += cell.n;
  }
  out.rms = std::sqrt(squares / count);
  out.noise_rms = std::sqrt(noise_squares / count);
  for (const int at : region.cells) {
    const Cell& cell = grid.cells[std::size_t(at)];
    out.area += cell.n * pixel_area(1 / double(cell.q), offset, rays.camera().intrinsics);
  }
  if (out.area < options.min_area) return std::nullopt;
  out.middle = Vec3(moments.wu / moments.w, moments.wv / moments.w, 1);
  out.middle /= plane.t.dot(out.middle);
  return out;
}

/// Planes 1/z = a u + b v + c, and the region of each cell: below their number a plane's, else a curve's or none.
struct CellPlanes {
  const std::vector<int>& owner;
  const std::vector<Eigen::Vector3f>& planes;
};

/// Labels of pixels: inside a region what lies within noise of its plane; at borders the nearest of the
/// planes that meet there.
class Labeller {
 public:
  Labeller(const CellGrid& grid, const DepthImage& image, const RayTable& rays, const CellPlanes& found,
           const PlaneOptions& options, Planes& out)
      : grid_(grid),
        inverse_(image, rays, options),
        rays_(rays),
        owner_(found.owner),
        alone_(alone_cells(grid, found.owner)),
        planes_(found.planes),
        noise_(options.noise),
        out_(out) {}

  /// Pixels by label, from 0.
  const std::vector<int>& counts() const { return counts_; }

  void run() {
    counts_.assign(out_.planes.size() + out_.curves.size(), 0);
    out_.labels = Image<std::int16_t>(rays_.size());
    for (int row = 0; row < grid_.rows; ++row) {
      inverse_.read(row);
      for (int column = 0; column < grid_.columns; ++column) label(inverse_.cell(column), column, row);
    }
  }

 private:
  void label(const CellInput& input, int column, int row) {
    const int own = owner_[std::size_t(grid_.index(column, row))];
    of_.count = 0;
    if (own >= 0) add(own);
    if (!alone_[std::size_t(grid_.index(column, row))]) add_neighbours(column, row, own);
    const Cell& cell = grid_.at(column, row);
    std::int16_t rest = Planes::kNone;
    if (own >= int(planes_.size()) || own == kUnexplained) {
      // A whole cell of a curve or of something curved.
      rest = own == kUnexplained ? Planes::kCurved : std::int16_t(own);
      of_.count = 0;
      if (rest >= 0) counts_[std::size_t(rest)] += cell.n;
    }
    const bool inside = own >= 0 && of_.count == 1;
    // Beside another surface less is theirs.
    of_.gate = (inside ? 2.5f : 2.0f) * std::sqrt(cell.sigma * cell.sigma + cell.shared * cell.shared);
    if (of_.count > 0 && !(of_.gate > 0)) of_.gate = 2 * spread_at(input);
    const int x0 = column * kCell, y0 = row * kCell;
    const int width = std::min(kCell, rays_.size().width - x0),
              rows = std::min(kCell, rays_.size().height - y0);
    std::array<int, kMaxCandidates> pixels{};
    const OtherLabels others{rest, Planes::kNothing};
    if (width == kCell) {
      kernels_.label(input, rows, of_, others, {out_.labels.row(y0) + x0, rays_.size().width}, pixels);
    } else {
      std::array<std::int16_t, std::size_t(kCell) * kCell> labels{};
      kernels_.label(input, rows, of_, others, {labels.data(), kCell}, pixels);
      for (int y = 0; y < rows; ++y)
        std::copy_n(labels.data() + std::ptrdiff_t(y) * kCell, width, out_.labels.row(y0 + y) + x0);
    }
    for (std::size_t k = 0; k < of_.count; ++k) counts_[std::size_t(of_.id[k])] += pixels[k];
  }

  void add_neighbours(int column, int row, int own) {
    const int left = std::max(column - 1, 0), right = std::min(column + 1, grid_.columns - 1);
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, grid_.rows - 1); ++y)
      for (int x = left; x <= right; ++x) {
        const int other = owner_[std::size_t(grid_.index(x, y))];
        if (other >= 0 && other != own) add(other);
      }
  }
  void add(int id) {
    for (std::size_t k = 0; k < of_.count; ++k)
      if (of_.id[k] == id) return;
    if (of_.count == kMaxCandidates || id >= int(planes_.size())) return;
    const Eigen::Vector3f& t = planes_[std::size_t(id)];
    of_.id[of_.count] = id;
    of_.a[of_.count] = t.x();
    of_.b[of_.count] = t.y();
    of_.c[of_.count] = t.z();
    ++of_.count;
  }
  /// Of a cell too empty to have a sigma of its own: at its nearest reading.
  float spread_at(const CellInput& input) const {
    float q = 0;
    for (int y = 0; y < kCell; ++y)
      for (int x = 0; x < kCell; ++x) q = std::max(q, input.q.begin[y * input.q.stride + x]);
    if (!(q > 0)) return 0;
    const double z = 1 / double(q);
    return float(std::hypot(noise_.sigma(z), noise_.correlated_sigma(z))) * q * q;
  }

  const CellGrid& grid_;
  InverseRows inverse_;
  const RayTable& rays_;
  const std::vector<int>& owner_;
  const std::vector<char> alone_;
  const std::vector<Eigen::Vector3f>& planes_;
  const DepthNoise& noise_;
  Planes& out_;
  const PixelKernels& kernels_ = pixel_kernels();
  std::vector<int> counts_;
  Candidates of_;
};

void check(const DepthImage& image, const RayTable& rays, const PlaneOptions& options) {
  require(image.size() == rays.size(), "find_planes: the image is of " + std::to_string(image.size().width) +
                                           "x" + std::to_string(image.size().height) +
                                           " pixels, the camera's of " + std::to_string(rays.size().width) +
                                           "x" + std::to_string(rays.size().height));
  require(options.nearest > 0 && options.farthest > options.nearest && options.farthest < 1e4,
          "find_planes: the range must be 0 < nearest < farthest");
  require(options.min_cells >= 4 && options.min_area >= 0 && options.curvature_threshold > 0 &&
              options.noise.correlated_share >= 0,
          "find_planes: min_cells must be 4 or more, the other options positive");
}

}  // namespace

double noise_ratio(const DepthImage& image, const RayTable& rays, const DepthNoise& noise) {
  PlaneOptions options;
  options.noise = noise;
  check(image, rays, options);
  return cell_grid(image, rays, options).noise_ratio;
}

Planes find_planes(const DepthImage& image, const RayTable& rays, const PlaneOptions& options) {
  check(image, rays, options);
  const CellGrid grid = cell_grid(image, rays, options);
  Regions regions = grow_regions(grid, options);
  std::vector<Curve> curves = take_curves(grid, options, regions);

  Planes out;
  out.noise_ratio = grid.noise_ratio;
  std::vector<std::optional<DetectedPlane>> found;
  std::vector<int> order;
  const std::vector<char> alone = alone_cells(grid, regions.owner);
  for (std::size_t i = 0; i < regions.regions.size(); ++i) {
    found.push_back(plane_of(image, grid, alone, regions.regions[i], rays, options));
    if (found.back()) order.push_back(int(i));
  }
  const auto readings = [&](int i) { return regions.regions[std::size_t(i)].moments.n; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return readings(a) > readings(b); });
  std::vector<int> place(regions.regions.size(), -1);
  std::vector<Eigen::Vector3f> inverse_planes;
  for (const int i : order) {
    place[std::size_t(i)] = int(out.planes.size());
    out.planes.push_back(*found[std::size_t(i)]);
    const Plane& plane = out.planes.back().estimate.plane;
    inverse_planes.emplace_back((-plane.normal / plane.offset).cast<float>());
  }
  for (Curve& curve : curves) out.curves.push_back(curve.curve);
  for (int& owner : regions.owner) {
    if (owner >= 0)
      owner = place[std::size_t(owner)];
    else if (owner <= kCurveOwner)
      owner = int(out.planes.size()) + (kCurveOwner - owner);
  }
  Labeller labeller(grid, image, rays, {regions.owner, inverse_planes}, options, out);
  labeller.run();

  for (std::size_t i = 0; i < out.planes.size(); ++i) out.planes[i].pixels = labeller.counts()[i];
  for (std::size_t i = 0; i < out.curves.size(); ++i)
    out.curves[i].pixels = labeller.counts()[out.planes.size() + i];
  return out;
}

}  // namespace procam::depth
