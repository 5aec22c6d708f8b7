/// Patterns that cover the print, on every kind of board, through the reading that the tools use: is each
/// point's projector pixel the one that lights it?
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>

#include "procam/detect/board_artwork.hpp"
#include "procam/session/patterns.hpp"
#include "procam/simulate/capture.hpp"
#include "small_stage.hpp"

namespace procam::test {
namespace {

/// The stage's first pose with another board; `shift` moves it along its rows, out of the pictures.
simulate::World stage_with(const Board& board, double shift) {
  simulate::World world = stage(0);
  world.board.layout = board;
  world.board.artwork = detect::board_artwork(board);
  const Vec3 old_middle = 0.5 * 0.045 * Vec3(7, 4, 0);
  const ArtworkRectangle print = print_of(board);
  const Vec2 middle = 0.5 * (print.low + print.high);
  world.rig_from_board =
      world.rig_from_board * Pose(Mat3::Identity(), old_middle - Vec3(middle.x() - shift, middle.y(), 0));
  return world;
}

struct KindCase {
  const char* name;
  Board board;
  const char* pattern;
  double shift;       ///< metres
  std::size_t least;  ///< points with a projector pixel
};

class BoardKinds : public ::testing::TestWithParam<KindCase> {};

TEST_P(BoardKinds, GetTheLightThatFallsOnTheirPoints) {
  const KindCase& which = GetParam();
  const simulate::World world = stage_with(which.board, which.shift);
  const auto pattern = session::make_pattern(which.pattern, kStageProjector);
  simulate::CaptureOptions options;
  options.camera_blur_px = 0.5;
  options.projector_blur_px = 0.3;
  options.noise = {1, 0.01};
  options.seed = 5;
  const std::vector<ImageU8> images = simulate::capture(world, pattern->frames(), options);
  const session::BoardView view = pattern->read("view", {images.begin(), images.end()}, which.board);
  std::map<int, Vec2> truth;
  for (const Observation& o : simulate::board_in_projector(world)) truth[o.point] = o.pixel;
  double squares = 0, scores = 0;
  const std::vector<Observation>& lit = view.detections[session::kProjectorDevice].observations;
  for (const Observation& o : lit) {
    ASSERT_EQ(truth.count(o.point), 1u) << o.point;
    const Vec2 error = o.pixel - truth[o.point];
    squares += error.squaredNorm();
    scores += error.dot(o.covariance.inverse() * error);
  }
  const double n = 2 * double(lit.size());
  std::printf("%s: %zu points of %zu seen, rms %.3f px, score %.2f\n", which.name, lit.size(),
              view.detections[session::kCameraDevice].observations.size(), std::sqrt(squares / n),
              scores / n);
  EXPECT_GE(lit.size(), which.least);
  if (which.shift != 0) {
    EXPECT_LT(lit.size(), points_in_board(which.board).size());
  }
  EXPECT_LT(std::sqrt(squares / n), 0.1);
  EXPECT_LT(scores / n, 3);
}

// Pictures are small: a square has 25 to 45 pixels, a camera pixel 0.8 of the projector's.
const CharucoBoard kCharuco{6, 4, 0.075, 0.055, MarkerDictionary::k4x4_50};
INSTANTIATE_TEST_SUITE_P(
    Kinds, BoardKinds,
    ::testing::Values(
        KindCase{"CharucoGray", kCharuco, "gray", 0, 13},
        KindCase{"CharucoInPartGray", kCharuco, "gray", -0.22, 5},
        KindCase{"CharucoPhase", kCharuco, "phase", 0, 13},
        KindCase{"MarkersGray", MarkerGrid{4, 3, 0.065, 0.03, MarkerDictionary::k4x4_50}, "gray", 0, 40},
        KindCase{"CirclesGrayPhase", CircleGrid{7, 4, 0.055, 0.035, false}, "gray+phase", 0, 24},
        KindCase{"StaggeredCirclesPhase", CircleGrid{4, 5, 0.05, 0.045, true}, "phase", 0, 18}),
    [](const auto& which) { return std::string(which.param.name); });

}  // namespace
}  // namespace procam::test
