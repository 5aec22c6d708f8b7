// Latency in the ROS 2 graph, on the loopback interface:
//   bench_dds                round trips of a pose through procam, beside those of ddsperf in the same seconds
//   bench_dds PROJECT_LIVE   and a show: 200 poses a second on /tf, depth images of 640 x 480 30 times a second, 60 frames a second
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "dds/image_messages.hpp"
#include "dds/member_process.hpp"
#include "dds/ros2_peer.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::test {
namespace {

constexpr double kSeconds = 4;  // of each measurement
constexpr int kRounds = 9;      // the two take turns: cores and caches of both are the same
// A PoseStamped goes there and a PoseWithCovarianceStamped comes back: bytes of both, in the mean.
constexpr int kBytes = 240;

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[std::size_t(q * double(values.size() - 1))];
}

struct RoundTrip {
  double median_us = 0, p99_us = 0;
};

/// ddsperf states half of a round trip; threads wait as procam's do (a waitset), not in the thread that receives.
std::optional<RoundTrip> ddsperf_round_trip(int domain) {
  const std::string common = "ddsperf -i " + std::to_string(domain) + " -D ";
  const std::string line = "(" + common + std::to_string(kSeconds + 1) +
                           " pong waitset >/dev/null 2>&1 &) ; " + common + std::to_string(kSeconds) +
                           " ping size " + std::to_string(kBytes) + " waitset 2>&1";
  FILE* const pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return std::nullopt;
  std::vector<double> medians, p99s;
  char text[400];
  while (std::fgets(text, sizeof text, pipe) != nullptr) {
    double median = 0, p99 = 0;
    const std::string words = text;
    const std::size_t at = words.find("50% ");
    if (at != words.npos &&
        std::sscanf(words.c_str() + at, "50%% %lfus 90%% %*fus 99%% %lfus", &median, &p99) == 2) {
      medians.push_back(2 * median);
      p99s.push_back(2 * p99);
    }
  }
  ::pclose(pipe);
  if (medians.empty()) return std::nullopt;
  return RoundTrip{quantile(medians, 0.5), quantile(p99s, 0.5)};
}

/// procam in a process of its own: what comes on /ping goes to /procam/pose.
void answer_poses() {
  const auto source = dds::open_pose_source("ros2:/ping");
  dds::ProjectorPublisher publisher("ros2:/procam");
  std::vector<track::StampedPose> arrived;
  for (double idle_since = steady_now(); steady_now() < idle_since + 30;) {
    source->poll(arrived);
    for (const track::StampedPose& pose : arrived) {
      publisher.publish_pose("map", {pose.frame_from_child, Mat6::Identity() * 1e-4}, pose.stamp.value_or(0));
      idle_since = steady_now();
    }
    source->wait(1);
  }
}

RoundTrip procam_round_trip(const LoopbackDomain& domain) {
  const Ros2Peer robot(domain);
  const dds_entity_t ping = robot.writer(geometry_msgs_msg_dds__PoseStamped__desc, "rt/ping");
  const dds_entity_t pong =
      robot.reader(geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, "rt/procam/pose");
  const dds_entity_t waitset = dds_create_waitset(robot.participant());
  dds_set_status_mask(pong, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, pong, 0);
  std::vector<double> times_us;
  char frame[] = "map";
  std::int32_t number = 0;
  for (const double begin = steady_now(); steady_now() < begin + kSeconds;) {
    geometry_msgs_msg_dds__PoseStamped_ message{};
    message.header.stamp.sec = ++number;
    message.header.frame_id = frame;
    message.pose.orientation.w = 1;
    const double sent = steady_now();
    dds_write(ping, &message);
    for (bool is_back = false; !is_back && steady_now() < sent + 0.1;) {
      dds_waitset_wait(waitset, nullptr, 0, DDS_MSECS(100));
      void* samples[1] = {};
      dds_sample_info_t info;
      while (dds_take(pong, samples, &info, 1, 1) > 0) {
        is_back |=
            static_cast<geometry_msgs_msg_dds__PoseWithCovarianceStamped_*>(samples[0])->header.stamp.sec ==
            number;
        dds_return_loan(pong, samples, 1);
      }
      if (is_back && steady_now() > begin + 1) times_us.push_back(1e6 * (steady_now() - sent));
    }
  }
  return {quantile(times_us, 0.5), quantile(times_us, 0.99)};
}

/// Poses and depth images for as long as the show runs; then its numbers.
void drive_show(const LoopbackDomain& domain, const std::string& program, const std::string& folder,
                double fps, bool with_depth) {
  const std::string out = folder + "/live.json";
  const std::string line =
      program + " --rig " + folder + "/rig.json --surfaces " +
      (with_depth ? "depth:ros2:/depth/image" : folder + "/surfaces.json") +
      " --pose-source ros2:map,base_link --control off --json --output none --duration 20s --fps " +
      std::to_string(fps) + (with_depth ? " --content ceiling=#00ff00" : "") + " >" + out + " 2>" + folder +
      "/live.err";
  const Ros2Peer robot(domain);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  const dds_entity_t depth = robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/depth/image");
  const dds_entity_t info = robot.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/depth/camera_info");
  std::thread show([&] { std::system(line.c_str()); });
  std::string map = "map", child = "base_link";
  ImageMessage image = grey_image(0, 0, 640, 480);
  image.encoding = "16UC1";
  image.step = 1280;
  image.data.resize(1280 * 480);
  for (std::size_t i = 0; i < image.data.size(); i += 2)
    image.data[i] = 0xd0, image.data[i + 1] = 0x07;  // 2 m
  const double begin = steady_now();
  double shown = 0;
  for (int k = 0; steady_now() < begin + 24; ++k) {
    const double t = steady_now();
    geometry_msgs_msg_dds__TransformStamped_ one{};
    one.header.stamp = ros_time(t);
    one.header.frame_id = map.data();
    one.child_frame_id = child.data();
    one.transform.translation.x = 0.05 * std::sin(t);
    one.transform.rotation.w = 1;
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._buffer = &one;
    message.transforms._length = message.transforms._maximum = 1;
    dds_write(tf, &message);
    if (with_depth && t > shown + 1 / 30.0) {
      shown = t;
      image.stamp = t;
      write_camera_info(info, 640, 480, 525, 0, {0, 0, 0, 0, 0});
      write_image(depth, image);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(5000) -
                                std::chrono::microseconds(long(1e6 * (steady_now() - t))));
  }
  show.join();
  std::printf("\nshow at %.0f frames a second%s:\n", fps, with_depth ? ", depth at 30 images a second" : "");
  std::fflush(stdout);
  std::system(("cat " + folder + "/live.err; head -c 1500 " + out).c_str());
}

void bench_show(const LoopbackDomain& domain, const std::string& program) {
  char name[] = "/tmp/procam_bench_XXXXXX";
  const std::string folder = ::mkdtemp(name);
  Rig rig;
  RigProjector lamp;
  lamp.name = "lamp";
  lamp.projector.inverse_camera.size = {640, 400};
  lamp.projector.inverse_camera.intrinsics = {820, 796, 331.3, 188.9, 1.7};
  rig.projectors.push_back(lamp);
  RigCamera camera;
  camera.name = "depth";
  camera.camera.size = {640, 480};
  camera.camera.intrinsics = {525, 525, 319.5, 239.5, 0};
  rig.cameras.push_back(camera);
  io::save_rig(folder + "/rig.json", rig);
  PlanarSurface wall;
  wall.frame_from_surface = Pose(Eigen::Quaterniond::Identity(), Vec3(-0.5, -0.3, 2));
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.points = {{0, 0}, {1, 0.02}, {0.99, 0.6}, {-0.02, 0.61}};
  SurfaceSet set;
  set.surfaces = {{"wall", wall, {}, "#00ff00"}};
  io::save_surfaces(folder + "/surfaces.json", set);
  drive_show(domain, program, folder, 1000, false);
  drive_show(domain, program, folder, 60, true);
  std::filesystem::remove_all(folder);
}

int bench(int count, char** arguments) {
  const LoopbackDomain domain;
  const MemberProcess procam(answer_poses);
  std::printf("round trip, us: median and 99 %%, of %d bytes in the mean\n", kBytes);
  for (int round = 0; round < kRounds; ++round) {
    const std::optional<RoundTrip> peer = ddsperf_round_trip(domain.number());
    const RoundTrip own = procam_round_trip(domain);
    std::printf("procam %6.1f %7.1f", own.median_us, own.p99_us);
    if (peer)
      std::printf("   ddsperf %6.1f %7.1f   ratio %.2f %.2f", peer->median_us, peer->p99_us,
                  own.median_us / peer->median_us, own.p99_us / peer->p99_us);
    std::printf("\n");
    std::fflush(stdout);
  }
  if (count > 1) bench_show(domain, arguments[1]);
  return 0;
}

}  // namespace
}  // namespace procam::test

int main(int count, char** arguments) {
  return procam::test::bench(count, arguments);
}
