#include <gtest/gtest.h>

#include <Eigen/LU>

#include "lit_board.hpp"
#include "procam/pattern/board_light.hpp"

namespace procam {
namespace {

using pattern::project_board;
using test::LitBoard;

/// What phase shift would decode of the world: every pixel's light with noise, fainter (and so less certain)
/// to the right; beyond `lit_below_u` nothing. A share of the pixels is wrong by a wave.
LightMap wave_light(const LitBoard& world, double wrong_share = 0) {
  LightMap light;
  light.projector_size = world.projector.size();
  light.period = 16;
  light.pixel = ImageF(world.camera.size, 2);
  light.sigma = ImageF(world.camera.size, 2);
  std::mt19937 random(world.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  for (int y = 0; y < world.camera.size.height; ++y)
    for (int x = 0; x < world.camera.size.width; ++x) {
      const Vec2 truth = world.light_at(Vec2(x, y));
      if (!light.projector_size.contains(truth) || truth.x() >= world.lit_below_u) continue;
      const double sigma = 0.05 + 0.1 * x / world.camera.size.width;
      for (int d = 0; d < 2; ++d) {
        double seen = truth[d] + sigma * normal(random);
        if (uniform(random) < wrong_share) seen += uniform(random) < 0.7 ? 16 : -16;
        light.pixel.at(x, y, d) = float(seen);
        light.sigma.at(x, y, d) = float(sigma);
      }
    }
  return light;
}

/// 70 coordinates, neighbours correlated: chi2 within a factor of 2.25; false alarm rate below 1e-3.
TEST(BoardLightFromWaves, IsPreciseAndStatesItsError) {
  for (const double corner_sigma : {1e-4, 0.03}) {
    const LitBoard world;
    const Detections projected =
        project_board(world.corners(corner_sigma), world.board, world.artwork(), wave_light(world));
    ASSERT_EQ(projected.observations.size(), 35u);
    EXPECT_EQ(projected.image_size, world.projector.size());
    const test::LightErrors errors = test::errors_of(projected, world);
    EXPECT_LT(errors.rms, 0.01 + 1.5 * corner_sigma);
    EXPECT_GT(errors.chi2, 1 / 2.25);
    EXPECT_LT(errors.chi2, 2.25);
  }
}

TEST(BoardLightFromWaves, IgnoresPixelsThatMissAWave) {
  const LitBoard world;
  const Detections projected =
      project_board(world.corners(1e-4), world.board, world.artwork(), wave_light(world, 0.1));
  ASSERT_EQ(projected.observations.size(), 35u);
  EXPECT_LT(test::errors_of(projected, world).rms, 0.02);
}

TEST(BoardLightFromWaves, GivesNoPixelToCornersThatLightDoesNotSurround) {
  LitBoard world;
  world.lit_below_u = world.light_at(world.corner_pixel(17)).x() + 2;  // just right of the middle column
  const Detections projected =
      project_board(world.corners(1e-4), world.board, world.artwork(), wave_light(world));
  ASSERT_FALSE(projected.observations.empty());
  for (const Observation& o : projected.observations) EXPECT_LT(o.point % 5, 3) << o.point;
  EXPECT_NE(projected.diagnostics.find("corners_not_lit"), nullptr);
}

TEST(BoardLightFromWaves, RefusesAMapOfAnotherSize) {
  const LitBoard world;
  Detections other = world.corners(0.01);
  other.image_size = {400, 480};
  EXPECT_THROW(project_board(other, world.board, world.artwork(), wave_light(world)), std::invalid_argument);
  LightMap dark = wave_light(world);
  dark.sigma = ImageF(world.camera.size, 2);
  EXPECT_NE(project_board(world.corners(0.01), world.board, world.artwork(), dark)
                .diagnostics.find("board_not_lit"),
            nullptr);
}

}  // namespace
}  // namespace procam
