#include "curve_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

#include "procam/core/base/stats.hpp"

namespace procam::depth::internal {
namespace {

constexpr double kMinRadius = 0.03, kLargestRadius = 20;
/// RMS of the cells, in sigmas of what readings share, at which a shape explains them.
constexpr double kExplains = 1.5;
/// And at which nothing will.
constexpr double kHopeless = 3;

/// Beyond four sigmas a cell is of something else.
constexpr double kMaxSquare = 16;
double clipped_square(double residual) {
  return std::min(residual * residual, kMaxSquare);
}

/// Four samples beside each other, which the processor works on two at a time: most of the time of finding
/// curves goes into refine().
struct FourSamples {
  std::array<Eigen::Array4d, 3> point, ray;
  Eigen::Array4d inverse_sigma = Eigen::Array4d::Zero();  ///< 0: no sample
};
std::vector<FourSamples> by_fours(const std::vector<Sample>& samples) {
  std::vector<FourSamples> out((samples.size() + 3) / 4);
  for (std::size_t i = 0; i < 4 * out.size(); ++i) {
    FourSamples& four = out[i / 4];
    const auto lane = Eigen::Index(i % 4);
    const Sample& s = samples[std::min(i, samples.size() - 1)];
    for (std::size_t k = 0; k < 3; ++k) {
      four.point[k][lane] = s.point[Eigen::Index(k)];
      four.ray[k][lane] = s.ray[Eigen::Index(k)];
    }
    if (i < samples.size()) four.inverse_sigma[lane] = 1 / s.sigma;
  }
  return out;
}

using Four = Eigen::Array4d;

Four dot(const std::array<Four, 3>& p, const Vec3& v) {
  return p[0] * v[0] + p[1] * v[1] + p[2] * v[2];
}

/// Normal equations of four lanes, which are summed at the end; the lower half.
template <bool kCylinder>
struct CurveEquations {
  static constexpr int kSize = kCylinder ? 5 : 4;

  std::array<std::array<Four, kSize>, kSize> hs;
  std::array<Four, kSize> gs;
  Four squares = Four::Zero();  ///< clipped, weighted

  CurveEquations() {
    for (std::array<Four, kSize>& row : hs) row.fill(Four::Zero());
    gs.fill(Four::Zero());
  }

  /// a, b: across the axis.
  void add(const FourSamples& s, const Shape& shape, const Vec3& a, const Vec3& b) {
    std::array<Four, 3> out;
    for (std::size_t k = 0; k < 3; ++k) out[k] = s.point[k] - shape.middle[Eigen::Index(k)];
    Four along = Four::Zero();
    if constexpr (kCylinder) {
      along = dot(out, shape.axis);
      for (std::size_t k = 0; k < 3; ++k) out[k] -= along * shape.axis[Eigen::Index(k)];
    }
    const Four length = (out[0].square() + out[1].square() + out[2].square()).sqrt();
    // A sample on the axis has no derivative and is ignored.
    const Four inverse_length = (length > 1e-9).select(1 / length, 0);
    for (Four& n : out) n *= inverse_length;
    const Four cosine = (out[0] * s.ray[0] + out[1] * s.ray[1] + out[2] * s.ray[2]).abs().max(0.2);
    const Four scale = (length > 1e-9).select(s.inverse_sigma / cosine, 0);
    const Four r = (length - shape.radius) * scale;
    const Four w = (2 / r.abs()).min(1);  // Huber's, at two sigmas
    squares += r.square().min(kMaxSquare);
    std::array<Four, kSize> j;
    j[0] = -dot(out, a) * scale;
    j[1] = -dot(out, b) * scale;
    if constexpr (kCylinder) {
      j[2] = along * j[0];
      j[3] = along * j[1];
    } else {
      j[2] = -out[2] * scale;
    }
    j[kSize - 1] = -scale;
    for (std::size_t row = 0; row < kSize; ++row) {
      const Four of_row = w * j[row];
      for (std::size_t column = 0; column <= row; ++column) hs[row][column] += of_row * j[column];
      gs[row] += of_row * r;
    }
  }

  Eigen::Matrix<double, kSize, 1> step() const {
    Eigen::Matrix<double, kSize, kSize> h = Eigen::Matrix<double, kSize, kSize>::Zero();
    Eigen::Matrix<double, kSize, 1> g;
    for (std::size_t row = 0; row < kSize; ++row) {
      for (std::size_t column = 0; column <= row; ++column)
        h(Eigen::Index(row), Eigen::Index(column)) = hs[row][column].sum();
      g[Eigen::Index(row)] = gs[row].sum();
    }
    h.diagonal() *= 1 + 1e-9;
    return -h.ldlt().solve(g);  // of the lower half
  }
};

/// Gauss-Newton on middle (and axis) and radius; derivatives are those of |out| - radius. Parameters: middle
/// along a, b; then (cylinder) turns of the axis towards a and b, or (sphere) middle along z; radius.
/// False as soon as it is plain that no such shape explains the samples.
template <bool kCylinder>
bool refine(const std::vector<Sample>& samples, Shape& shape) {
  constexpr double kStill = 0.999;  ///< convergence: stop when the cost fell by less than 0.1 %
  const std::vector<FourSamples> fours = by_fours(samples);
  double before = 0;
  for (int step = 0; step < 8; ++step) {
    const Vec3 a = kCylinder ? Vec3(shape.axis.unitOrthogonal()) : Vec3::UnitX();
    const Vec3 b = kCylinder ? Vec3(shape.axis.cross(a)) : Vec3::UnitY();
    CurveEquations<kCylinder> equations;
    for (const FourSamples& four : fours) equations.add(four, shape, a, b);
    const double squares = equations.squares.sum();
    // The linear start is near where one exists: what two steps do not bring close, none does.
    if (step >= 2 && squares > kHopeless * kHopeless * double(samples.size())) return false;
    if (step >= 2 && squares > kStill * before) return true;
    before = squares;
    const auto d = equations.step();
    if (!d.allFinite()) return true;
    shape.middle += d[0] * a + d[1] * b;
    if constexpr (kCylinder)
      shape.axis = (shape.axis + d[2] * a + d[3] * b).normalized();
    else
      shape.middle.z() += d[2];
    shape.radius += d[CurveEquations<kCylinder>::kSize - 1];
  }
  return true;
}

/// Kasa's linear fit of a circle or sphere, |p|^2 = 2 c . p + k, in the directions of `basis`.
std::optional<Shape> start(const std::vector<Sample>& samples, bool cylinder, const Vec3& axis) {
  Vec3 mean = Vec3::Zero();
  for (const Sample& s : samples) mean += s.point / double(samples.size());
  Mat3 basis = Mat3::Identity();
  if (cylinder) {
    basis.col(0) = axis.unitOrthogonal();
    basis.col(1) = axis.cross(basis.col(0));
    basis.col(2).setZero();
  }
  Mat4 h = Mat4::Zero();
  Vec4 g = Vec4::Zero();
  for (const Sample& s : samples) {
    const Vec3 p = basis.transpose() * (s.point - mean);
    const Vec4 row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
    const double w = 1 / (s.sigma * s.sigma);
    h.noalias() += w * row * row.transpose();
    g += w * p.squaredNorm() * row;
  }
  if (cylinder) h(2, 2) = 1;
  const Vec4 c = h.ldlt().solve(g);
  const double square = c.w() + c.head<3>().squaredNorm();
  if (!c.allFinite() || !(square > 0)) return std::nullopt;
  return Shape{cylinder, mean + basis * c.head<3>(), axis, std::sqrt(square)};
}

}  // namespace

Sample sample_of(const Cell& cell) {
  const double z = 1 / double(cell.q);
  const Vec3 ray(double(cell.u), double(cell.v), 1);
  return {z * ray, ray.normalized(), double(cell.shared) * z * z * ray.norm(), Vec3::Zero()};
}

std::optional<Fit> fit_from(const std::vector<Sample>& samples, Shape shape) {
  if (!(shape.cylinder ? refine<true>(samples, shape) : refine<false>(samples, shape))) return std::nullopt;
  if (!(shape.radius > kMinRadius && shape.radius < kLargestRadius) || !shape.middle.allFinite())
    return std::nullopt;
  Fit out{shape};
  double squares = 0, metres = 0, side = 0;
  for (const Sample& s : samples) squares += clipped_square(shape.residual(s));
  out.rms_sigmas = std::sqrt(squares / double(samples.size()));
  if (!(out.rms_sigmas < kExplains)) return std::nullopt;
  Vec3 middle = Vec3::Zero();
  for (const Sample& s : samples) {
    const Vec3 n = shape.from_axis(s.point).normalized();
    metres += std::pow(shape.from_axis(s.point).norm() - shape.radius, 2);
    side -= n.dot(s.ray);
    middle += n;
  }
  const auto count = double(samples.size());
  out.rms = std::sqrt(metres / count);
  out.outside = side > 0;
  std::vector<double> cosines;
  middle.normalize();
  for (const Sample& s : samples) cosines.push_back(shape.from_axis(s.point).normalized().dot(middle));
  out.turn = 2 * std::acos(std::clamp(at_rank(cosines, cosines.size() / 20), -1.0, 1.0));
  return out;
}

std::optional<Fit> fit_shape(const std::vector<Sample>& samples, bool cylinder) {
  Vec3 axis = Vec3::UnitY();
  if (cylinder) {
    // Normals of a cylinder lie across its axis.
    Mat3 spread = Mat3::Zero();
    for (const Sample& s : samples) spread += s.normal * s.normal.transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(spread);
    if (eigen.info() != Eigen::Success || !(eigen.eigenvalues()[1] > 0)) return std::nullopt;
    axis = eigen.eigenvectors().col(0);
  }
  const std::optional<Shape> shape = start(samples, cylinder, axis);
  return shape ? fit_from(samples, *shape) : std::nullopt;
}

DetectedCurve curve_of(const Fit& fit, const std::vector<Sample>& samples) {
  const Shape& shape = fit.shape;
  const double side = fit.outside ? -1 : 1;
  Vec3 mean = Vec3::Zero(), seen = Vec3::Zero();
  for (const Sample& s : samples) {
    mean += s.point / double(samples.size());
    seen += shape.from_axis(s.point);
  }
  Vec3 down = shape.cylinder ? shape.axis : Vec3::UnitY();
  if (down.dot(Vec3(0, 1, 0.01)) < 0) down = -down;
  Vec3 into = side * seen;
  into -= down * down.dot(into);
  if (!(into.norm() > 1e-9)) into = down.unitOrthogonal();
  into.normalize();
  Mat3 axes;
  axes << down.cross(into), down, into;
  const Vec3 origin =
      shape.cylinder ? Vec3(shape.middle + shape.axis * shape.axis.dot(mean - shape.middle)) : shape.middle;
  const Pose camera_from_surface(axes, origin);
  const Pose surface_from_camera = camera_from_surface.inverse();
  double left = 1e9, right = -1e9, low = 1e9, high = -1e9;
  for (const Sample& s : samples) {
    const Vec3 p = surface_from_camera * s.point;
    const double angle = std::atan2(p.x(), side * p.z());
    const double along = shape.cylinder ? p.y() : std::asin(std::clamp(-p.y() / p.norm(), -1.0, 1.0));
    left = std::min(left, angle), right = std::max(right, angle);
    low = std::min(low, along), high = std::max(high, along);
  }
  DetectedCurve out;
  out.rms = fit.rms;
  const SeenFrom from = fit.outside ? SeenFrom::kOutside : SeenFrom::kInside;
  if (shape.cylinder) {
    CylinderSurface s;
    s.frame_from_surface = camera_from_surface;
    s.radius = shape.radius;
    s.left = left, s.right = right, s.top = low, s.bottom = high;
    s.seen_from = from;
    out.shape = s;
  } else {
    SphereSurface s;
    s.frame_from_surface = camera_from_surface;
    s.radius = shape.radius;
    s.left = left, s.right = right, s.top = high, s.bottom = low;
    s.seen_from = from;
    out.shape = s;
  }
  return out;
}

std::vector<Sample> points_of(const CellGrid& grid, const std::vector<int>& cells) {
  std::vector<Sample> samples;
  const std::size_t step = cells.size() / kSamples + 1;
  samples.reserve(cells.size() / step + 1);
  for (std::size_t k = 0; k < cells.size(); k += step)
    samples.push_back(sample_of(grid.cells[std::size_t(cells[k])]));
  return samples;
}

std::vector<Sample> samples_of(const CellGrid& grid, const std::vector<int>& cells) {
  std::vector<char> taken(grid.cells.size());
  for (const int at : cells) taken[std::size_t(at)] = 1;
  std::vector<Sample> samples = points_of(grid, cells);
  const std::size_t step = cells.size() / kSamples + 1;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const int at = cells[k * step];
    const int column = at % grid.columns, row = at / grid.columns;
    Moments block;
    int count = 0;
    for (int j = -2; j <= 2; ++j)
      for (int i = -2; i <= 2; ++i) {
        const int x = column + i, y = row + j;
        if (x < 0 || y < 0 || x >= grid.columns || y >= grid.rows) continue;
        if (!taken[std::size_t(grid.index(x, y))]) continue;
        block += grid.at(x, y).moments;
        ++count;
      }
    const Vec3 t = fit(block).t;
    if (count >= 10 && t.norm() > 0) samples[k].normal = -t.normalized();
  }
  return samples;
}

}  // namespace procam::depth::internal
