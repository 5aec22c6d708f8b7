#pragma once
/// What feeds a show during the chaos test: a localiser, a camera on the network, a skeleton tracker, a depth
/// camera. Each has a thread of its own, and faults that are switched on and off.
#include <atomic>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <functional>

#include "e2e/running_tool.hpp"
#include "procam/core/base/image.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "procam/track/wire.hpp"
#include "support/local_socket.hpp"

namespace procam::test {

struct PoseFaults {
  double lost = 0, reordered = 0, duplicated = 0, malformed = 0;  ///< shares of the messages
  bool is_silent = false;
  double stamp_offset = 0;  ///< of the sender's clock, seconds
  double map_offset = 0;    ///< of the localiser's map, metres
};

/// A robot that turns and sways on the spot: 60 poses a second by UDP.
class PoseSender {
 public:
  PoseSender(int port, std::uint64_t seed);
  ~PoseSender();
  PoseSender(const PoseSender&) = delete;
  PoseSender& operator=(const PoseSender&) = delete;
  void set(const PoseFaults& faults);
  /// The sender is another program now: another socket, its messages count from zero.
  void restart();
  /// A message of this moment.
  track::StampedPose message() const;

 private:
  void send();

  const int port_;
  mutable std::mutex mutex_;
  PoseFaults faults_;
  bool is_new_ = false;
  std::mt19937_64 random_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

/// A camera that sends JPEG images by HTTP, ten a second.
class NetworkCamera {
 public:
  enum class State {
    kSends,
    kStalls,   ///< connections stay open, and nothing comes
    kGarbage,  ///< bytes that are no image
    kGone      ///< connections are closed at once
  };
  explicit NetworkCamera(const ImageU8& image);
  ~NetworkCamera();
  NetworkCamera(const NetworkCamera&) = delete;
  NetworkCamera& operator=(const NetworkCamera&) = delete;
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/live.mjpg"; }
  void set(State state) { state_ = state; }

 private:
  void serve();
  void feed(int client);

  std::string jpeg_;
  Socket listener_{SOCK_STREAM};
  int port_;
  std::atomic<State> state_{State::kSends};
  std::atomic<bool> ends_{false};
  std::vector<std::thread> clients_;
  std::thread thread_;
};

/// Calls a function some times a second while it is not paused.
class Repeated {
 public:
  Repeated(double rate_hz, std::function<void(int)> function);
  ~Repeated();
  Repeated(const Repeated&) = delete;
  Repeated& operator=(const Repeated&) = delete;
  void pause(bool paused) { is_paused_ = paused; }

 private:
  std::atomic<bool> is_paused_{false}, ends_{false};
  std::thread thread_;
};

/// A person before the sensor whose hand moves; `t` seconds.
people::SkeletonFrame person_at(double t);

}  // namespace procam::test
