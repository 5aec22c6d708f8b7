// simulate-robot on one end of a socket or a log, a track on the other.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <fstream>
#include <future>
#include <map>
#include <sstream>
#include <thread>

#include "procam/track/pose_log.hpp"
#include "procam/track/pose_source.hpp"
#include "procam/track/pose_track.hpp"
#include "tool_runner.hpp"

namespace procam::test {
namespace {

using track::StampedPose;

/// time -> x, y, z of the truth file.
std::map<double, Vec3> read_truth(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "time,stamp,x,y,z,qx,qy,qz,qw");
  std::map<double, Vec3> truth;
  while (std::getline(file, line)) {
    std::array<double, 5> v = {};
    char comma = 0;
    std::istringstream fields(line);
    for (double& value : v) fields >> value >> comma;
    truth[v[0]] = {v[2], v[3], v[4]};
  }
  return truth;
}

/// What the source is opened with, where the robot sends, and how the message's numbers survive.
struct Wire {
  const char* name;
  const char* source;
  const char* to;
  const char* flags;
};
void PrintTo(const Wire& wire, std::ostream* out) {
  *out << wire.name;
}
std::string with_port(std::string text, int port) {
  return text + std::to_string(port);
}

class RobotOnAWire : public ::testing::TestWithParam<Wire> {};
TEST_P(RobotOnAWire, IsFollowedAndEveryFaultIsCounted) {
  const Wire& wire = GetParam();
  const ScratchFolder folder;
  // Ports differ, since tests run side by side.
  const int port = 20000 + int(std::chrono::steady_clock::now().time_since_epoch().count() / 1000 % 40000);
  const std::string robot = "simulate-robot", truth = (folder / "truth.csv").string();
  const std::string arguments =
      "--path circle:-0.8m --speed 0.5m/s --duration 0.8s --rate 150 --delay 30ms --jitter 2ms "
      "--noise 4mm,0.2deg --loss 5% --reorder 5% --duplicate 4% --garbage 8% --seed 5 --json "
      "--truth " +
      truth + " " + wire.flags + " --to " + with_port(wire.to, port);
  const bool robot_listens = std::string(wire.source).rfind("tcp:", 0) == 0;
  std::unique_ptr<track::PoseSource> source;
  if (!robot_listens) source = track::open_pose_source(with_port(wire.source, port));
  auto running = std::async(std::launch::async, [&] { return run_tool(robot, arguments); });
  if (robot_listens) source = track::open_pose_source(with_port(wire.source, port));

  track::TrackOptions options;
  options.delay = 0;
  options.clock.known_offset =
      track::local_from_unix();  // one machine: no stall of it makes a stamp doubtful
  track::PoseTrack followed(options);
  std::vector<StampedPose> arrived;
  const auto fetch = [&] {
    source->poll(arrived);
    for (const StampedPose& message : arrived) followed.add(message);
  };
  while (running.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready) fetch();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  fetch();

  const ToolRun run = running.get();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto sent = run.json();
  const std::uint64_t messages = sent["messages"], duplicated = sent["duplicated"];
  EXPECT_GT(messages, 100u);
  EXPECT_GT(sent["lost"], 1);
  const track::SourceStatus status = source->status();
  const track::Faults& faults = followed.faults();
  if (!robot_listens) {  // who connects while the robot drives has missed the beginning
    EXPECT_EQ(status.messages, messages + duplicated) << status.last_error;
    EXPECT_EQ(status.malformed, sent["garbage"]) << status.last_error;
    EXPECT_EQ(faults.duplicated, duplicated);
    EXPECT_EQ(faults.taken + faults.reordered, messages);
  } else {
    EXPECT_GT(status.messages, messages / 2);
  }
  EXPECT_EQ(status.dropped, 0u);
  EXPECT_GT(faults.reordered, 1u);
  EXPECT_EQ(faults.outliers + faults.invalid + faults.foreign + faults.doubtful + faults.map_jumps, 0u);
  // Overtaken by the very first that was received: older than all that is kept.
  if (!robot_listens) EXPECT_EQ(faults.late, 0u);

  const std::map<double, Vec3> places = read_truth(truth);
  ASSERT_GT(places.size(), 100u);
  int compared = 0;
  for (const auto& [time, place] : places) {
    if (time > followed.newest_time() || time < followed.newest_time() - 0.3) continue;
    EXPECT_LT((followed.at(time).frame_from_child.translation - place).norm(), 0.02)
        << time - followed.newest_time();
    ++compared;
  }
  EXPECT_GT(compared, 20);
}
INSTANTIATE_TEST_SUITE_P(
    Wires, RobotOnAWire,
    ::testing::Values(Wire{"udp", "udp:127.0.0.1:", "udp:127.0.0.1:", "--twist --covariance"},
                      Wire{"udp_binary", "udp:", "udp:127.0.0.1:", "--binary --gyro --covariance"},
                      Wire{"tcp", "tcp:127.0.0.1:", "tcp-listen:", ""},
                      Wire{"tcp_listen", "tcp-listen:", "tcp:127.0.0.1:", "--binary"},
                      Wire{"osc", "osc:127.0.0.1:", "osc:127.0.0.1:", ""},
                      Wire{"psn", "psn:127.0.0.1:", "psn:127.0.0.1:", "--child \"tracker 3\""}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(RobotInALog, IsTheSameForEqualSeedsAndFollowed) {
  const ScratchFolder folder;
  const std::string log = (folder / "run.log").string(), truth = (folder / "truth.csv").string();
  const std::string arguments =
      "--path walk --duration 40s --rate 30 --delay 60ms --jitter 5ms --noise 3mm,0.2deg "
      "--loss 5% --clock-offset -3s --clock-drift 50 --seed 11 ";
  ASSERT_EQ(run_tool("simulate-robot", arguments + "-o " + log + " --truth " + truth).exit_code, 0);
  const std::string first = slurp(log);
  ASSERT_EQ(run_tool("simulate-robot", arguments + "-o " + log).exit_code, 0);
  EXPECT_EQ(first, slurp(log));

  const auto source = track::open_pose_source("log:" + log + "@0");
  std::vector<StampedPose> messages;
  source->poll(messages);
  ASSERT_GT(messages.size(), 1000u);
  track::TrackOptions options;
  options.delay = 0.06;
  track::PoseTrack predicted(options);
  options.prediction = track::Prediction::kNone;
  track::PoseTrack held(options);
  const std::map<double, Vec3> places = read_truth(truth);
  double sum = 0, sum_held = 0;
  int count = 0;
  for (const StampedPose& message : messages) {
    predicted.add(message);
    held.add(message);
    // The light of a frame that is computed now comes in 40 ms: the nearest moment whose truth is known.
    const auto place = places.lower_bound(message.arrival + 0.04);
    if (place == places.end() || ++count < 60) continue;
    sum += (predicted.at(place->first).frame_from_child.translation - place->second).squaredNorm();
    sum_held += (held.at(place->first).frame_from_child.translation - place->second).squaredNorm();
  }
  const double rms = std::sqrt(sum / (count - 60)), rms_held = std::sqrt(sum_held / (count - 60));
  RecordProperty("rms_mm", std::to_string(1e3 * rms));
  RecordProperty("rms_held_mm", std::to_string(1e3 * rms_held));
  EXPECT_LT(rms, 0.012);
  EXPECT_GT(rms_held, 2 * rms);
  EXPECT_EQ(predicted.faults().outliers + predicted.faults().doubtful, 0u);
}

TEST(SimulateRobot, TakesRecordedPathsAndRefusesNonsense) {
  const ScratchFolder folder;
  const std::string tum = (folder / "path.txt").string(), log = (folder / "run.log").string();
  std::ofstream(tum)
      << "# timestamp tx ty tz qx qy qz qw\n1305031098.6 1.35 0.63 1.64 0.6 0.6 -0.3 -0.4358898943540674\n"
         "1305031098.7 1.36 0.64 1.65 0.6 0.6 -0.3 -0.4358898943540674\n1305031099 1.4 0.6 1.6 0 0 0 1\n";
  ASSERT_EQ(run_tool("simulate-robot", "--path trajectory:" + tum + " --rate 100 -o " + log).exit_code, 0);
  const auto messages = track::read_pose_log(log);
  ASSERT_EQ(messages.size(), 41u);
  EXPECT_LT((messages[10].frame_from_child.translation - Vec3(1.36, 0.64, 1.65)).norm(), 1e-6);

  std::ofstream(tum) << "0 0 0 0\n3, 1, 0, 90\n";
  EXPECT_EQ(run_tool("simulate-robot", "--path waypoints:" + tum + " -o " + log).exit_code, 0);
  EXPECT_LT((track::read_pose_log(log).back().frame_from_child.translation - Vec3(1, 0, 0)).norm(), 1e-6);

  for (const char* nonsense :
       {"", "--to bus:1", "--to udp:nowhere", "--path circle:0m -o x.log", "--path zigzag -o x.log",
        "--path waypoints:/nowhere -o x.log", "--duration 0s -o x.log", "-o /nowhere/x.log"})
    EXPECT_EQ(run_tool("simulate-robot", nonsense).exit_code, 3) << nonsense;
  EXPECT_EQ(run_tool("simulate-robot", "--to tcp:127.0.0.1:1").exit_code, 6);
  EXPECT_EQ(run_tool("simulate-robot", "--loss 5 -o x.log").exit_code, 2);
  EXPECT_EQ(run_tool("simulate-robot", "--rate 0 -o x.log").exit_code, 2);
  std::ofstream(tum) << "0 0 0 0\n0 1 0 90\n";
  EXPECT_EQ(run_tool("simulate-robot", "--path waypoints:" + tum + " -o " + log).exit_code, 3);
}

}  // namespace
}  // namespace procam::test
