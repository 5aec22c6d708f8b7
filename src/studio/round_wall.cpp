#include "round_wall.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "procam/core/base/closed_form.hpp"

namespace procam::studio {
namespace {

constexpr std::size_t kFewestPoints = 12;
constexpr double kFlattest = 100;  // metres

Vec3 mean_of(const Points3& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / double(points.size());
  return mean;
}

std::optional<RoundWall> start(const Points3& points, const std::optional<double>& radius) {
  const Vec3 mean = mean_of(points);
  Mat3 moments = Mat3::Zero();
  for (const Vec3& p : points) moments += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(moments);
  const Vec3 z = solver.eigenvectors().col(0), x = solver.eigenvectors().col(2), y = z.cross(x);
  Eigen::MatrixXd rows(Eigen::Index(points.size()), 6);
  Eigen::VectorXd heights(Eigen::Index(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 d = points[i] - mean;
    const double u = d.dot(x), v = d.dot(y);
    rows.row(Eigen::Index(i)) << 1, u, v, u * u, u * v, v * v;
    heights[Eigen::Index(i)] = d.dot(z);
  }
  const Eigen::VectorXd c = rows.colPivHouseholderQr().solve(heights);
  Mat2 second;
  second << 2 * c[3], c[4], c[4], 2 * c[5];
  const SymmetricEigen2 curvatures = symmetric_eigen(second);
  const int bent = std::abs(curvatures.values[1]) > std::abs(curvatures.values[0]) ? 1 : 0;
  const double curvature = curvatures.values[bent];
  if (!(std::abs(curvature) * kFlattest > 1)) return std::nullopt;
  const Vec2 along = curvatures.vectors.col(1 - bent);
  RoundWall wall;
  wall.axis = (along.x() * x + along.y() * y).normalized();
  wall.radius = radius.value_or(1 / std::abs(curvature));
  wall.middle = mean + c[0] * z + (curvature > 0 ? wall.radius : -wall.radius) * z;
  return wall;
}

double cost_of(const Points3& points, const RoundWall& wall) {
  double cost = 0;
  for (const Vec3& p : points) cost += std::pow(wall.across(p).norm() - wall.radius, 2);
  return cost;
}

/// Parameters: the middle along a and b, the axis towards a and b, the radius.
RoundWall moved(const RoundWall& wall, const Vec3& a, const Vec3& b, const Eigen::Matrix<double, 5, 1>& by) {
  RoundWall result = wall;
  result.middle += by[0] * a + by[1] * b;
  result.axis = (wall.axis + by[2] * a + by[3] * b).normalized();
  result.radius += by[4];
  return result;
}

void refine(const Points3& points, bool radius_is_given, RoundWall& wall) {
  using Vec5 = Eigen::Matrix<double, 5, 1>;
  using Mat5 = Eigen::Matrix<double, 5, 5>;
  constexpr int kIterations = 60;
  constexpr double kStill = 1e-12;  // metres and radians
  double cost = cost_of(points, wall), damping = 1e-6;
  for (int step = 0; step < kIterations && damping < 1e9; ++step) {
    const Vec3 a = wall.axis.unitOrthogonal(), b = wall.axis.cross(a);
    Mat5 normal = Mat5::Zero();
    Vec5 gradient = Vec5::Zero();
    for (const Vec3& p : points) {
      const Vec3 across = wall.across(p);
      const double distance = across.norm(), height = (p - wall.middle).dot(wall.axis);
      if (!(distance > 1e-9)) continue;
      const Vec3 out = across / distance;
      Vec5 row;
      row << -out.dot(a), -out.dot(b), -height * out.dot(a), -height * out.dot(b),
          radius_is_given ? 0.0 : -1.0;
      normal += row * row.transpose();
      gradient += (distance - wall.radius) * row;
    }
    Mat5 damped = normal;
    damped.diagonal() += damping * normal.diagonal() + Vec5::Constant(1e-12);
    const Vec5 by = -damped.ldlt().solve(gradient);
    const RoundWall next = moved(wall, a, b, by);
    const double next_cost = cost_of(points, next);
    if (by.allFinite() && next.radius > 0 && next_cost <= cost) {
      wall = next, cost = next_cost, damping = std::max(1e-9, 0.1 * damping);
      if (by.norm() < kStill) break;
    } else {
      damping *= 10;
    }
  }
  wall.rms = std::sqrt(cost / double(points.size()));
  wall.points = points.size();
  wall.middle += (mean_of(points) - wall.middle).dot(wall.axis) * wall.axis;
}

}  // namespace

std::optional<RoundWall> fit_round_wall(Points3 points, const std::optional<double>& radius) {
  if (points.size() < kFewestPoints) return std::nullopt;
  std::optional<RoundWall> wall = start(points, radius);
  if (!wall) return std::nullopt;
  refine(points, radius.has_value(), *wall);
  constexpr int kRounds = 10;
  constexpr double kExact = 1e-9;  // metres; below, residuals are rounding
  for (int round = 0; round < kRounds && wall->rms > kExact; ++round) {
    const double limit = 4 * wall->rms;
    const auto end = std::remove_if(points.begin(), points.end(), [&](const Vec3& p) {
      return std::abs(wall->across(p).norm() - wall->radius) > limit;
    });
    if (end == points.end() || std::size_t(end - points.begin()) < kFewestPoints) break;
    points.erase(end, points.end());
    refine(points, radius.has_value(), *wall);
  }
  if (!(wall->radius < kFlattest)) return std::nullopt;
  return wall;
}

std::optional<Vec3> intersect(const Ray& ray, const RoundWall& wall, const Vec3& near) {
  const Vec3 from = wall.across(ray.origin),
             direction = ray.direction - ray.direction.dot(wall.axis) * wall.axis;
  const double a = direction.squaredNorm(), b = from.dot(direction),
               c = from.squaredNorm() - wall.radius * wall.radius, root = b * b - a * c;
  if (!(a > 1e-12 * ray.direction.squaredNorm() && root >= 0)) return std::nullopt;
  std::optional<Vec3> best;
  for (const double s : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) {
    if (!(s > 0)) continue;
    const Vec3 hit = ray.at(s);
    if (!best || wall.across(hit).dot(wall.across(near)) > wall.across(*best).dot(wall.across(near)))
      best = hit;
  }
  return best;
}

}  // namespace procam::studio
