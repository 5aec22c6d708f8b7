/// Lenses that do more than their models: smooth displacements of some hundredths of a pixel.
#include <gtest/gtest.h>

#include "inside_sigmas.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/simulate/lens_deviation.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

/// Every pixel as the true lenses show it.
Correspondences deviating(Correspondences data, const NumericWorld& world, double rms_px,
                          std::uint64_t seed) {
  const simulate::LensDeviation of_camera(world.camera, rms_px, seed),
      of_projector(world.projector.inverse_camera, rms_px, seed + 1);
  for (View& view : data.views) {
    for (Observation& o : view.observations[0]) o.pixel += of_camera.at(o.pixel);
    for (Observation& o : view.observations[1]) o.pixel += of_projector.at(o.pixel);
    for (LightPoint& light : view.light_points) {
      light.camera_pixel += of_camera.at(light.camera_pixel);
      light.projector_pixel += of_projector.at(light.projector_pixel);
    }
  }
  return data;
}

/// Twelve rigs whose lenses depart by 0.06 px from their models, with corners as noisy. Without allowing for it, 226 of
/// their 240 lens parameters were within three sigmas, and the light was 9.0 mm off where 4.0 mm were predicted; with it
/// 236, 6.3 and 6.0 mm. Of 240 at 99 %, fewer than 228 come up once in 10^4 runs.
TEST(ResidualDistortion, DoesNotPullTheLensesAndIsInTheirSigmas) {
  int inside = 0, told = 0;
  double true_squares = 0, predicted_squares = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(12, 300 + seed, 0.06, 0.06);
    const CalibrationResult result =
        calibrate_rig(deviating(world.correspondences(seed), world, 0.06, 40 + 2 * seed));
    inside += inside_three_sigmas(result, world);
    told += result.diagnostics.find("residual_distortion") != nullptr;
    const double off = analyze::true_light_error(result.rig, world.rig(), 2).rms_mm;
    const double predicted = analyze::predicted_light_error(result.rig, 2).rms_mm;
    true_squares += off * off, predicted_squares += predicted * predicted;
  }
  EXPECT_EQ(told, 12);
  EXPECT_GE(inside, 228) << "of 240";
  const double ratio = std::sqrt(true_squares / predicted_squares);
  EXPECT_GT(ratio, 0.5);
  EXPECT_LT(ratio, 1.6);
}

/// Six precise rigs whose projector departs. Its skew and k3 are uncertain by the departure, and averaging them (term_averaging.hpp)
/// is no reason to move the camera. (It was: the mean squared score of ten rigs was 6.2 instead of 1.3.)
TEST(ResidualDistortion, OfTheProjectorIsNotExplainedByTheCamera) {
  double squares = 0, worst = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(10, 700 + seed, 0.01, 0.006);
    Correspondences data = world.with_light_read_at_corners(seed);
    const simulate::LensDeviation departure(world.projector.inverse_camera, 0.04, 60 + seed);
    for (View& view : data.views)
      for (Observation& o : view.observations[1]) o.pixel += departure.at(o.pixel);
    const CalibrationResult result = calibrate_rig(data);
    EXPECT_NE(result.diagnostics.find("residual_distortion"), nullptr) << seed;
    const Camera& found = result.rig.camera().camera;
    for (const char* name : {"cx", "cy"}) {
      const double off = name[1] == 'x' ? found.intrinsics.cx - world.camera.intrinsics.cx
                                        : found.intrinsics.cy - world.camera.intrinsics.cy;
      const auto row = Eigen::Index(*result.rig.covariance.index_of(std::string("camera.") + name));
      const double score = off * off / result.rig.covariance.matrix(row, row);
      squares += score / 12, worst = std::max(worst, score);
    }
  }
  // Of twelve scores a mean of 3 comes up once in 3000 runs.
  EXPECT_LT(squares, 3);
  EXPECT_LT(worst, 4 * 4);
}

/// Forty rigs of exact models: one in 10^4 is stated, so that a single false one has a probability of 1 %.
TEST(ResidualDistortion, IsNotFoundWhereThereIsNone) {
  int told = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(8, 500 + seed, 0.05, 0.08);
    const Correspondences data =
        seed % 2 == 0 ? world.correspondences(seed) : world.with_light_read_at_corners(seed);
    told += calibrate_rig(data).diagnostics.find("residual_distortion") != nullptr;
  }
  EXPECT_LE(told, 1);
}

/// A view that shaped the residual distortion would look well predicted by it. Of four views, each says much that the others
/// do not: held out, the camera's corners are 1.4 times as far off as in the solution (0.97 times if the view may shape it).
TEST(ResidualDistortion, HeldOutViewsHaveNotShapedIt) {
  const NumericWorld world = NumericWorld::make_rig(4, 77, 0.03, 0.03);
  Options options;
  options.holdout = true;
  const CalibrationResult result = calibrate_rig(deviating(world.correspondences(5), world, 0.2, 9), options);
  ASSERT_NE(result.diagnostics.find("residual_distortion"), nullptr);
  EXPECT_GT(result.holdout_px[0], 1.2 * result.rms_px[0]);
}

/// A rig without views enough to tell keeps the usual solution.
TEST(ResidualDistortion, OfThreeViewsDoesNotEndTheCalibration) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(3, 900 + seed, 0.03, 0.03);
    EXPECT_NO_THROW(calibrate_rig(deviating(world.correspondences(seed), world, 0.1, seed))) << seed;
  }
}

}  // namespace
}  // namespace procam::calibrate
