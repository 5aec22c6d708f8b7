#include "procam/track/align_maps.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "map_pairs.hpp"
#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track {
namespace {

using internal::alignment_starts;
using internal::ElementPair;
using internal::Kind;
using internal::MapPairs;
using internal::pair_equations;

/// A pair that the others agree with is rejected by chance once in so many.
constexpr double kPairRate = 1e-4;
/// And maps whose sigmas are as stated "disagree" once in so many.
constexpr double kMapsRate = 1e-3;
/// Starts that are refined, the best first.
constexpr std::size_t kMaxStarts = 60;
/// Two alignments are two when they differ by more than this at the middle of the elements.
constexpr double kOtherPosition = 0.1, kOtherAngle = 0.05;

struct Alignment {
  Pose map_a_from_map_b;
  Vec3 centre = Vec3::Zero();       ///< in map A: mean of the used elements of A
  Mat6 information = Mat6::Zero();  ///< of the increment about the centre
  std::vector<std::size_t> used;    ///< indices of pairs
  int measurements = 0;             ///< numbers in the used pairs
  double chi2 = 0;                  ///< of the used pairs
};

double limit_of(const ElementPair& pair) {
  static const double of_plane = procam::internal::chi_square_limit(kPairRate, 3),
                      of_pose = procam::internal::chi_square_limit(kPairRate, 6);
  return pair.kind == Kind::kPose ? of_pose : of_plane;
}

/// Pairs within `widen` times their limit, each element once: the nearer pair first.
void choose(const MapPairs& all, double widen, Alignment& at) {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < all.pairs.size(); ++i) {
    const double chi2 =
        pair_equations(all, all.pairs[i], at.map_a_from_map_b, at.centre).residual.squaredNorm();
    if (chi2 < widen * limit_of(all.pairs[i])) near.push_back({chi2, i});
  }
  std::sort(near.begin(), near.end());
  std::vector<bool> taken_a(all.map_a.size()), taken_b(all.map_b.size());
  at.used.clear();
  at.measurements = 0;
  at.chi2 = 0;
  for (const auto& [chi2, i] : near) {
    const ElementPair& pair = all.pairs[i];
    if (taken_a[pair.a] || taken_b[pair.b]) continue;
    taken_a[pair.a] = taken_b[pair.b] = true;
    at.used.push_back(i);
    at.measurements += pair.size();
    at.chi2 += chi2;
  }
}

/// One step of Gauss-Newton over the used pairs; directions without information stay where they are. `widen` is that of
/// choose(): above 1, far pairs count less (Geman and McClure), so that a wrong one does not win over several right ones.
void step(const MapPairs& all, double widen, Alignment& at) {
  at.centre.setZero();
  for (const std::size_t i : at.used)
    at.centre += all.a(all.pairs[i]).map_from_element.translation / double(at.used.size());
  Mat6 information = Mat6::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  for (const std::size_t i : at.used) {
    const auto equations = pair_equations(all, all.pairs[i], at.map_a_from_map_b, at.centre);
    const double far = equations.residual.squaredNorm() / limit_of(all.pairs[i]);
    const double weight = widen > 1 ? 1 / ((1 + far) * (1 + far)) : 1;
    information += weight * equations.jacobian.transpose() * equations.jacobian;
    gradient += weight * equations.jacobian.transpose() * equations.residual;
  }
  at.information = information;
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(information);
  Eigen::Matrix<double, 6, 1> xi = Eigen::Matrix<double, 6, 1>::Zero();
  for (int k = 0; k < 6; ++k)
    if (eigen.eigenvalues()[k] > 1e-9 * eigen.eigenvalues()[5])
      xi -= eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).dot(gradient) / eigen.eigenvalues()[k];
  const Pose centre_from_a(Mat3(Mat3::Identity()), Vec3(-at.centre));
  at.map_a_from_map_b =
      (centre_from_a.inverse() * se3_exp(xi) * centre_from_a * at.map_a_from_map_b).normalized();
}

/// The pairs that agree sharpen from round to round.
Alignment refined(const MapPairs& all, const Pose& start) {
  Alignment at;
  at.map_a_from_map_b = start;
  for (const double widen : {50.0, 12.0, 3.0, 1.0, 1.0, 1.0, 1.0}) {
    choose(all, widen, at);
    if (at.used.empty()) return at;
    step(all, widen, at);
  }
  choose(all, 1, at);
  return at;
}

bool better(const Alignment& p, const Alignment& q) {
  return p.used.size() != q.used.size() ? p.used.size() > q.used.size() : p.chi2 < q.chi2;
}

/// All alignments that differ, the best first.
std::vector<Alignment> alignments(const MapPairs& all) {
  std::vector<Alignment> rough;
  for (const Pose& start : alignment_starts(all)) {
    Alignment at;
    at.map_a_from_map_b = start;
    choose(all, 50, at);
    rough.push_back(std::move(at));
  }
  std::sort(rough.begin(), rough.end(), better);
  std::vector<Alignment> found;
  std::size_t refinements = 0;
  const auto same = [](const Alignment& p, const Pose& q) {
    // At the middle of the elements, and what the rotation does there.
    const Pose change = q * p.map_a_from_map_b.inverse();
    return (change * p.centre - p.centre).norm() < kOtherPosition &&
           so3_log(change.rotation).norm() < kOtherAngle;
  };
  for (const Alignment& start : rough) {
    if (refinements == kMaxStarts) break;
    if (std::any_of(found.begin(), found.end(), [&](const Alignment& f) {
          return same(f, start.map_a_from_map_b) && f.used.size() >= start.used.size();
        }))
      continue;
    ++refinements;
    Alignment next = refined(all, start.map_a_from_map_b);
    const auto twin = std::find_if(found.begin(), found.end(),
                                   [&](const Alignment& f) { return same(f, next.map_a_from_map_b); });
    if (twin == found.end())
      found.push_back(std::move(next));
    else if (better(next, *twin))
      *twin = std::move(next);
  }
  std::sort(found.begin(), found.end(), better);
  return found;
}

MapPairs pairs_of(const std::vector<MapElement>& map_a, const std::vector<MapElement>& map_b,
                  bool planes_by_geometry) {
  MapPairs all{map_a, map_b, {}};
  for (std::size_t a = 0; a < map_a.size(); ++a)
    for (std::size_t b = 0; b < map_b.size(); ++b) {
      const Kind kind = map_a[a].kind;
      const bool by_geometry = planes_by_geometry && kind == Kind::kPlane;
      if (kind == map_b[b].kind && (by_geometry || map_a[a].name == map_b[b].name))
        all.pairs.push_back({a, b, kind});
    }
  if (all.pairs.empty())
    throw Error(
        ErrorKind::kNotEnoughData, "the two maps", "no surface and no marker is in both",
        "name the same walls alike in both maps, match them by geometry, or let both robots see one marker");
  return all;
}

/// With its largest component positive: of an axis, either sign means the same.
std::string direction(const Vec3& v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  const Vec3 n = v.normalized() * (v[largest] < 0 ? -1 : 1);
  const auto number = [](double x) { return fixed(std::abs(x) < 0.005 ? 0 : x, 2); };
  return "(" + number(n.x()) + " " + number(n.y()) + " " + number(n.z()) + ")";
}

/// Refuses what the pairs leave open, by its name: sigmas above the limits along any direction.
void check_observable(const Alignment& best, const PlacedSigma& largest) {
  Eigen::Matrix<double, 6, 1> scale;
  scale << Vec3::Constant(largest.angle), Vec3::Constant(largest.position);
  const Mat6 scaled = scale.asDiagonal() * best.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(scaled);
  std::string open;
  for (int k = 0; k < 6 && eigen.eigenvalues()[k] < 1; ++k) {
    const Eigen::Matrix<double, 6, 1> along = scale.cwiseProduct(eigen.eigenvectors().col(k));
    const Vec3 turn = along.head<3>() / largest.angle, shift = along.tail<3>() / largest.position;
    const std::string what = turn.norm() > shift.norm() ? "the turn about the axis " + direction(turn)
                                                        : "the position along " + direction(shift);
    open += (open.empty() ? "" : " and ") + what;
  }
  if (!open.empty())
    throw Error(ErrorKind::kDegenerate, "the maps' common surfaces and markers",
                "they do not fix " + open + " of map A to within " + significant(largest.position * 1e3, 2) +
                    " mm and " + significant(largest.angle * 180 / kPi, 2) + " degrees",
                "add a wall across, or a marker that both robots see, far from the others");
}

/// A second alignment that as many surfaces and markers agree with is as likely.
void check_unique(const std::vector<Alignment>& found, Diagnostics& diagnostics) {
  if (found.size() < 2) return;
  const Alignment &best = found[0], &other = found[1];
  if (other.used.size() + 1 < best.used.size()) return;
  const Pose change = other.map_a_from_map_b * best.map_a_from_map_b.inverse();
  const Vec3 turn = so3_log(change.rotation);
  const std::string how = "turned by " + fixed(turn.norm() * 180 / kPi, 0) + " degrees" +
                          (turn.norm() > kOtherAngle ? " about the axis " + direction(turn) : "") +
                          " and moved by " + fixed((change * best.centre - best.centre).norm(), 2) + " m";
  if (other.used.size() < best.used.size()) {
    diagnostics.warn("second_alignment",
                     "another alignment, " + how +
                         ", agrees with one surface or marker less; look at the result, or "
                         "let both robots see one marker");
    return;
  }
  throw Error(
      ErrorKind::kDegenerate, "the maps' common surfaces and markers",
      "equally many of them agree with two alignments; the second is " + how + ": the room is symmetric",
      "let both robots see one marker, or match the walls by their names");
}

/// By name, most pairs must agree: else either half could be the wrong one.
void check_majority(const MapPairs& all, const Alignment& best, bool planes_by_geometry) {
  std::size_t named = 0, agree = 0;
  for (const ElementPair& pair : all.pairs) named += !planes_by_geometry || pair.kind == Kind::kPose;
  for (const std::size_t i : best.used) agree += !planes_by_geometry || all.pairs[i].kind == Kind::kPose;
  if (named == 0 || 2 * agree > named) return;
  throw Error(ErrorKind::kDegenerate, "the two maps",
              "of " + std::to_string(named) + " surfaces and markers with the same name only " +
                  std::to_string(agree) + " agree on one alignment",
              "see that a name means the same thing in both maps, or match the planes by geometry");
}

std::vector<AlignedPair> describe(const MapPairs& all, const Alignment& best, bool planes_by_geometry) {
  std::vector<AlignedPair> pairs;
  for (std::size_t i = 0; i < all.pairs.size(); ++i) {
    const ElementPair& pair = all.pairs[i];
    const bool used = std::find(best.used.begin(), best.used.end(), i) != best.used.end();
    if (!used && planes_by_geometry && pair.kind == Kind::kPlane) continue;  // a pair that was only tried
    const MapElement &a = all.a(pair), &b = all.b(pair);
    const Pose a_from_b = a.map_from_element.inverse() * best.map_a_from_map_b * b.map_from_element;
    AlignedPair out{a.name, b.name, used};
    const Vec3 axis = a_from_b.rotate(Vec3::UnitZ());
    out.distance =
        pair.kind == Kind::kPose ? a_from_b.translation.norm() : std::abs(a_from_b.translation.z());
    out.angle = pair.kind == Kind::kPose ? so3_log(a_from_b.rotation).norm()
                                         : std::atan2(axis.head<2>().norm(), axis.z());
    out.chi2 = pair_equations(all, pair, best.map_a_from_map_b, best.centre).residual.squaredNorm();
    pairs.push_back(std::move(out));
  }
  return pairs;
}

std::vector<std::string> unmatched(const std::vector<MapElement>& map, const std::vector<AlignedPair>& pairs,
                                   std::string AlignedPair::*name) {
  std::vector<std::string> out;
  for (const MapElement& element : map)
    if (std::none_of(pairs.begin(), pairs.end(),
                     [&](const AlignedPair& pair) { return pair.*name == element.name; }))
      out.push_back(element.name);
  return out;
}

void remark(AlignMapsResult& result) {
  std::string rejected;
  for (const AlignedPair& pair : result.pairs)
    if (!pair.used)
      rejected += (rejected.empty() ? "'" : ", '") + pair.name_in_a + "' (" + fixed(pair.distance * 1e3, 0) +
                  " mm, " + fixed(pair.angle * 180 / kPi, 1) + " degrees)";
  if (!rejected.empty())
    result.diagnostics.warn("pair_rejected",
                            "rejected, because the others contradict it: " + rejected +
                                "; it was moved between the maps, or is not the same thing in both");
  if (result.degrees_of_freedom == 0) {
    result.diagnostics.warn(
        "unchecked",
        "there are no more measurements than unknowns: an error in either map would not be "
        "seen; add a surface or a marker that both robots see");
    return;
  }
  if (result.chi2 <= procam::internal::chi_square_limit(kMapsRate, result.degrees_of_freedom)) return;
  const double factor = result.chi2 / result.degrees_of_freedom;
  result.map_a_from_map_b.covariance *= factor;
  result.diagnostics.warn("maps_disagree",
                          "the maps differ by " + fixed(std::sqrt(factor), 1) +
                              " times what their sigmas allow; the stated error is scaled by it: "
                              "state larger sigmas, or look for a map that is bent");
}

}  // namespace

AlignMapsResult align_maps(const std::vector<MapElement>& map_a, const std::vector<MapElement>& map_b,
                           const AlignMapsOptions& options) {
  for (const auto* map : {&map_a, &map_b})
    for (const MapElement& element : *map)
      require(element.map_from_element.is_finite() && element.covariance.allFinite(),
              "align_maps: '" + element.name + "' is not finite");
  require(options.largest_sigma.position > 0 && options.largest_sigma.angle > 0,
          "align_maps: the largest sigmas must be positive");
  const MapPairs all = pairs_of(map_a, map_b, options.planes_by_geometry);
  const std::vector<Alignment> found = alignments(all);
  const Alignment& best = found.front();
  check_majority(all, best, options.planes_by_geometry);
  check_observable(best, options.largest_sigma);
  AlignMapsResult result;
  check_unique(found, result.diagnostics);
  const Mat6 origin_from_centre = adjoint(Pose(Mat3(Mat3::Identity()), best.centre));
  result.map_a_from_map_b = {best.map_a_from_map_b, origin_from_centre * best.information.inverse() *
                                                        origin_from_centre.transpose()};
  result.pairs = describe(all, best, options.planes_by_geometry);
  result.only_in_a = unmatched(map_a, result.pairs, &AlignedPair::name_in_a);
  result.only_in_b = unmatched(map_b, result.pairs, &AlignedPair::name_in_b);
  result.chi2 = best.chi2;
  result.degrees_of_freedom = best.measurements - 6;
  remark(result);
  return result;
}

std::vector<MapElement> elements_of(const SurfaceSet& surfaces, const PlacedSigma& sigma) {
  std::vector<MapElement> elements;
  for (const Surface& surface : surfaces.surfaces) {
    const auto* plane = std::get_if<PlanarSurface>(&surface.geometry);
    if (plane == nullptr || plane->frame != "world") continue;
    Vec3 middle = Vec3::Zero();
    for (const Vec2& point : plane->points) middle.head<2>() += point / double(plane->points.size());
    MapElement element{surface.name, Kind::kPlane,
                       plane->frame_from_surface * Pose(Mat3(Mat3::Identity()), middle)};
    element.covariance.diagonal() << Vec3::Constant(sigma.angle * sigma.angle),
        Vec3::Constant(sigma.position * sigma.position);
    elements.push_back(std::move(element));
  }
  return elements;
}

std::vector<MapElement> elements_of(const MarkerMap& map, const PlacedSigma& otherwise) {
  const bool states = map.position_sigma > 0 || map.angle_sigma > 0;
  const double position = states ? map.position_sigma : otherwise.position,
               angle = states ? map.angle_sigma : otherwise.angle;
  std::vector<MapElement> elements;
  for (const PlacedMarker& marker : map.markers) {
    MapElement element{"marker " + std::to_string(marker.id), Kind::kPose, marker.world_from_marker};
    element.covariance.diagonal() << Vec3::Constant(angle * angle), Vec3::Constant(position * position);
    elements.push_back(std::move(element));
  }
  return elements;
}

SurfaceSet moved(SurfaceSet surfaces, const Pose& map_a_from_map_b) {
  for (Surface& surface : surfaces.surfaces) {
    InRoom* place = place_of(surface.geometry);
    if (place != nullptr && place->frame == "world")
      place->frame_from_surface = (map_a_from_map_b * place->frame_from_surface).normalized();
  }
  return surfaces;
}

MarkerMap moved(MarkerMap map, const PoseWithCovariance& map_a_from_map_b) {
  double position = 0;
  for (PlacedMarker& marker : map.markers) {
    const Mat3 of_marker = point_covariance(map_a_from_map_b, marker.world_from_marker.translation);
    position = std::max(position, of_marker.diagonal().maxCoeff());
    marker.world_from_marker = (map_a_from_map_b.pose * marker.world_from_marker).normalized();
  }
  map.position_sigma = std::sqrt(map.position_sigma * map.position_sigma + position);
  map.angle_sigma = std::sqrt(map.angle_sigma * map.angle_sigma +
                              map_a_from_map_b.covariance.diagonal().head<3>().maxCoeff());
  return map;
}

}  // namespace procam::track
