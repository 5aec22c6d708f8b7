/// Focal lengths that EXIF or a data sheet states of cameras whose lens is estimated.
#include <gtest/gtest.h>

#include "procam/room/calibrate_room.hpp"
#include "room_cases.hpp"
#include "support/expect_error.hpp"

namespace procam::test {
namespace {

struct SheetResult {
  room::RoomCalibration result;
  double error = 0;  ///< of the walls, metres
};

/// Two places of a camera whose lens is not known, but for a focal length stated `factor` times too long.
SheetResult solve_with_sheet(std::optional<double> factor, unsigned seed) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const room::RoomPoints points = read_points(world, 60, {0.05, 0.01, seed});
  room::RoomOptions options;
  options.threads = 2;
  options.max_wall_sigma = 0.1;
  options.distances = {wall_distance(world, points)};
  if (factor) {
    const double focal = *factor * world.cameras[0].intrinsics.fx;
    options.camera_sheets["camera"] = {{focal, 0.1 * focal}, "the images' EXIF (28 mm equivalent)"};
  }
  SheetResult out{room::calibrate_room(points, options), 0};
  out.error = wall_error(world, out.result.rig);
  return out;
}

TEST(CameraSheet, IsAPriorThatTheResultKeepsTo) {
  const SheetResult with = solve_with_sheet(1.06, 3), bare = solve_with_sheet(std::nullopt, 3);
  const auto* remark = with.result.diagnostics.find("camera_sheet");
  ASSERT_NE(remark, nullptr);
  EXPECT_NE(remark->message.find("28 mm equivalent"), std::string::npos) << remark->message;
  EXPECT_EQ(with.result.diagnostics.find("camera_sheet_disagrees"), nullptr);
  EXPECT_LE(with.error, 3 * with.result.wall_sigma_95);
  EXPECT_LT(with.result.rig.covariance.sigma("camera.fx"), bare.result.rig.covariance.sigma("camera.fx"));
}

/// The EXIF of another lens: said, and as if it were not there.
TEST(CameraSheet, ThatTheLightContradictsIsNotUsed) {
  const SheetResult bare = solve_with_sheet(std::nullopt, 3);
  const SheetResult wrong = solve_with_sheet(2.2, 3);
  const auto* remark = wrong.result.diagnostics.find("camera_sheet_disagrees");
  ASSERT_NE(remark, nullptr);
  EXPECT_EQ(parameters_of(wrong.result.rig.cameras[0].camera),
            parameters_of(bare.result.rig.cameras[0].camera));
  EXPECT_FALSE(wrong.result.diagnostics.failed());
}

TEST(CameraSheet, IsComparedWithAKnownLens) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const room::RoomPoints points = read_points(world, 44, {0.05, 0.01, 4});
  room::RoomOptions options = known_cameras(world);
  options.distances = {wall_distance(world, points)};
  const room::RoomCalibration bare = room::calibrate_room(points, options);
  for (const double factor : {1.1, 1.6}) {
    const double focal = factor * world.cameras[0].intrinsics.fx;
    options.camera_sheets["camera"] = {{focal, 0.1 * focal}, "the images' EXIF (28 mm equivalent)"};
    const room::RoomCalibration result = room::calibrate_room(points, options);
    EXPECT_EQ(result.rig.covariance.matrix, bare.rig.covariance.matrix);
    EXPECT_EQ(result.diagnostics.find("camera_sheet_disagrees") != nullptr, factor > 1.3);
  }
}

TEST(CameraSheet, OfACameraThatThereIsNotIsRefused) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const room::RoomPoints points = read_points(world, 44, {0.05, 0.01, 4});
  room::RoomOptions options = known_cameras(world);
  options.distances = {wall_distance(world, points)};
  options.camera_sheets["webcam"] = {{1000, 100}, "a data sheet"};
  EXPECT_ERROR(room::calibrate_room(points, options), kInput, "webcam");
}

}  // namespace
}  // namespace procam::test
