#include "procam/analyze/prediction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "analyze/uncertain_room.hpp"
#include "support/expect_error.hpp"

namespace procam::analyze {
namespace {

using Room = test::UncertainRoom;

TEST(Prediction, RanksTheCausesAndNamesTheChangeThatHelpsMost) {
  Room room;
  const SurfacePrediction wall = predict_surface("wall", room.path(), room.plane_from_content, room.sources);
  EXPECT_EQ(wall.lit_share, 1);
  EXPECT_NEAR(wall.size.x(), 0.7, 1e-12);
  ASSERT_FALSE(wall.causes.empty());
  EXPECT_EQ(wall.causes.front().name, "delay");
  EXPECT_TRUE(procam::test::contains(wall.advice, "--with-prediction")) << wall.advice;
  double squares = 0;
  for (std::size_t i = 0; i < wall.causes.size(); ++i) {
    EXPECT_LE(wall.causes[i].rms_mm, wall.causes[i == 0 ? 0 : i - 1].rms_mm);
    EXPECT_LT(wall.causes[i].without_mm, wall.rms_mm);
    squares += wall.causes[i].rms_mm * wall.causes[i].rms_mm;
  }
  std::set<std::string> names;
  for (const Cause& cause : wall.causes) names.insert(cause.name);
  EXPECT_EQ(names, (std::set<std::string>{"calibration", "delay", "map: position", "rig pose: position",
                                          "rig pose: rotation"}));
  // The worst point may be a corner.
  double worst = 0;
  for (const auto* points : {&wall.grid, &wall.corners})
    for (const auto& error : *points)
      if (error) worst = std::max(worst, 1e3 * error->total.rms());
  EXPECT_DOUBLE_EQ(wall.worst_mm, worst);
  // All parts are independent here: their squares add up.
  EXPECT_NEAR(std::sqrt(squares), wall.rms_mm, 1e-9 * wall.rms_mm);
  EXPECT_GE(wall.worst_mm, wall.rms_mm);

  room.sources.motion.predicted = true;
  const SurfacePrediction predicted =
      predict_surface("wall", room.path(), room.plane_from_content, room.sources);
  // Not quite the same: without prediction the spread is that of the place where the drive leads.
  EXPECT_NEAR(predicted.rms_mm / wall.causes.front().without_mm, 1, 0.1);
  EXPECT_FALSE(procam::test::contains(predicted.advice, "--with-prediction")) << predicted.advice;
}

TEST(Prediction, CausesOfNoPointsAndOfUnequalPointsAreRefused) {
  EXPECT_THROW(rank_causes({}), std::invalid_argument);
  const Room room;
  const SurfacePrediction wall = predict_surface("wall", room.path(), room.plane_from_content, room.sources);
  const LandingError without_sources;
  ASSERT_TRUE(wall.corners[0]);
  EXPECT_THROW(rank_causes({&*wall.corners[0], &without_sources}), std::invalid_argument);
}

/// 20 000 draws: the rms's standard error is below 0.6 %; 4 % is seven of them and what first order leaves.
TEST(Prediction, AgreesWithMonteCarlo) {
  Room room;
  const auto wall = predict_surface("wall", room.path(), room.plane_from_content, room.sources,
                                    MonteCarloOptions{20000, 5, 0});
  ASSERT_EQ(wall.drawn.size(), wall.grid.size());
  EXPECT_NEAR(wall.drawn_rms_mm / wall.rms_mm, 1, 0.04);
}

TEST(Prediction, SweepsPassThroughWhatIs) {
  Room room;
  const auto wall = predict_surface("wall", room.path(), room.plane_from_content, room.sources);
  ASSERT_EQ(wall.sweeps.size(), 5u);
  // The curves are taken at the lit point nearest to the content's middle; the first of four alike.
  for (const Sweep& curve : wall.sweeps) {
    ASSERT_GE(curve.values.size(), 25u) << curve.name;
    EXPECT_LE(curve.values.front(), curve.here);
    EXPECT_GE(curve.values.back(), curve.here);
    // Between the neighbours of `here` lies the error as it is.
    std::size_t after = 1;
    while (curve.values[after] < curve.here) ++after;
    const double low = std::min(curve.rms_mm[after - 1], curve.rms_mm[after]),
                 high = std::max(curve.rms_mm[after - 1], curve.rms_mm[after]);
    const double as_it_is =
        1e3 * wall.grid[std::size_t((wall.rows / 2 - 1) * wall.columns + wall.columns / 2 - 1)]->total.rms();
    EXPECT_GE(as_it_is, low - 1e-6) << curve.name;
    EXPECT_LE(as_it_is, high + 1e-6) << curve.name;
  }
}

TEST(Prediction, SweepsGoWhereTheirAxisSays) {
  Room room;
  const auto wall = predict_surface("wall", room.path(), room.plane_from_content, room.sources);
  const auto curve = [&](const std::string& name) {
    return *std::find_if(wall.sweeps.begin(), wall.sweeps.end(),
                         [&](const Sweep& one) { return one.name == name; });
  };
  // Light that grazes lands much farther off than light that comes straight.
  const Sweep incidence = curve("incidence");
  EXPECT_GT(incidence.rms_mm.back(), 3 * incidence.rms_mm.front());
  // The variance grows with the square of the sigma.
  const Sweep sigma = curve("localisation sigma");
  const auto grown = [&](std::size_t i) {
    return std::pow(sigma.rms_mm[i], 2) - std::pow(sigma.rms_mm.front(), 2);
  };
  EXPECT_NEAR(grown(32) / grown(16), 4, 1e-6);
}

TEST(Prediction, SaysWhatIsNotLitAndRefusesADarkSurface) {
  Room room;
  Mat3 wide = room.plane_from_content;
  wide(0, 0) = 4;
  const auto wall = predict_surface("wall", room.path(), wide, room.sources);
  EXPECT_GT(wall.lit_share, 0.05);
  EXPECT_LT(wall.lit_share, 0.9);
  EXPECT_NE(wall.diagnostics.find("not_lit"), nullptr);
  double squares = 0;
  for (const auto& error : wall.grid)
    if (error) squares += std::pow(1e3 * error->total.rms(), 2);
  EXPECT_NEAR(wall.rms_mm, std::sqrt(squares / (wall.lit_share * double(wall.grid.size()))), 1e-9);
  Mat3 sideways = room.plane_from_content;
  sideways(0, 2) += 6;
  EXPECT_ERROR(predict_surface("wall", room.path(), sideways, room.sources), kDegenerate, "lights no point");
  LightPath behind = room.path();
  behind.rig_from_surface.translation.z() -= 5;
  EXPECT_ERROR(predict_surface("wall", behind, room.plane_from_content, room.sources), kDegenerate,
               "behind the projector");
}

}  // namespace
}  // namespace procam::analyze
