/// How a show ends, and what does not end it: signals, full disks, readers that go away.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/un.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "lamp_show.hpp"
#include "procam/device/content_source.hpp"
#include "running_tool.hpp"
#include "support/local_socket.hpp"

namespace procam::test {
namespace {

/// Generous, for a machine that does other work.
template <typename Condition>
bool wait_for(const Condition& holds) {
  for (int i = 0; i < 3000 && !holds(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return holds();
}

/// The datagrams that a service manager would get.
class ServiceSocket {
 public:
  explicit ServiceSocket(const std::string& path) : handle_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    bind(handle_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  ~ServiceSocket() { close(handle_); }
  ServiceSocket(const ServiceSocket&) = delete;
  ServiceSocket& operator=(const ServiceSocket&) = delete;
  /// All that came so far.
  const std::vector<std::string>& states() {
    char text[64];
    for (ssize_t size = 0; (size = recv(handle_, text, sizeof text, MSG_DONTWAIT)) > 0;)
      states_.emplace_back(text, std::size_t(size));
    return states_;
  }

 private:
  int handle_;
  std::vector<std::string> states_;
};

/// The answer to an HTTP request to this machine; empty when nobody listens.
std::string ask(int port, const std::string& request) {
  const Socket client(SOCK_STREAM);
  const sockaddr_in address = loopback(port);
  if (connect(client.handle(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return "";
  (void)!send(client.handle(), request.data(), request.size(), MSG_NOSIGNAL);
  std::string answer;
  char bytes[4096];
  for (ssize_t size = 0; (size = recv(client.handle(), bytes, sizeof bytes, 0)) > 0;)
    answer.append(bytes, std::size_t(size));
  return answer;
}

class ShowStop : public LampShow {
 protected:
  void SetUp() override { save("surfaces.json", lamp_sign("sign", "#ff8040")); }
  void save(const std::string& name, const Surface& surface) const {
    LampShow::save(name, SurfaceSet{{surface}});
  }
};

/// A service manager's SIGTERM: the video can be read, and the statistics are printed.
TEST_F(ShowStop, SigtermClosesTheVideoAndPrintsTheStatistics) {
  Running running("project-live",
                  show() + "--control off --json --fps 20 --output video:" + at("show.mkv") + " --record " +
                      at("run.log"),
                  at("out"));
  ASSERT_TRUE(wait_for([&] {
    return slurp(at("run.log")).find("\"frame\":5,") != std::string::npos || !running.is_running();
  }));
  running.tell(SIGTERM);
  EXPECT_EQ(running.wait(), 130);
  const nlohmann::json summary = nlohmann::json::parse(slurp(at("out")));
  EXPECT_GE(summary["frames"].get<double>(), 6) << summary;
  EXPECT_EQ(summary["exit_code"], 130);
  EXPECT_NE(summary["error"]["why"].get<std::string>().find("SIGTERM"), std::string::npos);
  device::ContentOptions exact;
  exact.pace = device::Pace::kExact;
  const auto video = device::open_content(at("show.mkv"), exact);
  EXPECT_EQ(video->at(0.1).view.size(), (ImageSize{320, 200}));
  const ToolRun replayed =
      run_tool("project-live", show() + "--control off --json --replay " + at("run.log"));
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_GE(replayed.json()["frames"].get<double>(), 5);
}

/// A service manager learns that frames are shown, and that they still are.
TEST_F(ShowStop, AServiceManagerIsNotified) {
  ServiceSocket manager(at("notify"));
  Running running("project-live", show() + "--control off --output none --fps 20", at("out"),
                  "NOTIFY_SOCKET=" + at("notify") + " WATCHDOG_USEC=200000");
  ASSERT_TRUE(wait_for([&] { return manager.states().size() >= 4 || !running.is_running(); }));
  running.tell(SIGTERM);
  EXPECT_EQ(running.wait(), 130) << slurp(at("out.err"));
  const std::vector<std::string>& states = manager.states();
  EXPECT_EQ(states.front(), "READY=1");
  EXPECT_EQ(states.back(), "STOPPING=1");
  EXPECT_GE(std::count(states.begin(), states.end(), "WATCHDOG=1"), 3);
}

/// kill -9 while a person edits: the next show begins with the last edit. PROCAM_KILLS: how often (4 unless given).
TEST_F(ShowStop, AKilledShowStartsAgainWithItsEdits) {
  const int port = free_port(SOCK_STREAM);
  const std::string head =
      " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) + "\r\nAuthorization: Bearer 0123456789\r\n";
  const auto status = [&] { return ask(port, "GET /status" + head + "\r\n"); };
  std::string name = "sign";
  const char* wanted = std::getenv("PROCAM_KILLS");
  const int rounds = wanted != nullptr ? std::atoi(wanted) : 4;
  std::vector<double> dark_s;
  for (int round = 0; round < rounds; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    Running running(
        "project-live",
        show() + "--output none --fps 20 --autosave --token 0123456789 --control " + std::to_string(port),
        at("out"));
    ASSERT_TRUE(wait_for([&] { return status().find("\"name\":\"" + name + "\"") != std::string::npos; }))
        << round << ": " << status() << slurp(at("out.err"));
    const std::chrono::duration<double> dark = std::chrono::steady_clock::now() - begin;
    dark_s.push_back(dark.count());
    const std::string next = "sign " + std::to_string(round);
    const std::string body = "{\"do\":\"rename\",\"surface\":\"" + name + "\",\"text\":\"" + next + "\"}";
    EXPECT_NE(ask(port, "POST /command" + head + "Content-Length: " + std::to_string(body.size()) +
                            "\r\n\r\n" + body)
                  .find("202"),
              std::string::npos);
    name = next;
    ASSERT_TRUE(wait_for([&] { return slurp(at("surfaces.json")).find(next) != std::string::npos; }));
  }  // each is killed by SIGKILL here
  std::sort(dark_s.begin(), dark_s.end());
  RecordProperty("median_start_s", std::to_string(dark_s[dark_s.size() / 2]));
  RecordProperty("p99_start_s", std::to_string(dark_s[dark_s.size() * 99 / 100]));
  RecordProperty("longest_start_s", std::to_string(dark_s.back()));
}

/// A closed terminal ends it as well, in the middle of a long wait; the shared memory is removed.
TEST_F(ShowStop, SighupEndsASlowShowAndRemovesItsMemory) {
  const std::string name = "procam_stop_" + std::to_string(getpid());
  Running running("project-live", show() + "--control off --json --fps 0.1 --output shm:" + name, at("out"));
  ASSERT_TRUE(wait_for([&] { return fs::exists("/dev/shm/" + name) || !running.is_running(); }));
  running.tell(SIGHUP);
  EXPECT_EQ(running.wait(), 130) << slurp(at("out.err"));
  EXPECT_FALSE(fs::exists("/dev/shm/" + name));
}

/// Also where stdout is no terminal.
TEST_F(ShowStop, TheControlPagesAddressComesAtOnce) {
  Running running("project-live", show() + "--control 127.0.0.1:0 --output none --fps 20", at("out"));
  EXPECT_TRUE(wait_for([&] { return slurp(at("out")).find("control page: http://") != std::string::npos; }));
}

TEST_F(ShowStop, AReaderOfTheMessagesThatGoesAwayDoesNotEndTheShow) {
  run_tool("project-live", show() + "--control 127.0.0.1:0 --output none --fps 20 --duration 2s --record " +
                               at("run.log") + " | head -n 1");
  const std::string log = slurp(at("run.log"));
  const std::size_t last = log.rfind("\"content\":");
  ASSERT_NE(last, std::string::npos) << log;
  EXPECT_GT(std::atof(log.c_str() + last + 10), 1.5) << "the show lasted two seconds";
}

TEST_F(ShowStop, AFullDiskEndsTheRecordingOnly) {
  const ToolRun run = run_program(
      "/bin/sh", "-c 'ulimit -f 16; exec " + std::string(PROCAM_TOOLS) + "/project-live " + show() +
                     "--control off --json --output none --fps 500 --duration 3s --record " + at("run.log") +
                     "'");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("recording has stopped; the show continues"), std::string::npos) << run.err;
  EXPECT_EQ(run.json()["faults"]["record"], 1) << run.out;
}

/// Also the log on the full disk: with room again, messages are written again.
TEST_F(ShowStop, AFullDiskForAWhileEndsNoMessages) {
  const int port = free_port(SOCK_STREAM);
  const std::string head =
      " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) + "\r\nAuthorization: Bearer 0123456789\r\n";
  Running running("project-live",
                  show() + "--output none --fps 20 --json --autosave --token 0123456789 --control " +
                      std::to_string(port),
                  at("out"));
  const auto faults = [&](const std::string& name) {
    const std::string metrics = ask(port, "GET /metrics" + head + "\r\n");
    const std::size_t found = metrics.find("procam_faults_total{name=\"" + name + "\"} ");
    return found == std::string::npos ? 0 : std::atoi(metrics.c_str() + metrics.find('}', found) + 1);
  };
  const auto command = [&](const std::string& body) {
    ask(port, "POST /command" + head + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  };
  ASSERT_TRUE(wait_for([&] { return !ask(port, "GET /status" + head + "\r\n").empty(); }));
  rlimit disk{50, RLIM_INFINITY};  // bytes of a file: fewer than there are
  ASSERT_EQ(prlimit(running.process(), RLIMIT_FSIZE, &disk, nullptr), 0);
  command("{\"do\":\"rename\",\"surface\":\"sign\",\"text\":\"renamed\"}");
  ASSERT_TRUE(wait_for([&] { return faults("save") > 0; }));
  disk.rlim_cur = RLIM_INFINITY;
  ASSERT_EQ(prlimit(running.process(), RLIMIT_FSIZE, &disk, nullptr), 0);
  EXPECT_TRUE(wait_for([&] { return slurp(at("surfaces.json")).find("renamed") != std::string::npos; }));
  command("{\"do\":\"explode\"}");
  ASSERT_TRUE(wait_for([&] { return faults("command") > 0; }));
  EXPECT_TRUE(wait_for([&] { return slurp(at("out.err")).find("explode") != std::string::npos; }))
      << slurp(at("out.err"));
}

TEST_F(ShowStop, AShowThatNobodySeesIsNoSilentSuccess) {
  PlanarSurface wall;
  wall.frame_from_surface = Pose(so3_exp(Vec3(0.1, 0.45, -0.07)), Vec3(-0.3, -0.2, 2.1));
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.points = {{0, 0}, {0.71, 0.02}, {0.68, 0.42}, {-0.03, 0.4}};
  save("wall.json", Surface{"sign", wall, {}, "#ff8040"});
  const std::string brief = "--control off --json --output none --fps 20 --duration 1500ms ";
  const ToolRun without = run_tool("project-live", show("wall.json") + brief);
  EXPECT_EQ(without.exit_code, 0) << without.err;
  EXPECT_NE(without.err.find("no pose is given"), std::string::npos) << without.err;
  EXPECT_EQ(without.json()["diagnostics"][0]["code"], "no_pose") << without.out;

  wall.frame = "rig";
  for (Vec2& point : wall.points) point *= 1000;
  wall.frame_from_surface.translation = {3000, -200, 2100};
  save("wall.json", Surface{"sign", wall, {}, "#ff8040"});
  const ToolRun far = run_tool("project-live", show("wall.json") + brief);
  EXPECT_NE(far.err.find("millimetres"), std::string::npos) << far.err;
  EXPECT_EQ(far.json()["diagnostics"][0]["code"], "no_light") << far.out;
}

TEST_F(ShowStop, AnEmptyLogIsNoReplay) {
  std::ofstream(at("empty.log")) << "";
  const ToolRun run = run_tool("project-live", show() + "--control off --replay " + at("empty.log"));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("the log is empty"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace procam::test
