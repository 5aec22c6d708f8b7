#include "chaos_steps.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>

#include "procam/simulate/robot.hpp"

namespace procam::test {
namespace {

using nlohmann::json;

void wait(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Random bytes.
std::string noise(std::mt19937_64& random, std::size_t size) {
  std::string bytes(size, ' ');
  for (char& byte : bytes) byte = char(random());
  return bytes;
}

/// A TCP connection that is open until it is destroyed.
class Connection {
 public:
  Connection(int port, const std::string& bytes) {
    const sockaddr_in address = loopback(port);
    is_open_ = connect(socket_.handle(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    say(bytes);
  }
  void say(const std::string& bytes) const {
    if (is_open_) (void)!send(socket_.handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }

 private:
  Socket socket_{SOCK_STREAM};
  bool is_open_ = false;
};

class Steps : public std::enable_shared_from_this<Steps> {
 public:
  explicit Steps(ChaosStage& stage) : stage_(stage) {}

  std::vector<ChaosStep> all() {
    pose_steps();
    stream_steps();
    page_steps();
    edit_steps();
    file_steps();
    content_steps();
    limit_steps();
    depth_steps();
    people_steps();
    camera_steps();
    return std::move(steps_);
  }

 private:
  template <typename Act>
  ChaosStep& add(ChaosShow& show, const char* name, std::vector<std::string> counters, Act act) {
    steps_.push_back({name, &show, std::move(counters), [act, self = shared_from_this()] {
                        if constexpr (std::is_void_v<decltype(act())>) {
                          act();
                          return std::string();
                        } else {
                          return std::string(act());
                        }
                      }});
    return steps_.back();
  }
  double between(double low, double high) {
    return std::uniform_real_distribution<>(low, high)(stage_.random);
  }

  void pose_steps() {
    ChaosStage& s = stage_;
    const auto share = [this, &s](double PoseFaults::*member) {
      return [this, &s, member] {
        PoseFaults faults;
        faults.*member = between(0.1, 0.6);
        s.poses->set(faults);
      };
    };
    add(*s.show, "message loss", {"pose_faults/lost"}, share(&PoseFaults::lost));
    add(*s.show, "reordering", {"pose_faults/reordered", "pose_faults/late"}, share(&PoseFaults::reordered));
    add(*s.show, "duplicates", {"pose_faults/duplicated"}, share(&PoseFaults::duplicated));
    add(*s.show, "garbage bytes", {"poses_malformed"}, share(&PoseFaults::malformed));
    add(*s.show, "stopped sender", {"pose_faults/stale"}, [this, &s] {
      PoseFaults faults;
      faults.is_silent = true;
      s.poses->set(faults);
      wait(between(0.5, 1.5));
      s.poses->set({});
    });
    add(*s.show, "sender restart", {"pose_faults/clock_jumps"}, [this, &s] {
      PoseFaults faults;
      faults.is_silent = true;
      s.poses->set(faults);
      wait(between(0.1, 0.5));
      s.poses->restart();
      faults = {};
      faults.stamp_offset = between(-1e4, 1e9);
      s.poses->set(faults);
    });
    add(*s.show, "clock set forward", {"pose_faults/clock_jumps"}, [this, &s] {
      PoseFaults faults;
      faults.stamp_offset = between(0.5, 50);
      s.poses->set(faults);
    });
    add(*s.show, "clock set back", {"pose_faults/clock_jumps"}, [this, &s] {
      PoseFaults faults;
      faults.stamp_offset = between(-50, -1);
      s.poses->set(faults);
    });
    add(*s.show, "map correction", {"pose_faults/map_jumps"}, [this, &s] {
      PoseFaults faults;
      faults.map_offset = between(0.8, 2);
      s.poses->set(faults);
    });
    add(*s.show, "outliers", {"pose_faults/outliers"}, [&s] {
      for (int i = 0; i < 6; ++i) {
        track::StampedPose message = s.poses->message();
        message.frame_from_child.translation.x() += 30 + 10 * i;
        Socket(SOCK_DGRAM).send_to(s.pose_port, track::to_json_line(message));
        wait(0.05);
      }
    });
    add(*s.show, "impossible poses", {"poses_malformed"}, [&s] {
      const std::string good = track::to_json_line(s.poses->message());
      for (const char* place : {"[NaN,0,0]", "[1e999,0,0]", "[1e30,0,0]", "[0,0]", "[\"a\",0,0]", "{}"}) {
        std::string bad = good;
        const std::size_t begin = bad.find('[', bad.find("\"position\"")), end = bad.find(']', begin);
        bad.replace(begin, end + 1 - begin, place);
        Socket(SOCK_DGRAM).send_to(s.pose_port, bad);
      }
    });
    add(*s.show, "flood of garbage", {"poses_malformed"}, [&s] {
      const Socket sender(SOCK_DGRAM);
      const std::string good = track::to_json_line(s.poses->message());
      for (int burst = 0; burst < 30; ++burst) {
        for (int i = 0; i < 100; ++i) sender.send_to(s.pose_port, simulate::malformed_bytes(s.random, good));
        wait(0.02);
      }
    });
  }

  void stream_steps() {
    ChaosStage& s = stage_;
    const auto foreign = [&s] {
      track::StampedPose message = s.poses->message();
      message.child = "another robot";
      return track::to_json_line(message);
    };
    add(*s.show, "another robot", {"pose_faults/foreign"}, [&s, foreign] {
      const Connection sender(s.tcp_port, foreign());
      wait(0.1);
    });
    add(*s.show, "garbage stream", {"poses_malformed"}, [&s] {
      Connection sender(s.tcp_port, "");
      for (int i = 0; i < 20; ++i) sender.say(noise(s.random, 1000) + "\n");
      wait(0.1);
    });
    add(*s.show, "endless line", {"poses_malformed"}, [&s] {
      Connection sender(s.tcp_port, "{");
      for (int i = 0; i < 20; ++i) sender.say(std::string(4000, ' '));
      wait(0.1);
      sender.say("\n");
      wait(0.1);
    });
    add(*s.show, "silent connections", {"pose_faults/foreign"}, [&s, foreign] {
      std::vector<std::unique_ptr<Connection>> silent;
      for (int i = 0; i < 12; ++i) silent.push_back(std::make_unique<Connection>(s.tcp_port, ""));
      wait(0.1);
      const Connection sender(s.tcp_port, foreign());  // finds a place all the same
      wait(0.2);
    });
    add(*s.show, "sender that goes", {"faults/pose_source"}, [&s, foreign] {
      {
        const Connection sender(s.tcp_port, foreign());
        wait(0.7);
      }
      wait(0.6);
    });
    add(*s.show, "garbage OSC", {"poses_malformed"}, [&s] {
      const std::string good = track::to_osc(s.poses->message());
      const Socket sender(SOCK_DGRAM);
      for (int i = 0; i < 50; ++i)
        sender.send_to(s.osc_port,
                       i % 2 == 0 ? noise(s.random, 64) : simulate::malformed_bytes(s.random, good));
    });
  }

  void page_steps() {
    ChaosStage& s = stage_;
    ChaosShow& show = *s.show;
    add(show, "half-open requests", {"faults/page_connection", "faults/page_refused"}, [this, &s] {
      std::vector<std::unique_ptr<Connection>> open;
      const char* beginnings[] = {"", "GET", "GET /status HTTP/1.1\r\nHost: local",
                                  "POST /command HTTP/1.1\r\n"};
      for (int i = 0; i < 40; ++i)
        open.push_back(std::make_unique<Connection>(s.show->port(), beginnings[s.random() % 4]));
      wait(between(0.2, 1));
      return s.show->get("/status").empty() ? "the owner was locked out" : "";
    });
    add(show, "wrong tokens", {"faults/page_refused"}, [&s] {
      for (int i = 0; i < 20; ++i) {
        const std::string answer =
            talk(s.show->port(),
                 "GET /" + std::string(i % 2 == 0 ? "status" : "") + "?token=" + std::to_string(i) +
                     " HTTP/1.1\r\nHost: localhost:" + std::to_string(s.show->port()) + "\r\n\r\n");
        if (answer.find(" 403 ") == std::string::npos)
          return "a wrong token was not refused: " + answer.substr(0, 40);
      }
      return std::string();
    });
    add(show, "oversized requests", {"faults/page_refused"}, [&s] {
      talk(s.show->port(), s.show->request("GET /", "X: " + std::string(20000, 'x') + "\r\n"));
      talk(s.show->port(), s.show->request("POST /command", "", std::string(40000, ' ')));
      talk(s.show->port(), s.show->request("POST /command", "Content-Length: 99999999999999\r\n"));
    });
    add(show, "no HTTP", {"faults/page_refused"}, [&s] {
      for (int i = 0; i < 10; ++i) talk(s.show->port(), noise(s.random, 200) + "\r\n\r\n");
      talk(s.show->port(), "GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\nContent-Length: 5\r\n\r\nzz\r\n");
    });
    add(show, "WebSocket nonsense", {"faults/page_refused"}, [&s] {
      const std::string upgrade =
          s.show->request("GET /ws",
                          "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                          "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
      for (int i = 0; i < 6; ++i) {
        Connection client(s.show->port(), upgrade);
        wait(0.1);
        // A masked text frame "{}", which is no command; or bytes that are no frame.
        client.say(i % 2 == 0 ? std::string("\x81\x82\0\0\0\0{}", 8) : noise(s.random, 100));
        wait(0.05);
      }
    });
    add(show, "flood of requests", {}, [&s] {
      int answered = 0;
      for (int i = 0; i < 150; ++i)
        answered += s.show->get(i % 3 == 0 ? "/frame.jpg" : "/status").empty() ? 0 : 1;
      return answered == 150 ? "" : std::to_string(answered) + " of 150 requests were answered";
    });
  }

  void edit_steps() {
    ChaosStage& s = stage_;
    add(*s.show, "nonsense commands", {"faults/command"}, [&s] {
      for (const json& command :
           {json{{"do", "explode"}}, json{{"do", "remove"}, {"surface", "nobody"}},
            json{{"do", "picture"}, {"text", "none"}},
            json{{"do", "content"}, {"surface", "sign"}, {"text", "/etc/passwd"}},
            json{{"do", "move"}, {"surface", "sign"}, {"point", 99}, {"pixels", {1, 2}}},
            json{{"do", "rename"}, {"surface", "sign"}, {"text", "a\x01\x02"}},
            json{{"do", "rename"}, {"surface", "sign"}, {"text", std::string(1000, 'x')}}})
        s.show->command(command);
    });
    add(*s.show, "no commands", {"faults/page_refused"}, [&s] {
      for (const std::string& body :
           {std::string("{}"), std::string("[[[["), std::string("{\"do\":5}"),
            std::string("{\"do\":\"move\",\"pixels\":[1,1e999]}"), noise(s.random, 50)})
        talk(s.show->port(), s.show->request("POST /command", "", body));
    });
    add(*s.show, "edits that cannot be shown", {"faults/surfaces", "faults/command"}, [&s] {
      for (int i = 0; i < 4; ++i)
        s.show->command({{"do", "move"}, {"surface", "sign"}, {"point", i}, {"pixels", {50 + i * 1e-7, 50}}});
      for (int i = 0; i < 4; ++i)
        s.show->command({{"do", "move"}, {"surface", "wall 0"}, {"point", i}, {"pixels", {-9e4, 9e4}}});
    });
    add(*s.show, "flood of edits", {}, [this, &s] {
      int accepted = 0;
      for (int i = 0; i < 150; ++i) {
        const Vec2 pixel(between(-500, 900), between(-500, 900));
        accepted += s.show->command(i % 5 == 4 ? json{{"do", s.random() % 2 == 0 ? "undo" : "redo"}}
                                               : json{{"do", "move"},
                                                      {"surface", "sign"},
                                                      {"point", int(s.random() % 4)},
                                                      {"pixels", {pixel.x(), pixel.y()}}}) == 202;
      }
      return accepted == 150 ? "" : std::to_string(accepted) + " of 150 edits were accepted";
    });
  }

  void file_steps() {
    ChaosStage& s = stage_;
    const std::vector<std::string> reload = {"reloads_failed"};
    add(*s.show, "broken surfaces file", reload, [&s] {
      const std::string good = slurp(s.at("surfaces.json"));
      s.write("surfaces.json", good.substr(0, good.size() * (1 + s.random() % 8) / 10));
    });
    add(*s.show, "surfaces file of noise", reload,
        [&s] { s.replace("surfaces.json", noise(s.random, 1 + s.random() % 100000)); });
    add(*s.show, "surfaces file removed", reload, [&s] { fs::remove(s.at("surfaces.json")); });
    add(*s.show, "named pipe as surfaces file", reload, [&s] {
      fs::remove(s.at("surfaces.json"));
      mkfifo(s.at("surfaces.json").c_str(), 0600);
    });
    add(*s.show, "folder as surfaces file", reload, [&s] {
      fs::remove(s.at("surfaces.json"));
      fs::create_directory(s.at("surfaces.json"));
    });
  }

  void content_steps() {
    ChaosStage& s = stage_;
    const std::vector<std::string> content = {"faults/content"};
    const auto choose = [&s](const char* file) {
      return [&s, file] {
        const int answer = s.show->command({{"do", "content"}, {"surface", "wall 3"}, {"text", file}});
        return answer == 202 ? "" : "the command was refused";
      };
    };
    add(*s.show, "garbage as content", content, choose("garbage.png"));
    add(*s.show, "named pipe as content", content, choose("pipe.png"));
    add(*s.show, "images that vanish", content, [&s] {
      for (int i = 0; i < 8; ++i) fs::remove(s.at("shots/" + std::to_string(i) + ".png"));
    });
    add(*s.show, "images of noise", content, [&s] {
      for (int i = 0; i < 8; ++i) s.replace("shots/" + std::to_string(i) + ".png", noise(s.random, 3000));
    });
    add(*s.show, "video replaced by noise", content, [&s] { s.replace("clip.avi", noise(s.random, 20000)); });
    add(*s.show, "video removed", content, [&s] { fs::remove(s.at("clip.avi")); });
    add(*s.show, "named pipe in a video's place", content, [&s] {
      fs::remove(s.at("clip.avi"));
      mkfifo(s.at("clip.avi").c_str(), 0600);
    });
    const std::string memory = "/dev/shm/" + s.shared_name();
    add(*s.show, "truncated shared memory", content, [&s, memory] {
      s.shared_frames->pause(true);
      (void)!truncate(memory.c_str(), off_t(s.random() % 5000));
    }).end = [&s] {
      s.open_shared_writer();
      s.shared_frames->pause(false);
    };
    add(*s.show, "shared memory removed", content, [memory] { fs::remove(memory); }).end = [&s] {
      s.open_shared_writer();
    };
    add(*s.show, "shared memory of noise", {}, [&s, memory] {
      std::fstream file(memory, std::ios::binary | std::ios::in | std::ios::out);
      file << noise(s.random, 200);
      file.close();
      wait(0.3);
      return "";
    }).end = [&s] { s.open_shared_writer(); };
    const auto camera = [&s](NetworkCamera::State state) { return [&s, state] { s.camera->set(state); }; };
    add(*s.show, "content camera closes", content, camera(NetworkCamera::State::kGone));
    add(*s.show, "content camera stalls", content, camera(NetworkCamera::State::kStalls));
    add(*s.show, "stalled camera is replaced", {}, [&s] {
      s.camera->set(NetworkCamera::State::kStalls);
      wait(0.5);
      const double before = s.show->metric("frames");
      s.show->command({{"do", "content"}, {"surface", "camera"}, {"text", "other.png"}});
      wait(2);
      const double frames = s.show->metric("frames") - before;
      return frames > 10 ? "" : std::to_string(frames) + " frames in two seconds";
    });
  }

  void limit_steps() {
    ChaosStage& s = stage_;
    add(*s.show, "full disk", {"faults/save"}, [this, &s] {
      limit(RLIMIT_FSIZE, 100);
      s.show->command(
          {{"do", "rename"}, {"surface", "sign"}, {"text", "renamed " + std::to_string(s.random() % 1000)}});
      // The first one ends the recording as well, as soon as its buffer is full.
      for (int i = 0; i < 100 && s.show->metric("faults/record") == 0; ++i) wait(0.1);
      return s.show->metric("faults/record") > 0 ? "" : "the end of the recording is not counted";
    }).end = [this, &s] {
      limit(RLIMIT_FSIZE, RLIM_INFINITY);
      // What could not be saved is saved as soon as there is room.
      for (int i = 0; i < 50 && s.show->status().value("unsaved", true); ++i) wait(0.1);
    };
    add(*s.show, "no more descriptors", {"faults/page_request"}, [this, &s] {
      limit(RLIMIT_NOFILE, rlim_t(s.show->resources().descriptors));
      std::vector<std::unique_ptr<Connection>> waiting;
      for (int i = 0; i < 5; ++i)
        waiting.push_back(std::make_unique<Connection>(s.show->port(), "GET / HTTP/1.1\r\n"));
      wait(1);
      limit(RLIMIT_NOFILE, 1024);
    });
  }
  void limit(__rlimit_resource resource, rlim_t value) const {
    rlimit now{};
    prlimit(stage_.show->process(), resource, nullptr, &now);
    now.rlim_cur = std::min(value, now.rlim_max);
    prlimit(stage_.show->process(), resource, &now, nullptr);
  }

  void depth_steps() {
    ChaosStage& s = stage_;
    const std::vector<std::string> depth = {"faults/depth"};
    add(*s.room, "depth camera stops", depth, [&s] { s.depth->pause(true); });
    add(*s.room, "depth image of noise", depth, [&s] {
      s.write("next_noise", noise(s.random, 5000));
      fs::rename(s.at("next_noise"), s.at("depth/noise.png"));
    }).end = [&s] { fs::remove(s.at("depth/noise.png")); };
    add(*s.room, "depth image of another size", depth, [&s] {
      fs::copy_file(s.at("picture.png"), s.at("depth/picture.png"), fs::copy_options::overwrite_existing);
    }).end = [&s] { fs::remove(s.at("depth/picture.png")); };
    add(*s.room, "depth folder vanishes", depth, [&s] {
      fs::rename(s.at("depth"), s.at("depth_away"));
    }).end = [&s] { fs::rename(s.at("depth_away"), s.at("depth")); };
  }

  void people_steps() {
    ChaosStage& s = stage_;
    const auto say = [&s](const std::string& bytes) { Socket(SOCK_DGRAM).send_to(s.people_port, bytes); };
    add(*s.room, "garbage skeletons", {"faults/people_malformed"}, [&s, say] {
      const std::string good = people::to_json_line(person_at(1));
      for (int i = 0; i < 40; ++i)
        say(i % 2 == 0 ? noise(s.random, 300) : simulate::malformed_bytes(s.random, good));
    });
    add(*s.room, "impossible skeletons", {"faults/people_malformed", "faults/people_refused"}, [say] {
      for (const char* joint : {"[NaN,0,2]", "[1e30,0,2]", "[1e999,0,2]", "[0,0]", "\"here\"", "[0,0,-5]"})
        say("{\"people\":[{\"joints\":{\"head\":" + std::string(joint) + "}}]}\n");
      std::string crowd = "{\"people\":[";
      for (int i = 0; i < 500; ++i)
        crowd += std::string(i > 0 ? "," : "") + "{\"joints\":{\"head\":[0,0,2]}}";
      say(crowd + "]}\n");
    });
    add(*s.room, "repeated skeletons", {"faults/people_repeated"}, [say] {
      const std::string line = people::to_json_line(person_at(device::now_s()));
      for (int i = 0; i < 10; ++i) say(line);
    });
    add(*s.room, "joints that jump", {"faults/people_teleports"}, [say] {
      for (int i = 0; i < 6; ++i) {
        people::SkeletonFrame frame = person_at(device::now_s());
        frame.people[0][people::Joint::kLeftHand]->position = Vec3(i % 2 == 0 ? -3 : 3, 1, 4);
        say(people::to_json_line(frame));
        wait(0.06);
      }
    });
  }

  void camera_steps() {
    ChaosStage& s = stage_;
    const auto camera = [&s](NetworkCamera::State state) {
      return [&s, state] { s.marker_camera->set(state); };
    };
    // One that is lost and back within half a second is counted with the frames that gave no pose.
    const std::vector<std::string> camera_faults = {"faults/pose_source", "poses_malformed"};
    add(*s.marker, "marker camera closes", camera_faults, camera(NetworkCamera::State::kGone));
    add(*s.marker, "marker camera stalls", camera_faults, camera(NetworkCamera::State::kStalls));
    add(*s.marker, "marker camera sends garbage", camera_faults, camera(NetworkCamera::State::kGarbage));
  }

  ChaosStage& stage_;
  std::vector<ChaosStep> steps_;
};

}  // namespace

std::vector<ChaosStep> chaos_steps(ChaosStage& stage) {
  return std::make_shared<Steps>(stage)->all();
}

}  // namespace procam::test
