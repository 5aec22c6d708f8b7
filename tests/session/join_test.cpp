#include "procam/session/join.hpp"

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
  session::BoardView first{"pose_a", {seen({640, 480}, 12), seen({1024, 768}, 9)}};
  first.detections[1].diagnostics.warn("corners_not_lit", "3 corners");
  const session::BoardView second{"pose_b", {seen({640, 480}, 5), seen({1024, 768}, 0)}};
  const Correspondences joined = session::join(kBoard, kDevices, {first, second});
  ASSERT_EQ(joined.views.size(), 2u);
  EXPECT_EQ(joined.views[0].name, "pose_a");
  EXPECT_EQ(joined.views[0].observations[1].size(), 9u);
  EXPECT_TRUE(joined.views[1].observations[1].empty());
  ASSERT_NE(joined.diagnostics.find("corners_not_lit"), nullptr);
  EXPECT_EQ(joined.diagnostics.find("corners_not_lit")->message, "view 'pose_a', projector: 3 corners");
}

TEST(Join, CarriesLightPointsOfKnownDevices) {
  session::BoardView view{"pose_a", {seen({640, 480}, 12), seen({1024, 768}, 0)}};
  view.light_points.push_back({1, Vec2(311.5, 207.5), 0, Vec2(81.25, 99.5), Mat2::Identity()});
  const Correspondences joined = session::join(kBoard, kDevices, {view});
  ASSERT_EQ(joined.views[0].light_points.size(), 1u);
  EXPECT_EQ(joined.views[0].light_points[0].projector_pixel, Vec2(311.5, 207.5));
  std::swap(view.light_points[0].camera, view.light_points[0].projector);
  EXPECT_THROW(session::join(kBoard, kDevices, {view}), std::invalid_argument);
}

TEST(Join, LeavesOutAViewTheCameraHardlySees) {
  const session::BoardView good{"good", {seen({640, 480}, 12), seen({1024, 768}, 12)}};
  const session::BoardView poor{"poor", {seen({640, 480}, 3), seen({1024, 768}, 3)}};
  const Correspondences joined = session::join(kBoard, kDevices, {poor, good});
  ASSERT_EQ(joined.views.size(), 1u);
  EXPECT_EQ(joined.views[0].name, "good");
  ASSERT_NE(joined.diagnostics.find("view_left_out"), nullptr);
  EXPECT_THROW(session::join(kBoard, kDevices, {poor}), Error);
}

/// "Take it again with the board in full view" is no advice for a view whose images have another size.
TEST(Join, GivesNoSecondCauseForAViewThatHasOne) {
  const session::BoardView good{"good", {seen({640, 480}, 12), seen({1024, 768}, 12)}};
  session::BoardView poor{"poor", {seen({640, 480}, 0), seen({1024, 768}, 0)}};
  const auto remark = [&] {
    return session::join(kBoard, kDevices, {poor, good}).diagnostics.find("view_left_out")->message;
  };
  EXPECT_NE(remark().find("in full view"), std::string::npos) << remark();
  poor.detections[0].diagnostics.warn("image_size_differs", "a.png is rejected");
  const Correspondences joined = session::join(kBoard, kDevices, {poor, good});
  ASSERT_NE(joined.diagnostics.find("view_left_out"), nullptr);
  EXPECT_EQ(joined.diagnostics.find("view_left_out")->message.find("in full view"), std::string::npos)
      << joined.diagnostics.find("view_left_out")->message;
}

TEST(Join, NamesTheViewWhoseImageHasAnotherSize) {
  const session::BoardView view{"turned", {seen({480, 640}, 12), seen({1024, 768}, 12)}};
  try {
    session::join(kBoard, kDevices, {view});
    FAIL() << "a turned image was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(error.subject().find("turned"), std::string::npos);
  }
}

const std::vector<Device> kFleet{{"left", DeviceKind::kCamera, {640, 480}},
                                 {"right", DeviceKind::kCamera, {800, 600}},
                                 {"lamp", DeviceKind::kProjector, {1024, 768}},
                                 {"beamer", DeviceKind::kProjector, {1280, 800}}};

/// Twelve corners, found `off` from their place, and the light there under a map of that projector.
session::Reading reading(int camera, int projector, const Vec2& off, double scale) {
  session::Reading read{camera,
                        projector,
                        {kFleet[std::size_t(camera)].size, {}, {}},
                        {kFleet[std::size_t(projector)].size, {}, {}}};
  for (int i = 0; i < 12; ++i) {
    const Vec2 found = Vec2(100 + 40 * (i % 3), 90 + 35 * (i / 3)) + off;
    read.in_camera.observations.push_back({i, found, 0.01 * Mat2::Identity()});
    read.in_projector.observations.push_back(
        {i, Vec2(300 + scale * found.x() - 0.2 * found.y(), 50 + 0.1 * found.x() + scale * found.y()),
         0.02 * Mat2::Identity()});
  }
  return read;
}

TEST(Combine, TakesACornerThatWasFoundTwiceForOneMeasurement) {
  const session::BoardView view = session::combine(
      "pose", kFleet, {reading(0, 2, Vec2(0.3, -0.1), 1.5), reading(0, 3, Vec2(-0.1, 0.3), 2)});
  ASSERT_EQ(view.detections.size(), 4u);
  ASSERT_EQ(view.detections[0].observations.size(), 12u);
  const Vec2 mean = Vec2(140, 90) + Vec2(0.1, 0.1);
  EXPECT_LT((view.detections[0].observations[1].pixel - mean).norm(), 1e-12);
  EXPECT_NEAR(view.detections[0].observations[1].covariance(0, 0), 0.01, 1e-15);
  // Both projectors' light is that of the mean corner.
  EXPECT_LT((view.detections[2].observations[1].pixel -
             Vec2(300 + 1.5 * mean.x() - 0.2 * mean.y(), 50 + 0.1 * mean.x() + 1.5 * mean.y()))
                .norm(),
            1e-9);
  EXPECT_LT((view.detections[3].observations[1].pixel -
             Vec2(300 + 2 * mean.x() - 0.2 * mean.y(), 50 + 0.1 * mean.x() + 2 * mean.y()))
                .norm(),
            1e-9);
}

TEST(Combine, KeepsApartWhatEachCameraRead) {
  session::Reading beside = reading(1, 2, Vec2(0, 0), 2);
  beside.light_points.push_back({1, Vec2(1, 2), 0, Vec2(3, 4), Mat2::Identity()});
  const session::BoardView view = session::combine("pose", kFleet, {reading(0, 2, Vec2(0, 0), 1.5), beside});
  ASSERT_EQ(view.detections[2].observations.size(), 24u);
  EXPECT_EQ(view.detections[2].observations[0].camera, 0);
  EXPECT_EQ(view.detections[2].observations[12].camera, 1);
  ASSERT_EQ(view.light_points.size(), 1u);
  EXPECT_EQ(view.light_points[0].camera, 1);
  EXPECT_EQ(view.light_points[0].projector, 2);
  EXPECT_TRUE(view.detections[3].observations.empty());
  EXPECT_EQ(view.detections[3].image_size, (ImageSize{1280, 800}));
  EXPECT_THROW(session::combine("pose", kFleet, {reading(2, 3, Vec2(0, 0), 1)}), std::invalid_argument);
  // A view that the first camera does not see counts.
  const Correspondences joined =
      session::join(kBoard, kFleet, {session::combine("pose", kFleet, {reading(1, 2, Vec2(0, 0), 2)})});
  EXPECT_EQ(joined.views.size(), 1u);
}

}  // namespace
}  // namespace procam
