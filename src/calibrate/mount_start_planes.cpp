#include "mount_start_planes.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

namespace procam::calibrate::mount {
namespace {

/// A wall as the rig sees it at a time.
struct WallSighting {
  double time, distance;
  Vec2 normal;  ///< level, towards the rig
  Eigen::Index wall;
};

Vec3 normal_in_rig(const MarkerSighting& seen) {
  return seen.marker_from_rig.pose.rotation.conjugate() * Vec3::UnitZ();
}

[[noreturn]] void refuse_planes(const std::string& why) {
  throw Error(
      ErrorKind::kInput, "sightings", why,
      "check that planes and poses are in metres and of one drive, and that each plane is plane_from_rig, with z "
      "towards the rig (docs/mount.md)");
}

struct Floor {
  Eigen::Quaterniond level_from_rig;
  double distance;
};
Floor floor_of(const Model& model) {
  const MountOptions& options = *model.options;
  const std::string name = options.floor ? options.floor->plane : MountFloor().plane;
  Vec3 up = Vec3::Zero();
  Points3 normals;
  std::vector<double> distances;
  for (const MarkerSighting& seen : model.data->sightings) {
    if (seen.marker != name || !model.at(seen.time)) continue;
    normals.push_back(normal_in_rig(seen));
    up += normals.back();
    distances.push_back(seen.marker_from_rig.pose.translation.z());
  }
  if (distances.empty())
    throw Error(ErrorKind::kDegenerate, "mount",
                "only walls are seen, which give no start values for roll and pitch of the rig",
                "let the sensor see the floor as well (" + name + "), show it a marker, or give --prior");
  std::vector<double> off;
  for (const Vec3& normal : normals)
    off.push_back(std::acos(std::clamp(normal.dot(up.normalized()), -1.0, 1.0)));
  const double usual = median(off);
  constexpr double kSteady = 5 * kDegree;
  if (!(usual < kSteady))
    refuse_planes("the normal of the floor, as the rig sees it, is not steady (" + fixed(usual / kDegree, 0) +
                  " degrees off its mean in the median)");
  return {rotation_between(up, Vec3::UnitZ()), median(distances)};
}

std::vector<WallSighting> walls_of(const Model& model, const Floor& floor) {
  constexpr double kLevel = 0.5;
  std::vector<WallSighting> walls;
  std::vector<Eigen::Index> number(model.markers.size(), -1);
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < model.data->sightings.size(); ++i) {
    const MarkerSighting& seen = model.data->sightings[i];
    const Vec3 normal = floor.level_from_rig * normal_in_rig(seen);
    if (!model.at(seen.time) || std::abs(normal.z()) > kLevel) continue;
    Eigen::Index& wall = number[std::size_t(model.marker_of[i])];
    if (wall < 0) wall = count++;
    walls.push_back(
        {seen.time, seen.marker_from_rig.pose.translation.z(), normal.head<2>().normalized(), wall});
  }
  return walls;
}

struct FromWalls {
  VecX solved;                                              ///< cos(yaw), sin(yaw), u, the walls' c
  double misfit = std::numeric_limits<double>::infinity();  ///< median, metres
};

/// By how much the walls' directions in the world change with time, radians: median.
double unsteadiness(const Model& model, const std::vector<const WallSighting*>& walls, Eigen::Index count,
                    double later) {
  std::vector<Vec2> mean(std::size_t(count), Vec2::Zero()), directions;
  for (const WallSighting* seen : walls) {
    const Vec3 normal = model.path(seen->time + later).rotate(Vec3(seen->normal.x(), seen->normal.y(), 0));
    directions.push_back(normal.head<2>().normalized());
    mean[std::size_t(seen->wall)] += directions.back();
  }
  std::vector<double> off;
  for (std::size_t i = 0; i < walls.size(); ++i)
    off.push_back(
        std::acos(std::clamp(directions[i].dot(mean[std::size_t(walls[i]->wall)].normalized()), -1.0, 1.0)));
  return median(std::move(off));
}

/// With the clocks so far apart.
FromWalls from_walls(const Model& model, const std::vector<WallSighting>& walls, double later) {
  constexpr double kUsual = 0.03;  // m
  constexpr std::size_t kEnough = 600;
  const std::size_t step = 1 + walls.size() / kEnough;
  std::vector<const WallSighting*> taken;
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < walls.size(); i += step) taken.push_back(&walls[i]);
  for (const WallSighting* seen : taken) count = std::max(count, seen->wall + 1);
  const auto n = Eigen::Index(taken.size());
  MatX rows = MatX::Zero(n, 4 + count);
  VecX right(n), weight = VecX::Ones(n);
  const Vec3 middle = model.path(taken[std::size_t(n / 2)]->time).translation;
  for (Eigen::Index i = 0; i < n; ++i) {
    const WallSighting& seen = *taken[std::size_t(i)];
    const Pose base = model.path(seen.time + later);
    const Vec3 m(seen.normal.x(), seen.normal.y(), 0), across(-m.y(), m.x(), 0);
    const Vec3 from_middle = base.translation - middle;
    rows.row(i).head<4>() << base.rotate(m).dot(from_middle), base.rotate(across).dot(from_middle), m.x(),
        m.y();
    rows(i, 4 + seen.wall) = -1;
    right[i] = seen.distance;
  }
  FromWalls found;
  for (int round = 0; round < 4; ++round) {
    found.solved = (weight.asDiagonal() * rows).colPivHouseholderQr().solve(VecX(weight.cwiseProduct(right)));
    const VecX off = (rows * found.solved - right).cwiseAbs();
    for (Eigen::Index i = 0; i < n; ++i) weight[i] = 1 / (1 + std::pow(off[i] / kUsual, 2));
    found.misfit = median(std::vector<double>(off.begin(), off.end()));
  }
  constexpr double kAway = 1;  // m: at which a turn counts as a distance
  found.misfit += kAway * unsteadiness(model, taken, count, later);
  return found;
}

}  // namespace

void check_planes(const MountData& data, const MountOptions& options) {
  std::vector<std::string> planes, markers;
  for (const MarkerSighting& seen : data.sightings) {
    std::vector<std::string>& names = seen.is_plane ? planes : markers;
    if (std::find(names.begin(), names.end(), seen.marker) == names.end()) names.push_back(seen.marker);
  }
  for (const std::string& name : planes)
    if (std::find(markers.begin(), markers.end(), name) != markers.end())
      throw Error(ErrorKind::kInput, "sightings", "'" + name + "' is both a marker and a plane",
                  "give planes names of their own");
  if (!options.floor) return;
  require(std::isfinite(options.floor->below) && options.floor->sigma > 0,
          "calibrate_mount: the floor needs a positive sigma");
  if (std::find(planes.begin(), planes.end(), options.floor->plane) == planes.end())
    throw Error(
        ErrorKind::kInput, "sightings",
        "the floor, '" + options.floor->plane + "', is stated and not seen" +
            (planes.empty() ? std::string("; there are no planes") : "; the planes are " + and_list(planes)),
        "name the floor's sightings so, or leave out --floor");
}

void move_within_plane(std::vector<Pose>& poses) {
  for (Pose& pose : poses) {
    const Pose off = poses.front().inverse() * pose;
    const Vec3 normal = off.rotate(Vec3::UnitZ());
    pose =
        poses.front() * Pose(rotation_between(Vec3::UnitZ(), normal), normal * normal.dot(off.translation));
  }
}

Pose mount_from_planes(Model& model) {
  const MountOptions& options = *model.options;
  if (!model.planar)
    throw Error(ErrorKind::kDegenerate, "mount",
                "only planes are seen, which suffice on a robot that drives in a plane",
                "show the rig a marker, or give --prior");
  const Floor floor = floor_of(model);
  const std::vector<WallSighting> walls = walls_of(model, floor);
  constexpr double kStep = 0.02;  // s
  constexpr std::size_t kFewest = 20;
  const int steps = options.estimate_time_offset ? int(std::ceil(options.max_time_offset / kStep)) : 0;
  FromWalls best;
  double chosen = 0;
  if (walls.size() >= kFewest)
    for (int s = -steps; s <= steps; ++s) {
      const FromWalls found = from_walls(model, walls, s * kStep);
      if (found.misfit < best.misfit) best = found, chosen = s * kStep;
    }
  constexpr double kFits = 0.1;  // m
  if (best.solved.size() > 0 && best.misfit > kFits)
    refuse_planes("the distances of the walls do not follow the poses of the base (" + mm(best.misfit, 0) +
                  " off in the median)");
  constexpr double kDirection = 0.3;  // of 1
  if (best.solved.size() == 0 || !(best.solved.head<2>().norm() > kDirection))
    throw Error(ErrorKind::kDegenerate, "mount",
                "the walls that are seen do not determine yaw, x and y of the rig on the base",
                "drive curves, and towards and away from two walls or more, or show the rig a marker");
  model.offset += chosen;
  model.start -= chosen;
  const Eigen::Quaterniond turned = so3_exp(Vec3(0, 0, std::atan2(best.solved[1], best.solved[0])));
  const Vec3 level(best.solved[2], best.solved[3], 0);
  Pose mount(turned * floor.level_from_rig, turned * level);
  mount.translation.z() = floor.distance - (options.floor ? options.floor->below : 0);
  return mount;
}

}  // namespace procam::calibrate::mount
