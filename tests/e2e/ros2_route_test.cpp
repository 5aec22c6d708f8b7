// A show in the ROS 2 graph as a user starts it: poses of /tf in, CameraInfo and static frames out, by real DDS traffic on
// the loopback interface. The robot is a DDS domain of this process.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "capture_stage.hpp"
#include "dds/graph_values.hpp"
#include "dds/image_messages.hpp"
#include "dds/log_files.hpp"
#include "dds/ros2_peer.hpp"
#include "lamp_show.hpp"
#ifdef PROCAM_TEST_KEYSTORE
#include "dds/keystore.hpp"
#include "procam/dds/security.hpp"
#include "security.hpp"
#endif
#include "procam/core/base/clock.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/io/image/images.hpp"
#include "procam/simulate/depth_view.hpp"
#include "procam/simulate/marker_view.hpp"
#include "running_tool.hpp"
#include "show_page.hpp"
#include "support/udp.hpp"

namespace procam::test {
namespace {

class Ros2Route : public LampShow {
 protected:
  void SetUp() override {
    SurfaceSet set;
    for (int i = 0; i < 4; ++i) set.surfaces.push_back(wall_around(i, "#ffffff"));
    save("surfaces.json", set);
  }
};

/// What publishes one transform as often as it is called.
class Sender {
 public:
  Sender(dds_entity_t writer, std::string frame, std::string child)
      : writer_(writer), frame_(std::move(frame)), child_(std::move(child)) {}
  void send(double stamp, double yaw, double x = 0) {
    geometry_msgs_msg_dds__TransformStamped_ one{};
    one.header.stamp = {std::int32_t(std::floor(stamp)), std::uint32_t(1e9 * (stamp - std::floor(stamp)))};
    one.header.frame_id = frame_.data();
    one.child_frame_id = child_.data();
    one.transform.translation = {x, 0, 0};
    one.transform.rotation = {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)};
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._buffer = &one;
    message.transforms._length = message.transforms._maximum = 1;
    EXPECT_EQ(dds_write(writer_, &message), DDS_RETCODE_OK);
  }

 private:
  dds_entity_t writer_;
  std::string frame_, child_;
};

/// Calls visit(message) for all that a reader has.
template <typename Message, typename Visit>
void for_each(dds_entity_t reader, Visit visit) {
  for (;;) {
    void* samples[1] = {};
    dds_sample_info_t info;
    if (dds_take(reader, samples, &info, 1, 1) < 1) return;
    if (info.valid_data) visit(*static_cast<const Message*>(samples[0]));
    dds_return_loan(reader, samples, 1);
  }
}

/// Each image is one of the frames of the folder, bit for bit; some are lit.
void expect_frames_as_images(dds_entity_t reader, const std::string& folder) {
  std::set<std::string> shown;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    const ImageU8 frame = io::load_image(file.path().string()).image;
    shown.emplace(frame.data(), frame.data() + std::ptrdiff_t(frame.width()) * frame.height() * 3);
  }
  int count = 0, lit = 0;
  for_each<sensor_msgs_msg_dds__Image_>(reader, [&](const auto& message) {
    ++count;
    EXPECT_EQ(message.width, 320u);
    EXPECT_EQ(message.step, 960u);
    EXPECT_STREQ(message.encoding, "rgb8");
    EXPECT_STREQ(message.header.frame_id, "procam/lamp");
    EXPECT_NEAR(message.header.stamp.sec, std::time(nullptr), 60);
    const std::string pixels(message.data._buffer, message.data._buffer + message.data._length);
    EXPECT_EQ(shown.count(pixels), 1u) << count;
    lit += pixels.find_first_not_of('\0') != pixels.npos ? 1 : 0;
  });
  EXPECT_GE(count, 5) << "five a second, for three seconds";
  EXPECT_LE(count, 17);
  EXPECT_GT(lit, 0);
}

TEST_F(Ros2Route, AShowFollowsTheRobotAndTellsTheGraphOfItsProjector) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  Sender odom(robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf"), "odom", "base_link");
  Sender map(robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true, true), "map", "odom");
  map.send(0, 0.25);
  const Ros2Peer viewer(domain);
  const dds_entity_t frames = viewer.reader(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true, true);
  const dds_entity_t info =
      viewer.reader(sensor_msgs_msg_dds__CameraInfo__desc, "rt/procam/lamp/camera_info", false);
  const dds_entity_t drawn =
      viewer.reader(visualization_msgs_msg_dds__MarkerArray__desc, "rt/procam/markers", true, true);
  const dds_entity_t health = viewer.reader(diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics");
  const dds_entity_t images = viewer.reader(sensor_msgs_msg_dds__Image__desc, "rt/procam/lamp/image", false);
  Running show("project-live",
               this->show() + "--control off --json --pose-source ros2:map,base_link --publish ros2:/procam" +
                   " --output frames:" + at("frames") + " --fps 20 --duration 3s --blank-on-stale 500ms",
               folder_ / "live.json");
  const double begin = steady_now();
  while (show.is_running() && steady_now() < begin + 20) {
    const double t = steady_now() - begin;
    odom.send(1.7e9 + t, 0.1 * std::sin(t), 0.05 * t);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_EQ(show.wait(), 0) << slurp(at("live.json.err"));
  const std::string said = slurp(at("live.json.err"));
  EXPECT_NE(said.find("ROS 2 domain " + std::to_string(domain.number()) + ", network lo (127.0.0.1)"),
            std::string::npos)
      << said;
  EXPECT_NE(
      said.find("publishes /procam/lamp/camera_info, /procam/lamp/image, /tf_static, /procam/markers, "),
      std::string::npos)
      << said;
  const nlohmann::json live = nlohmann::json::parse(slurp(at("live.json")));
  EXPECT_GT(live["poses"]["taken"].get<double>(), 40) << live;
  EXPECT_EQ(live["poses"]["malformed"], 0);
  EXPECT_FALSE(live.contains("faults")) << live.dump();
  // What the graph was told: the tree of frames, with the surfaces where the file places them.
  std::map<std::string, std::string> parents;
  for_each<tf2_msgs_msg_dds__TFMessage_>(frames, [&](const auto& message) {
    for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
      const geometry_msgs_msg_dds__TransformStamped_& one = message.transforms._buffer[i];
      parents[one.child_frame_id] = one.header.frame_id;
      if (std::string(one.child_frame_id) == "procam/lamp") {
        const auto& t = one.transform.translation;
        EXPECT_EQ(Vec3(t.x, t.y, t.z), Vec3(0.2, 0.03, 0.9));
      }
      if (std::string(one.child_frame_id) == "procam/surfaces/wall 1") {
        const auto& t = one.transform.translation;
        const Vec3 expected =
            std::get<PlanarSurface>(wall_around(1, "").geometry).frame_from_surface.translation;
        EXPECT_LT((Vec3(t.x, t.y, t.z) - expected).norm(), 1e-6);
      }
    }
  });
  const std::map<std::string, std::string> expected = {{"odom", "map"},
                                                       {"procam/rig", "base_link"},
                                                       {"procam/lamp", "procam/rig"},
                                                       {"procam/surfaces/wall 0", "map"},
                                                       {"procam/surfaces/wall 1", "map"},
                                                       {"procam/surfaces/wall 2", "map"},
                                                       {"procam/surfaces/wall 3", "map"}};
  EXPECT_EQ(parents, expected);
  int infos = 0;
  for_each<sensor_msgs_msg_dds__CameraInfo_>(info, [&](const auto& message) {
    ++infos;
    EXPECT_EQ(message.width, 320u);
    EXPECT_EQ(message.k[0], 410.0);
    EXPECT_STREQ(message.header.frame_id, "procam/lamp");
  });
  EXPECT_GE(infos, 2);
  std::set<std::string> names;
  for_each<visualization_msgs_msg_dds__MarkerArray_>(drawn, [&](const auto& message) {
    ASSERT_GT(message.markers._length, 0u);
    EXPECT_EQ(message.markers._buffer[0].action, 3) << "what was there before goes";
    names.clear();
    for (std::uint32_t i = 1; i < message.markers._length; ++i) names.insert(message.markers._buffer[i].ns);
  });
  for (const char* name : {"frustum", "surface wall 0", "surface wall 1", "surface wall 2", "surface wall 3",
                           "error wall 0", "error in mm wall 0"})
    EXPECT_EQ(names.count(name), 1u) << name;
  EXPECT_EQ(names.count("error wall 2"), 0u) << "it is behind the projector";
  bool is_healthy = false;  // once: a machine under load may be late at other times
  for_each<diagnostic_msgs_msg_dds__DiagnosticArray_>(health, [&](const auto& message) {
    ASSERT_EQ(message.status._length, 1u);
    EXPECT_STREQ(message.status._buffer[0].name, "procam: lamp");
    is_healthy |= message.status._buffer[0].level == 0 &&
                  std::string(message.status._buffer[0].message) == "projecting";
  });
  EXPECT_TRUE(is_healthy);
  expect_frames_as_images(images, at("frames"));
  // A frame near the end is lit. A machine under load leaves numbers out.
  std::string name;
  for (const auto& file : std::filesystem::directory_iterator(at("frames")))
    if (file.path().filename() <= "frame_000050.png") name = std::max(name, file.path().string());
  ASSERT_NE(name, "");
  const ImageU8 last = io::load_image(name).image;
  const std::uint8_t* end = last.data() + std::ptrdiff_t(last.width()) * last.height() * 3;
  EXPECT_TRUE(std::any_of(last.data(), end, [](std::uint8_t v) { return v > 0; }));
}

/// A robot that loses one packet of twenty, is killed and started again, beside one that sends garbage: no frame is drawn for
/// a stale pose, everything is counted, and memory stays. PROCAM_GRAPH_MINUTES sets how long, 1/3 without.
TEST_F(Ros2Route, LossRestartsAndGarbageLeaveNoStaleFrameAndNoMemory) {
  const LoopbackDomain domain;
  const char* const minutes = std::getenv("PROCAM_GRAPH_MINUTES");
  const double duration = 60 * (minutes == nullptr ? 1 / 3.0 : std::stod(minutes));
  const Page page(free_udp_port());
  Running live("project-live",
               show() +
                   "--output none --json --fps 30 --blank-on-stale 300ms --pose-source ros2:map,base_link "
                   "--publish ros2:/procam" +
                   page.flags(),
               folder_ / "live.json", "MALLOC_MMAP_THRESHOLD_=131072");
  ASSERT_TRUE(becomes_true([&] { return page.status().is_object(); })) << slurp(at("live.json.err"));
  const Ros2Peer forger(domain);
  dds_topic_descriptor_t forged = nav_msgs_msg_dds__Odometry__desc;
  forged.m_typename = tf2_msgs_msg_dds__TFMessage__desc.m_typename;
  const dds_entity_t garbage = forger.writer(forged, "rt/tf");
  char text[] = "\xff\xfe";
  nav_msgs_msg_dds__Odometry_ wrong{};
  wrong.header.frame_id = wrong.child_frame_id = text;
  int starts = 0, sent = 0;
  double memory = 0;  // when all has happened a few times
  const double begin = steady_now();
  while (steady_now() < begin + duration) {
    const auto robot = std::make_unique<Ros2Peer>(domain, 50);
    Sender tf(robot->writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf"), "map", "base_link");
    ++starts;
    for (const double start = steady_now(); steady_now() < start + 3;) {
      const double t = steady_now();
      tf.send(t, 0.1 * std::sin(t), 0.05 * std::sin(t));
      wrong.header.stamp.sec = std::int32_t(t);
      dds_write(garbage, &wrong);
      ++sent;
      std::this_thread::sleep_for(std::chrono::milliseconds(15));
    }
    EXPECT_TRUE(becomes_true([&] {
      tf.send(steady_now(), 0);
      return page.status()["pose_state"] == "fresh";
    })) << starts;
    if (memory == 0 && steady_now() > begin + duration / 4) memory = live.memory();
  }
  const double grown = (live.memory() - memory) / (1 << 20);
  std::printf("%d starts of the robot; memory grew by %.2f MiB to %.1f MiB\n", starts, grown,
              live.memory() / (1 << 20));
  EXPECT_LT(grown, 3);
  live.tell(SIGTERM);
  EXPECT_EQ(live.wait(), 130);
  const nlohmann::json numbers = nlohmann::json::parse(slurp(at("live.json")));
  // What is sent before a new robot is known is lost.
  EXPECT_GT(numbers["poses"]["taken"].get<double>(), 0.6 * sent);
  EXPECT_GT(numbers["faults"]["ros2_undecodable"].get<double>(), 0.6 * sent) << numbers["faults"];
  EXPECT_LE(numbers["pose_age_ms"]["largest"].get<double>(), 300) << "of frames that are not black";
  std::printf("%.0f poses, %.0f messages rejected, oldest pose of a lit frame %.0f ms\n",
              numbers["poses"]["taken"].get<double>(), numbers["faults"]["ros2_undecodable"].get<double>(),
              numbers["pose_age_ms"]["largest"].get<double>());
}

/// A recorded drive, without a graph.
TEST_F(Ros2Route, AShowFollowsARecordedLog) {
  McapFile log;
  log.channel(1, "/tf", "tf2_msgs/msg/TFMessage").channel(2, "/tf_static", "tf2_msgs/msg/TFMessage");
  const auto transform = [](double yaw, int tenth, const char* frame, const char* child) {
    const Pose pose(so3_exp(Vec3(0, 0, yaw)), Vec3(0.01 * tenth, 0, 0));
    return text_of(
        transforms(1700000000 + tenth / 10, unsigned(tenth % 10) * 100'000'000, frame, child, pose).bytes());
  };
  constexpr std::uint64_t kBegin = 1'700'000'000'000'000'000;
  log.message(2, kBegin, transform(0.25, 0, "map", "odom"));
  for (int k = 0; k < 20; ++k)
    log.message(1, kBegin + std::uint64_t(k) * 100'000'000, transform(0.01 * k, k, "odom", "base_link"));
  write_file(at("run.mcap"), log.chunk("").unclosed());  // the recorder was killed
  const ToolRun run = run_tool(
      "project-live", show() + "--control off --json --output none --fps 20 --duration 3s --record " +
                          at("show.mcap") + " --pose-source log:" + at("run.mcap") + "+map,base_link");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json()["poses"]["taken"], 20) << run.json();
  EXPECT_NE(run.err.find("'base_link' in 'map' from /tf and /tf_static; the log has no end"),
            std::string::npos)
      << run.err;
  // What was recorded as messages of ROS 2 is shown again, and its poses drive another show.
  const ToolRun again =
      run_tool("project-live", show() + "--control off --json --output none --replay " + at("show.mcap"));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.json()["equal"], run.json()["frames"]);
  const ToolRun other = run_tool(
      "project-live", show() + "--control off --json --output none --duration 500ms --pose-source log:" +
                          at("show.mcap") + "@0");
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_EQ(other.json()["poses"]["arrived"], run.json()["poses"]["arrived"]);
  const ToolRun wrong =
      run_tool("project-live", show() + "--output none --pose-source log:" + at("run.mcap") + "+/odom");
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_NE(wrong.err.find("it holds /tf (tf2_msgs/msg/TFMessage)"), std::string::npos) << wrong.err;
}

/// The environment's graph has no such robot: that is said, and the frames are dark.
#ifdef PROCAM_TEST_KEYSTORE
/// The options of a user: a stranger's poses are not taken, and the camera of another host is not opened without them.
TEST_F(Ros2Route, ASecuredShowFollowsTheRobotOfItsKeystoreAlone) {
  const LoopbackDomain domain;
  const Keystore keystore;
  const auto enclave = keystore.enclave("projector");
  dds::use_security(keystore.enclave("robot"));
  const dds::internal::Security of_robot = dds::internal::security_of_process();
  dds::use_security({});
  const Ros2Peer stranger(domain), robot(domain, 0, of_robot.qos.get());
  Sender other(stranger.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf"), "map", "base_link");
  Sender ours(robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf"), "map", "base_link");
  const Page page(free_udp_port());
  Running live(
      "project-live",
      show() +
          "--output none --fps 30 --pose-source ros2:map,base_link --publish ros2:/procam --dds-security " +
          enclave.string() + page.flags(),
      folder_ / "live.out");
  ASSERT_TRUE(becomes_true([&] { return page.status().is_object(); })) << slurp(folder_ / "live.out.err");
  for (int i = 0; i < 100; ++i) {
    other.send(100 + 0.02 * i, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_NE(page.status()["pose_state"], "fresh");
  EXPECT_TRUE(becomes_true([&] {
    ours.send(steady_now(), 0);
    return page.status()["pose_state"] == "fresh";
  })) << page.status().dump();
  live.tell(SIGTERM);
  EXPECT_EQ(live.wait(), 130);
  EXPECT_NE(slurp(folder_ / "live.out").find("DDS Security by " + enclave.string()), std::string::npos)
      << slurp(folder_ / "live.out");
  const ToolRun none =
      run_tool("project-live", show() + "--output none --control off --pose-source ros2: --dds-security " +
                                   (folder_ / "none").string());
  EXPECT_EQ(none.exit_code, 3) << none.err;
  EXPECT_NE(none.err.find("create_enclave"), std::string::npos) << none.err;
}
#endif

TEST_F(Ros2Route, WithoutARobotTheReasonIsGiven) {
  const LoopbackDomain domain;
  const ToolRun run =
      run_tool("project-live", show() + "--control off --json --pose-source ros2: --output none " +
                                   "--fps 20 --duration 1500ms --blank-on-stale 500ms");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("no publisher of /tf was found in ROS domain " + std::to_string(domain.number())),
            std::string::npos)
      << run.err;
  EXPECT_EQ(run.json()["poses"]["taken"], 0);
  const ToolRun wrong = run_tool("project-live", show() + "--pose-source ros2:map --output none");
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_NE(wrong.err.find("give two frames"), std::string::npos) << wrong.err;
}

/// A sign that shows a topic; then the topic breaks, which is counted, and the last picture stays.
TEST_F(Ros2Route, ATopicIsTheContentOfASurface) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t writer = robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/camera/image_raw", false);
  SurfaceSet set;
  set.surfaces.push_back(lamp_sign("sign", "ros2:/camera/image_raw"));
  save("sign.json", set);
  Running show("project-live",
               this->show("sign.json") + "--control off --json --output frames:" + at("frames") +
                   " --fps 20 --duration 4s",
               folder_ / "live.json");
  const double begin = steady_now();
  for (int i = 0; show.is_running() && steady_now() < begin + 30; ++i) {
    ImageMessage image;
    image.stamp = 0.02 * i;
    image.width = image.height = 8;
    image.encoding = "bgr8";
    image.step = 24;
    for (int k = 0; k < 64; ++k) image.data.insert(image.data.end(), {0, 255, 40});
    if (i % 50 == 49) image.data.pop_back();
    write_image(writer, image);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_EQ(show.wait(), 0) << slurp(at("live.json.err"));
  const nlohmann::json live = nlohmann::json::parse(slurp(at("live.json")));
  EXPECT_GE(live["faults"]["ros2_invalid_image"].get<int>(), 1) << live.dump();
  EXPECT_FALSE(live["faults"].contains("content")) << live.dump();
  const ImageU8 last = io::load_image(at("frames/frame_000060.png")).image;
  EXPECT_EQ(last.at(70, 140, 0), 40);
  EXPECT_EQ(last.at(70, 140, 1), 255);
  EXPECT_EQ(last.at(70, 140, 2), 0);
}

/// The rig file's lens is of another size: that of CameraInfo counts.
TEST_F(Ros2Route, ADepthTopicSuppliesTheSurfaces) {
  Rig rig = lamp_rig();
  rig.projectors[0].rig_from_projector = Pose(so3_exp(Vec3(0.02, -0.03, 0.01)), Vec3(0.05, -0.02, 0.03));
  simulate::DepthSensor sensor;
  sensor.camera = {{320, 240}, {292, 283.24, 166.4, 112.8, 0.2}, NoDistortion{}};
  RigCamera eye;
  eye.name = "depth";
  eye.camera = {{640, 480}, {500, 490, 320.5, 230.5, 0}, NoDistortion{}};
  eye.rig_from_camera = Pose(so3_exp(Vec3(-0.01, 0.04, 0.02)), Vec3(-0.04, 0.03, 0));
  rig.cameras.push_back(eye);
  io::save_rig(at("room.json"), rig);
  simulate::Room room;
  room.bodies.push_back({"wall", simulate::Rectangle{Vec2(-2, -1.5), Vec2(2, 1.0)},
                         Pose(so3_exp(Vec3(0.03, 0.1, 0)), Vec3(0, 0, 2)), 0.5});
  std::vector<ImageMessage> made;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Image<std::uint16_t> mm = simulate::depth_view(room, sensor, eye.rig_from_camera, seed).mm;
    ImageMessage image;
    image.width = 320;
    image.height = 240;
    image.step = 640;
    image.encoding = "16UC1";
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x) {
        image.data.push_back(std::uint8_t(mm.at(x, y) & 255));
        image.data.push_back(std::uint8_t(mm.at(x, y) >> 8));
      }
    made.push_back(std::move(image));
  }
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t depth = robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/camera/depth");
  const dds_entity_t info = robot.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/camera/camera_info");
  Running show("project-live",
               "--rig " + at("room.json") + " --surfaces depth:ros2:/camera/depth --content wall_1=#ffffff" +
                   " --control off --json --output frames:" + at("seen") + " --fps 8 --duration 9s",
               folder_ / "live.json");
  const double begin = steady_now();
  for (std::size_t i = 0; show.is_running() && steady_now() < begin + 40; ++i) {
    write_camera_info(info, 320, 240, 292, 0.2, {});
    made[i % 3].stamp = 1000 + 0.1 * double(i);
    write_image(depth, made[i % 3]);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_EQ(show.wait(), 0) << slurp(at("live.json.err"));
  const std::string said = slurp(at("live.json.err"));
  EXPECT_NE(said.find("sees wall_1"), std::string::npos) << said;
  EXPECT_NE(said.find("network lo (127.0.0.1): images of /camera/depth"), std::string::npos) << said;
  const int last = nlohmann::json::parse(slurp(at("live.json")))["frames"].get<int>() - 1;
  char name[32];
  std::snprintf(name, sizeof name, "seen/frame_%06d.png", last);
  const ImageU8 frame = io::load_image(at(name)).image;
  const auto lit = std::count(frame.data(), frame.data() + 320 * 200 * 3, std::uint8_t(255));
  EXPECT_GT(double(lit), 0.5 * 320 * 200 * 3);
}

/// The rig's camera is a topic; what it sees of a marker places the rig, and the graph is told.
TEST_F(Ros2Route, AMarkerBeforeACameraOfTheGraphGivesThePoseOfTheRig) {
  Rig rig = lamp_rig();
  RigCamera eye;
  eye.name = "eye";
  eye.camera = {{640, 480}, {720, 705, 331, 228, 1.1}, NoDistortion{}};
  eye.rig_from_camera = Pose(so3_exp(Vec3(0.1, -0.2, 0.05)), Vec3(0.1, 0.2, -0.05));
  rig.cameras.push_back(eye);
  io::save_rig(at("rig.json"), rig);
  PlacedMarker marker;
  marker.id = 3;
  marker.size = 0.3;
  const Pose camera_from_world(so3_exp(Vec3(0.4, -0.5, 0.1)), Vec3(0.05, -0.03, 1.3));
  const ImageU8 view = simulate::marker_view(eye.camera, camera_from_world, {marker},
                                             detect::marker_cells(MarkerDictionary::kAprilTag36h11));
  ImageMessage image = grey_image(0, 0, 640, 480);
  std::copy_n(view.data(), image.data.size(), image.data.begin());
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t writer = robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/eye/image_raw");
  const dds_entity_t poses =
      robot.reader(geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, "rt/procam/pose");
  Running show("project-live",
               this->show() +
                   "--control off --json --marker-camera ros2:/eye/image_raw --output none --fps 20 " +
                   "--marker apriltag_36h11:3:300mm --publish ros2:/procam --duration 5s",
               folder_ / "live.json");
  const double begin = steady_now();
  for (int i = 0; show.is_running() && steady_now() < begin + 30; ++i) {
    image.stamp = 100 + 0.1 * i;
    write_image(writer, image);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_EQ(show.wait(), 0) << slurp(at("live.json.err"));
  const nlohmann::json live = nlohmann::json::parse(slurp(at("live.json")));
  EXPECT_GT(live["poses"]["taken"].get<double>(), 5) << live.dump();
  const std::string said = slurp(at("live.json.err"));
  EXPECT_NE(said.find("network lo (127.0.0.1): images of /eye/image_raw"), std::string::npos) << said;
  const Pose truth = (eye.rig_from_camera * camera_from_world).inverse();
  int count = 0;
  for_each<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>(poses, [&](const auto& message) {
    ++count;
    EXPECT_STREQ(message.header.frame_id, "world");
    const auto& p = message.pose.pose.position;
    EXPECT_LT((Vec3(p.x, p.y, p.z) - truth.translation).norm(), 0.05);
    EXPECT_GT(message.pose.covariance[0], 0);
    EXPECT_GT(message.header.stamp.sec, 1700000000) << "Unix time, not the camera's";
  });
  EXPECT_GT(count, 5);
}

/// A topic that nobody publishes: a content says so within its patience, a camera after five seconds.
TEST_F(Ros2Route, ATopicWithoutAPublisherIsReportedWithTheReason) {
  const LoopbackDomain domain;
  SurfaceSet set;
  set.surfaces.push_back(lamp_sign("sign", "#ffffff"));
  save("sign.json", set);
  const ToolRun markers =
      run_tool("project-live", show("sign.json") +
                                   "--control off --json --output none --marker apriltag_36h11:3:160mm " +
                                   "--marker-camera ros2:/a,/b");
  EXPECT_EQ(markers.exit_code, 3) << markers.err;
  const ToolRun delay =
      run_tool("project-live",
               show("sign.json") + "--control off --output none --delay auto " + "--camera ros2:/nothing");
  EXPECT_EQ(delay.exit_code, 6) << delay.err;
  EXPECT_NE(delay.err.find("no publisher of /nothing was found in ROS domain"), std::string::npos)
      << delay.err;
}

#ifdef PROCAM_SIMULATED_CAMERA

class Ros2Capture : public CaptureStage {};

/// A camera on another machine, as far as DDS is concerned: what a simulated camera sees goes through the graph.
TEST_F(Ros2Capture, ACameraOfTheGraphCapturesAView) {
  const LoopbackDomain domain;
  const Ros2Peer host(domain);
  const dds_entity_t writer = host.writer(sensor_msgs_msg_dds__Image__desc, "rt/camera/image_raw");
  const Process camera_process(camera(30, 0, 0));
  std::atomic<bool> ends{false};
  std::thread relay([&] {
    const auto shots = device::watch_folder(scratch_ / "shots");
    while (!ends) {
      const auto shot = shots->next(0, 0.05);
      if (!shot) continue;
      ImageMessage image = grey_image(shot->time_s, 0, std::uint32_t(shot->image.width()),
                                      std::uint32_t(shot->image.height()));
      std::copy_n(shot->image.data(), image.data.size(), image.data.begin());
      write_image(writer, image);
    }
  });
  const ToolRun run = this->run(rest_of_arguments("--camera ros2:/camera/image_raw", 1), "graph");
  ends = true;
  relay.join();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("images of /camera/image_raw"), std::string::npos) << run.err;
  EXPECT_GT(run.json()["delay"]["delay_ms"], 25);
  EXPECT_LT(run.json()["delay"]["delay_ms"], 250);
  EXPECT_NEAR(run.json()["light"]["gamma"], 2.2, 0.15);
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(session()) / "view_00"));
}

#endif

}  // namespace
}  // namespace procam::test
