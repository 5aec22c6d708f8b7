#include "procam/match/join.hpp"

#include <gtest/gtest.h>

namespace procam {
namespace {

const Chessboard kBoard{3, 4, 0.04};
const std::vector<Device> kDevices{{"camera", DeviceKind::kCamera, {640, 480}},
                                   {"projector", DeviceKind::kProjector, {1024, 768}}};

Detections seen(const ImageSize& size, int points) {
  Detections detections;
  detections.image_size = size;
  for (int i = 0; i < points; ++i)
    detections.observations.push_back({i, Vec2(10 + 3 * i, 20 - i), Mat2::Identity()});
  return detections;
}

TEST(Join, KeepsViewsInOrderWithWhatEachDeviceSaw) {
  match::BoardView first{"pose_a", {seen({640, 480}, 12), seen({1024, 768}, 9)}};
  first.detections[1].diagnostics.warn("corners_not_lit", "3 corners");
  const match::BoardView second{"pose_b", {seen({640, 480}, 5), seen({1024, 768}, 0)}};
  const Correspondences joined = match::join(kBoard, kDevices, {first, second});
  ASSERT_EQ(joined.views.size(), 2u);
  EXPECT_EQ(joined.views[0].name, "pose_a");
  EXPECT_EQ(joined.views[0].observations[1].size(), 9u);
  EXPECT_TRUE(joined.views[1].observations[1].empty());
  ASSERT_NE(joined.diagnostics.find("corners_not_lit"), nullptr);
  EXPECT_EQ(joined.diagnostics.find("corners_not_lit")->message, "view 'pose_a', projector: 3 corners");
}

TEST(Join, CarriesLightPointsOfKnownDevices) {
  match::BoardView view{"pose_a", {seen({640, 480}, 12), seen({1024, 768}, 0)}};
  view.light_points.push_back({1, Vec2(311.5, 207.5), 0, Vec2(81.25, 99.5), Mat2::Identity()});
  const Correspondences joined = match::join(kBoard, kDevices, {view});
  ASSERT_EQ(joined.views[0].light_points.size(), 1u);
  EXPECT_EQ(joined.views[0].light_points[0].projector_pixel, Vec2(311.5, 207.5));
  std::swap(view.light_points[0].camera, view.light_points[0].projector);
  EXPECT_THROW(match::join(kBoard, kDevices, {view}), std::invalid_argument);
}

TEST(Join, LeavesOutAViewTheCameraHardlySees) {
  const match::BoardView good{"good", {seen({640, 480}, 12), seen({1024, 768}, 12)}};
  const match::BoardView poor{"poor", {seen({640, 480}, 3), seen({1024, 768}, 3)}};
  const Correspondences joined = match::join(kBoard, kDevices, {poor, good});
  ASSERT_EQ(joined.views.size(), 1u);
  EXPECT_EQ(joined.views[0].name, "good");
  ASSERT_NE(joined.diagnostics.find("view_left_out"), nullptr);
  EXPECT_THROW(match::join(kBoard, kDevices, {poor}), Error);
}

TEST(Join, NamesTheViewWhoseImageHasAnotherSize) {
  const match::BoardView view{"turned", {seen({480, 640}, 12), seen({1024, 768}, 12)}};
  try {
    match::join(kBoard, kDevices, {view});
    FAIL() << "a turned image was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(error.subject().find("turned"), std::string::npos);
  }
}

}  // namespace
}  // namespace procam
