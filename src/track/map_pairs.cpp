#include "map_pairs.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track::internal {
namespace {

/// Two normals are independent from this angle on, and three from this volume on.
constexpr double kIndependentSine = 0.1, kIndependentVolume = 0.05;
/// Angles between normals may differ by so many sigmas in the two maps.
constexpr double kAngleSigmas = 5;
/// Smallest cosine of the angle between the normals in the equations of a plane pair.
constexpr double kMinCosine = 1e-3;

Vec3 normal(const MapElement& element) {
  return element.map_from_element.rotate(Vec3::UnitZ());
}

double tilt_sigma(const MapElement& element) {
  return std::sqrt(std::max(element.covariance(0, 0), element.covariance(1, 1)));
}

/// Columns: `first`, across both, and the third axis.
Mat3 frame_of(const Vec3& first, const Vec3& second) {
  Mat3 frame;
  frame.col(0) = first;
  frame.col(1) = first.cross(second).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

bool same_angle(const MapPairs& all, const ElementPair& p, const ElementPair& q) {
  const double in_a = std::acos(std::clamp(normal(all.a(p)).dot(normal(all.a(q))), -1.0, 1.0));
  const double in_b = std::acos(std::clamp(normal(all.b(p)).dot(normal(all.b(q))), -1.0, 1.0));
  const double sigma = std::hypot(std::hypot(tilt_sigma(all.a(p)), tilt_sigma(all.a(q))),
                                  std::hypot(tilt_sigma(all.b(p)), tilt_sigma(all.b(q))));
  return std::abs(in_a - in_b) < kAngleSigmas * sigma + 1e-6;
}

bool independent(const MapPairs& all, const ElementPair& p, const ElementPair& q) {
  return p.a != q.a && p.b != q.b && normal(all.a(p)).cross(normal(all.a(q))).norm() > kIndependentSine &&
         normal(all.b(p)).cross(normal(all.b(q))).norm() > kIndependentSine && same_angle(all, p, q);
}

Mat3 rotation_of(const MapPairs& all, const ElementPair& p, const ElementPair& q) {
  return frame_of(normal(all.a(p)), normal(all.a(q))) *
         frame_of(normal(all.b(p)), normal(all.b(q))).transpose();
}

/// The shortest translation that puts the origins of B's planes onto A's: n_a . (R p_b + t - p_a) = 0.
Pose with_translation(const MapPairs& all, const Mat3& rotation, const std::vector<ElementPair>& planes) {
  MatX normals(planes.size(), 3);
  VecX offsets(planes.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Vec3 n = normal(all.a(planes[i]));
    normals.row(Eigen::Index(i)) = n.transpose();
    offsets[Eigen::Index(i)] = n.dot(all.a(planes[i]).map_from_element.translation -
                                     rotation * all.b(planes[i]).map_from_element.translation);
  }
  const MatX gram = normals * normals.transpose();
  return {rotation, Vec3(normals.transpose() * gram.ldlt().solve(offsets))};
}

/// Starts by planes alone: three that fix all, else two, else one; what fewer leave free is found and named later.
std::vector<Pose> plane_starts(const MapPairs& all, const std::vector<ElementPair>& planes) {
  std::vector<Pose> threes, twos;
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t j = i + 1; j < planes.size(); ++j) {
      if (!independent(all, planes[i], planes[j])) continue;
      const Mat3 rotation = rotation_of(all, planes[i], planes[j]);
      if (threes.empty()) twos.push_back(with_translation(all, rotation, {planes[i], planes[j]}));
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        const Vec3 n = normal(all.a(planes[k]));
        const double volume = normal(all.a(planes[i])).cross(normal(all.a(planes[j]))).dot(n);
        const bool fits = planes[k].a != planes[i].a && planes[k].a != planes[j].a &&
                          planes[k].b != planes[i].b && planes[k].b != planes[j].b &&
                          std::abs(volume) > kIndependentVolume &&
                          n.dot(rotation * normal(all.b(planes[k]))) > 0.9;
        if (fits) threes.push_back(with_translation(all, rotation, {planes[i], planes[j], planes[k]}));
      }
    }
  if (!threes.empty()) return threes;
  if (!twos.empty()) return twos;
  for (const ElementPair& plane : planes)
    twos.push_back(with_translation(
        all, rotation_between(normal(all.b(plane)), normal(all.a(plane))).toRotationMatrix(), {plane}));
  return twos;
}

}  // namespace

PairEquations pair_equations(const MapPairs& all, const ElementPair& pair, const Pose& map_a_from_map_b,
                             const Vec3& centre) {
  const MapElement &a = all.a(pair), &b = all.b(pair);
  const Pose a_from_b = a.map_from_element.inverse() * map_a_from_map_b * b.map_from_element;
  const Pose element_from_centre = a.map_from_element.inverse() * Pose(Mat3(Mat3::Identity()), centre);
  const Mat6 moved_b = adjoint(a_from_b);
  PairEquations out;
  MatX covariance;
  if (pair.kind == Kind::kPose) {
    out.residual = se3_log(a_from_b);
    out.jacobian = adjoint(element_from_centre);
    covariance = a.covariance + moved_b * b.covariance * moved_b.transpose();
  } else {
    // r = (E e_z).xy and (E origin).z for E <- exp(eta) E: d(E e_z) = eta_w x E e_z, d(E origin) = eta_w x E
    // origin + eta_t.
    const Vec3 axis = a_from_b.rotate(Vec3::UnitZ()), origin = a_from_b.translation;
    Eigen::Matrix<double, 3, 6> by_eta = Eigen::Matrix<double, 3, 6>::Zero();
    // Across normals lose a direction here: their covariance would be singular. With the smallest cosine it is not, and
    // the pair is far from agreeing.
    const double cosine = std::copysign(std::max(std::abs(axis.z()), kMinCosine), axis.z());
    by_eta.topLeftCorner<2, 3>() = -hat(Vec3(axis.x(), axis.y(), cosine)).topRows<2>();
    by_eta.bottomLeftCorner<1, 3>() = -hat(origin).bottomRows<1>();
    by_eta(2, 5) = 1;
    // The angle instead of its sine: a plane that is read from the other side does not agree.
    const double sine = axis.head<2>().norm(), per_sine = sine > 1e-6 ? std::atan2(sine, axis.z()) / sine : 1;
    out.residual = Vec3(per_sine * axis.x(), per_sine * axis.y(), origin.z());
    if (axis.z() < 0 && sine <= 1e-6) out.residual.x() = kPi;
    out.jacobian = by_eta * adjoint(element_from_centre);
    // A plane's turn and shift within itself mean nothing.
    const auto of_plane = [](Mat6 c) {
      for (const int i : {2, 3, 4}) c.row(i).setZero(), c.col(i).setZero();
      return c;
    };
    const Eigen::Matrix<double, 3, 6> by_b = by_eta * moved_b;
    covariance = by_eta * of_plane(a.covariance) * by_eta.transpose() +
                 by_b * of_plane(b.covariance) * by_b.transpose();
  }
  const Eigen::LLT<MatX> lower(covariance);
  if (lower.info() != Eigen::Success)
    throw Error(ErrorKind::kInput, "'" + a.name + "' of map A and '" + b.name + "' of map B",
                "both are stated to be exact, or their covariance is not positive definite",
                "state how well they are known, e.g. 5 mm and 0.3 degrees");
  out.residual = lower.matrixL().solve(out.residual);
  out.jacobian = lower.matrixL().solve(out.jacobian);
  return out;
}

std::vector<Pose> alignment_starts(const MapPairs& all) {
  std::vector<Pose> starts;
  std::vector<ElementPair> planes;
  for (const ElementPair& pair : all.pairs) {
    if (pair.kind == Kind::kPose)
      starts.push_back(all.a(pair).map_from_element * all.b(pair).map_from_element.inverse());
    else
      planes.push_back(pair);
  }
  const std::vector<Pose> by_planes = plane_starts(all, planes);
  starts.insert(starts.end(), by_planes.begin(), by_planes.end());
  return starts;
}

}  // namespace procam::track::internal
