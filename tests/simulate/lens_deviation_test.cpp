/// True lenses that do more than their models.
#include "procam/simulate/lens_deviation.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "procam/core/lens/lens_change.hpp"
#include "procam/simulate/session.hpp"

namespace procam::simulate {
namespace {

const Camera kLens{
    {1280, 960}, {1290.0, 1237.0, 655.0, 470.0, 2.0}, BrownConrady{{-0.12, 0.06, 0.0007, -0.0011, 0.01}}};

TEST(LensDeviation, HasItsSizeAndNothingThatTheLensCouldTake) {
  const LensDeviation deviation(kLens, 0.05, 3);
  const Points2 grid = grid_over(kLens.size, 40, 30);
  MatX displacements(Eigen::Index(2 * grid.size()), 1);
  for (std::size_t i = 0; i < grid.size(); ++i)
    displacements.block<2, 1>(Eigen::Index(2 * i), 0) = deviation.at(grid[i]);
  EXPECT_NEAR(std::sqrt(displacements.squaredNorm() / double(grid.size())), 0.05, 0.002);
  std::vector<int> free(static_cast<std::size_t>(parameters_of(kLens).size()));
  std::iota(free.begin(), free.end(), 0);
  const Camera nearest = with_lens_change(kLens, free, lens_change(kLens, free, grid, displacements).col(0));
  for (const Vec2& pixel : grid) EXPECT_LT((*nearest.project(*kLens.unproject(pixel)) - pixel).norm(), 0.004);
  EXPECT_TRUE(LensDeviation().empty());
  EXPECT_TRUE(LensDeviation(kLens, 0, 3).empty());
  EXPECT_EQ(LensDeviation(kLens, 0.05, 3).at({100, 200}), deviation.at({100, 200}));
  EXPECT_GT((LensDeviation(kLens, 0.05, 4).at({100, 200}) - deviation.at({100, 200})).norm(), 1e-4);
}

/// What a lens lacks is found again: the change that makes it another lens of the same model.
TEST(LensChange, FindsTheLensThatADisplacementMeans) {
  VecX parameters = parameters_of(kLens);
  std::vector<int> free{0, 1, 2, 3, 4, 5, 7};
  const VecX wanted = (VecX(7) << 0.4, -0.3, 0.2, 0.5, -0.1, 0.0004, 0.0001).finished();
  const Camera other = with_lens_change(kLens, free, wanted);
  const Points2 grid = grid_over(kLens.size, 24, 18);
  MatX displacements(Eigen::Index(2 * grid.size()), 1);
  for (std::size_t i = 0; i < grid.size(); ++i)
    displacements.block<2, 1>(Eigen::Index(2 * i), 0) = *other.project(*kLens.unproject(grid[i])) - grid[i];
  const VecX found = lens_change(kLens, free, grid, displacements).col(0);
  for (Eigen::Index k = 0; k < wanted.size(); ++k)
    EXPECT_NEAR(found[k], wanted[k], 2e-3 * std::abs(wanted[k]));
  EXPECT_THROW(lens_change(kLens, free, grid, MatX::Zero(3, 1)), std::invalid_argument);
}

/// A printed corner is seen by the camera where the light of the projector's own corner falls: rays that are cast through the
/// image meet what was projected point by point. Off by the deviation, it would be 0.2 px.
TEST(LensDeviation, IsInRaysAsItIsInPoints) {
  Conditions conditions = level_conditions(Level::kPaper);
  conditions.camera_deviation_px = conditions.projector_deviation_px = 0.2;
  const SimulatedSession session = make_session(Level::kPaper, 7, {}, {}, conditions);
  int compared = 0;
  for (const World& world : session.views)
    for (const Observation& lit : board_in_projector(world))
      for (const Observation& seen : board_in_camera(world)) {
        if (seen.point != lit.point) continue;
        const auto there = projector_pixel_seen_at(world, seen.pixel);
        ASSERT_TRUE(there);
        EXPECT_LT((*there - lit.pixel).norm(), 0.002);
        ++compared;
      }
  EXPECT_GT(compared, 400);
}

}  // namespace
}  // namespace procam::simulate
