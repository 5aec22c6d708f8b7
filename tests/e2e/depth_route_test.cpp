/// The running show by depth, as a user starts it: a simulated robot drives and tells its poses by UDP, a
/// depth sensor on it sees the room through OpenNI2's own library (pictures in a folder where procam was
/// built without), somebody walks through, and the frames' light is cast onto the true wall.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>

#include "procam/core/geometry/se3.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/simulate/depth_view.hpp"
#include "procam/track/wire.hpp"
#include "running_tool.hpp"
#include "simulate/rooms.hpp"
#include "support/room_stage.hpp"
#include "support/simulated_sensor.hpp"
#include "support/udp.hpp"

namespace procam::test {
namespace {

using device::now_s;

constexpr double kWallAt = 3.2, kDepthDelay = 0.06, kSeconds = 7;
constexpr double kSilentFrom = 5.2;  ///< when the sensor is unplugged, in the test in which it is

class DepthRoute : public testing::Test {
 protected:
  void SetUp() override {
    using simulate::test::hung;
    room_.bodies.push_back(hung("far", Vec3(0, kWallAt, 1.3), Vec3(0, -1, 0), Vec2(4.4, 2.6), 0.6));
    room_.bodies.push_back(hung("floor", Vec3(0, 1, 0), Vec3(0, 0, 1), Vec2(4.4, 5), 0.6));
    depth_.camera = {
        {320, 240}, {292, 289, 158.6, 121.5, 0.2}, BrownConrady{{0.04, -0.08, 0.001, -0.0006, 0}}};
    RigProjector lamp;
    lamp.name = "lamp";
    lamp.projector.inverse_camera = {{320, 200}, {410, 396, 171.3, 128.9, 1.7}, {}};
    lamp.rig_from_projector = Pose(so3_exp(Vec3(0.03, -0.02, 0.04)), Vec3(0.12, -0.05, 0.11));
    rig_.projectors.push_back(lamp);
    RigCamera eye;
    eye.name = "depth";
    eye.camera = depth_.camera;
    eye.rig_from_camera = Pose(so3_exp(Vec3(0.02, 0.05, -0.03)), Vec3(-0.06, 0.04, 0.02));
    rig_.cameras.push_back(eye);
    io::save_rig(folder_ / "rig.json", rig_);
    io::save_image(folder_ / "quarters.png", quarters());
    begin_ = now_s() + 0.5;
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }

  /// Two metres before the wall, to and fro by 0.1 m and 6 degrees.
  Pose world_from_rig(double time) const {
    const double t = time - begin_;
    return simulate::test::looking_at(Vec3(0.1 * std::sin(0.9 * t), 1.2, 1.25),
                                      Vec3(0.2 * std::sin(0.7 * t + 1), kWallAt, 1.3));
  }
  std::optional<Walker> walker(double time) const {
    const double t = time - begin_ - 3.5;
    if (t < 0) return std::nullopt;
    return Walker{Vec3(-1.7 + 1.1 * t, 2.55, 0)};
  }

  /// Runs the show while robot, sensor and walker do their part.
  std::string run_show(const std::string& more, double silent_from = 1e9) {
    const std::string port = free_udp_port();
#ifdef PROCAM_SIMULATED_OPENNI2
    const SimulatedSensor sensor(folder_ / "sensor");
    sensor.plug();
    const std::string source = "openni2:", variables = sensor.environment();
#else
    fs::create_directory(folder_ / "depth");
    const std::string source = "watch:" + at("depth"), variables;
#endif
    Running show("project-live",
                 "--rig " + at("rig.json") + " --surfaces depth:" + source + " --depth-delay " +
                     std::to_string(int(1e3 * kDepthDelay)) + "ms --content wall_1=" + at("quarters.png") +
                     " --pose-source udp:127.0.0.1:" + port +
                     " --delay 30ms --control off --json --threads 1" + " --fps 15 --output frames:" +
                     at("frames") + " --duration " + std::to_string(kSeconds) + "s " + more,
                 folder_ / "live.json", variables);
    std::atomic<bool> ends{false};
    std::thread robot([&] {
      UdpSender poses(port);
      while (!ends) {
        track::StampedPose pose;
        pose.stamp = now_s();
        pose.frame = "room";
        pose.child = "rig";
        pose.frame_from_child = world_from_rig(*pose.stamp);
        poses.send(track::to_json_line(pose));
        std::this_thread::sleep_for(std::chrono::milliseconds(16));
      }
    });
    for (std::uint64_t i = 1; show.is_running(); ++i) {
      const double exposure = now_s();
      if (exposure > begin_ + silent_from) {
#ifdef PROCAM_SIMULATED_OPENNI2
        sensor.unplug();
#endif
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        continue;
      }
      simulate::Room now = room_;
      if (const auto somebody = walker(exposure))
        for (const simulate::Body& body : somebody->bodies()) now.bodies.push_back(body);
      const Pose world_from_camera = world_from_rig(exposure) * rig_.cameras[0].rig_from_camera;
      const simulate::DepthView view = simulate::depth_view(now, depth_, world_from_camera, i, 1);
      // What comes late says so by its stamp; a folder's pictures have none.
      while (now_s() < exposure + kDepthDelay) std::this_thread::sleep_for(std::chrono::milliseconds(1));
#ifdef PROCAM_SIMULATED_OPENNI2
      Image<std::uint16_t> tenths(view.mm.width(), view.mm.height());
      for (int y = 0; y < tenths.height(); ++y)
        for (int x = 0; x < tenths.width(); ++x)
          tenths.at(x, y) = std::uint16_t(std::lround(1e4f * view.metres.at(x, y)));
      sensor.show(tenths.view(), std::uint64_t(1e6 * (exposure - begin_ + 10)));
#else
      io::save_depth(folder_ / "next.png", view.mm.view());
      fs::rename(folder_ / "next.png", folder_ / "depth" / (std::to_string(i) + ".png"));
#endif
      while (now_s() < exposure + 0.066) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ends = true;
    robot.join();
    const std::string said = slurp(at("live.json.err"));
    EXPECT_EQ(show.wait(), 0) << said;
    return said;
  }

  std::string frame_name(int number) const {
    char name[32];
    std::snprintf(name, sizeof name, "frames/frame_%06d.png", number);
    return at(name);
  }
  /// Of a pixel's light, from the true place of the lamp.
  std::pair<Vec3, Vec3> ray_of(const Vec2& pixel, double time) const {
    const Pose world_from_lamp = world_from_rig(time) * rig_.projectors[0].rig_from_projector;
    const auto ray = rig_.projectors[0].projector.inverse_camera.unproject(pixel);
    return {world_from_lamp.translation, world_from_lamp.rotate(*ray)};
  }

  ScratchFolder folder_;
  simulate::Room room_;
  simulate::DepthSensor depth_;
  Rig rig_;
  double begin_ = 0;
};

TEST_F(DepthRoute, ContentStaysOnTheWallWhileTheRobotDrivesAndSomebodyPasses) {
  const std::string said = run_show("--record " + at("run.log"));
  EXPECT_NE(said.find("sees wall_1"), std::string::npos) << said;
  EXPECT_EQ(said.find("sees wall_2"), std::string::npos) << said;
  std::ifstream log(at("run.log"));
  Points3 hits;
  int lit = 0, dark_after = 0, number = 0;
  for (std::string line; std::getline(log, line);) {
    if (line.rfind("{\"frame\":", 0) != 0 || line.find("\"light\"") == std::string::npos) continue;
    const nlohmann::json told = nlohmann::json::parse(line);
    const auto pixel = middle_of(io::load_image(frame_name(number++)).image);
    if (!pixel) {
      dark_after += lit > 0;
      continue;
    }
    ++lit;
    const auto [origin, along] = ray_of(*pixel, told["light"].get<double>());
    hits.push_back(origin + along * ((kWallAt - origin.y()) / along.y()));
  }
  ASSERT_GT(lit, 30) << said;
  EXPECT_EQ(dark_after, 0) << "its name went away";
  Vec3 mean = Vec3::Zero();
  for (const Vec3& hit : hits) mean += hit / double(hits.size());
  double largest = 0, squares = 0;
  for (const Vec3& hit : hits) {
    largest = std::max(largest, (hit - mean).norm());
    squares += (hit - mean).squaredNorm() / double(hits.size());
  }
  std::printf("%d frames lit, on the wall off by %.2f mm rms, %.2f mm at most\n", lit,
              1e3 * std::sqrt(squares), 1e3 * largest);
  EXPECT_LT(std::sqrt(squares), 0.003);
}

TEST_F(DepthRoute, WhoeverWalksThroughIsKeptOutOfTheLight) {
  const std::string said = run_show("--silhouettes", kSilentFrom);
  EXPECT_NE(said.find("sees wall_1"), std::string::npos) << said;
  // A frame's file is written within some 20 ms of its begin; its light is 30 ms after that.
  const double steady_from_file =
      now_s() -
      std::chrono::duration<double>(fs::file_time_type::clock::now() - fs::file_time_type()).count();
  struct Lit {
    double light = 0;
    ImageU8 frame;
    bool at(int x, int y) const { return frame.at(x, y, 0) + frame.at(x, y, 1) + frame.at(x, y, 2) > 0; }
  };
  std::vector<Lit> frames;
  for (int i = 0; fs::exists(frame_name(i)); ++i) {
    const auto written = fs::last_write_time(frame_name(i)) - fs::file_time_type();
    frames.push_back({std::chrono::duration<double>(written).count() + steady_from_file + 0.01,
                      io::load_image(frame_name(i)).image});
  }
  const auto on_wall = [&](int x, int y, double light) {
    const auto [origin, along] = ray_of(Vec2(x, y), light);
    return Vec2((origin + along * ((kWallAt - origin.y()) / along.y()))(Eigen::Vector2i(0, 2)));
  };
  // Where the content is on the wall: its light before anybody came.
  Vec2 low(9, 9), high(-9, -9);
  for (const Lit& lit : frames)
    for (int y = 0; y < lit.frame.height() && !walker(lit.light); y += 4)
      for (int x = 0; x < lit.frame.width(); x += 4)
        if (lit.at(x, y)) {
          low = low.cwiseMin(on_wall(x, y, lit.light));
          high = high.cwiseMax(on_wall(x, y, lit.light));
        }
  long on_walker = 0, lit_on_walker = 0, beside = 0, lit_beside = 0, after = 0, lit_after = 0;
  for (const Lit& lit : frames) {
    const auto somebody = walker(lit.light);
    if (!somebody) continue;
    const auto before = walker(lit.light - 0.08);
    const bool is_silent = lit.light > begin_ + kSilentFrom + 0.6;
    for (int y = 0; y < lit.frame.height(); y += 4)
      for (int x = 0; x < lit.frame.width(); x += 4) {
        const auto [origin, along] = ray_of(Vec2(x, y), lit.light);
        const double off = somebody->clearance(origin, along);
        // A busy machine may write a file late, so its light may have been earlier.
        const bool is_hit = off < 0 && before && before->clearance(origin, along) < 0;
        const Vec2 hit = on_wall(x, y, lit.light);
        const bool on_content = ((hit - low).array() > 0.05).all() && ((high - hit).array() > 0.05).all();
        if (is_silent) ++after, lit_after += lit.at(x, y);
        if (is_hit) ++on_walker, lit_on_walker += lit.at(x, y);
        // From the silence on it gets dark.
        if (off > 0.7 && on_content && lit.light < begin_ + kSilentFrom) ++beside, lit_beside += lit.at(x, y);
      }
  }
  std::printf("on the walker %ld pixels, %ld lit; of the content beside %.1f %% lit; in silence %ld of %ld\n",
              on_walker, lit_on_walker, 100.0 * double(lit_beside) / double(beside), lit_after, after);
  EXPECT_GT(on_walker, 1000);
  EXPECT_EQ(lit_on_walker, 0);
  EXPECT_GT(beside, 10000);
  EXPECT_GT(double(lit_beside), 0.3 * double(beside));  // a busy machine is late, and late is dark
  EXPECT_NE(said.find("no news of depth"), std::string::npos) << said;
  EXPECT_GT(after, 0);
  EXPECT_EQ(lit_after, 0);
#ifdef PROCAM_SIMULATED_OPENNI2
  EXPECT_NE(said.find("it was unplugged"), std::string::npos) << said;
#endif
}

}  // namespace
}  // namespace procam::test
