/// Sessions of printed and projected boards: is each light point where the light falls?
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <map>

#include "procam/detect/board_artwork.hpp"
#include "procam/session/reader.hpp"
#include "procam/simulate/session.hpp"

namespace procam::test {
namespace {

struct LightCase {
  simulate::Level level;
  const char* name;
  const char* pattern;
  std::size_t views, min_points;  ///< of light, all views together
};

class LightPoints : public ::testing::TestWithParam<LightCase> {};

/// Squared errors in units of their covariance, a point counting 2 degrees of freedom.
struct Errors {
  double squares = 0, scores = 0;
  int count = 0;

  void add(const Vec2& error, const Mat2& covariance) {
    squares += error.squaredNorm();
    scores += error.dot(covariance.inverse() * error);
    ++count;
  }
  double rms() const { return std::sqrt(squares / (2 * count)); }
  double mean_score() const { return scores / (2 * count); }
};

TEST_P(LightPoints, LieWhereTheLightFalls) {
  const LightCase& which = GetParam();
  const auto pattern = session::make_pattern(which.pattern, simulate::projector_size(which.level));
  // Light of which a part is enough stands beside a print of which a part is enough.
  const Board charuco = CharucoBoard{6, 5, 0.06, 0.045, MarkerDictionary::k4x4_50};
  std::optional<simulate::BoardPrint> sheet;
  if (std::string(which.pattern).rfind("chessboard", 0) != 0)
    sheet = simulate::BoardPrint{charuco, detect::board_artwork(charuco)};
  const simulate::SimulatedSession session =
      simulate::make_session(which.level, 4, pattern->on_blank_paper(), sheet, simulate::plain_conditions());
  ASSERT_EQ(session.views.size(), 18u);
  const std::vector<ImageU8> frames = pattern->frames();
  Errors light, print;
  std::size_t points = 0, corners = 0, corners_seen = 0;
  for (std::size_t v = 0; v < which.views; ++v) {
    const std::vector<ImageU8> images = simulate::capture_view(session, v, frames);
    const session::BoardView view =
        pattern->read("view", {images.begin(), images.end()}, session.board().layout);
    points += view.light_points.size();
    for (const LightPoint& point : view.light_points) {
      const auto truth = simulate::camera_pixel_of_light(session.views[v], point.projector_pixel);
      ASSERT_TRUE(truth);
      light.add(point.camera_pixel - *truth, point.camera_covariance);
    }
    std::map<int, Vec2> printed;
    for (const Observation& corner : simulate::board_in_camera(session.views[v]))
      printed[corner.point] = corner.pixel;
    corners_seen += printed.size();
    corners += view.detections[session::kCameraDevice].observations.size();
    for (const Observation& corner : view.detections[session::kCameraDevice].observations)
      print.add(corner.pixel - printed.at(corner.point), corner.covariance);
  }
  std::printf(
      "%s: light points %zu, rms %.3f px, score %.2f; printed points %zu of %zu, rms %.3f px, score %.2f\n",
      which.name, points, light.rms(), light.mean_score(), corners, corners_seen, print.rms(),
      print.mean_score());
  EXPECT_GE(points, which.min_points);
  EXPECT_GE(double(corners), 0.8 * double(corners_seen));
  EXPECT_LT(light.rms(), 0.1);
  EXPECT_LT(light.mean_score(), 2);
  EXPECT_LT(print.mean_score(), 2);
}

// Of 108 corners 97 %; of 280 corners of markers and 140 of squares, of which a part falls beside paper or
// image, less; of 77 discs all.
INSTANTIATE_TEST_SUITE_P(
    Patterns, LightPoints,
    ::testing::Values(LightCase{simulate::Level::kEasy, "EasyChessboard", "chessboard", 3, 314},
                      LightCase{simulate::Level::kPaper, "PaperChessboard", "chessboard", 3, 314},
                      LightCase{simulate::Level::kHard, "HardChessboard", "chessboard", 3, 314},
                      LightCase{simulate::Level::kHard, "HardChessboardInColour", "chessboard:colour", 2,
                                205},
                      LightCase{simulate::Level::kHard, "HardCharuco", "charuco", 2, 200},
                      LightCase{simulate::Level::kPaper, "PaperMarkers", "markers", 2, 400},
                      LightCase{simulate::Level::kHard, "HardCircles", "circles", 2, 150}),
    [](const auto& which) { return std::string(which.param.name); });

}  // namespace
}  // namespace procam::test
