/// Two projectors that draw on the scan of a room, each by a rig with the error of a calibration: how far apart their light shows the
/// same content.
#include <gtest/gtest.h>

#include <algorithm>

#include "procam/core/base/stats.hpp"
#include "procam/scan/scan_mesh.hpp"
#include "procam/simulate/room.hpp"
#include "simulate/room_hit.hpp"
#include "true_room.hpp"

namespace procam::scan {
namespace {

/// true_rig() with a second projector on the other side.
Rig rig_of_two() {
  Rig rig = test::true_rig();
  rig.projectors[0].name = "right";
  RigProjector left = rig.projectors[0];
  left.name = "left";
  left.projector.inverse_camera.intrinsics = {592, 603, 335, 371, 0.6};
  left.rig_from_projector = Pose(so3_exp(Vec3(-0.1, 0.15, -0.06)), Vec3(-0.27, 0.15, 0.02));
  rig.projectors.push_back(left);
  return rig;
}

/// With errors of both projectors, as of calibrations; the camera is common.
Rig with_errors(const Rig& truth, std::mt19937& random) {
  Rig of_one = truth;
  of_one.projectors.pop_back();
  const Rig first = test::calibrated_rig(of_one, random);
  of_one.projectors = {truth.projectors[1]};
  const Rig second = test::calibrated_rig(of_one, random);
  Rig rig = first;
  rig.projectors.push_back(second.projectors[0]);
  rig.covariance = {};
  return rig;
}

/// The direction from the eye in which a projector's pixel shows content, by the meshes that are the first on its way.
std::optional<Vec3> shown_at(const Vec2& pixel, const RigProjector& projector, const simulate::Room& meshes,
                             const Vec3& eye) {
  const auto ray = projector.projector.emit(pixel);
  if (!ray) return std::nullopt;
  const auto hit = simulate::nearest_hit(meshes, {projector.rig_from_projector * ray->origin,
                                                  projector.rig_from_projector.rotate(ray->direction)});
  if (!hit) return std::nullopt;
  return Vec3(hit->point_in_room - eye).normalized();
}

/// In projector pixels, of the places that both projectors light.
std::vector<double> seams(unsigned seed, const Vec3& eye) {
  std::mt19937 random(seed);
  const Rig truth = rig_of_two(), rig = with_errors(truth, random);
  simulate::Room meshes;
  std::vector<test::SeenRoom> seen;
  for (const RigProjector& projector : truth.projectors) {
    Rig pair = truth;
    pair.projectors = {projector};
    seen.push_back(test::look(pair, test::alcove(), Pose(), 0.03, random));
    ScanOptions options;
    options.threads = 1;
    const Scan scan = measure_depth(seen.back().light, rig, "", projector.name, options);
    meshes.bodies.push_back(
        {projector.name, simulate::TriangleMesh(std::make_shared<const Mesh>(mesh_of(scan))), Pose()});
  }
  const RigCamera& camera = truth.camera();
  std::vector<double> apart;
  for (int y = 2; y < camera.camera.size.height; y += 5)
    for (int x = 2; x < camera.camera.size.width; x += 5) {
      if (!seen[0].light.decoded(x, y) || !seen[1].light.decoded(x, y)) continue;
      const Vec3 bearing = *camera.camera.unproject(Vec2(x, y));
      const Vec3 point =
          camera.rig_from_camera * Vec3(bearing * (double(seen[0].truth.depth.at(x, y)) / bearing.z()));
      std::optional<Vec3> shown[2];
      double pixels_a_metre = 0;
      for (std::size_t p = 0; p < 2; ++p) {
        const RigProjector& projector = truth.projectors[p];
        const Vec3 in_projector = projector.rig_from_projector.inverse() * point;
        shown[p] = shown_at(*projector.projector.project(in_projector), rig.projectors[p], meshes, eye);
        pixels_a_metre += 0.5 * projector.projector.inverse_camera.intrinsics.fx / in_projector.z();
      }
      if (shown[0] && shown[1])
        apart.push_back((*shown[0] - *shown[1]).norm() * (point - eye).norm() * pixels_a_metre);
    }
  return apart;
}

/// Each projector draws by the mesh that is first on its way, of both scans.
TEST(Seams, OfTwoProjectorsOnTheScanAreBelowHalfAPixel) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const std::vector<double> apart = seams(seed, Vec3(0.6, -0.3, -0.2));
    ASSERT_GT(apart.size(), 400u) << seed;
    EXPECT_LT(quantile(apart, 0.95), 0.5) << seed;
    EXPECT_GT(quantile(apart, 0.95), 0.01) << seed << ": no error was drawn";
  }
}

}  // namespace
}  // namespace procam::scan
