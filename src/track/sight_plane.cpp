#include "procam/track/sight_plane.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/triangulate.hpp"
#include "projection_jacobian.hpp"

namespace procam::track {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMinPoints = 4;
/// Of a squared residual of two degrees of freedom: 1 good point in 10 000 is beyond.
constexpr double kRejectAbove = 18.4;

/// A point whose rays meet.
struct Usable {
  std::size_t index = 0;
  Ray light;  ///< in the rig's frame
  Vec2 camera_pixel, projector_pixel;
  Mat2 whiten;  ///< whiten^T whiten = covariance^-1
  double sigma_px = 0;
  Vec3 triangulated;
};

struct LitPoints {
  const Camera* camera = nullptr;
  Pose camera_from_rig;
  std::vector<Usable> points;
};

[[noreturn]] void refuse_plane(const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kDegenerate, "plane in the projector's light", why, next);
}

Mat2 whitening(const Mat2& covariance) {
  require(covariance.allFinite() && covariance(0, 0) > 0 && covariance.determinant() > 0,
          "sight_plane: a covariance is not positive");
  return cholesky_lower(covariance).inverse();
}

LitPoints lit_points_of(const std::vector<LightPoint>& points, const RigCamera& camera,
                        const RigProjector& projector) {
  const TriangulationOptions triangulation;
  LitPoints problem{&camera.camera, camera.rig_from_camera.inverse(), {}};
  std::size_t parallel = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LightPoint& point = points[i];
    require(point.projector_pixel.allFinite() && point.camera_pixel.allFinite(),
            "sight_plane: point " + std::to_string(i) + " is not finite");
    const Mat2 whiten = whitening(point.camera_covariance);
    const auto lit = projector.projector.emit(point.projector_pixel);
    const auto seen = camera.camera.unproject(point.camera_pixel);
    if (!lit || !seen) continue;
    const Ray light = projector.rig_from_projector * *lit;
    const Ray sight = camera.rig_from_camera * Ray{Vec3::Zero(), *seen};
    if (light.direction.cross(sight.direction).norm() < triangulation.parallel_tolerance) {
      ++parallel;
      continue;
    }
    const auto met = triangulate({light, sight}, triangulation);
    if (!met) continue;
    problem.points.push_back({i, light, point.camera_pixel, point.projector_pixel, whiten,
                              std::sqrt(0.5 * point.camera_covariance.trace()), met->point});
  }
  if (2 * parallel > points.size())
    refuse_plane(
        "the rays of camera and projector are parallel: they have no baseline, or the plane is too far",
        "move closer to the plane; the baseline should be a tenth of the distance or more");
  if (problem.points.size() < kMinPoints)
    throw Error(ErrorKind::kNotEnoughData, "plane in the projector's light",
                counted(problem.points.size(), "point") + " of " + std::to_string(points.size()) +
                    " have rays of camera and projector that meet; 4 are needed",
                "let the camera see more of the pattern, and check that the rig is the one used");
  return problem;
}

struct LitPixel {
  Vec3 point;  ///< in the rig's frame
  Vec2 pixel;
  double cosine = 0;  ///< of the ray's direction and the plane's normal, signed
};

std::optional<LitPixel> predict(const LitPoints& problem, const Usable& point, const Plane& plane) {
  const auto met = intersect(point.light, plane);
  if (!met) return std::nullopt;
  const auto pixel = problem.camera->project(problem.camera_from_rig * *met);
  if (!pixel) return std::nullopt;
  return LitPixel{*met, *pixel, plane.normal.dot(point.light.direction)};
}

/// The squared residual, in units of its covariance.
double squared_residual(const LitPoints& problem, const Usable& point, const Plane& plane) {
  const auto predicted = predict(problem, point, plane);
  return predicted ? (point.whiten * (point.camera_pixel - predicted->pixel)).squaredNorm() : kInfinity;
}
std::vector<double> squared_residuals(const LitPoints& problem, const Plane& plane) {
  std::vector<double> squares;
  for (const Usable& point : problem.points) squares.push_back(squared_residual(problem, point, plane));
  return squares;
}

using Subset = std::vector<std::size_t>;  ///< indices into LitPoints::points

/// z along the plane's normal, towards the camera, the origin in the middle of the points.
Pose rig_from_frame(const LitPoints& problem, const Plane& plane, const Subset& subset) {
  const Pose rig_from_camera = problem.camera_from_rig.inverse();
  const Vec3 z = plane.signed_distance(rig_from_camera.translation) < 0 ? Vec3(-plane.normal) : plane.normal;
  Vec3 middle = Vec3::Zero();
  for (const std::size_t i : subset) {
    const auto met = intersect(problem.points[i].light, plane);
    middle += (met ? *met : problem.points[i].triangulated) / double(subset.size());
  }
  middle -= plane.signed_distance(middle) * plane.normal;
  Vec3 along = rig_from_camera.rotate(Vec3::UnitX());
  if (std::abs(along.dot(z)) > 0.8) along = rig_from_camera.rotate(Vec3::UnitY());
  const Vec3 x = (along - along.dot(z) * z).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return Pose(axes, middle);
}

/// Normal equations of the increment (w_x, w_y, t_z) of plane_from_rig.
struct PlaneEquations {
  Mat3 information = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double chi2 = 0;
  double across = 0;  ///< sum of the squared residuals across the epipolar lines, pixels^2
};

/// nullopt where a point cannot be predicted.
std::optional<PlaneEquations> plane_equations(const LitPoints& problem, const Subset& subset,
                                              const Pose& rig_from_plane) {
  const Plane plane = Plane::of_xy(rig_from_plane);
  const Pose plane_from_rig = rig_from_plane.inverse();
  PlaneEquations sum;
  for (const std::size_t i : subset) {
    const Usable& point = problem.points[i];
    const auto predicted = predict(problem, point, plane);
    if (!predicted) return std::nullopt;
    const auto by_point =
        internal::projection_jacobian(*problem.camera, problem.camera_from_rig * predicted->point);
    if (!by_point) return std::nullopt;
    const Vec2 by_range = *by_point * problem.camera_from_rig.rotate(point.light.direction);
    const Vec3 on_plane = plane_from_rig * predicted->point;
    const Vec3 range_by_plane = -Vec3(on_plane.y(), -on_plane.x(), 1) / predicted->cosine;
    const Vec2 residual = point.camera_pixel - predicted->pixel, whitened = point.whiten * residual;
    const Eigen::Matrix<double, 2, 3> jacobian = point.whiten * by_range * range_by_plane.transpose();
    sum.information += jacobian.transpose() * jacobian;
    sum.right += jacobian.transpose() * whitened;
    sum.chi2 += whitened.squaredNorm();
    const double across = Vec2(-by_range.y(), by_range.x()).dot(residual) / by_range.norm();
    sum.across += across * across;
  }
  if (!sum.information.allFinite() || !std::isfinite(sum.chi2)) return std::nullopt;
  return sum;
}

/// The best plane of these points, from a start.
Plane fit(const LitPoints& problem, const Subset& subset, const Plane& start) {
  constexpr int kIterations = 30;
  constexpr double kConverged = 1e-16;  // predicted decrease of chi2
  Pose pose = rig_from_frame(problem, start, subset);
  std::optional<PlaneEquations> at = plane_equations(problem, subset, pose);
  if (!at) return start;
  double damping = 0;
  for (int i = 0; i < kIterations; ++i) {
    Mat3 damped = at->information;
    damped.diagonal() *= 1 + damping;
    const Vec3 step = Cholesky(damped).solve(at->right);
    if (!(step.dot(at->right) > kConverged * (1 + at->chi2))) break;  // also where it is not finite
    Vec6 back = Vec6::Zero();
    back[0] = -step[0], back[1] = -step[1], back[5] = -step[2];
    const Pose next = (pose * se3_exp(back)).normalized();
    const std::optional<PlaneEquations> there = plane_equations(problem, subset, next);
    if (!there || there->chi2 > at->chi2) {
      if (damping > 1e6) break;
      damping = std::max(10 * damping, 1e-3);
      continue;
    }
    damping *= 0.1;
    pose = rig_from_frame(problem, Plane::of_xy(next), subset);
    at = plane_equations(problem, subset, pose);
    if (!at) break;
  }
  return Plane::of_xy(pose);
}

std::size_t majority(std::size_t points, double min_share) {
  const auto share = std::size_t(std::ceil(min_share * double(points) - 1e-9));
  return std::max(share, std::min(points, kMinPoints));
}

/// The plane through three of the points whose smallest `count` residuals are the smallest.
Plane robust_start(const LitPoints& problem, std::size_t count) {
  // With 60 % good points, 100 triples miss them with a probability of 3e-11.
  constexpr int kTriples = 100;
  const std::size_t n = problem.points.size();
  std::mt19937_64 random(1);
  std::optional<Plane> best;
  double least = kInfinity;
  for (int triple = 0; triple < kTriples; ++triple) {
    const Vec3& a = problem.points[random() % n].triangulated;
    const Vec3 ab = problem.points[random() % n].triangulated - a,
               ac = problem.points[random() % n].triangulated - a, normal = ab.cross(ac);
    constexpr double kMinSine = 0.02;
    if (!(normal.norm() > kMinSine * ab.norm() * ac.norm())) continue;
    const Plane plane = Plane::through(a, normal);
    const double score = at_rank(squared_residuals(problem, plane), count - 1);
    if (score < least) least = score, best = plane;
  }
  if (!best)
    refuse_plane("no three of " + counted(n, "point") + " determine a plane",
                 "let the camera see more of the pattern, in both directions");
  return *best;
}

/// The `count` points of the smallest residuals.
Subset best_points(const LitPoints& problem, const Plane& plane, std::size_t count) {
  const std::vector<double> squares = squared_residuals(problem, plane);
  Subset order(squares.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return squares[a] < squares[b]; });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

Plane plane_of_majority(const LitPoints& problem, std::size_t count) {
  constexpr int kSteps = 20;
  Plane plane = robust_start(problem, count);
  Subset subset;
  for (int i = 0; i < kSteps; ++i) {
    Subset next = best_points(problem, plane, count);
    if (next == subset) break;
    subset = std::move(next);
    plane = fit(problem, subset, plane);
  }
  return plane;
}

Subset points_within(const LitPoints& problem, const Plane& plane, double limit) {
  Subset within;
  for (std::size_t i = 0; i < problem.points.size(); ++i)
    if (squared_residual(problem, problem.points[i], plane) <= limit) within.push_back(i);
  return within;
}

/// The smaller one over the larger one of the standard deviations of the projector pixels, along two axes.
double width_over_length(const LitPoints& problem) {
  Vec2 middle = Vec2::Zero();
  for (const Usable& point : problem.points) middle += point.projector_pixel / double(problem.points.size());
  Mat2 scatter = Mat2::Zero();
  for (const Usable& point : problem.points)
    scatter += (point.projector_pixel - middle) * (point.projector_pixel - middle).transpose();
  const Vec2 squares = symmetric_eigen(scatter).values;
  return squares[0] > 0 ? std::sqrt(std::max(squares[1], 0.0) / squares[0]) : 0;
}

void require_not_on_a_line(const LitPoints& problem) {
  constexpr double kMinWidth = 0.02;
  if (width_over_length(problem) < kMinWidth)
    refuse_plane(counted(problem.points.size(), "point") + " are on a line",
                 "let the camera see more of the pattern, in both directions");
}

/// Median of the sines at which light and sight meet the plane.
void require_not_edge_on(const LitPoints& problem, const Plane& plane) {
  constexpr double kMinSine = 0.03;  // 1.7 degrees
  const Vec3 eye = problem.camera_from_rig.inverse().translation;
  std::vector<double> lit, seen;
  for (const Usable& point : problem.points) {
    lit.push_back(std::abs(plane.normal.dot(point.light.direction)));
    const Vec3 sight = point.triangulated - eye;
    seen.push_back(std::abs(plane.normal.dot(sight)) / sight.norm());
  }
  if (std::min(median(std::move(lit)), median(std::move(seen))) < kMinSine)
    refuse_plane("the plane is seen or lit edge-on", "turn the rig towards the plane");
}

/// The estimated variance of the best `count` residuals over the stated one, 1 at least. Refuses what is not one plane.
double variance_factor(const LitPoints& problem, const Plane& plane, std::size_t count,
                       const SightPlaneOptions& options) {
  const double share = double(count) / double(problem.points.size());
  // Of two degrees of freedom, P(X > x) = exp(-x / 2).
  const double expected = share < 0.99 ? -2 * std::log(1 - share) : 9.2;
  const double square = at_rank(squared_residuals(problem, plane), count - 1);
  std::vector<double> sigmas;
  for (const Usable& point : problem.points) sigmas.push_back(point.sigma_px);
  const double noise = std::sqrt(square / expected) * median(std::move(sigmas));
  if (noise <= options.max_noise_px) return std::max(1.0, square / expected);
  const Subset best = best_points(problem, plane, count);
  const auto equations = plane_equations(problem, best, rig_from_frame(problem, plane, best));
  const double across = equations ? std::sqrt(equations->across / double(count)) : 0;
  if (across > options.max_noise_px)
    refuse_plane(
        "the camera pixels are " + px(across) + " beside the epipolar lines of their projector pixels",
        "check that the pattern is the one shown, unscaled, and that camera and projector have not moved "
        "against each other since the calibration");
  refuse_plane("fewer than " + percent(options.min_share, 0) + " of " +
                   counted(problem.points.size(), "point") + " are on one plane (residuals of " +
                   (std::isfinite(noise) ? px(noise) : "any size") + ")",
               "point the rig at one flat wall or at the floor, and not into a corner");
}

/// The points of the plane that most of `remaining` are near.
Subset largest_plane(const LitPoints& problem, const Subset& remaining) {
  constexpr int kTriples = 200;
  constexpr std::size_t kNeighbours = 16;
  constexpr double kNear = 4 * kRejectAbove;  // the noise may be twice that stated
  std::mt19937_64 random(1);
  Subset best;
  std::optional<Plane> found;
  const auto near = [&](const Plane& plane) {
    Subset on_plane;
    for (const std::size_t i : remaining)
      if (squared_residual(problem, problem.points[i], plane) <= kNear) on_plane.push_back(i);
    return on_plane;
  };
  for (int triple = 0; triple < kTriples; ++triple) {
    const Usable& a = problem.points[remaining[random() % remaining.size()]];
    Subset neighbours = remaining;
    const std::size_t count = std::min(kNeighbours, neighbours.size());
    std::partial_sort(neighbours.begin(), neighbours.begin() + std::ptrdiff_t(count), neighbours.end(),
                      [&](std::size_t one, std::size_t other) {
                        const auto distance = [&](std::size_t i) {
                          return (problem.points[i].projector_pixel - a.projector_pixel).squaredNorm();
                        };
                        return distance(one) < distance(other);
                      });
    const Vec3 ab = problem.points[neighbours[random() % count]].triangulated - a.triangulated,
               ac = problem.points[neighbours[random() % count]].triangulated - a.triangulated;
    constexpr double kMinSine = 0.1;
    const Vec3 normal = ab.cross(ac);
    if (!(normal.norm() > kMinSine * ab.norm() * ac.norm())) continue;
    const Plane plane = Plane::through(a.triangulated, normal);
    Subset on_plane = near(plane);
    if (on_plane.size() > best.size()) best = std::move(on_plane), found = plane;
  }
  constexpr int kRounds = 5;
  for (int i = 0; i < kRounds && best.size() >= kMinPoints; ++i) {
    found = fit(problem, best, *found);
    Subset next = near(*found);
    if (next.size() <= best.size() && i > 0) break;
    best = std::move(next);
  }
  return best;
}

/// Do the unknowns differ in their effect? A pivot over its diagonal entry is the share that the unknowns before it do not
/// explain.
bool determines_plane(const Mat3& information) {
  constexpr double kMinShare = 1e-12;
  const Cholesky factor(information);
  for (int i = 0; i < 3; ++i)
    if (!(factor.pivots()[i] > kMinShare * information(i, i))) return false;
  return true;
}

}  // namespace

PlaneSighting sight_plane(const std::vector<LightPoint>& points, const RigCamera& camera,
                          const RigProjector& projector, const SightPlaneOptions& options) {
  require(options.min_share >= 0.5 && options.min_share <= 1, "sight_plane: min_share is not 0.5 .. 1");
  require(options.max_noise_px > 0 && options.max_tilt_sigma > 0, "sight_plane: a limit is not positive");
  const LitPoints problem = lit_points_of(points, camera, projector);
  require_not_on_a_line(problem);
  const std::size_t count = majority(problem.points.size(), options.min_share);
  Plane plane = plane_of_majority(problem, count);
  require_not_edge_on(problem, plane);
  const double limit = kRejectAbove * variance_factor(problem, plane, count, options);

  constexpr int kRounds = 10;
  Subset used;
  for (int i = 0; i < kRounds; ++i) {
    Subset next = points_within(problem, plane, limit);
    if (next.size() < count)
      refuse_plane(std::to_string(next.size()) + " of " + counted(problem.points.size(), "point") +
                       " are on one plane",
                   "point the rig at one flat wall or at the floor, and not into a corner");
    if (next == used) break;
    used = std::move(next);
    plane = fit(problem, used, plane);
  }

  const Pose rig_from_plane = rig_from_frame(problem, plane, used);
  const auto equations = plane_equations(problem, used, rig_from_plane);
  if (!equations || !determines_plane(equations->information))
    refuse_plane("the points do not determine it",
                 "let the camera see more of the pattern, in both directions");
  PlaneSighting sighting;
  sighting.used = int(used.size());
  sighting.chi2_per_dof = equations->chi2 / double(2 * used.size() - 3);
  sighting.across_px = std::sqrt(equations->across / double(used.size()));
  const Mat3 covariance = std::max(1.0, sighting.chi2_per_dof) * equations->information.inverse();
  const double tilt_sigma = std::sqrt(symmetric_eigen(Mat2(covariance.topLeftCorner<2, 2>())).values[0]);
  if (!(tilt_sigma <= options.max_tilt_sigma))
    refuse_plane("its normal has a standard deviation of " + fixed(tilt_sigma * 180 / M_PI, 1) + " degrees",
                 "let the camera see more of the pattern, in both directions");
  sighting.plane_from_rig.pose = rig_from_plane.inverse();
  sighting.plane_from_rig.covariance.setIdentity();
  constexpr int kCounting[] = {0, 1, 5};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      sighting.plane_from_rig.covariance(kCounting[i], kCounting[k]) = covariance(i, k);
  std::vector<bool> is_used(points.size(), false);
  for (const std::size_t i : used) is_used[problem.points[i].index] = true;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_used[i]) sighting.rejected.push_back(i);
  return sighting;
}

std::vector<PlaneSighting> sight_planes(const std::vector<LightPoint>& points, const RigCamera& camera,
                                        const RigProjector& projector, const SightPlaneOptions& options) {
  require(options.min_points >= int(kMinPoints), "sight_planes: min_points is below 4");
  const LitPoints problem = lit_points_of(points, camera, projector);
  Subset remaining(problem.points.size());
  for (std::size_t i = 0; i < remaining.size(); ++i) remaining[i] = i;
  std::vector<PlaneSighting> sightings;
  constexpr std::size_t kMaxPlanes = 6;
  while (remaining.size() >= std::size_t(options.min_points) && sightings.size() < kMaxPlanes) {
    const Subset on_plane = largest_plane(problem, remaining);
    if (on_plane.size() < std::size_t(options.min_points)) break;
    std::vector<LightPoint> some;
    for (const std::size_t i : on_plane) some.push_back(points[problem.points[i].index]);
    std::vector<char> is_used(points.size(), 0);
    try {
      PlaneSighting sighting = sight_plane(some, camera, projector, options);
      for (const std::size_t i : on_plane) is_used[problem.points[i].index] = 1;
      for (const std::size_t i : sighting.rejected) is_used[problem.points[on_plane[i]].index] = 0;
      sighting.rejected.clear();
      for (std::size_t i = 0; i < points.size(); ++i)
        if (is_used[i] == 0) sighting.rejected.push_back(i);
      if (sighting.used >= options.min_points) sightings.push_back(std::move(sighting));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kDegenerate && error.kind() != ErrorKind::kNotEnoughData) throw;
    }
    Subset others;
    std::set_difference(remaining.begin(), remaining.end(), on_plane.begin(), on_plane.end(),
                        std::back_inserter(others));
    remaining = std::move(others);
  }
  if (sightings.empty()) {
    sight_plane(points, camera, projector, options);  // its cause
    refuse_plane("no " + std::to_string(options.min_points) + " of " + counted(points.size(), "point") +
                     " are on one plane",
                 "point the rig at a flat wall or at the floor, and not into a corner");
  }
  return sightings;
}

}  // namespace procam::track
