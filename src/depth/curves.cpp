#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "regions.hpp"

namespace procam::depth::internal {
namespace {

/// A shape must turn by this much over what is seen of it: less is a plane with a distorted depth.
constexpr double kLeastTurn = 12 * kDegree;
constexpr double kLeastRadius = 0.03, kLargestRadius = 20;
/// RMS of the cells, in sigmas of what readings share, at which a shape explains them.
constexpr double kExplains = 1.5;
/// A cell within this many of those sigmas lies on the shape.
constexpr double kOnShape = 3;
/// So many cells say what a shape is as well as all of them, sooner.
constexpr std::size_t kSamples = 120;

/// A cell as a point, and what it may be off along its ray.
struct Sample {
  Vec3 point, ray;
  double sigma = 0;
  Vec3 normal = Vec3::Zero();  ///< towards the camera; zero where too little is known
};

Sample sample_of(const Cell& cell) {
  const double z = 1 / double(cell.q);
  const Vec3 ray(double(cell.u), double(cell.v), 1);
  return {z * ray, ray.normalized(), double(cell.shared) * z * z * ray.norm(), Vec3::Zero()};
}

/// One of two: with an axis a cylinder, without a sphere.
struct Shape {
  bool cylinder = true;
  Vec3 middle = Vec3::Zero(), axis = Vec3::UnitY();
  double radius = 0;

  Vec3 from_axis(const Vec3& point) const {
    const Vec3 d = point - middle;
    return cylinder ? Vec3(d - axis * axis.dot(d)) : d;
  }
  /// In sigmas along the ray.
  double residual(const Sample& s) const {
    const Vec3 out = from_axis(s.point);
    const double length = out.norm();
    if (!(length > 1e-9)) return 1e3;
    const double cosine = std::max(std::abs(out.dot(s.ray)) / length, 0.2);
    return (length - radius) / (s.sigma * cosine);
  }
};

double weight_of(double residual) {  // Huber's, at two sigmas
  const double size = std::abs(residual);
  return size < 2 ? 1 : 2 / size;
}

/// Gauss-Newton on middle (and axis) and radius; derivatives are those of |out| - radius.
void refine(const std::vector<Sample>& samples, Shape& shape) {
  for (int step = 0; step < 8; ++step) {
    const Vec3 a = shape.cylinder ? Vec3(shape.axis.unitOrthogonal()) : Vec3::UnitX();
    const Vec3 b = shape.cylinder ? Vec3(shape.axis.cross(a)) : Vec3::UnitY();
    // Parameters: middle along a, b and (sphere) z; radius; (cylinder) turns of the axis towards a and b.
    using Mat66 = Eigen::Matrix<double, 6, 6>;
    Mat66 h = Mat66::Zero();
    Vec6 g = Vec6::Zero();
    for (const Sample& s : samples) {
      const Vec3 out = shape.from_axis(s.point);
      const double length = out.norm();
      if (!(length > 1e-9)) continue;
      const Vec3 n = out / length;
      const double scale = 1 / (s.sigma * std::max(std::abs(n.dot(s.ray)), 0.2));
      const double r = (length - shape.radius) * scale, w = weight_of(r);
      Vec6 j = Vec6::Zero();
      j[0] = -n.dot(a);
      j[1] = -n.dot(b);
      j[3] = -1;
      if (shape.cylinder) {
        const double along = shape.axis.dot(s.point - shape.middle);
        j[4] = -along * n.dot(a);
        j[5] = -along * n.dot(b);
      } else {
        j[2] = -n.z();
      }
      j *= scale;
      h.noalias() += w * j * j.transpose();
      g += w * r * j;
    }
    if (shape.cylinder)
      h(2, 2) = 1;
    else
      h(4, 4) = h(5, 5) = 1;
    h.diagonal() *= 1 + 1e-9;
    const Vec6 d = -h.ldlt().solve(g);
    if (!d.allFinite()) return;
    shape.middle += d[0] * a + d[1] * b + (shape.cylinder ? Vec3::Zero() : Vec3(0, 0, d[2]));
    shape.radius += d[3];
    if (shape.cylinder) shape.axis = (shape.axis + d[4] * a + d[5] * b).normalized();
    if (d.norm() < 1e-5) return;
  }
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

struct Fit {
  Shape shape;
  double rms_sigmas = 0, rms = 0, turn = 0;
  bool outside = true;
};

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
  auto shape = start(samples, cylinder, axis);
  if (!shape) return std::nullopt;
  refine(samples, *shape);
  if (!(shape->radius > kLeastRadius && shape->radius < kLargestRadius) || !shape->middle.allFinite())
    return std::nullopt;
  Fit out{*shape};
  double squares = 0, metres = 0, side = 0;
  Vec3 middle = Vec3::Zero();
  for (const Sample& s : samples) {
    const double r = std::min(std::abs(shape->residual(s)), 10.0);
    const Vec3 n = shape->from_axis(s.point).normalized();
    squares += r * r;
    metres += std::pow(shape->from_axis(s.point).norm() - shape->radius, 2);
    side -= n.dot(s.ray);
    middle += n;
  }
  const auto count = double(samples.size());
  out.rms_sigmas = std::sqrt(squares / count);
  out.rms = std::sqrt(metres / count);
  out.outside = side > 0;
  std::vector<double> cosines;
  middle.normalize();
  for (const Sample& s : samples) cosines.push_back(shape->from_axis(s.point).normalized().dot(middle));
  std::nth_element(cosines.begin(), cosines.begin() + std::ptrdiff_t(cosines.size() / 20), cosines.end());
  out.turn = 2 * std::acos(std::clamp(cosines[cosines.size() / 20], -1.0, 1.0));
  return out;
}

/// The part of the shape that the samples lie on, in a frame that is read upright by the camera.
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

/// Samples of the cells with normals of blocks of 5 x 5 of them.
std::vector<Sample> samples_of(const CellGrid& grid, const std::vector<int>& cells) {
  std::vector<char> taken(grid.cells.size());
  for (const int at : cells) taken[std::size_t(at)] = 1;
  std::vector<Sample> samples;
  const std::size_t step = cells.size() / kSamples + 1;
  for (std::size_t k = 0; k < cells.size(); k += step) {
    const int at = cells[k];
    samples.push_back(sample_of(grid.cells[std::size_t(at)]));
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
    if (count >= 10 && t.norm() > 0) samples.back().normal = -t.normalized();
  }
  return samples;
}

}  // namespace

std::vector<Curve> take_curves(const CellGrid& grid, const PlaneOptions& options, Regions& all) {
  auto& regions = all.regions;
  std::vector<Curve> curves;
  if (std::none_of(regions.begin(), regions.end(), [](const Region& r) { return r.bend > 0; })) return curves;

  // Which regions lie beside which, across a gap of up to three cells.
  const std::size_t n = regions.size();
  std::vector<char> beside(n * n);
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const int own = all.owner[std::size_t(grid.index(column, row))];
      if (own < 0) continue;
      for (int j = 0; j <= 3; ++j)
        for (int i = j == 0 ? 1 : -3; i <= 3; ++i) {
          const int x = column + i, y = row + j;
          if (x < 0 || x >= grid.columns || y >= grid.rows) continue;
          const int other = all.owner[std::size_t(grid.index(x, y))];
          if (other < 0 || other == own) continue;
          beside[std::size_t(own) * n + std::size_t(other)] = 1;
          beside[std::size_t(other) * n + std::size_t(own)] = 1;
        }
    }
  const auto take_all = [&](std::vector<std::size_t>& group, const auto& wanted) {
    for (std::size_t head = 0; head < group.size(); ++head)
      for (std::size_t k = 0; k < n; ++k)
        if (beside[group[head] * n + k] && std::find(group.begin(), group.end(), k) == group.end() &&
            wanted(k))
          group.push_back(k);
  };
  const auto cells_of = [&](const std::vector<std::size_t>& group) {
    std::vector<int> cells;
    for (const std::size_t k : group)
      cells.insert(cells.end(), regions[k].cells.begin(), regions[k].cells.end());
    return cells;
  };

  std::vector<char> gone(n);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return regions[a].cells.size() > regions[b].cells.size();
  });
  for (const std::size_t first : order) {
    if (gone[first] || !(regions[first].bend > options.curved_from)) continue;
    std::vector<std::size_t> group{first};
    take_all(group, [&](std::size_t k) { return !gone[k] && regions[k].bend > options.curved_from; });
    // All of them together, and if nothing explains that, the first alone.
    std::optional<Fit> best;
    for (;;) {
      const std::vector<Sample> samples = samples_of(grid, cells_of(group));
      for (const bool cylinder : {true, false}) {
        const auto found = fit_shape(samples, cylinder);
        if (found && found->rms_sigmas < kExplains && found->turn > kLeastTurn &&
            (!best || found->rms_sigmas < 0.8 * best->rms_sigmas))
          best = found;
      }
      if (best || group.size() == 1) break;
      group.resize(1);
    }
    if (!best) continue;
    // What is beside and lies on it belongs to it, curved by itself or not.
    const auto on_shape = [&](std::size_t k) {
      if (gone[k]) return false;
      std::size_t count = 0;
      for (const int at : regions[k].cells)
        count += std::abs(best->shape.residual(sample_of(grid.cells[std::size_t(at)]))) < kOnShape;
      return double(count) > 0.7 * double(regions[k].cells.size());
    };
    for (std::size_t before = 0; before != group.size();) {
      before = group.size();
      take_all(group, on_shape);
      const auto again = fit_shape(samples_of(grid, cells_of(group)), best->shape.cylinder);
      if (again && again->rms_sigmas < kExplains) best = again;
    }
    const std::vector<int> cells = cells_of(group);
    curves.push_back({curve_of(*best, samples_of(grid, cells)), cells});
    for (const std::size_t k : group) gone[k] = 1;
    for (const int at : cells) all.owner[std::size_t(at)] = kCurveOwner - int(curves.size() - 1);
  }
  for (std::size_t k = 0; k < n; ++k)
    if (!gone[k] && regions[k].bend > 3 * options.curved_from) {
      gone[k] = 1;
      for (const int at : regions[k].cells) all.owner[std::size_t(at)] = kUnexplained;
    }
  for (std::size_t k = 0; k < n; ++k)
    if (gone[k]) regions[k].cells.clear();
  return curves;
}

}  // namespace procam::depth::internal
