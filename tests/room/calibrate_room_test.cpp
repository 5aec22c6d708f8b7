#include "procam/room/calibrate_room.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "numeric_room.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::test {
namespace {

using room::RoomCalibration;
using room::RoomOptions;
using room::RoomPoints;

RoomOptions known_cameras(const NumericWorld& world) {
  RoomOptions options;
  for (int c = 0; c < int(world.cameras.size()); ++c)
    options.cameras[numeric_camera_name(world, c)] = {world.cameras[std::size_t(c)], {}};
  options.threads = 2;
  return options;
}

/// The distance from the first camera position to the projector, known to a millimetre.
room::KnownDistance projector_distance(const NumericWorld& world) {
  return {{},
          {numeric_camera_name(world, 0), world.projectors[0].name},
          world.projectors[0].rig_from_projector.translation.norm(),
          1e-3};
}

/// (estimate - truth) / sigma of every parameter that the covariance names.
std::vector<std::pair<std::string, double>> deviations(const NumericWorld& world, const Rig& rig) {
  std::vector<std::pair<std::string, double>> out;
  const auto lens = [&](const std::string& name, const Camera& solved, const Camera& truth) {
    const VecX a = parameters_of(solved), b = parameters_of(truth);
    const std::vector<std::string> names = parameter_names(truth);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (rig.covariance.index_of(name + "." + names[i]))
        out.emplace_back(name + "." + names[i], (a[Eigen::Index(i)] - b[Eigen::Index(i)]) / rig.covariance.sigma(name + "." + names[i]));
  };
  const auto pose = [&](const std::string& name, const Pose& solved, const Pose& truth) {
    const Vec6 off = se3_log(Pose(solved * truth.inverse()));
    const std::vector<std::string> names = pose_increment_names("rig_from_" + name);
    for (std::size_t i = 0; i < 6; ++i)
      if (rig.covariance.index_of(names[i])) out.emplace_back(names[i], off[Eigen::Index(i)] / rig.covariance.sigma(names[i]));
  };
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    lens(rig.cameras[c].name, rig.cameras[c].camera, world.cameras[c]);
    for (const NumericPosition& p : world.positions)
      if (p.camera == int(c)) {
        pose(rig.cameras[c].name, rig.cameras[c].rig_from_camera, p.rig_from_camera);
        break;
      }
  }
  for (std::size_t p = 0; p < rig.projectors.size(); ++p) {
    lens(rig.projectors[p].name, rig.projectors[p].projector.inverse_camera, world.projectors[p].projector.inverse_camera);
    pose(rig.projectors[p].name, rig.projectors[p].rig_from_projector, world.projectors[p].rig_from_projector);
  }
  return out;
}

/// RMS of the depths that the solved rig gives the exact light of the first map, metres.
double wall_error(const NumericWorld& world, const Rig& rig) {
  double sum = 0;
  int count = 0;
  const RigCamera& camera = rig.cameras[0];
  const RigProjector& projector = rig.projectors[0];
  const Pose projector_from_camera = projector.rig_from_projector.inverse() * camera.rig_from_camera;
  for (int y = 30; y < 960; y += 60)
    for (int x = 30; x < 1280; x += 60) {
      const auto light = world.light(0, 0, Vec2(x, y));
      if (!light) continue;
      const Vec3 truth = *world.seen(0, Vec2(x, y));
      const auto d = camera.camera.unproject(Vec2(x, y)), e = projector.projector.inverse_camera.unproject(*light);
      if (!d || !e) continue;
      const Vec3 a = e->cross(projector_from_camera.rotation * *d), b = e->cross(projector_from_camera.translation);
      const double range = -a.dot(b) / a.squaredNorm();
      sum += std::pow(range - truth.norm(), 2);
      ++count;
    }
  return std::sqrt(sum / std::max(1, count));
}

void print(const char* name, const NumericWorld& world, const RoomPoints& points, const RoomCalibration& r) {
  std::vector<double> all;
  int outside = 0;
  std::string list;
  for (const auto& [parameter, value] : deviations(world, r.rig)) {
    all.push_back(std::abs(value));
    outside += std::abs(value) > 3;
    if (std::abs(value) > 3) list += parameter + " " + std::to_string(value) + ", ";
  }
  std::printf("%s: %zu pts used %d out %d rms %.4f held %.4f scatter %.2f parallax %.1f deg wall sigma %.2f/%.2f mm (%.3f %%) true %.2f mm; params %zu outside %d max %.1f %s\n",
              name, points.points.size(), r.points, r.outliers, r.rms_px, r.held_out_px, r.scatter,
              r.parallax / kDegree, 1e3 * r.wall_sigma, 1e3 * r.wall_sigma_95, 100 * r.wall_sigma_share,
              1e3 * wall_error(world, r.rig), all.size(), outside, all.empty() ? 0 : quantile(all, 1.0), list.c_str());
}

TEST(CalibrateRoom, Explore) {
  for (const auto& [c, v, p] : {std::array<int, 3>{1, 2, 1}, {1, 3, 1}, {2, 1, 2}, {4, 1, 4}}) {
    const NumericWorld world = numeric_world(c, v, p);
    const auto t0 = std::chrono::steady_clock::now();
    const RoomPoints points = read_points(world, 24, {0.05, 0.02, 3});
    const auto t1 = std::chrono::steady_clock::now();
    RoomOptions options = known_cameras(world);
    options.distances = {projector_distance(world)};
    try {
      const RoomCalibration result = room::calibrate_room(points, options);
      print("case", world, points, result);
    } catch (const Error& error) {
      std::printf("refused: %s\n", error.what());
    }
    std::printf("%d %d %d: read %.1f s, solve %.1f s\n", c, v, p, std::chrono::duration<double>(t1 - t0).count(),
                std::chrono::duration<double>(std::chrono::steady_clock::now() - t1).count());
  }
}

}  // namespace
}  // namespace procam::test
