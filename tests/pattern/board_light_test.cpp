#include "procam/pattern/board_light.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>

#include "lit_board.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/chessboard.hpp"
#include "procam/pattern/stripe_edges.hpp"
#include "support/test_data.hpp"

namespace procam {
namespace {

using pattern::project_board;
using test::LitBoard;

/// The usual way, as referee: a homography from the integer codes of 33x33 pixels round the corner.
Vec2 local_homography(const DecodedMap& decoded, const Vec2& corner) {
  std::vector<cv::Point2f> camera, projector;
  const int x0 = int(std::lround(corner.x())), y0 = int(std::lround(corner.y()));
  for (int y = std::max(0, y0 - 16); y <= std::min(decoded.camera_size().height - 1, y0 + 16); ++y)
    for (int x = std::max(0, x0 - 16); x <= std::min(decoded.camera_size().width - 1, x0 + 16); ++x)
      if (const auto light = decoded.projector_pixel(x, y)) {
        camera.emplace_back(float(x), float(y));
        projector.emplace_back(float(light->x()), float(light->y()));
      }
  const cv::Mat h = cv::findHomography(camera, projector, cv::RANSAC);
  const cv::Mat p = h * cv::Mat(cv::Vec3d(corner.x(), corner.y(), 1));
  return Vec2(p.at<double>(0), p.at<double>(1)) / p.at<double>(2);
}

TEST(BoardLight, IsSeveralTimesBetterThanLocalHomographiesOnABentBoard) {
  const LitBoard world;
  const test::Light light = test::shine(world);
  const Detections corners = world.corners(1e-4);
  const Detections projected =
      project_board(corners, world.board, world.artwork(), light.decoded, light.edges);
  ASSERT_EQ(projected.observations.size(), 35u);
  EXPECT_EQ(projected.image_size, world.projector.size());
  const test::LightErrors own = test::errors_of(projected, world);
  double local = 0;
  for (const Observation& o : corners.observations)
    local += (local_homography(light.decoded, o.pixel) - world.light_at(o.pixel)).squaredNorm() / 70;
  RecordProperty("rms_px", std::to_string(own.rms));
  RecordProperty("local_rms_px", std::to_string(std::sqrt(local)));
  RecordProperty("chi2", std::to_string(own.chi2));
  EXPECT_LT(own.rms, 0.012);
  EXPECT_GT(std::sqrt(local), 3 * own.rms);
}

TEST(BoardLight, StatesItsErrorHonestly) {
  // 70 coordinates, neighbours correlated: chi2 within a factor of 2.25 (1.5 in sigma); false alarm rate
  // below 1e-3.
  for (const double corner_sigma : {1e-4, 0.03}) {
    const LitBoard world;
    const test::Light light = test::shine(world);
    const test::LightErrors own = test::errors_of(
        project_board(world.corners(corner_sigma), world.board, world.artwork(), light.decoded, light.edges),
        world);
    EXPECT_GT(own.chi2, 1 / 2.25) << corner_sigma;
    EXPECT_LT(own.chi2, 2.25) << corner_sigma;
  }
}

TEST(BoardLight, SetsWrongCodesAndPrintedBordersAside) {
  LitBoard world;
  world.wrong_edges = 0.05;
  world.border_shift_px = 0.15;  // too little to be seen as an outlier
  const test::Light light = test::shine(world);
  const Detections projected =
      project_board(world.corners(1e-4), world.board, world.artwork(), light.decoded, light.edges);
  ASSERT_EQ(projected.observations.size(), 35u);
  EXPECT_LT(test::errors_of(projected, world).rms, 0.015);
  pattern::BoardLightOptions no_band;
  no_band.border_px = 0;
  EXPECT_GT(test::errors_of(project_board(world.corners(1e-4), world.board, world.artwork(), light.decoded,
                                          light.edges, no_band),
                            world)
                .rms,
            test::errors_of(projected, world).rms);
}

TEST(BoardLight, GivesNoPixelToCornersThatLightDoesNotSurround) {
  LitBoard world;
  world.lit_below_u = world.light_at(world.corner_pixel(17)).x() + 2;  // just right of the middle column
  const test::Light light = test::shine(world);
  const Detections projected =
      project_board(world.corners(1e-4), world.board, world.artwork(), light.decoded, light.edges);
  ASSERT_FALSE(projected.observations.empty());
  for (const Observation& o : projected.observations) EXPECT_LT(o.point % 5, 3) << o.point;
  ASSERT_NE(projected.diagnostics.find("corners_not_lit"), nullptr);
  EXPECT_LT(test::errors_of(projected, world).rms, 0.02);
}

/// Boards of about the size of the chessboard, 25 x 35 cm.
const Board kOtherBoards[] = {CharucoBoard{6, 8, 0.05, 0.036, MarkerDictionary::k4x4_50},
                              MarkerGrid{3, 4, 0.06, 0.025, MarkerDictionary::k4x4_50},
                              CircleGrid{5, 7, 0.05, 0.03, false}, CircleGrid{4, 9, 0.036, 0.03, true}};

TEST(BoardLight, IsReadOnEveryKindOfBoard) {
  for (const Board& board : kOtherBoards) {
    LitBoard world;
    world.board = board;
    const test::Light light = test::shine(world);
    const Detections corners = world.corners(1e-4);
    const Detections projected =
        project_board(corners, world.board, world.artwork(), light.decoded, light.edges);
    EXPECT_EQ(projected.observations.size(), corners.observations.size()) << board.index();
    const test::LightErrors own = test::errors_of(projected, world);
    EXPECT_LT(own.rms, 0.02) << board.index();
    // As for the chessboard: a factor of 2.25, false alarm rate below 1e-3 a board.
    EXPECT_GT(own.chi2, 1 / 2.25) << board.index();
    EXPECT_LT(own.chi2, 2.25) << board.index();
  }
}

TEST(BoardLight, TakesAPartOfTheBoard) {
  for (const Board& board : {kOtherBoards[0], kOtherBoards[1]}) {
    LitBoard world;
    world.board = board;
    const test::Light light = test::shine(world);
    Detections part = world.corners(1e-4);
    const Points3 points = points_in_board(board);
    const double middle = 0.5 * (points.front().x() + points.back().x());
    const auto hidden = [&](const Observation& o) {
      return points[std::size_t(o.point)].x() > middle + 1e-9;
    };
    part.observations.erase(std::remove_if(part.observations.begin(), part.observations.end(), hidden),
                            part.observations.end());
    ASSERT_LT(part.observations.size(), points.size());
    const Detections projected =
        project_board(part, world.board, world.artwork(), light.decoded, light.edges);
    EXPECT_EQ(projected.observations.size(), part.observations.size()) << board.index();
    EXPECT_LT(test::errors_of(projected, world).rms, 0.03) << board.index();
  }
}

TEST(BoardLight, SaysWhenTheBoardIsNotLitOrNotSeen) {
  LitBoard world;
  const test::Light light = test::shine(world);
  test::Light dark = light;
  dark.decoded.columns = Image<std::int16_t>(world.camera.size, 1, DecodedMap::kUndecoded);
  EXPECT_NE(project_board(world.corners(0.01), world.board, world.artwork(), dark.decoded, {})
                .diagnostics.find("board_not_lit"),
            nullptr);
  EXPECT_NE(project_board(world.corners(0.01), world.board, world.artwork(), light.decoded, {})
                .diagnostics.find("board_not_lit"),
            nullptr);
  Detections few = world.corners(0.01);
  few.observations.resize(3);
  EXPECT_NE(project_board(few, world.board, world.artwork(), light.decoded, light.edges)
                .diagnostics.find("board_not_lit"),
            nullptr);
  Detections other = world.corners(0.01);
  other.image_size = {400, 480};
  EXPECT_THROW(project_board(other, world.board, world.artwork(), light.decoded, light.edges),
               std::invalid_argument);
}

TEST(BoardLight, RepeatsToHundredthsOnRealCaptures) {
  PROCAM_REQUIRE_TEST_DATA("graycode/capture_0");
  std::vector<cv::Mat> images;
  std::vector<ViewU8> captures;
  for (int i = 0; i < 42; ++i) {
    const std::string name =
        "graycode/capture_0/graycode_" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png";
    images.push_back(cv::imread((test::test_data() / name).string(), cv::IMREAD_GRAYSCALE));
    captures.emplace_back(images.back().data, images.back().cols, images.back().rows);
  }
  const pattern::GrayCode gray_code{{1024, 768}, 1};
  const Chessboard board{7, 9, 0.075};
  const DecodedMap decoded = pattern::decode(captures, gray_code);
  const std::vector<StripeEdge> edges = pattern::stripe_edges(captures, decoded, gray_code);
  const Detections corners = detect::detect_chessboard(captures[40], board);
  // Two halves without a common stripe, each with all bits.
  std::vector<StripeEdge> half[2];
  for (const StripeEdge& edge : edges)
    half[(std::lround(edge.projector_coordinate + 0.5) >> 1) & 1].push_back(edge);
  const Detections a = project_board(corners, board, detect::board_artwork(board), decoded, half[0]),
                   b = project_board(corners, board, detect::board_artwork(board), decoded, half[1]);
  ASSERT_EQ(a.observations.size(), 63u);
  ASSERT_EQ(b.observations.size(), 63u);
  double difference = 0, local = 0;
  for (int i = 0; i < 63; ++i) {
    difference +=
        (a.observations[std::size_t(i)].pixel - b.observations[std::size_t(i)].pixel).squaredNorm() / 126;
    local += (a.observations[std::size_t(i)].pixel -
              local_homography(decoded, corners.observations[std::size_t(i)].pixel))
                 .squaredNorm() /
             126;
  }
  EXPECT_LT(std::sqrt(difference), 0.01);
  EXPECT_LT(std::sqrt(local), 0.08);  // the two ways agree to what the local one can do
}

}  // namespace
}  // namespace procam
