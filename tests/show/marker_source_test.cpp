/// A marker in the camera's frames is a stream of poses.
#include "marker_source.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <thread>

#include "procam/detect/marker_edges.hpp"
#include "procam/simulate/marker_view.hpp"
#include "support/lopsided.hpp"

namespace procam::show {
namespace {

/// Hands out what it was given, then a camera's end.
class FramesAtHand : public device::FrameSource {
 public:
  std::deque<ImageU8> frames;
  std::optional<device::SeenFrame> next(double after_s, double) override {
    // One at a time: the source passes over what has arrived meanwhile.
    if (pause_ = !pause_; !pause_) return std::nullopt;
    if (frames.empty()) throw Error(ErrorKind::kDevice, "camera", "it is gone", "plug it in");
    device::SeenFrame frame{std::move(frames.front()), after_s + 1};
    frames.pop_front();
    return frame;
  }

 private:
  bool pause_ = false;
};

TEST(MarkerSource, PlacesTheRig) {
  RigCamera camera;
  camera.camera.size = {640, 480};
  camera.camera.intrinsics = {720, 705, 331, 228, 1.1};
  camera.rig_from_camera = test::lopsided_pose();
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  PlacedMarker marker;
  marker.id = 3;
  marker.size = 0.3;
  map.markers = {marker};
  const MarkerCells cells = detect::marker_cells(map.dictionary);

  auto frames = std::make_unique<FramesAtHand>();
  std::vector<Pose> truth;
  for (int i = 0; i < 4; ++i) {
    const Pose camera_from_world(so3_exp(Vec3(0.4, -0.5 + 0.1 * i, 0.1)), Vec3(0.05 * i, -0.03, 1.3));
    simulate::MarkerViewOptions options;
    options.seed = std::uint64_t(i);
    frames->frames.push_back(
        simulate::marker_view(camera.camera, camera_from_world, map.markers, cells, options));
    truth.push_back((camera.rig_from_camera * camera_from_world).inverse());
  }
  frames->frames.insert(frames->frames.begin() + 2, ImageU8(640, 480, 1, 90));  // nothing to see
  frames->frames.push_back(ImageU8(320, 240, 1, 90));                           // of another mode
  MarkerSource source(std::move(frames), camera, map, cells);
  std::vector<track::StampedPose> all, arrived;
  for (int i = 0; i < 1000 && source.status().connected; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    source.poll(arrived);
    all.insert(all.end(), arrived.begin(), arrived.end());
  }
  source.poll(arrived);
  all.insert(all.end(), arrived.begin(), arrived.end());
  ASSERT_EQ(all.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(all[i].frame, "world");
    EXPECT_EQ(all[i].child, "rig");
    ASSERT_TRUE(all[i].covariance);
    const Vec6 off = se3_log(Pose(truth[i] * all[i].frame_from_child.inverse()));
    // Chi-square of 6: below 30 but for 1 pose of 25 000; four are looked at, with fixed seeds.
    EXPECT_LT(off.dot(all[i].covariance->ldlt().solve(off)), 30) << i;
    EXPECT_LT(off.tail<3>().norm(), 0.05);
  }
  const track::SourceStatus status = source.status();
  EXPECT_FALSE(status.connected);
  EXPECT_EQ(status.messages, 4u);
  EXPECT_EQ(status.malformed, 3u) << "one empty, one of another size, the camera's end";
  EXPECT_NE(status.last_error.find("gone"), std::string::npos);
}

/// A camera that fails as its driver likes, then ends; frames come again when it was opened anew.
class FailingCamera : public device::FrameSource {
 public:
  explicit FailingCamera(bool works) : works_(works) {}
  std::optional<device::SeenFrame> next(double after_s, double) override {
    if (!works_ && calls_++ == 0) throw std::length_error("a driver's own exception");
    if (!works_) throw Error(ErrorKind::kDevice, "camera", "it is gone", "plug it in");
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (calls_++ % 2 == 0) return std::nullopt;
    return device::SeenFrame{ImageU8(32, 24, 1, 90), after_s + 1};
  }

 private:
  const bool works_;
  int calls_ = 0;
};

TEST(MarkerSource, ACameraThatIsGoneIsOpenedAgain) {
  RigCamera camera;
  camera.camera = {{32, 24}, {30, 29, 15, 12, 0.1}, {}};
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{3, 0.3, Pose()}};
  int opened = 0;
  MarkerSource source(std::make_unique<FailingCamera>(false), camera, map,
                      detect::marker_cells(map.dictionary),
                      [&opened]() -> std::unique_ptr<device::FrameSource> {
                        if (++opened == 1) throw Error(ErrorKind::kDevice, "camera", "it is away", "wait");
                        return std::make_unique<FailingCamera>(true);
                      });
  const auto wait_for = [&](const auto& holds) {
    for (int i = 0; i < 2000 && !holds(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return holds();
  };
  EXPECT_TRUE(wait_for([&] { return !source.status().connected; }));
  EXPECT_TRUE(wait_for([&] { return source.status().connected && source.status().malformed > 5; }))
      << source.status().last_error;
  EXPECT_EQ(opened, 2);
}

}  // namespace
}  // namespace procam::show
