#include "chaos_senders.hpp"

#include <poll.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "procam/device/frame_sink.hpp"
#include "procam/simulate/robot.hpp"

namespace procam::test {
namespace {

using device::now_s;

void sleep_until(double time_s, const std::atomic<bool>& ends) {
  while (!ends && now_s() < time_s)
    std::this_thread::sleep_for(
        std::chrono::duration<double>(std::min(0.01, std::max(0.0, time_s - now_s()))));
}

bool send_all(int client, const std::string& bytes) {
  return send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL) == ssize_t(bytes.size());
}

}  // namespace

PoseSender::PoseSender(int port, std::uint64_t seed) : port_(port), random_(seed) {
  thread_ = std::thread([this] { send(); });
}
PoseSender::~PoseSender() {
  ends_ = true;
  thread_.join();
}
void PoseSender::set(const PoseFaults& faults) {
  const std::lock_guard<std::mutex> lock(mutex_);
  faults_ = faults;
}
void PoseSender::restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_new_ = true;
}

track::StampedPose PoseSender::message() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double t = now_s();
  track::StampedPose message;
  message.stamp = t + faults_.stamp_offset;
  message.frame = "map";
  message.child = "base";
  message.frame_from_child =
      Pose(so3_exp(Vec3(0, 0, 0.4 * std::sin(0.5 * t))),
           Vec3(0.2 * std::sin(0.7 * t) + faults_.map_offset, 0.1 * std::sin(1.1 * t), 0));
  return message;
}

void PoseSender::send() {
  auto socket = std::make_unique<Socket>(SOCK_DGRAM);
  std::uint32_t sequence = 0;
  std::string held;  // overtaken by the next one
  for (double due = now_s(); !ends_; due = std::max(due + 1 / 60.0, now_s() - 0.1)) {
    sleep_until(due, ends_);
    track::StampedPose next = message();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::exchange(is_new_, false)) {
      socket = std::make_unique<Socket>(SOCK_DGRAM);
      sequence = 0;
    }
    next.sequence = sequence++;
    if (faults_.is_silent) continue;
    const auto happens = [&](double share) { return std::uniform_real_distribution<>()(random_) < share; };
    if (happens(faults_.lost)) continue;
    const std::string bytes = sequence % 2 == 0 ? track::to_json_line(next) : track::to_binary(next);
    if (happens(faults_.malformed)) socket->send_to(port_, simulate::malformed_bytes(random_, bytes));
    if (held.empty() && happens(faults_.reordered)) {
      held = bytes;
      continue;
    }
    socket->send_to(port_, bytes);
    if (!held.empty()) socket->send_to(port_, std::exchange(held, ""));
    if (happens(faults_.duplicated)) socket->send_to(port_, bytes);
  }
}

NetworkCamera::NetworkCamera(const ImageU8& image) : port_(listener_.bound_port()) {
  const cv::Mat pixels(image.height(), image.width(), image.channels() == 3 ? CV_8UC3 : CV_8UC1,
                       const_cast<std::uint8_t*>(image.data()));
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", pixels, bytes);
  jpeg_.assign(bytes.begin(), bytes.end());
  listen(listener_.handle(), 8);
  thread_ = std::thread([this] { serve(); });
}
NetworkCamera::~NetworkCamera() {
  ends_ = true;
  thread_.join();
}

void NetworkCamera::serve() {
  pollfd waiting{listener_.handle(), POLLIN, 0};
  while (!ends_) {
    if (poll(&waiting, 1, 50) != 1) continue;
    const int client = accept(listener_.handle(), nullptr, nullptr);
    if (client < 0) continue;
    // One at a time: each show opens one connection, and again after a fault.
    clients_.emplace_back([this, client] {
      feed(client);
      close(client);
    });
  }
  for (std::thread& client : clients_) client.join();
}

void NetworkCamera::feed(int client) {
  if (state_ == State::kGone) return;
  char request[4096];
  (void)!recv(client, request, sizeof request, 0);
  if (!send_all(client, "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=frame\r\n\r\n"))
    return;
  std::mt19937_64 random(7);
  for (double due = now_s(); !ends_ && state_ != State::kGone; due += 0.1) {
    sleep_until(due, ends_);
    if (state_ == State::kStalls) continue;
    std::string image = jpeg_;
    if (state_ == State::kGarbage)
      for (char& byte : image) byte = char(random());
    if (!send_all(client, "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                              std::to_string(image.size()) + "\r\n\r\n" + image + "\r\n"))
      return;
  }
}

Repeated::Repeated(double rate_hz, std::function<void(int)> function) {
  thread_ = std::thread([this, rate_hz, function = std::move(function)] {
    int count = 0;
    for (double due = now_s(); !ends_; due = std::max(due + 1 / rate_hz, now_s() - 0.1)) {
      sleep_until(due, ends_);
      if (!is_paused_ && !ends_) function(count++);
    }
  });
}
Repeated::~Repeated() {
  ends_ = true;
  thread_.join();
}

people::SkeletonFrame person_at(double t) {
  using people::Joint;
  people::SkeletonFrame frame;
  frame.stamp = t;
  people::Skeleton person;
  const auto put = [&](Joint joint, const Vec3& at) { person[joint] = people::SeenJoint<Vec3>{at, 1}; };
  put(Joint::kHead, Vec3(0.6, -0.3, 1.6));
  put(Joint::kNeck, Vec3(0.6, -0.05, 1.6));
  put(Joint::kPelvis, Vec3(0.6, 0.5, 1.6));
  put(Joint::kLeftHand, Vec3(0.3 + 0.05 * std::sin(t), 0.1, 1.5));
  frame.people.push_back(person);
  return frame;
}

}  // namespace procam::test
