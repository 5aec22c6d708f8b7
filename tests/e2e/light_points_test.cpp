/// Sessions of printed and projected chessboards: is each light point where the light falls?
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdio>

#include "common/session_reader.hpp"
#include "procam/simulate/session.hpp"

namespace procam::test {
namespace {

class LightPoints : public ::testing::TestWithParam<simulate::Level> {};

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
  const auto pattern = tools::make_pattern("chessboard", simulate::projector_size(GetParam()));
  const simulate::Session session = simulate::make_session(GetParam(), 4, pattern->on_blank_paper());
  ASSERT_EQ(session.views.size(), 18u);
  const std::vector<ImageU8> frames = pattern->frames();
  Errors light, print;
  std::size_t points = 0, corners = 0;
  constexpr std::size_t kViews = 3;
  for (std::size_t v = 0; v < kViews; ++v) {
    const std::vector<ImageU8> images = simulate::capture_view(session, v, frames);
    const match::BoardView view =
        pattern->read("view", {images.begin(), images.end()}, session.board().layout);
    points += view.light_points.size();
    for (const LightPoint& point : view.light_points) {
      const auto truth = simulate::camera_pixel_of_light(session.views[v], point.projector_pixel);
      ASSERT_TRUE(truth);
      light.add(point.camera_pixel - *truth, point.camera_covariance);
    }
    const std::vector<Observation> truth = simulate::board_in_camera(session.views[v]);
    corners += view.detections[tools::kCameraDevice].observations.size();
    for (const Observation& corner : view.detections[tools::kCameraDevice].observations)
      print.add(corner.pixel - truth[std::size_t(corner.point)].pixel, corner.covariance);
  }
  std::printf("%s: light points %zu, rms %.3f px, score %.2f; printed corners %zu, rms %.3f px, score %.2f\n",
              simulate::to_string(GetParam()), points, light.rms(), light.mean_score(), corners, print.rms(),
              print.mean_score());
  EXPECT_GE(points, 0.97 * 108 * kViews);
  EXPECT_GE(corners, 0.85 * double(points_in_board(session.board().layout).size()) * kViews);
  EXPECT_LT(light.rms(), 0.1);
  EXPECT_LT(light.mean_score(), 2);
  EXPECT_LT(print.mean_score(), 2);
}

INSTANTIATE_TEST_SUITE_P(Levels, LightPoints,
                         ::testing::Values(simulate::Level::kEasy, simulate::Level::kPaper,
                                           simulate::Level::kHard),
                         [](const auto& level) { return std::string(simulate::to_string(level.param)); });

}  // namespace
}  // namespace procam::test
