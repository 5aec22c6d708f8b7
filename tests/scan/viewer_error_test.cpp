#include "procam/scan/viewer_error.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "procam/core/base/stats.hpp"
#include "true_room.hpp"

namespace procam::scan {
namespace {

const Vec3 kEye(-0.4, -0.2, 0.1);

ScanOptions one_thread() {
  ScanOptions options;
  options.threads = 1;
  return options;
}

/// The angle that 95 % of the points are within, of a scan against the true points: as they are, and after the rigid motion of the scan
/// that is nearest to them.
struct TrueAngles {
  double given, placed;
};

double angle_95(const Eigen::Matrix3Xd& scanned, const Eigen::Matrix3Xd& room) {
  std::vector<double> angles;
  for (Eigen::Index i = 0; i < room.cols(); ++i)
    angles.push_back(
        (Vec3(scanned.col(i) - kEye).normalized() - Vec3(room.col(i) - kEye).normalized()).norm());
  return quantile(angles, 0.95);
}

TrueAngles true_angles(const Scan& scan, const TrueView& truth, const RigCamera& true_camera) {
  std::vector<Vec3> scanned, room;
  for (int y = 4; y < scan.depth.height(); y += 8)
    for (int x = 4; x < scan.depth.width(); x += 8) {
      if (!scan.measured(x, y)) continue;
      const auto point = [&](const RigCamera& camera, double z) {
        const Vec3 bearing = *camera.camera.unproject(Vec2(x, y));
        return Vec3(camera.rig_from_camera * Vec3(bearing * (z / bearing.z())));
      };
      scanned.push_back(point(scan.camera, double(scan.depth.at(x, y))));
      room.push_back(point(true_camera, double(truth.depth.at(x, y))));
    }
  const auto count = Eigen::Index(room.size());
  const Eigen::Matrix3Xd a = Eigen::Map<const Eigen::Matrix3Xd>(scanned.front().data(), 3, count),
                         b = Eigen::Map<const Eigen::Matrix3Xd>(room.front().data(), 3, count);
  const Eigen::Matrix4d room_from_scan = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd placed =
      (room_from_scan.topLeftCorner<3, 3>() * a).colwise() + room_from_scan.topRightCorner<3, 1>();
  return {angle_95(a, b), angle_95(placed, b)};
}

/// Scans by 60 rigs drawn from the covariance, of light with little noise. The standard error of a median of 60 is about 10 % here;
/// three of them.
TEST(ViewerError, IsWhatDrawnRigsHave) {
  const Rig truth = test::true_rig();
  std::mt19937 random(17);
  const test::SeenRoom seen = test::look(truth, test::alcove(), Pose(), 1e-3, random);
  const LightMap& light = seen.light;
  const Scan exact = measure_depth(light, truth, "", "", one_thread());
  const ViewerError predicted = viewer_error(exact, kEye);
  EXPECT_GT(predicted.points, 100);
  std::vector<double> given, placed;
  ScanOptions all = one_thread();
  all.consistency_sigmas = 1e6;
  for (int draw = 0; draw < 60; ++draw) {
    const Scan scan = measure_depth(light, test::calibrated_rig(truth, random), "", "", all);
    const TrueAngles off = true_angles(scan, seen.truth, truth.camera());
    given.push_back(off.given);
    placed.push_back(off.placed);
  }
  EXPECT_NEAR(predicted.given.median / median(given), 1, 0.3);
  EXPECT_NEAR(predicted.given.of_95 / quantile(given, 0.95), 1, 0.4);
  EXPECT_NEAR(predicted.placed.median / median(placed), 1, 0.3);
}

/// More than a pixel of a viewer's image is said, less is not.
TEST(ViewerError, SaysWhenItExceedsAPixel) {
  Rig rig = test::true_rig();
  std::mt19937 random(17);
  const LightMap light = test::look(rig, test::alcove(), Pose(), 1e-3, random).light;
  const ViewerError before = viewer_error(measure_depth(light, rig, "", "", one_thread()), kEye);
  ASSERT_GT(before.given.of_95, 0);
  for (const double pixels : {0.7, 1.5}) {
    Rig scaled = rig;
    scaled.covariance.matrix *= std::pow(pixels * kViewerPixel / before.given.of_95, 2);
    const ViewerError error = viewer_error(measure_depth(light, scaled, "", "", one_thread()), kEye);
    EXPECT_NEAR(error.given.of_95 / kViewerPixel, pixels, 0.15);  // other draws of 400 rigs
    EXPECT_EQ(error.diagnostics.find("viewer_off") != nullptr, pixels > 1);
  }
}

TEST(ViewerError, NeedsACovarianceAndAnEye) {
  Rig rig = test::true_rig();
  std::mt19937 random(2);
  const LightMap light = test::look(rig, test::alcove(), Pose(), 0.01, random).light;
  const Scan scan = measure_depth(light, rig, "", "", one_thread());
  EXPECT_THROW(viewer_error(scan, Vec3(0, std::nan(""), 0)), std::invalid_argument);
  rig.covariance = {};
  EXPECT_EQ(viewer_error(measure_depth(light, rig, "", "", one_thread()), kEye).points, 0);
}

}  // namespace
}  // namespace procam::scan
