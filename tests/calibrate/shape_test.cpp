/// Boards that are not as they were printed.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

/// Detectors promise less than the noise: as on real boards, something is left to explain.
Correspondences modest(Correspondences data) {
  for (View& view : data.views) {
    for (auto& observations : view.observations)
      for (Observation& o : observations) o.covariance *= 0.8;
    for (LightPoint& light : view.light_points) light.camera_covariance *= 0.8;
  }
  return data;
}

/// Of a rig's light at 2 m, mm.
double light_error(const Rig& rig, const NumericWorld& world) {
  return analyze::true_light_error(rig, world.rig(), 2).rms_mm;
}

NumericWorld bent_world(int views, std::uint64_t seed) {
  NumericWorld world = NumericWorld::make(views, seed, 0.05, 0.08);
  world.bend_board();
  return world;
}

TEST(BoardShape, OfABentSheetIsFoundAndHelps) {
  const NumericWorld world = bent_world(8, 5);
  const Correspondences data = world.correspondences(6);
  const CalibrationResult automatic = calibrate_rig(data);
  ASSERT_TRUE(automatic.shape.free);
  EXPECT_LT(automatic.shape.holdout_free_px, 0.5 * automatic.shape.holdout_flat_px);
  EXPECT_LT(automatic.rms_px[0], 1.15 * 0.05 * std::sqrt(2));
  EXPECT_NE(automatic.diagnostics.find("board_shape"), nullptr);
  // Offsets out of the plane; a shift and a tilt of all of them are the poses' business, not the shape's.
  const Points3 printed = points_in_board(world.board);
  const auto bend_of = [&](const Points3& offsets) {
    Eigen::Matrix<double, Eigen::Dynamic, 3> plane(offsets.size(), 3);
    VecX z(offsets.size());
    for (std::size_t i = 0; i < offsets.size(); ++i)
      plane.row(Eigen::Index(i)) << 1, printed[i].x(), printed[i].y();
    for (std::size_t i = 0; i < offsets.size(); ++i) z[Eigen::Index(i)] = offsets[i].z();
    return VecX(z - plane * (plane.transpose() * plane).ldlt().solve(plane.transpose() * z));
  };
  const VecX truth = bend_of(world.bend);
  EXPECT_LT((bend_of(automatic.shape.offsets) - truth).norm(), 0.3 * truth.norm());

  Options flat;
  flat.board_shape = BoardShape::kFlat;
  const CalibrationResult as_printed = calibrate_rig(data, flat);
  EXPECT_FALSE(as_printed.shape.free);
  EXPECT_GT(as_printed.rms_all_px[0], 2 * automatic.rms_all_px[0]);
  EXPECT_LT(light_error(automatic.rig, world), light_error(as_printed.rig, world));
}

/// Twenty flat sheets: a shape must win by 5 % on held-out views, which noise almost never gives it. One
/// false alarm in twenty is allowed; at a true rate of 1 % more come up in 1.7 % of runs, and the seeds are
/// fixed.
TEST(BoardShape, OfAFlatSheetIsLeftAlone) {
  int free = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    free +=
        calibrate_rig(modest(NumericWorld::make(6, 200 + seed, 0.1, 0.12).correspondences(seed))).shape.free;
  EXPECT_LE(free, 1);
}

/// The same with light beside the print.
TEST(BoardShape, OfAFlatSheetThatLightFallsOnIsLeftAlone) {
  int free = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    free += calibrate_rig(modest(NumericWorld::make(10, 2200 + seed, 0.08, 0).with_projected_board(seed)))
                .shape.free;
  EXPECT_LE(free, 1);
}

TEST(BoardShape, SettlesTheOrderOfASymmetricBoard) {
  NumericWorld world = NumericWorld::make(7, 8, 0.04, 0.06);
  world.board = Chessboard{9, 7, 0.03};
  world.bend_board();
  Correspondences data = world.correspondences(9);
  for (const std::size_t v : {std::size_t(1), std::size_t(4), std::size_t(5)})
    for (auto& observations : data.views[v].observations)
      for (Observation& o : observations) o.point = 62 - o.point;
  const CalibrationResult result = calibrate_rig(data);
  ASSERT_TRUE(result.shape.free);
  EXPECT_LT(result.rms_all_px[0], 1.2 * 0.04 * std::sqrt(2));
  int turned = 0;
  for (const ViewResult& view : result.views)
    turned += view.note.find("as the board's shape asked") != std::string::npos;
  EXPECT_EQ(turned, 3);
}

TEST(BoardShape, TellsAPrintThatIsTooWide) {
  NumericWorld world = NumericWorld::make(10, 15, 0.03, 0.05);
  for (const Vec3& p : points_in_board(world.board)) world.bend.emplace_back(0.004 * p.x(), 0, 0);
  const CalibrationResult result = calibrate_rig(world.correspondences(16));
  ASSERT_TRUE(result.shape.free);
  EXPECT_NEAR(result.shape.stretch_x_over_y, 0.004, 0.0008);
  // The lenses are right all the same, and the scale of every distance is not: nothing said so.
  const Diagnostic* stretched = result.diagnostics.find("print_stretched");
  ASSERT_NE(stretched, nullptr);
  EXPECT_NE(stretched->message.find("0.4 % longer along its x than along its y"), std::string::npos)
      << stretched->message;
  NumericWorld usual = NumericWorld::make(10, 15, 0.03, 0.05);
  for (const Vec3& p : points_in_board(usual.board))
    usual.bend.emplace_back(0, 0.0012 * p.y(), 0.001 * std::sin(40 * p.x()));
  const CalibrationResult of_usual = calibrate_rig(usual.correspondences(16));
  ASSERT_TRUE(of_usual.shape.free_points);
  EXPECT_EQ(of_usual.diagnostics.find("print_stretched"), nullptr) << "as printers do";
}

TEST(BoardShape, IsRefusedByAGateWhenTheSheetIsCrumpled) {
  NumericWorld world = NumericWorld::make(9, 25, 0.05, 0.08);
  const Points3 points = points_in_board(world.board);
  for (std::size_t i = 0; i < points.size(); ++i)
    world.bend.emplace_back(0, 0, 0.008 * std::sin(30 * points[i].x()) * std::cos(25 * points[i].y()));
  Options options;
  options.board_shape = BoardShape::kFree;
  const CalibrationResult result = calibrate_rig(world.correspondences(26), options);
  const auto gate = std::find_if(result.rig.quality.gates.begin(), result.rig.quality.gates.end(),
                                 [](const Gate& g) { return g.name == "board's shape"; });
  ASSERT_NE(gate, result.rig.quality.gates.end());
  EXPECT_FALSE(gate->passed);
  EXPECT_NE(gate->detail.find("flat plate"), std::string::npos);
}

/// Printed and projected chessboards on a sheet that is bent by 6 mm half a metre from the print's middle. The bend is 0.7 mm
/// at most on the print and 20 mm where light falls. 20 rigs: the light's error is that of flat sheets, which is
/// 2.1 mm for this noise, and as predicted: the mean of 20 squares of one normal number lies in 0.37 .. 2 in 99 % of runs.
TEST(BoardShape, OfABentSheetIsKnownWhereLightFallsBesideThePrint) {
  double squares = 0, predicted = 0;
  constexpr int kRigs = 20;
  for (std::uint64_t seed = 0; seed < kRigs; ++seed) {
    NumericWorld world = NumericWorld::make(12, 3200 + seed, 0.06, 0);
    world.bend_sheet(0.006);
    const Correspondences data = modest(world.with_projected_board(seed));
    const CalibrationResult result = calibrate_rig(data);
    ASSERT_TRUE(result.shape.free) << seed;
    EXPECT_FALSE(result.shape.free_points) << seed;
    EXPECT_LT((result.shape.sheet.curvature - world.sheet.curvature).norm(),
              0.1 * world.sheet.curvature.norm())
        << seed;
    EXPECT_GT(result.shape.largest_of_light, 5 * result.shape.largest);
    const double error = light_error(result.rig, world);
    squares += error * error / kRigs;
    const double expected = analyze::predicted_light_error(result.rig, 2).rms_mm;
    predicted += expected * expected / kRigs;
    if (seed > 0) continue;
    EXPECT_NE(result.diagnostics.find("board_shape"), nullptr);
    Options flat;
    flat.board_shape = BoardShape::kFlat;
    EXPECT_GT(light_error(calibrate_rig(data, flat).rig, world), 10 * error);
  }
  EXPECT_LT(std::sqrt(squares), 3) << "mm at 2 m";
  EXPECT_GT(squares, 0.37 * predicted);
  EXPECT_LT(squares, 2 * predicted);
}

}  // namespace
}  // namespace procam::calibrate
