#pragma once
/// A lopsided rig before a wall, with pictures on it, and a sink that keeps what it is shown.
#include <mutex>
#include <utility>

#include "procam/device/frame_sink.hpp"
#include "procam/show/projection.hpp"
#include "support/lopsided.hpp"

namespace procam::show {

inline Rig small_rig() {
  Rig rig;
  RigProjector projector;
  projector.name = "wall_lamp";
  projector.projector.inverse_camera.intrinsics = {410.0, 396.0, 171.3, 148.9, 1.7};
  projector.projector.inverse_camera.size = {320, 200};
  projector.rig_from_projector = Pose(so3_exp(Vec3(0.03, -0.07, 0.11)), Vec3(0.12, -0.05, 0.21));
  rig.projectors.push_back(projector);
  return rig;
}

/// Optical axis along the world's z, more or less; the wall stands askew two metres ahead.
inline Surface wall(const std::string& name, const Vec2& at) {
  PlanarSurface plane;
  plane.frame = "world";
  plane.frame_from_surface = Pose(so3_exp(Vec3(0.1, 0.45, -0.07)), Vec3(at.x(), at.y(), 2.1));
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {{0, 0}, {0.71, 0.02}, {0.68, 0.42}, {-0.03, 0.4}};
  return {name, plane, {}, name + ".png"};
}

inline Surface pixel_area(const std::string& name) {
  PixelSurface pixels;
  pixels.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  pixels.pixels = {{20, 110}, {120, 101}, {131, 170}, {15, 185}};
  return {name, pixels, {}, name + ".png"};
}

/// Different everywhere, so that no two placements look alike.
inline ImageU8 colourful(int width, int height, int seed) {
  ImageU8 picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      picture.at(x, y, 0) = std::uint8_t(40 + (x * 13 + seed * 50) % 200);
      picture.at(x, y, 1) = std::uint8_t(40 + (y * 17 + seed * 90) % 200);
      picture.at(x, y, 2) = std::uint8_t(60 + (x * y + seed) % 150);
    }
  return picture;
}

inline Show small_show() {
  Show show;
  show.surfaces.surfaces = {wall("left", {-0.75, -0.3}), wall("right", {0.05, -0.2}), pixel_area("sign")};
  for (int i = 0; i < 3; ++i) show.contents.push_back(device::still_content(colourful(61, 47, i)));
  return show;
}

/// A message that says where the rig is; stamped by the clock that it arrives by.
inline track::StampedPose message(double time, const Pose& world_from_rig) {
  track::StampedPose pose;
  pose.stamp = time;
  pose.arrival = time;
  pose.frame = "world";
  pose.child = "rig";
  pose.frame_from_child = world_from_rig;
  return pose;
}

class KeptFrames : public device::FrameSink {
 public:
  explicit KeptFrames(ImageSize size) : size_(size) {}
  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_ = ImageU8(picture.size(), picture.channels);
    for (int y = 0; y < picture.height; ++y)
      std::copy(picture.row(y), picture.row(y) + picture.width * picture.channels, last_.row(y));
    ++count_;
    return device::now_s();
  }
  device::WindowEvent poll() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(wish_, device::WindowEvent::kNone);
  }
  void wish(device::WindowEvent wish) {
    const std::lock_guard<std::mutex> lock(mutex_);
    wish_ = wish;
  }
  ImageU8 last() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_;
  }
  int count() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return count_;
  }

 private:
  ImageSize size_;
  std::mutex mutex_;
  ImageU8 last_;
  device::WindowEvent wish_ = device::WindowEvent::kNone;
  int count_ = 0;
};

}  // namespace procam::show
