#pragma once
/// What the tests of the graph share: an encoder of CDR that is written from its rules, and values about no axis.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <string>
#include <thread>
#include <vector>

#include "procam/core/base/clock.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::test {

inline bool wait_until(const std::function<bool()>& is_done, double seconds = 8) {
  for (const double begin = steady_now(); steady_now() < begin + seconds;) {
    if (is_done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return is_done();
}

/// A source that has found `count` publishers: what is written before may be lost.
inline bool is_connected(const track::PoseSource& source, std::uint64_t count = 1) {
  return wait_until([&] { return source.status().connections >= count; });
}

/// The next `count` poses, or those that came in time.
inline std::vector<track::StampedPose> next_poses(track::PoseSource& source, std::size_t count = 1) {
  std::vector<track::StampedPose> all, arrived;
  wait_until([&] {
    source.poll(arrived);
    all.insert(all.end(), arrived.begin(), arrived.end());
    return all.size() >= count;
  });
  return all;
}

/// A reader that is made when its publisher is found may miss what is written at that moment: writes until a message arrives,
/// and takes all of them.
template <typename Source, typename Write>
bool in_step(Source& source, const Write& write) {
  const bool is = wait_until([&] {
    write();
    return source.next(0.1).has_value();
  });
  while (source.next(0.2)) {
  }
  return is;
}

/// A pose about no axis, different for each k.
inline Pose some_pose(double k) {
  Vec6 xi;
  xi << 0.3 + 0.1 * k, -0.2, 0.5 - 0.05 * k, 1 + k, -2, 0.7 * k;
  return se3_exp(xi);
}

inline void expect_equal(const Pose& a, const Pose& b, double tolerance = 1e-12) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance);
}

/// A covariance without symmetry between its parts; ROS: x, y, z, then rotations about the axes of the frame.
inline Mat6 some_ros_covariance() {
  Mat6 root = Mat6::Zero();
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k <= i; ++k) root(i, k) = 0.01 * (i + 1) + 0.003 * k * (i - 2);
  return root * root.transpose();
}

/// By differences: ROS shifts the child's origin and rotates about it; procam's increment acts on the left.
inline Mat6 left_covariance(const Mat6& ros, const Pose& mean) {
  Mat6 left_from_ros;
  const double h = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const auto increment = [&](double step) {
      Vec6 shift = Vec6::Zero();
      shift[k] = step;
      const Pose moved(so3_exp(Vec3(shift.tail<3>())) * mean.rotation, mean.translation + shift.head<3>());
      return se3_log(Pose(moved * mean.inverse()));
    };
    left_from_ros.col(k) = (increment(h) - increment(-h)) / (2 * h);
  }
  return left_from_ros * ros * left_from_ros.transpose();
}

inline Camera lens_shifted_projector() {
  Camera camera;
  camera.size = {1280, 800};
  camera.intrinsics = {1510.5, 1498.25, 655.75, 905.5, 1.25};  // its cy lies below the image
  camera.distortion = BrownConrady{{-0.1, 0.02, 0.003, -0.004, 0.0005}};
  return camera;
}

/// CDR by its rules (OMG DDSI-RTPS 2.3, 10.2; CORBA 3.0.3, 15.3), little endian unless stated: numbers aligned to their size from the
/// end of the header of four bytes; a text as its length with the zero, and the zero.
class Cdr {
 public:
  explicit Cdr(bool big_endian = false) : big_endian_(big_endian) {
    if (big_endian) bytes_[1] = 0;
  }
  template <typename T>
  Cdr& number(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof value);
    for (std::size_t i = 0; i < sizeof value; ++i)
      bytes_.push_back(std::uint8_t(bits >> (8 * (big_endian_ ? sizeof value - 1 - i : i))));
    return *this;
  }
  Cdr& text(const std::string& value) {
    number(std::uint32_t(value.size() + 1));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    bytes_.push_back(0);
    return *this;
  }
  Cdr& numbers(std::initializer_list<double> values) {
    for (const double value : values) number(value);
    return *this;
  }
  std::vector<std::uint8_t> bytes() const { return bytes_; }

 private:
  bool big_endian_;
  std::vector<std::uint8_t> bytes_ = {0, 1, 0, 0};  // CDR_LE, no options
};

inline Cdr& put(Cdr& cdr, const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return cdr.numbers(
      {pose.translation.x(), pose.translation.y(), pose.translation.z(), q.x(), q.y(), q.z(), q.w()});
}
/// A std_msgs/Header.
inline Cdr& put(Cdr& cdr, int sec, unsigned nanosec, const char* frame) {
  return cdr.number(std::int32_t(sec)).number(std::uint32_t(nanosec)).text(frame);
}
/// A TFMessage of one transform.
inline Cdr transforms(int sec, unsigned nanosec, const char* frame, const char* child, const Pose& pose) {
  Cdr cdr;
  put(cdr.number(std::uint32_t(1)), sec, nanosec, frame).text(child);
  put(cdr, pose);
  return cdr;
}

/// A sensor_msgs/Image all of whose bytes have one value.
inline std::vector<std::uint8_t> image_bytes(int sec, unsigned nanosec, std::uint32_t width,
                                             std::uint32_t height, const std::string& encoding,
                                             std::uint32_t step, int value) {
  Cdr cdr;
  put(cdr, sec, nanosec, "camera").number(height).number(width).text(encoding);
  cdr.number(std::uint8_t(0)).number(step).number(step * height);
  for (std::uint32_t i = 0; i < step * height; ++i) cdr.number(std::uint8_t(value));
  return cdr.bytes();
}

/// sensor_msgs/CameraInfo of lens_shifted_projector().
inline std::vector<std::uint8_t> camera_info_bytes(int sec, unsigned nanosec, const std::string& frame) {
  Cdr cdr;
  cdr.number(std::int32_t(sec)).number(std::uint32_t(nanosec)).text(frame);
  cdr.number(std::uint32_t(800)).number(std::uint32_t(1280)).text("plumb_bob");
  cdr.number(std::uint32_t(5)).numbers({-0.1, 0.02, 0.003, -0.004, 0.0005});
  cdr.numbers({1510.5, 1.25, 655.75, 0, 1498.25, 905.5, 0, 0, 1});
  cdr.numbers({1, 0, 0, 0, 1, 0, 0, 0, 1});
  cdr.numbers({1510.5, 1.25, 655.75, 0, 0, 1498.25, 905.5, 0, 0, 0, 1, 0});
  for (int i = 0; i < 6; ++i) cdr.number(std::uint32_t(0));
  cdr.number(std::uint8_t(0));
  return cdr.bytes();
}

/// Lines and a text, and the MarkerArray of them at 2.5 s.
inline std::vector<dds::GraphMarker> some_markers() {
  return {{"procam/lamp", "frustum", {{0, 0, 0}, {0.5, -0.25, 1}}, "", 0.01, {1, 0.5f, 0.25f, 1}},
          {"map", "words", {{1, 2, 3}}, "95 %", 0.125, {0, 1, 0, 0.5f}}};
}
/// visualization_msgs/Marker of Humble and later, member by member.
inline Cdr& put_marker(Cdr& cdr, const char* frame, const char* ns, std::int32_t type, std::int32_t action,
                       std::initializer_list<double> position, std::initializer_list<double> scale,
                       std::array<float, 4> color, const std::vector<Vec3>& points, const char* text) {
  cdr.number(std::int32_t(2)).number(std::uint32_t(500000000)).text(frame).text(ns);
  cdr.number(std::int32_t(0)).number(type).number(action);
  cdr.numbers(position).numbers({0, 0, 0, 1}).numbers(scale);
  for (const float value : color) cdr.number(value);
  cdr.number(std::int32_t(0)).number(std::uint32_t(0)).number(std::uint8_t(action == 0 ? 1 : 0));
  cdr.number(std::uint32_t(points.size()));
  for (const Vec3& p : points) cdr.numbers({p.x(), p.y(), p.z()});
  cdr.number(std::uint32_t(0)).text("");  // colors, texture_resource
  cdr.number(std::int32_t(0)).number(std::uint32_t(0)).text("").text("").number(std::uint32_t(0));  // texture
  cdr.number(std::uint32_t(0)).text(text).text("").text("").number(std::uint32_t(0)).number(std::uint8_t(0));
  return cdr;
}

inline std::vector<std::uint8_t> marker_bytes() {
  Cdr cdr;
  cdr.number(std::uint32_t(3));
  put_marker(cdr, "", "", 0, 3, {0, 0, 0}, {0, 0, 0}, {0, 0, 0, 0}, {}, "");
  put_marker(cdr, "procam/lamp", "frustum", 5, 0, {0, 0, 0}, {0.01, 0, 0}, {1, 0.5f, 0.25f, 1},
             some_markers().front().lines, "");
  put_marker(cdr, "map", "words", 9, 0, {1, 2, 3}, {0, 0, 0.125}, {0, 1, 0, 0.5f}, {}, "95 %");
  return cdr.bytes();
}

/// A state of a device, and the DiagnosticArray of it at 2.5 s.
inline dds::DeviceHealth some_health() {
  return {"procam: lamp", dds::HealthLevel::kWarning, "faults: depth 2", {{"frames", "61"}, {"a", ""}}};
}
inline std::vector<std::uint8_t> health_bytes() {
  Cdr cdr;
  put(cdr, 2, 500000000, "").number(std::uint32_t(1)).number(std::uint8_t(1));
  cdr.text("procam: lamp").text("faults: depth 2").text("");
  cdr.number(std::uint32_t(2)).text("frames").text("61").text("a").text("");
  return cdr.bytes();
}

}  // namespace procam::test
