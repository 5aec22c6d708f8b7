/// Cameras that focus anew in each view, or whose images a stabiliser displaces.
#include <gtest/gtest.h>

#include <cmath>

#include "inside_sigmas.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

struct Changes {
  double focus = 0, shift_px = 0;
};

/// Of several rigs together.
struct RigErrors {
  double off = 0, predicted = 0;  ///< mm^2 at 2 m, mean
  int inside = 0, told = 0;
};

/// Five rigs with printed and projected chessboards.
RigErrors errors_of(const Changes& changes) {
  RigErrors all;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    NumericWorld world = NumericWorld::make_rig(12, 1200 + seed, 0.03, 0);
    world.change_images(changes.focus, changes.shift_px, seed);
    const CalibrationResult result = calibrate_rig(world.with_projected_board(seed));
    const double off = analyze::true_light_error(result.rig, world.rig(), 2).rms_mm;
    const double predicted = analyze::predicted_light_error(result.rig, 2).rms_mm;
    all.off += off * off / 5, all.predicted += predicted * predicted / 5;
    all.inside += inside_three_sigmas(result, world);
    all.told += result.diagnostics.find("image_changes") != nullptr;
    EXPECT_EQ(result.diagnostics.find("board_flexes"), nullptr) << seed;
    EXPECT_EQ(result.diagnostics.find("board_shape"), nullptr) << seed;
    EXPECT_EQ(result.image_changes[0].focus_rms > 0, changes.focus > 0) << seed;
    EXPECT_EQ(result.image_changes[0].shift_rms_px > 0, changes.shift_px > 0) << seed;
    EXPECT_EQ(result.image_changes[1].focus_rms, 0) << seed;
  }
  return all;
}

class ImageChanges : public ::testing::TestWithParam<Changes> {};

/// Of 100 lens parameters at 99 %, fewer than 94 are within three sigmas once in 10^4 runs; the mean of 5 squares of a normal
/// number lies in 0.08 .. 3.35 of its expectation in 99 %.
TEST_P(ImageChanges, AreEstimatedViewByView) {
  const RigErrors errors = errors_of(GetParam());
  EXPECT_EQ(errors.told, 5);
  EXPECT_GE(errors.inside, 94) << "of 100";
  EXPECT_GT(errors.off, 0.08 * errors.predicted);
  EXPECT_LT(errors.off, 3.35 * errors.predicted);
  EXPECT_LT(std::sqrt(errors.off), 2.5);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ImageChanges,
                         ::testing::Values(Changes{0.0005, 0}, Changes{0.006, 0}, Changes{0, 0.3},
                                           Changes{0, 4}, Changes{0.003, 2}));

/// A camera alone shows a change of its focal length as a board that is farther away: it is not looked for, and the sigmas
/// include it.
TEST(ImageChangesOfACamera, AreInItsSigmas) {
  double squares = 0, count = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    NumericWorld world = NumericWorld::make_rig(14, 1310 + seed, 0.03, 0.03);
    world.change_images(0.003, 0, seed);
    const CalibrationResult result = calibrate_camera(world.correspondences(seed));
    EXPECT_EQ(result.image_changes[0].focus_rms, 0) << seed;
    const double off = result.rig.camera().camera.intrinsics.fx - world.camera.intrinsics.fx;
    squares += std::pow(off / result.rig.covariance.sigma("camera.fx"), 2);
    ++count;
  }
  // chi-squared of 10: above 2.96 of its mean once in 1000.
  EXPECT_LT(squares / count, 2.96);
}

/// Of two cameras, one of which a stabiliser displaces: each corrects the other.
TEST(ImageChangesOfTwoCameras, AreFound) {
  double off = 0, predicted = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    NumericWorld world = NumericWorld::make_rig(12, 1350 + seed, 0.03, 0.03);
    world.change_images(0, 2, seed);
    Correspondences data = world.correspondences(seed);
    data.devices[1] = {"right", DeviceKind::kCamera, data.devices[1].size};
    const CalibrationResult result = calibrate_rig(data);
    EXPECT_NE(result.diagnostics.find("image_changes"), nullptr) << seed;
    const Vec3 wrong =
        result.rig.cameras[1].rig_from_camera.translation - world.projector_from_camera.inverse().translation;
    off += wrong.squaredNorm();
    for (const char* axis : {"x", "y", "z"})
      predicted += std::pow(result.rig.covariance.sigma(std::string("rig_from_right.t") + axis), 2);
  }
  EXPECT_LT(off, 3 * predicted);
}

/// Nobody knows how the image of a held-out view has changed: its light is off by that, and the check expects it. The mean of
/// 24 squares of a normal number is within 0.4 to 1.9 of its expectation in 99.9 %.
TEST(ImageChangesOfHeldOutViews, AreExpected) {
  NumericWorld world = NumericWorld::make_rig(12, 1370, 0.03, 0);
  world.change_images(0.002, 2, 4);
  Options options;
  options.holdout = true;
  const CalibrationResult result = calibrate_rig(world.with_projected_board(4), options);
  const double expected = result.rig.quality.expected_holdout_px.at("projector");
  EXPECT_GT(expected, 1.5);
  EXPECT_GT(result.holdout_px[1], std::sqrt(0.4) * expected);
  EXPECT_LT(result.holdout_px[1], std::sqrt(1.9) * expected);
  for (const Gate& gate : result.rig.quality.gates)
    EXPECT_TRUE(gate.passed) << gate.name << ": " << gate.detail;
}

/// A stated shape of the board says nothing of the camera.
TEST(ImageChangesOfAStatedBoard, AreFound) {
  for (const BoardShape shape : {BoardShape::kFlat, BoardShape::kFree}) {
    NumericWorld world = NumericWorld::make_rig(10, 1380, 0.03, 0.03);
    if (shape == BoardShape::kFree) world.bend_board();
    world.change_images(0, 1, 2);
    Options options;
    options.board_shape = shape;
    const CalibrationResult result = calibrate_rig(world.correspondences(2), options);
    EXPECT_NEAR(result.image_changes[0].shift_rms_px, 1, 0.35) << int(shape);
    EXPECT_EQ(result.shape.free, shape == BoardShape::kFree);
    EXPECT_EQ(result.shape.flex_rms, 0);
  }
}

/// Each view's own change, of a rig that is known well: half of the noise of a view with 60 points.
TEST(ImageChangesOfViews, AreThoseOfTheWorld) {
  NumericWorld world = NumericWorld::make_rig(20, 1330, 0.02, 0.02);
  world.change_images(0.004, 3, 1);
  const CalibrationResult result = calibrate_rig(world.correspondences(1));
  Vec3 mean = Vec3::Zero();
  for (std::size_t v = 0; v < world.image_changes.size(); ++v)
    mean += (result.solved.state.image_changes[v][0] - world.image_changes[v]) / 20;
  for (std::size_t v = 0; v < world.image_changes.size(); ++v) {
    const Vec3 off = result.solved.state.image_changes[v][0] - world.image_changes[v] - mean;
    EXPECT_LT(std::abs(off[0]), 0.0008) << v;
    EXPECT_LT(off.tail<2>().norm(), 0.6) << v;
  }
}

}  // namespace
}  // namespace procam::calibrate
