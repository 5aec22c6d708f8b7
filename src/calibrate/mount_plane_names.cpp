#include "mount_plane_names.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "mount_costs.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::calibrate::mount {
namespace {

/// A plane as the rig sees it: n . x = -distance, n towards the rig.
struct PlaneInRig {
  Vec3 normal;
  double distance;
};
PlaneInRig plane_in_rig(const MarkerSighting& seen) {
  return {seen.marker_from_rig.pose.rotation.conjugate() * Vec3::UnitZ(),
          seen.marker_from_rig.pose.translation.z()};
}

double angle_between(const Vec3& one, const Vec3& other) {
  return std::atan2(one.cross(other).norm(), one.dot(other));
}

/// One plane, from image to image.
struct Track {
  std::vector<std::size_t> sightings;
  double time = 0;
  PlaneInRig last{};
  bool has_rate = false;
  Vec3 normal_rate = Vec3::Zero();
  double distance_rate = 0;

  PlaneInRig predicted(double at) const {
    const double later = at - time;
    return {(last.normal + later * normal_rate).normalized(), last.distance + later * distance_rate};
  }
  void add(std::size_t sighting, const PlaneInRig& seen, double at) {
    constexpr double kShare = 0.5;  // of the newest rate
    if (!sightings.empty() && at > time) {
      const double share = has_rate ? kShare : 1;
      normal_rate += share * ((seen.normal - last.normal) / (at - time) - normal_rate);
      distance_rate += share * ((seen.distance - last.distance) / (at - time) - distance_rate);
      has_rate = true;
    }
    sightings.push_back(sighting);
    last = seen;
    time = at;
  }
  /// How far a plane is from the predicted one, 1 at the most that a robot and noise make it.
  double misfit(const PlaneInRig& seen, double at) const {
    constexpr double kAngle = 3 * kDegree, kTurn = 1.6, kTurnChange = 1.8;  // rad/s, rad/s^2
    constexpr double kDistance = 0.04, kSpeed = 0.7, kSpeedChange = 1;      // m, m/s, m/s^2
    const double later = at - time;
    const PlaneInRig there = predicted(at);
    const double angle = kAngle + (has_rate ? kTurnChange * later * later : kTurn * later),
                 distance = kDistance + (has_rate ? kSpeedChange * later * later : kSpeed * later);
    return std::max(angle_between(there.normal, seen.normal) / angle,
                    std::abs(there.distance - seen.distance) / distance);
  }
};

/// Each image gives a track one sighting at most, the nearest first.
void extend(std::vector<Track>& tracks, const MountData& data, const std::vector<std::size_t>& image) {
  struct Pairing {
    double misfit;
    std::size_t track, sighting;
  };
  constexpr double kLongestGap = 0.6;  // s
  std::vector<Pairing> pairings;
  for (std::size_t t = 0; t < tracks.size(); ++t)
    for (const std::size_t i : image) {
      const double at = data.sightings[i].time;
      if (at - tracks[t].time > kLongestGap) continue;
      const double misfit = tracks[t].misfit(plane_in_rig(data.sightings[i]), at);
      if (misfit < 1) pairings.push_back({misfit, t, i});
    }
  std::sort(pairings.begin(), pairings.end(),
            [](const Pairing& one, const Pairing& other) { return one.misfit < other.misfit; });
  std::vector<std::size_t> taken;
  std::vector<char> extended(tracks.size(), 0);
  const auto is_taken = [&](std::size_t i) {
    return std::find(taken.begin(), taken.end(), i) != taken.end();
  };
  for (const Pairing& pairing : pairings) {
    if (extended[pairing.track] != 0 || is_taken(pairing.sighting)) continue;
    const MarkerSighting& seen = data.sightings[pairing.sighting];
    tracks[pairing.track].add(pairing.sighting, plane_in_rig(seen), seen.time);
    extended[pairing.track] = 1;
    taken.push_back(pairing.sighting);
  }
  for (const std::size_t i : image) {
    if (is_taken(i)) continue;
    tracks.emplace_back();
    tracks.back().add(i, plane_in_rig(data.sightings[i]), data.sightings[i].time);
  }
}

std::vector<Track> tracks_of(const MountData& data) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < data.sightings.size(); ++i)
    if (data.sightings[i].is_plane && data.sightings[i].marker.empty()) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return data.sightings[a].time < data.sightings[b].time;
  });
  std::vector<Track> tracks;
  for (std::size_t first = 0; first < order.size();) {
    std::size_t end = first;
    while (end < order.size() && data.sightings[order[end]].time == data.sightings[order[first]].time) ++end;
    extend(tracks, data, {order.begin() + std::ptrdiff_t(first), order.begin() + std::ptrdiff_t(end)});
    first = end;
  }
  return tracks;
}

/// Heading of the base at its poses, unwrapped; between them linear.
class Heading {
 public:
  explicit Heading(const std::vector<BasePose>& base) {
    Vec3 up = Vec3::Zero();
    for (const BasePose& pose : base) up += pose.world_from_base.rotate(Vec3::UnitZ());
    const Eigen::Quaterniond level = rotation_between(up, Vec3::UnitZ());
    double heading = 0, before = 0;
    for (std::size_t i = 0; i < base.size(); ++i) {
      const Vec3 ahead = level * base[i].world_from_base.rotate(Vec3::UnitX());
      const double angle = std::atan2(ahead.y(), ahead.x());
      heading += i == 0 ? 0 : std::remainder(angle - before, 2 * kPi);
      before = angle;
      times_.push_back(base[i].time);
      headings_.push_back(heading);
    }
  }
  double operator()(double time) const {
    const auto after = std::lower_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return headings_.front();
    if (after == times_.end()) return headings_.back();
    const auto i = std::size_t(after - times_.begin());
    const double share = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
    return headings_[i - 1] + share * (headings_[i] - headings_[i - 1]);
  }

 private:
  std::vector<double> times_, headings_;
};

/// A plane that stays where it is for the rig while the base turns.
struct Horizontal {
  Vec3 normal = Vec3::Zero();
  double distance = 0;
  std::size_t sightings = 0;
};

constexpr double kSteadyAngle = 2 * kDegree, kSteadyDistance = 0.02;

/// The mean of a track, if nine of ten sightings are near it.
std::optional<Horizontal> steady(const Track& track, const MountData& data) {
  constexpr std::size_t kFewest = 5;
  constexpr double kShare = 0.9;
  if (track.sightings.size() < kFewest) return std::nullopt;
  Horizontal mean;
  std::vector<double> distances, angles;
  for (const std::size_t i : track.sightings) {
    const PlaneInRig seen = plane_in_rig(data.sightings[i]);
    mean.normal += seen.normal;
    distances.push_back(seen.distance);
  }
  mean.normal.normalize();
  mean.distance = median(distances);
  mean.sightings = distances.size();
  for (double& distance : distances) distance = std::abs(distance - mean.distance);
  for (const std::size_t i : track.sightings)
    angles.push_back(angle_between(plane_in_rig(data.sightings[i]).normal, mean.normal));
  if (quantile(angles, kShare) > kSteadyAngle || quantile(distances, kShare) > kSteadyDistance)
    return std::nullopt;
  return mean;
}

/// Range of the heading while a track is seen.
double turn_during(const Track& track, const MountData& data, const Heading& heading, double offset) {
  double low = 1e300, high = -1e300;
  for (const std::size_t i : track.sightings) {
    const double at = heading(data.sightings[i].time + offset);
    low = std::min(low, at), high = std::max(high, at);
  }
  return high - low;
}

bool is_part_of(const Horizontal& part, const Horizontal& whole) {
  constexpr double kAngle = 3 * kDegree, kDistance = 0.05;
  return angle_between(part.normal, whole.normal) < kAngle &&
         std::abs(part.distance - whole.distance) < kDistance;
}

/// Walls turn against the base. About a normal that points downwards they turn with it.
double turns_with_base(const std::vector<Track>& tracks, const MountData& data, const Heading& heading,
                       double offset, const Vec3& normal) {
  const Eigen::Quaterniond level = rotation_between(normal, Vec3::UnitZ());
  constexpr double kUpright = 0.5;
  double sum = 0;
  for (const Track& track : tracks) {
    double turn = 0, before = 0;
    bool is_wall = track.sightings.size() > 1;
    for (std::size_t k = 0; k < track.sightings.size() && is_wall; ++k) {
      const Vec3 seen = level * plane_in_rig(data.sightings[track.sightings[k]]).normal;
      is_wall = std::abs(seen.z()) < kUpright;
      const double angle = std::atan2(seen.y(), seen.x());
      turn += k == 0 ? 0 : std::remainder(angle - before, 2 * kPi);
      before = angle;
    }
    if (!is_wall) continue;
    const double first = data.sightings[track.sightings.front()].time + offset,
                 last = data.sightings[track.sightings.back()].time + offset;
    sum += turn * (heading(last) - heading(first));
  }
  return sum;
}

/// The lowest plane below the rig.
std::optional<Horizontal> floor_of(const std::vector<Track>& tracks, const MountData& data, double offset) {
  const Heading heading(data.base);
  constexpr double kTurns = 20 * kDegree;
  std::vector<Horizontal> planes;
  for (const Track& track : tracks) {
    const auto mean = steady(track, data);
    if (!mean || turn_during(track, data, heading, offset) < kTurns) continue;
    const auto known = std::find_if(planes.begin(), planes.end(),
                                    [&](const Horizontal& plane) { return is_part_of(*mean, plane); });
    if (known == planes.end())
      planes.push_back(*mean);
    else
      known->sightings += mean->sightings;
  }
  if (planes.empty()) return std::nullopt;
  const auto most = std::max_element(
      planes.begin(), planes.end(),
      [](const Horizontal& one, const Horizontal& other) { return one.sightings < other.sightings; });
  // Without walls: the camera is not upside down, its y points downwards.
  const double with_base = turns_with_base(tracks, data, heading, offset, most->normal);
  const bool upwards = with_base == 0 ? most->normal.y() < 0 : with_base < 0;
  const Vec3 up = upwards ? most->normal : Vec3(-most->normal);
  constexpr double kRare = 0.1;  // of the sightings of the plane that is seen most
  std::optional<Horizontal> floor;
  for (const Horizontal& plane : planes) {
    if (plane.normal.dot(up) < 0 || double(plane.sightings) < kRare * double(most->sightings)) continue;
    if (!floor || plane.distance > floor->distance) floor = plane;
  }
  return floor;
}

}  // namespace

bool has_unnamed_planes(const MountData& data) {
  return std::any_of(data.sightings.begin(), data.sightings.end(),
                     [](const MarkerSighting& seen) { return seen.is_plane && seen.marker.empty(); });
}

MountData with_plane_names(const MountData& data, const MountOptions& options) {
  if (options.carrier != MountCarrier::kBase)
    throw Error(ErrorKind::kInput, "sightings", "planes without names are those of a robot that drives",
                "name the planes that an arm or a head sees");
  MountData named = data;
  const std::string floor_name = options.floor ? options.floor->plane : MountFloor().plane;
  const std::vector<Track> tracks = tracks_of(data);
  const std::optional<Horizontal> floor = floor_of(tracks, data, options.time_offset);
  const bool is_named = std::any_of(data.sightings.begin(), data.sightings.end(),
                                    [&](const MarkerSighting& seen) { return seen.marker == floor_name; });
  if (options.floor && !floor && !is_named)
    throw Error(
        ErrorKind::kDegenerate, "the floor",
        "no plane keeps its tilt and distance while the base turns, as a floor does",
        "tilt the sensor so that it sees the floor ahead, and drive curves; or leave out --floor and measure "
        "the height (--height)");
  int count = 0;
  for (const Track& track : tracks) {
    const auto mean = steady(track, data);
    const bool is_floor = floor && mean && is_part_of(*mean, *floor);
    const std::string name = is_floor ? floor_name : "plane_" + std::to_string(++count);
    for (const std::size_t i : track.sightings) named.sightings[i].marker = name;
  }
  return named;
}

MountData with_joined_planes(MountData data, const MountResult& first) {
  constexpr double kAngle = 3 * kDegree, kGap = 0.06, kAgrees = 16.3;  // 0.1 % of 3 degrees of freedom
  const std::vector<MountPlane>& planes = first.planes;
  // At the origin of the other one, tilt in its frame.
  const auto are_one = [&](const MountPlane& one, const MountPlane& other) {
    const Pose between = one.world_from_plane.inverse() * other.world_from_plane;
    const Vec3 off = off_plane(between);
    if (off.head<2>().norm() > kAngle || std::abs(off.z()) > kGap || between.rotate(Vec3::UnitZ()).z() < 0)
      return false;
    const Vec3 ahead = between.rotate(Vec3::UnitX());
    const double angle = std::atan2(ahead.y(), ahead.x()), c = std::cos(angle), s = std::sin(angle);
    Mat3 there;  // the first one's tilt and height
    there << c, s, 0, -s, c, 0, between.translation.y(), -between.translation.x(), 1;
    const Mat3 covariance = there * one.covariance * there.transpose() + other.covariance;
    return off.dot(covariance.ldlt().solve(off)) < kAgrees;
  };
  std::map<std::string, std::size_t> seen;
  for (const MarkerSighting& sighting : data.sightings)
    if (sighting.is_plane) ++seen[sighting.marker];
  // The one that is seen most stands for the others.
  std::vector<std::size_t> order(planes.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return seen[planes[a].name] > seen[planes[b].name]; });
  std::map<std::string, std::string> names;
  std::vector<std::size_t> kept;
  for (const std::size_t i : order) {
    const auto same =
        std::find_if(kept.begin(), kept.end(), [&](std::size_t k) { return are_one(planes[k], planes[i]); });
    if (same == kept.end())
      kept.push_back(i);
    else
      names[planes[i].name] = planes[*same].name;
  }
  for (MarkerSighting& sighting : data.sightings)
    if (const auto other = names.find(sighting.marker); sighting.is_plane && other != names.end())
      sighting.marker = other->second;
  return data;
}

}  // namespace procam::calibrate::mount
