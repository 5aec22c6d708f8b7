#pragma once
/// Rooms of a few exact surfaces, and what a lopsided rig measures of them from a station: no images, so that many seeds are quick.
#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "procam/core/geometry/se3.hpp"
#include "procam/scan/scan_error.hpp"
#include "procam/scan/stations.hpp"

namespace procam::scan::test {

/// The t > 0 at which origin + t direction meets a surface; infinity where it does not.
using Surface = std::function<double(const Vec3& origin, const Vec3& direction)>;
using Surfaces = std::vector<Surface>;

inline Surface plane(const Vec3& normal, double distance) {
  const Vec3 n = normal.normalized();
  return [n, distance](const Vec3& o, const Vec3& d) {
    const double t = (distance - n.dot(o)) / n.dot(d);
    return t > 0 ? t : std::numeric_limits<double>::infinity();
  };
}

inline Surface ball(const Vec3& centre, double radius) {
  return [centre, radius](const Vec3& o, const Vec3& d) {
    const Vec3 from = o - centre;
    const double a = d.squaredNorm(), b = d.dot(from),
                 root = b * b - a * (from.squaredNorm() - radius * radius);
    return root > 0 ? (-b - std::sqrt(root)) / a : std::numeric_limits<double>::infinity();
  };
}

/// Upright waves on the wall z = distance, 30 mm high.
inline Surface waves(double distance) {
  return [distance](const Vec3& o, const Vec3& d) {
    const auto height = [](const Vec3& p) {
      return 0.015 * (std::sin(2 * kPi * p.x() / 0.5) + std::sin(2 * kPi * p.y() / 0.7));
    };
    double t = (distance - o.z()) / d.z();
    for (int i = 0; i < 12; ++i) t = (distance + height(o + t * d) - o.z()) / d.z();
    return t;
  };
}

inline double meet(const Surfaces& room, const Vec3& origin, const Vec3& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Surface& surface : room) nearest = std::min(nearest, surface(origin, direction));
  return nearest;
}

/// Two walls, a floor and a ball.
inline Surfaces alcove() {
  return {plane(Vec3(0.1, 0.03, 1), 2.0), plane(Vec3(1, 0.05, 0.7), 1.75), plane(Vec3(0.02, 1, 0.5), 1.05),
          ball(Vec3(-0.2, 0.15, 1.6), 0.16)};
}

/// Skewed, distorted lenses, their axes off the middle; the projector stands to the right, turned and rolled.
inline Rig true_rig() {
  Rig rig;
  RigCamera camera;
  camera.camera = {{320, 240}, {330, 337, 161.5, 112, 0.7}, BrownConrady{{-0.08, 0.02, 0.001, -0.0008, 0}}};
  camera.rig_from_camera = Pose(so3_exp(Vec3(0.02, -0.01, 0.03)), Vec3(0.01, 0.02, -0.03));
  RigProjector projector;
  projector.projector.inverse_camera = {
      {640, 480}, {610, 597, 306, 391, -0.9}, BrownConrady{{0.05, -0.03, -0.001, 0.002, 0}}};
  projector.rig_from_projector = Pose(so3_exp(Vec3(-0.12, -0.17, 0.1)), Vec3(0.31, 0.12, 0.05));
  rig.cameras.push_back(camera);
  rig.projectors.push_back(projector);
  rig.covariance.names = {"camera.fx",
                          "camera.fy",
                          "camera.cx",
                          "camera.cy",
                          "projector.fx",
                          "projector.fy",
                          "projector.cx",
                          "projector.cy",
                          "rig_from_projector.rx",
                          "rig_from_projector.ry",
                          "rig_from_projector.rz",
                          "rig_from_projector.tx",
                          "rig_from_projector.ty",
                          "rig_from_projector.tz"};
  VecX sigma(14);
  sigma << 0.06, 0.06, 0.08, 0.08, 0.12, 0.12, 0.15, 0.15, 1.5e-4, 1.5e-4, 1.2e-4, 1e-4, 1e-4, 1.5e-4;
  sigma *= 0.12;  // half a millimetre at 1.7 m, as calibrations have
  MatX correlation = MatX::Identity(14, 14);
  correlation(4, 11) = correlation(11, 4) = 0.5;
  correlation(6, 9) = correlation(9, 6) = -0.6;
  rig.covariance.matrix = sigma.asDiagonal() * correlation * sigma.asDiagonal();
  return rig;
}

/// The rig as it was calibrated: with an error drawn from its covariance.
inline Rig calibrated_rig(const Rig& truth, std::mt19937& random) {
  std::normal_distribution<double> normal;
  VecX unit(truth.covariance.matrix.rows());
  for (double& value : unit) value = normal(random);
  const VecX e = Eigen::LLT<MatX>(truth.covariance.matrix).matrixL() * unit;
  Rig rig = truth;
  for (Eigen::Index i = 0; i < 4; ++i) {
    VecX values = parameters_of(rig.cameras[0].camera);
    values[i] += e[i];
    rig.cameras[0].camera = with_parameters(rig.cameras[0].camera, values);
    values = parameters_of(rig.projectors[0].projector.inverse_camera);
    values[i] += e[4 + i];
    rig.projectors[0].projector.inverse_camera =
        with_parameters(rig.projectors[0].projector.inverse_camera, values);
  }
  rig.projectors[0].rig_from_projector = se3_exp(Vec6(e.tail<6>())) * rig.projectors[0].rig_from_projector;
  return rig;
}

/// Three places that look at overlapping parts of the room.
inline Pose true_station(int number) {
  const Pose poses[] = {Pose(so3_exp(Vec3(0.02, 0.03, -0.01)), Vec3(0.02, -0.01, 0.03)),
                        Pose(so3_exp(Vec3(-0.05, 0.16, 0.06)), Vec3(-0.35, -0.06, 0.05)),
                        Pose(so3_exp(Vec3(0.04, -0.15, -0.03)), Vec3(0.3, 0.08, -0.1))};
  return poses[number];
}

struct SeenRoom {
  LightMap light;
  TrueView truth;
};

/// The exact light on the room with that standard deviation, projector pixels.
inline SeenRoom look(const Rig& rig, const Surfaces& room, const Pose& world_from_rig, double sigma,
                     std::mt19937& random) {
  const RigCamera& camera = rig.camera();
  const RigProjector& projector = rig.projector();
  std::normal_distribution<double> noise(0, sigma);
  SeenRoom seen;
  const ImageSize size = camera.camera.size;
  seen.light.projector_size = projector.projector.size();
  seen.light.pixel = ImageF(size, 2);
  seen.light.sigma = ImageF(size, 2);
  seen.truth = {camera.camera, world_from_rig * camera.rig_from_camera, ImageF(size)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Vec3 bearing = *camera.camera.unproject(Vec2(x, y));
      const Vec3 ray = bearing / bearing.z();
      const double z =
          meet(room, seen.truth.world_from_camera.translation, seen.truth.world_from_camera.rotate(ray));
      if (!(z > 0.2 && z < 6)) continue;
      seen.truth.depth.at(x, y) = float(z);
      const Vec3 point = camera.rig_from_camera * Vec3(z * ray);
      const auto pixel = projector.projector.project(projector.rig_from_projector.inverse() * point);
      if (!pixel || !projector.projector.size().contains(*pixel)) continue;
      for (int c = 0; c < 2; ++c) {
        seen.light.pixel.at(x, y, c) = float((*pixel)[c] + noise(random));
        seen.light.sigma.at(x, y, c) = float(sigma);
      }
    }
  return seen;
}

struct SeenStations {
  std::vector<Station> stations;
  std::vector<TrueView> truth;
};

/// The first `count` stations in a room, measured by `rig`, the light made by `truth`.
inline SeenStations see(const Surfaces& room, const Rig& truth, const Rig& rig, int count,
                        std::mt19937& random, double sigma = 0.03) {
  SeenStations out;
  ScanOptions options;
  options.threads = 1;
  for (int s = 0; s < count; ++s) {
    SeenRoom seen = look(truth, room, true_station(s), sigma, random);
    Station station;
    station.name = std::to_string(s + 1);
    station.scans = {measure_depth(seen.light, rig, "", "", options)};
    out.stations.push_back(std::move(station));
    out.truth.push_back(std::move(seen.truth));
  }
  return out;
}

/// Known poses: the true ones with an error drawn from these standard deviations about the rig.
inline void know_poses(double position, double angle, std::mt19937& random, std::vector<Station>& stations) {
  std::normal_distribution<double> normal;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    Vec6 sigma, error;
    sigma << Vec3::Constant(angle), Vec3::Constant(position);
    for (double& value : error) value = normal(random);
    const Mat6 to_world = adjoint(true_station(int(s)));
    PoseWithCovariance pose;
    pose.pose = true_station(int(s)) * se3_exp(Vec6(sigma.cwiseProduct(error)));
    pose.covariance = to_world * Mat6(sigma.cwiseAbs2().asDiagonal()) * to_world.transpose();
    stations[s].world_from_rig = pose;
  }
}

/// log(estimated * true^-1), where the world is the first station's rig unless the poses were known.
inline Vec6 pose_error(const Registration& at, int station) {
  const Pose to_world = at.has_known_poses ? Pose() : true_station(0).inverse();
  return se3_log(at.stations[std::size_t(station)].pose.pose * (to_world * true_station(station)).inverse());
}

}  // namespace procam::scan::test
