#pragma once
/// Why a set of point pairs carries no homography, in words that name the points. Off the fast path: called
/// when the normal equations look suspicious.
///
/// A homography needs four points of which no three are collinear. A set lacks such four exactly when all but
/// at most one of its distinct places lie on one line.
#include <algorithm>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography.hpp"

namespace procam::detail {

/// "3", "3 and 7", "3, 7 and 9", "3, 7, 9 and 20 more".
inline std::string list_points(const std::vector<int>& indices) {
  constexpr std::size_t kShown = 6;
  std::string text;
  const std::size_t shown = std::min(indices.size(), kShown);
  for (std::size_t i = 0; i < shown; ++i) {
    if (i > 0) text += i + 1 == indices.size() ? " and " : ", ";
    text += std::to_string(indices[i]);
  }
  if (indices.size() > shown) text += " and " + std::to_string(indices.size() - shown) + " more";
  return text;
}

/// The points off the line through a and b (farther than `distance`), at most one place of them allowed to be
/// tried: nullopt as soon as two of them are farther than `distance` from each other.
inline std::optional<std::vector<int>> single_place_off_line(const Points2& points,
                                                             const std::vector<int>& used, int a, int b,
                                                             double distance) {
  const Vec2 along = (points[b] - points[a]).normalized();
  std::vector<int> off;
  for (const int i : used) {
    const Vec2 offset = points[i] - points[a];
    if (std::abs(along.x() * offset.y() - along.y() * offset.x()) <= distance) continue;
    if (!off.empty() && (points[i] - points[off.front()]).norm() > distance) return std::nullopt;
    off.push_back(i);
  }
  return off;
}

/// Throws when all but at most one place of `points` lie on one line.
inline void refuse_one_line(const Points2& points, const std::vector<int>& used, const std::string& side,
                            double tolerance) {
  const std::string what = "homography from " + std::to_string(used.size()) + " points";
  const auto farthest = [&](auto distance_to) {
    return *std::max_element(used.begin(), used.end(),
                             [&](int i, int j) { return distance_to(points[i]) < distance_to(points[j]); });
  };
  Vec2 centre = Vec2::Zero();
  for (const int i : used) centre += points[i] / double(used.size());
  const int a = farthest([&](const Vec2& p) { return (p - centre).norm(); });
  const int b = farthest([&](const Vec2& p) { return (p - points[a]).norm(); });
  const Vec2 ab = points[b] - points[a];
  const double extent = ab.norm();
  if (extent == 0.0)
    throw Error(ErrorKind::kDegenerate, what, "all " + side + " points coincide",
                "give at least four distinct points");
  const int c = farthest(
      [&](const Vec2& p) { return std::abs(ab.x() * (p - points[a]).y() - ab.y() * (p - points[a]).x()); });
  // If a line holds all places but one, it holds two of any three: of a, b and c, which lie far apart.
  for (const auto& [i, j] : {std::pair(a, b), std::pair(a, c), std::pair(b, c)}) {
    if (i == j || (points[i] - points[j]).norm() <= tolerance * extent) continue;
    const auto off = single_place_off_line(points, used, i, j, tolerance * extent);
    if (!off) continue;
    const std::string why = off->empty()
                                ? "all " + side + " points lie on one line"
                                : "all " + side + " points but " + list_points(*off) + " lie on one line";
    throw Error(ErrorKind::kDegenerate, what, why,
                "add points off that line: four are needed with no three on a line");
  }
}

/// Throws the reason if the pairs (of positive weight) are too few, not finite or degenerate; returns
/// otherwise.
inline void refuse_degenerate(const Points2& source, const Points2& destination,
                              const std::vector<double>& weights, double tolerance) {
  std::vector<int> used, not_finite;
  for (int i = 0; i < int(source.size()); ++i) {
    if (!weights.empty() && !(weights[i] > 0.0)) continue;
    used.push_back(i);
    if (!source[i].allFinite() || !destination[i].allFinite()) not_finite.push_back(i);
  }
  const std::string what = "homography from " + std::to_string(used.size()) + " points";
  if (!not_finite.empty())
    throw Error(ErrorKind::kInput, what, "pair(s) " + list_points(not_finite) + " are not finite",
                "remove them or measure them again");
  if (used.size() < 4)
    throw Error(ErrorKind::kNotEnoughData, what,
                "a homography has eight unknowns and each pair gives two equations",
                "give at least four pairs");
  if (used.size() == 4) {
    std::array<Vec2, 4> s, d;
    std::array<int, 4> index;
    for (int i = 0; i < 4; ++i) s[i] = source[used[i]], d[i] = destination[used[i]], index[i] = used[i];
    if (!exact_from_four(s, d, kCollinearTolerance)) refuse_four(s, d, index, kCollinearTolerance);
    return;
  }
  refuse_one_line(source, used, "source", tolerance);
  refuse_one_line(destination, used, "destination", tolerance);
}

[[noreturn]] inline void refuse_horizon(const Points2& source, const std::vector<double>& weights,
                                        const Mat3& matrix) {
  std::vector<int> behind, front;
  for (int i = 0; i < int(source.size()); ++i)
    if (weights.empty() || weights[i] > 0.0)
      (matrix.row(2).dot(Vec3(source[i].x(), source[i].y(), 1.0)) > 0.0 ? front : behind).push_back(i);
  if (behind.size() > front.size()) std::swap(behind, front);
  throw Error(ErrorKind::kDegenerate,
              "homography from " + std::to_string(front.size() + behind.size()) + " points",
              "its horizon runs between the points: " + list_points(behind) + " lie beyond it",
              "check that both lists name the same points in the same order, or use the robust fit");
}

[[noreturn]] inline void refuse_not_converged(int iterations) {
  throw Error(ErrorKind::kNotConverged, "homography",
              "no minimum after " + std::to_string(iterations) + " iterations",
              "check the pairs for outliers, or use the robust fit");
}

[[noreturn]] inline void refuse_unexplained() {
  throw Error(ErrorKind::kDegenerate, "homography", "the points determine no homography to within rounding",
              "spread the points over both planes");
}

template <typename Matrix>
double norm_1(const Matrix& m) {
  return m.cwiseAbs().colwise().sum().maxCoeff();
}

}  // namespace procam::detail
