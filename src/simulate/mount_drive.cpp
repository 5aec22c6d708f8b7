#include "procam/simulate/mount_drive.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "draw.hpp"
#include "mount_sightings.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/distortion/brown_conrady.hpp"

namespace procam::simulate {
namespace {

Camera usual_camera() {
  Camera camera;
  camera.size = {1280, 960};
  camera.intrinsics = {1150, 1157, 652, 468, 0.4};
  camera.distortion = BrownConrady{{-0.09, 0.05, 0.0004, -0.0003, 0}};
  return camera;
}

/// Robot: x ahead, z up. Camera ahead, some degrees off in each direction.
Pose usual_mount(Draw& draw) {
  Mat3 optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Vec3 off(draw.uniform(-0.1, 0.1), draw.uniform(-0.15, 0.25), draw.uniform(-0.5, 0.5));
  const Vec3 position(draw.uniform(0.05, 0.25), draw.uniform(-0.12, 0.12), draw.uniform(0.6, 1.1));
  return {so3_exp(off) * Eigen::Quaterniond(optical), position};
}

/// Slow waves: roll, pitch and height of a base on an uneven floor.
class Floor {
 public:
  Floor(const SightingOptions& options, Draw draw) : options_(options) {
    for (auto& wave : waves_) wave = {draw.uniform(0, 2 * kPi), draw.uniform(0.5, 3)};
  }
  Pose operator()(double time) const {
    const auto wave = [&](std::size_t i) {
      return std::sin(waves_[i].second * time + waves_[i].first) +
             std::sin(1.7 * waves_[i].second * time + 2 * waves_[i].first);
    };
    return {so3_exp(Vec3(options_.floor_tilt_sigma * wave(0), options_.floor_tilt_sigma * wave(1), 0)),
            Vec3(0, 0, options_.floor_sigma * wave(2))};
  }

 private:
  SightingOptions options_;
  std::array<std::pair<double, double>, 3> waves_;
};

Vec3 corner(const PlacedMarker& marker, std::size_t i) {
  const Vec2 at = marker_corners()[i] * marker.size;
  return {at.x(), at.y(), 0};
}

/// A marker before the camera, its print towards it.
Pose placed_before(const Pose& world_from_camera, Draw& draw) {
  const double distance = draw.uniform(1.2, 3);
  const Vec3 towards = Vec3(draw.uniform(-0.35, 0.35), draw.uniform(-0.2, 0.2), 1).normalized();
  const double turn = draw.uniform(15, 40) * kDegree * (draw.uniform(-1, 1) < 0 ? -1 : 1);
  const Pose camera_from_marker(so3_exp(Vec3(draw.uniform(-0.2, 0.2), turn, draw.uniform(-0.3, 0.3))),
                                distance * towards);
  return world_from_camera * camera_from_marker;
}

struct Corners {
  std::array<Vec2, 4> pixels;
};
std::optional<Corners> seen_corners(const Camera& camera, const Pose& camera_from_marker,
                                    const PlacedMarker& marker) {
  // From its back and at more than 70 degrees nobody detects it.
  const Vec3 sight = camera_from_marker.translation;
  if (camera_from_marker.rotate(Vec3::UnitZ()).dot(sight.normalized()) < std::cos(70 * kDegree))
    return std::nullopt;
  Corners corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 point = camera_from_marker * corner(marker, i);
    if (!(point.z() > 0.3) || !camera.sees(point)) return std::nullopt;
    corners.pixels[i] = *camera.project(point);
  }
  constexpr double kMinSide = 30;
  if ((corners.pixels[0] - corners.pixels[1]).norm() < kMinSide) return std::nullopt;
  return corners;
}

/// marker_from_camera by Gauss-Newton on the corners, from the truth on.
std::optional<PoseWithCovariance> fitted(const Camera& camera, const PlacedMarker& marker,
                                         const Corners& corners, Pose marker_from_camera, double sigma) {
  Mat6 normal = Mat6::Zero();
  for (int round = 0; round < 6; ++round) {
    Vec6 gradient = Vec6::Zero();
    normal.setZero();
    for (std::size_t i = 0; i < 4; ++i) {
      const auto pixel = [&](const Vec6& xi) {
        return camera.project((se3_exp(xi) * marker_from_camera).inverse() * corner(marker, i));
      };
      const auto at = pixel(Vec6::Zero());
      if (!at) return std::nullopt;
      Eigen::Matrix<double, 2, 6> by;
      for (int k = 0; k < 6; ++k) {
        constexpr double kStep = 1e-6;
        const auto ahead = pixel(kStep * Vec6::Unit(k)), behind = pixel(-kStep * Vec6::Unit(k));
        if (!ahead || !behind) return std::nullopt;
        by.col(k) = (*ahead - *behind) / (2 * kStep);
      }
      normal += by.transpose() * by;
      gradient += by.transpose() * (*at - corners.pixels[i]);
    }
    const Vec6 step = -normal.ldlt().solve(gradient);
    if (!(step.norm() < 0.5)) return std::nullopt;
    marker_from_camera = se3_exp(step) * marker_from_camera;
  }
  return PoseWithCovariance{marker_from_camera.normalized(),
                            sigma * sigma * normal.ldlt().solve(Mat6::Identity())};
}

std::vector<track::StampedPose> localiser_poses(const Drive& drive, const MountDriveOptions& options) {
  Draw draw(options.seed, 1);
  const double share = options.correlation_s > 0 ? std::exp(-1 / (options.rate * options.correlation_s)) : 0;
  Vec3 shift = options.position_sigma * draw.gauss3(), turn = options.rotation_sigma * draw.gauss3();
  Pose jump;  // of the world
  if (options.jump_time) {
    const Pose there = drive(drive.start_time() + *options.jump_time);
    jump = there * options.jump * there.inverse();
  }
  std::vector<track::StampedPose> poses;
  std::vector<double> times;
  for (const double time : options.pose_times) times.push_back(drive.start_time() + time);
  if (times.empty())
    for (int i = 0; i <= int((drive.end_time() - drive.start_time()) * options.rate); ++i)
      times.push_back(drive.start_time() + i / options.rate);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double time = times[i];
    track::StampedPose message;
    message.stamp = time + options.latency;
    message.arrival = *message.stamp;
    message.sequence = std::uint32_t(i);
    message.frame = "map";
    message.child = "base";
    const Pose truth = drive(time);
    Pose measured(truth.rotation * so3_exp(turn), truth.translation + shift);
    if (options.planar_localiser) {
      const Vec3 ahead = measured.rotate(Vec3::UnitX());
      measured = Pose(so3_exp(Vec3(0, 0, std::atan2(ahead.y(), ahead.x()))),
                      Vec3(measured.translation.x(), measured.translation.y(), 0));
    }
    if (options.jump_time && time >= drive.start_time() + *options.jump_time) measured = jump * measured;
    message.frame_from_child = measured.normalized();
    poses.push_back(message);
    const double fresh = std::sqrt(1 - share * share);
    shift = share * shift + fresh * options.position_sigma * draw.gauss3();
    turn = share * turn + fresh * options.rotation_sigma * draw.gauss3();
  }
  return poses;
}

std::vector<double> image_times(double start, double duration, const SightingOptions& options) {
  std::vector<double> times;
  for (const double time : options.image_times) times.push_back(start + time);
  if (!times.empty()) return times;
  const int images = int(duration * options.sighting_rate);
  // Not in step with the localiser.
  for (int k = 0; k <= images; ++k) times.push_back(start + (k + 0.37) / options.sighting_rate);
  return times;
}

/// The floor z = 0 and four walls about the drive, each with z of its frame into the room.
std::vector<Pose> room_about(const Motion& drive, double start, double end, Draw& draw) {
  const Eigen::Quaterniond turned = so3_exp(Vec3(0, 0, draw.uniform(-0.6, 0.6)));
  Vec2 low = Vec2::Constant(1e9), high = -low;
  for (int i = 0; i <= 200; ++i) {
    const Vec3 at = turned.conjugate() * drive(start + (end - start) * i / 200).translation;
    low = low.cwiseMin(at.head<2>()), high = high.cwiseMax(at.head<2>());
  }
  constexpr double kBeyond = 1.5;
  const Vec2 middle = 0.5 * (low + high), half = 0.5 * (high - low) + Vec2::Constant(kBeyond);
  std::vector<Pose> planes{Pose()};
  for (int wall = 0; wall < 4; ++wall) {
    const Eigen::Quaterniond side = so3_exp(Vec3(0, 0, wall * kPi / 2));  // outwards along its x
    const Vec3 outwards = side * Vec3::UnitX();
    const Vec3 at(middle.x() + outwards.x() * half.x(), middle.y() + outwards.y() * half.y(), 1);
    // Walls are not quite at right angles.
    const Eigen::Quaterniond crooked = so3_exp(Vec3(0, 0, draw.uniform(-0.05, 0.05)));
    planes.push_back(
        {turned * crooked * side * rotation_between(Vec3::UnitZ(), -Vec3::UnitX()), turned * at});
  }
  return planes;
}

/// Where rays of the sensor first meet each plane, in the world; at least four for a plane that is seen.
std::vector<std::vector<Vec3>> seen_of(const std::vector<Pose>& planes, const Pose& world_from_camera) {
  constexpr double kNearest = 0.4, kFarthest = 5, kGrazing = 0.25;
  std::vector<std::vector<Vec3>> seen(planes.size());
  for (int row = -3; row <= 3; ++row)
    for (int column = -3; column <= 3; ++column) {
      const double step = std::tan(25 * kDegree) / 3;
      const Vec3 ray = world_from_camera.rotate(Vec3(step * column, step * row, 1).normalized());
      double nearest = kFarthest;
      std::size_t hit = planes.size();
      for (std::size_t p = 0; p < planes.size(); ++p) {
        const Vec3 normal = planes[p].rotate(Vec3::UnitZ());
        const double towards = -normal.dot(ray);
        if (towards < kGrazing) continue;
        const double t = normal.dot(world_from_camera.translation - planes[p].translation) / towards;
        if (t > kNearest && t < nearest) nearest = t, hit = p;
      }
      if (hit < planes.size()) seen[hit].push_back(world_from_camera.translation + nearest * ray);
    }
  constexpr std::size_t kFewest = 4;
  for (std::vector<Vec3>& points : seen)
    if (points.size() < kFewest) points.clear();
  return seen;
}

std::string plane_name(std::size_t plane) {
  return plane == 0 ? "plane_floor" : "plane_" + std::to_string(plane);
}

/// A plane from the middle of what is seen: there the errors of tilt and distance are independent.
PoseWithCovariance measured_plane(const Pose& world_from_plane, const std::vector<Vec3>& points,
                                  const Pose& world_from_rig, const SightingOptions& options, Draw& draw) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& point : points) middle += point / double(points.size());
  const Pose plane_from_rig = Pose(world_from_plane.rotation, middle).inverse() * world_from_rig;
  constexpr double kArbitrary = 1;  // rad, m: within the plane nothing is measured
  Vec6 sigma, off = Vec6::Zero();
  sigma << options.plane_tilt_sigma, options.plane_tilt_sigma, kArbitrary, kArbitrary, kArbitrary,
      options.plane_sigma;
  for (const int i : {0, 1, 5}) off[i] = sigma[i] * draw.gauss();
  return {(se3_exp(off) * plane_from_rig).normalized(), sigma.cwiseAbs2().asDiagonal()};
}

Vec6 mistake(Draw& draw) {
  Vec6 off;
  off << 0.35 * Vec3(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1)),
      0.3 * Vec3(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1));
  return off;
}

track::StampedPose sighting_message(double time, const std::string& name, const PoseWithCovariance& pose) {
  track::StampedPose message;
  message.stamp = time;
  message.arrival = time;
  message.frame = name;
  message.child = "rig";
  message.frame_from_child = pose.pose.normalized();
  message.covariance = pose.covariance;
  return message;
}

}  // namespace

MarkerSightings sightings_along(const Motion& drive, double start, double end,
                                const SightingOptions& options) {
  require(options.sighting_rate > 0 && options.corner_sigma_px > 0 && options.markers > 0 &&
              options.marker_size > 0 && options.plane_sigma > 0 && options.plane_tilt_sigma > 0 &&
              options.outliers >= 0 && options.outliers < 1 && options.floor_sigma >= 0 &&
              options.floor_tilt_sigma >= 0,
          "marker_sightings: a rate, sigma, size or share is out of range");
  const Camera camera = options.camera.value_or(usual_camera());
  MarkerSightings made;
  Draw of_mount(options.seed, 2), of_markers(options.seed, 3), of_pixels(options.seed, 4),
      of_outliers(options.seed, 5);
  const Pose drawn = usual_mount(of_mount);
  made.base_from_rig_at_start = options.base_from_rig.value_or(drawn);
  made.base_from_rig =
      options.bump_time ? options.bump * made.base_from_rig_at_start : made.base_from_rig_at_start;
  const double duration = end - start;
  const bool markers = options.kind != SightingKind::kPlanes, planes = options.kind != SightingKind::kMarkers;
  Draw of_planes(options.seed, 7);
  if (planes) made.planes = room_about(drive, start, end, of_planes);
  for (int i = 0; markers && i < options.markers; ++i) {
    const double time = start + (i + of_markers.uniform(0, 1)) * duration / options.markers;
    made.markers.push_back(
        {i, options.marker_size, placed_before(drive(time) * made.base_from_rig_at_start, of_markers)});
  }
  const Floor floor(options, Draw(options.seed, 6));
  for (const double time : image_times(start, duration, options)) {
    const bool bumped = options.bump_time && time >= start + *options.bump_time;
    const Pose world_from_camera =
        drive(time) * floor(time) * (bumped ? made.base_from_rig : made.base_from_rig_at_start);
    made.rig.push_back({time, world_from_camera});
    for (const PlacedMarker& marker : made.markers) {
      const Pose camera_from_marker = world_from_camera.inverse() * marker.world_from_marker;
      std::optional<Corners> corners = seen_corners(camera, camera_from_marker, marker);
      if (!corners) continue;
      for (Vec2& pixel : corners->pixels)
        pixel += options.corner_sigma_px * Vec2(of_pixels.gauss(), of_pixels.gauss());
      auto pose = fitted(camera, marker, *corners, camera_from_marker.inverse(), options.corner_sigma_px);
      if (!pose) continue;
      if (of_outliers.uniform(0, 1) < options.outliers) {
        pose->pose = se3_exp(mistake(of_outliers)) * pose->pose;
        made.outliers.push_back(made.messages.size());
      }
      made.messages.push_back(sighting_message(time, "marker_" + std::to_string(marker.id), *pose));
    }
    if (!planes) continue;
    const std::vector<std::vector<Vec3>> seen = seen_of(made.planes, world_from_camera);
    for (std::size_t p = 0; p < seen.size(); ++p) {
      if (seen[p].empty()) continue;
      PoseWithCovariance pose =
          measured_plane(made.planes[p], seen[p], world_from_camera, options, of_planes);
      if (of_outliers.uniform(0, 1) < options.outliers) {
        pose.pose = se3_exp(mistake(of_outliers)) * pose.pose;
        made.outliers.push_back(made.messages.size());
      }
      made.messages.push_back(sighting_message(time, plane_name(p), pose));
    }
  }
  if (made.messages.empty())
    throw Error(ErrorKind::kNotEnoughData, "drive", "no marker or plane is seen",
                "drive further or place more markers");
  return made;
}

MarkerSightings marker_sightings(const Drive& drive, const SightingOptions& options) {
  return sightings_along(drive, drive.start_time(), drive.end_time(), options);
}

MountDrive mount_drive(const Drive& drive, const MountDriveOptions& options) {
  require(options.rate > 0 && options.position_sigma >= 0 && options.rotation_sigma >= 0 &&
              options.correlation_s >= 0 && std::isfinite(options.latency),
          "mount_drive: the localiser's rate, sigmas or latency is out of range");
  return {localiser_poses(drive, options), marker_sightings(drive, options), options.latency};
}

}  // namespace procam::simulate
