/// Causes that a rig names: right ones, and none where there is none.
#include <gtest/gtest.h>

#include "broken_session.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::calibrate {
namespace {

constexpr std::size_t kForeign[] = {2, 6, 9};

Session twelve_views(std::uint64_t seed) {
  Session session;
  session.world = test::NumericWorld::make(12, seed, 0.05, 0.05);
  session.data = session.world.correspondences(seed + 1);
  return session;
}

/// Frames of the projector that were mixed up say nothing about the camera.
TEST(ForeignViews, KeepCornersThatFitTheCamera) {
  Session session = twelve_views(44);
  for (const std::size_t v : kForeign)
    for (Observation& o : session.seen(v, 1)) o.pixel += 60 * Vec2(session.normal(), session.normal());
  const CalibrationResult result = calibrate_rig(session.data);
  for (const ViewResult& view : result.views) EXPECT_TRUE(view.used) << view.name;
  EXPECT_EQ(result.rig.quality.views_used, 12);
}

/// Noise at the points of a projected board, which lie on a grid of pixels, is no picture that repeats. It was in all of
/// these sessions ("repeat every 2.2 pixels"), as its own size moved the places at which it was compared.
TEST(ResampledPicture, IsNotSeenInTheNoiseOfAProjectedBoard) {
  for (const std::uint64_t seed : {51u, 52u, 53u, 54u}) {
    const test::NumericWorld world = test::NumericWorld::make(12, seed, 0.2, 0.2);
    const CalibrationResult result = calibrate_rig(world.with_projected_board(seed + 10));
    EXPECT_EQ(result.diagnostics.find("picture_resampled"), nullptr) << seed;
  }
}

/// Focal lengths 2 % off were absorbed by changes of the image, a principal point 8 px off by bent boards: every check
/// passed, and the predicted error was a thirtieth of the true one.
TEST(KnownCamera, IsCheckedAgainstTheViews) {
  const test::NumericWorld world = test::NumericWorld::make(12, 61, 0.05, 0.05);
  const auto passes = [&](const Camera& lens, const NamedCovariance& covariance = {}) {
    const CalibrationResult result = calibrate_projector(world.correspondences(62), {lens, covariance});
    for (const Gate& gate : result.rig.quality.gates)
      if (gate.name == "camera as known") return gate.passed;
    ADD_FAILURE() << "it is not checked";
    return false;
  };
  EXPECT_TRUE(passes(world.camera));
  Camera zoomed = world.camera, shifted = world.camera, rectified = world.camera;
  zoomed.intrinsics.fx *= 1.02, zoomed.intrinsics.fy *= 1.02;
  shifted.intrinsics.cx += 60;
  rectified.distortion = NoDistortion{};
  EXPECT_FALSE(passes(zoomed));
  EXPECT_FALSE(passes(shifted));
  EXPECT_FALSE(passes(rectified));
  // What the file says of its own error counts.
  const MatX variance = MatX(VecX{{900.0, 900.0}}.asDiagonal());
  EXPECT_TRUE(passes(zoomed, {{"fx", "fy"}, variance}));
}

}  // namespace
}  // namespace procam::calibrate
