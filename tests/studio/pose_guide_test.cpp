/// The outline of the board that the projector shows, and the board that is found in its light.
#include "pose_guide.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "board_spotter.hpp"
#include "procam/core/geometry/homography.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/text.hpp"
#include "projector_screens.hpp"

namespace procam::studio {
namespace {

const Board kBoard = io::parse_board("chessboard:9x6:30mm");

double distance_to_side(const std::vector<Vec2>& ring, const Vec2& point) {
  double least = 1e9;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 along = ring[(i + 1) % ring.size()] - ring[i];
    const double at = std::clamp((point - ring[i]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (ring[i] + at * along - point).norm());
  }
  return least;
}

TEST(PoseGuide, TheOutlineIsBrightLinesOnDimmerLight) {
  const std::vector<Vec2> ring = {{55.3, 40}, {215, 20.5}, {350, 166}, {45, 150}};  // one corner is outside
  const ImageU8 frame = guide_frame({320, 180}, ring);
  ASSERT_EQ(frame.size(), (ImageSize{320, 180}));
  for (int y = 0; y < 180; ++y)
    for (int x = 0; x < 320; ++x) {
      const double off = distance_to_side(ring, Vec2(x, y));
      if (off < 1) ASSERT_EQ(frame.at(x, y), kGuideLine) << x << ", " << y;
      if (off > 3) ASSERT_EQ(frame.at(x, y), kGuideGround) << x << ", " << y;
    }
  // Nothing can be drawn of these, and nothing breaks.
  const double nan = std::nan("");
  for (const std::vector<Vec2>& odd : {std::vector<Vec2>{}, {{nan, 1}, {2, nan}}, {{1e12, 0}, {-1e12, 5}}}) {
    const ImageU8 plain = guide_frame({64, 36}, odd);
    for (int y = 0; y < 36; ++y)
      for (int x = 0; x < 64; ++x) ASSERT_EQ(plain.at(x, y), kGuideGround);
  }
}

/// The light leaves the corners alone, and stays on the sheet or next to it.
TEST(PoseGuide, TheOutlineIsRoundTheSquares) {
  EXPECT_GT(light_margin(kBoard), 0.03);
  EXPECT_LT(light_margin(kBoard), 0.045);
}

TEST(PoseGuide, ByARigTheOutlineIsWhereTheProjectorLightsTheBoard) {
  Projector projector;
  projector.inverse_camera.size = {800, 600};
  projector.inverse_camera.intrinsics = {910, 870, 390, 610, 1.3};
  const Pose projector_from_board(so3_exp(Vec3(0.2, -0.3, 0.1)), Vec3(-0.05, -0.31, 1.2));
  const std::vector<Vec2> shown = outline_in_frame(kBoard, projector_from_board, projector);
  ASSERT_EQ(shown.size(), 4u);
  const double margin = light_margin(kBoard);
  // 9 x 6 corners, 30 mm apart; the frame of a board begins at its first corner.
  const auto points = points_in_board(kBoard);
  Vec2 low = Vec2::Constant(1e9), high = -low;
  for (const Vec3& point : points) low = low.cwiseMin(point.head<2>()), high = high.cwiseMax(point.head<2>());
  EXPECT_NEAR((high - low).x(), 0.24, 1e-12);
  const Vec3 second(high.x() + margin, low.y() - margin, 0);
  EXPECT_LT((shown[1] - *projector.project(projector_from_board * second)).norm(), 1e-9);
  const Pose beside(projector_from_board.rotation, Vec3(9, 0, 1.2));
  EXPECT_TRUE(outline_in_frame(kBoard, beside, projector).empty()) << "no corner is in the frame";
  const Pose behind(projector_from_board.rotation, Vec3(0, 0, -1.2));
  EXPECT_TRUE(outline_in_frame(kBoard, behind, projector).empty());
}

TEST(PoseGuide, WithoutARigTheLitBoxIsTheFrame) {
  const LitBox lit{{210, 95}, {1010, 545}};
  GuidedPose pose = guided_pose(1, kBoard, {1280, 720}, lit);
  const ImageSize frame{1024, 768};
  const std::vector<Vec2> shown = outline_in_frame(kBoard, pose, lit, frame);
  const std::vector<Vec2> seen = outline(kBoard, pose.camera_from_board, pose.camera, light_margin(kBoard));
  ASSERT_EQ(shown.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR((shown[i].x() + 0.5) / 1024, (seen[i].x() - 210) / 800, 1e-12);
    EXPECT_NEAR((shown[i].y() + 0.5) / 768, (seen[i].y() - 95) / 450, 1e-12);
  }
}

/// A chessboard on its sheet before a wall, as grey values in white light.
std::vector<double> board_before_a_wall(const Homography& image_from_board, ImageSize size) {
  const Homography board_from_image = image_from_board.inverse();
  constexpr double kSquare = 0.03, kMargin = 0.055;  // of the sheet round the corners
  std::vector<double> seen;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (const double dx : {-0.25, 0.25})
        for (const double dy : {-0.25, 0.25}) {
          const Vec2 at = board_from_image.apply_unchecked(Vec2(x + dx, y + dy));
          const Vec2 square = (at / kSquare).array().floor();
          const bool on_sheet = at.x() > -kMargin && at.y() > -kMargin && at.x() < 8 * kSquare + kMargin &&
                                at.y() < 5 * kSquare + kMargin;
          const bool in_print = square.minCoeff() >= -1 && square.x() <= 8 && square.y() <= 5;
          const bool is_black = in_print && std::abs(int(square.x() + square.y())) % 2 == 0;
          sum += (on_sheet ? (is_black ? 12.0 : 200.0) : 90.0) / 4;
        }
      seen.push_back(sum);
    }
  return seen;
}

/// A camera's image of it in the guide's light, with noise.
ImageU8 seen_in(const ImageU8& light, const std::vector<double>& in_white, unsigned seed) {
  const double ground = std::pow(kGuideGround / 255.0, 2.2);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 2);
  ImageU8 seen(light.size(), 1);
  for (int y = 0; y < seen.height(); ++y)
    for (int x = 0; x < seen.width(); ++x) {
      const double grey =
          in_white[std::size_t(y * seen.width() + x)] * (light.at(x, y) == kGuideLine ? 1 : ground);
      seen.at(x, y) = std::uint8_t(std::clamp(std::lround(grey + noise(random)), 0L, 255L));
    }
  return seen;
}

/// Whoever holds the board elsewhere has lines across it. It is found nonetheless, but for corners under the lines, and seen to
/// be still. The patterns' frames, which are measured, have no lines.
TEST(PoseGuide, TheBoardIsFoundStillUnderTheLines) {
  const ImageSize size{640, 480};
  const Homography image_from_board((Mat3() << 1450, 130, 150, -90, 1380, 110, 0.25, 0.1, 1).finished());
  const std::vector<double> in_white = board_before_a_wall(image_from_board, size);
  const auto points = points_in_board(kBoard);
  for (const double shift : {25.0, 97.0}) {
    const ImageU8 light = guide_frame(
        size, {{130 + shift, 60 + shift}, {570 + shift, 95}, {520 - shift, 370 - shift}, {90 + shift, 330}});
    const Detections found = detect::detect_board(seen_in(light, in_white, 7), kBoard),
                     again = detect::detect_board(seen_in(light, in_white, 8), kBoard);
    EXPECT_GE(found.observations.size(), 36u) << "of 54, lines displaced by " << shift << " px";
    const std::optional<double> moved = largest_move(found, again);
    ASSERT_TRUE(moved) << "lines displaced by " << shift << " px";
    EXPECT_LT(*moved, BoardSpotter::kStillPx) << "lines displaced by " << shift << " px";
    for (const Observation& one : found.observations) {
      const Vec2 board = points[std::size_t(one.point)].head<2>();
      double off = 1e9;  // the print looks the same from two sides
      for (const Vec2& same : {board, Vec2(Vec2(0.24, 0.15) - board)})
        off = std::min(off, (image_from_board.apply_unchecked(same) - one.pixel).norm());
      EXPECT_LT(off, 1) << one.point << ", lines displaced by " << shift << " px";
    }
  }
}

}  // namespace
}  // namespace procam::studio
