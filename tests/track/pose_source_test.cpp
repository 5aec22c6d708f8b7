// Sources on real sockets of this machine. What every kind reads is tested end to end with simulate-robot;
// here is what needs a peer that misbehaves.
#include "procam/track/pose_source.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include "procam/core/base/error.hpp"
#include "procam/track/skeleton_source.hpp"
#include "procam/track/wire.hpp"
#include "support/expect_error.hpp"

namespace procam::track {
namespace {

StampedPose message_of(std::uint32_t sequence) {
  StampedPose message;
  message.sequence = sequence;
  message.frame = "map";
  message.child = "base";
  message.frame_from_child.translation = Vec3(0.1, -0.2, 0.3);
  return message;
}

sockaddr_in loopback(int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A socket that is closed at the end; its port is the system's choice.
class Socket {
 public:
  explicit Socket(int type) : handle_(socket(AF_INET, type, 0)) {}
  ~Socket() { close(handle_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int handle() const { return handle_; }
  int bound_port() {
    const sockaddr_in any = loopback(0);
    bind(handle_, reinterpret_cast<const sockaddr*>(&any), sizeof any);
    sockaddr_in bound = {};
    socklen_t size = sizeof bound;
    getsockname(handle_, reinterpret_cast<sockaddr*>(&bound), &size);
    return ntohs(bound.sin_port);
  }
  void send_to(int port, const std::string& bytes) const {
    const sockaddr_in to = loopback(port);
    sendto(handle_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

 private:
  int handle_;
};
int free_port(int type) {
  return Socket(type).bound_port();
}

/// Polls until `done`; false after ten seconds.
bool poll_until(PoseSource& source, std::vector<StampedPose>& all, const std::function<bool()>& done) {
  std::vector<StampedPose> arrived;
  for (int i = 0; i < 10000; ++i) {
    source.poll(arrived);
    all.insert(all.end(), arrived.begin(), arrived.end());
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(PoseSource, UdpTellsPosesFromGarbage) {
  const int port = free_port(SOCK_DGRAM);
  const auto source = open_pose_source("udp:127.0.0.1:" + std::to_string(port));
  const Socket sender(SOCK_DGRAM);
  const double before = steady_now();
  for (std::uint32_t k = 0; k < 50; ++k) {
    sender.send_to(port, "garbage");
    sender.send_to(port, k % 2 ? to_binary(message_of(k)) : to_json_line(message_of(k)));
  }
  std::vector<StampedPose> all;
  ASSERT_TRUE(poll_until(*source, all, [&] { return all.size() >= 50; }));
  const SourceStatus status = source->status();
  EXPECT_EQ(status.messages, 50u);
  EXPECT_EQ(status.malformed, 50u);
  EXPECT_EQ(status.dropped, 0u);
  EXPECT_TRUE(status.connected);
  EXPECT_NE(status.last_error.find("neither"), std::string::npos);
  for (std::uint32_t k = 0; k < 50; ++k) {
    EXPECT_EQ(all[k].sequence, k);
    EXPECT_GE(all[k].arrival, before);
    EXPECT_LE(all[k].arrival, steady_now());
  }
}

TEST(PoseSource, KeepsTheNewestAndCountsTheRest) {
  SourceOptions options;
  options.queue = 10;
  PoseQueue queue(options);
  for (std::uint32_t k = 0; k < 25; ++k) EXPECT_TRUE(queue.push(message_of(k)));
  std::vector<StampedPose> arrived;
  queue.poll(arrived);
  ASSERT_EQ(arrived.size(), 10u);
  EXPECT_EQ(arrived.front().sequence, 15u);
  EXPECT_EQ(arrived.back().sequence, 24u);
  EXPECT_EQ(queue.status().dropped, 15u);
  StampedPose broken = message_of(1);
  broken.frame_from_child.translation.x() = NAN;
  EXPECT_FALSE(queue.push(broken));
  EXPECT_EQ(queue.status().malformed, 1u);
  queue.poll(arrived);
  EXPECT_TRUE(arrived.empty());
}

TEST(PoseSource, TcpConnectsWhenTheSenderComesAndAgainWhenItReturns) {
  Socket reserved(SOCK_STREAM);
  const int port = reserved.bound_port();  // nobody listens yet
  const auto source = open_pose_source("tcp:127.0.0.1:" + std::to_string(port));
  std::vector<StampedPose> all;
  ASSERT_TRUE(poll_until(*source, all, [&] { return !source->status().last_error.empty(); }));
  EXPECT_FALSE(source->status().connected);
  listen(reserved.handle(), 1);
  for (std::size_t round = 1; round <= 2; ++round) {
    const int peer = accept(reserved.handle(), nullptr, nullptr);
    ASSERT_GE(peer, 0);
    const std::string line = to_json_line(message_of(std::uint32_t(round)));
    // The second half comes later.
    EXPECT_GT(send(peer, line.data(), 20, MSG_NOSIGNAL), 0);
    EXPECT_GT(send(peer, line.data() + 20, line.size() - 20, MSG_NOSIGNAL), 0);
    EXPECT_TRUE(poll_until(*source, all, [&] { return all.size() == round; }));
    EXPECT_EQ(source->status().connections, round);
    close(peer);
    EXPECT_TRUE(poll_until(*source, all, [&] { return !source->status().connected || round == 2; }));
  }
}

TEST(PoseSource, ListensToSendersThatComeAndGo) {
  const int port = free_port(SOCK_STREAM);
  const auto source = open_pose_source("tcp-listen:127.0.0.1:" + std::to_string(port));
  std::vector<StampedPose> all;
  const sockaddr_in to = loopback(port);
  for (std::uint32_t k = 0; k < 20; ++k) {
    const Socket sender(SOCK_STREAM);
    ASSERT_EQ(connect(sender.handle(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    const std::string bytes = "{\"no\"\n" + to_binary(message_of(k));
    EXPECT_EQ(send(sender.handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
    ASSERT_TRUE(poll_until(*source, all, [&] { return all.size() == k + 1; })) << k;
  }
  EXPECT_TRUE(poll_until(*source, all, [&] { return !source->status().connected; }));
  EXPECT_EQ(source->status().connections, 20u);
  EXPECT_EQ(source->status().malformed, 20u);
}

TEST(PoseSource, RosbridgeSubscribesAndReconnects) {
  namespace asio = boost::asio;
  asio::io_context io;
  asio::ip::tcp::acceptor acceptor(io, {asio::ip::make_address("127.0.0.1"), 0});
  const auto source =
      open_pose_source("rosbridge:127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()));
  std::vector<StampedPose> all;
  for (std::size_t round = 1; round <= 2; ++round) {
    boost::beast::websocket::stream<asio::ip::tcp::socket, false> peer(acceptor.accept());
    peer.accept();
    for (const char* topic : {"/tf", "/amcl_pose", "/odom"}) {
      boost::beast::flat_buffer request;
      peer.read(request);
      const std::string text(static_cast<const char*>(request.data().data()), request.size());
      EXPECT_NE(text.find("\"op\":\"subscribe\",\"topic\":\"" + std::string(topic) + "\""), std::string::npos)
          << text;
    }
    const std::string pose =
        R"({"op":"publish","topic":"/amcl_pose","msg":{"header":{"stamp":{"sec":5,"nanosec":0},"frame_id":"map"},)"
        R"("pose":{"pose":{"position":{"x":1,"y":2,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}},"covariance":[)";
    std::string zeros = "0";
    for (int i = 1; i < 36; ++i) zeros += ",0";
    peer.write(asio::buffer(std::string("not JSON")));
    peer.write(asio::buffer(pose + zeros + "]}}}"));
    ASSERT_TRUE(poll_until(*source, all, [&] { return all.size() == round; })) << source->status().last_error;
    EXPECT_EQ(all.back().frame, "map");
    EXPECT_FALSE(all.back().covariance);  // zeros: unknown
    EXPECT_EQ(source->status().malformed, round);
  }
  EXPECT_EQ(source->status().connections, 2u);
}

TEST(PoseSource, TextsThatNameNoneAreRefusedInThreeParts) {
  for (const char* text :
       {"udp", "udp:", "udp:0", "udp:70000", "udp:nowhere.example:9000", "tcp:9000", "bus:1",
        "log:/nowhere/run.log", "rosbridge:host:9090/", "psn:1.2.3:5", "log:x@fast", "osc:12x"}) {
    try {
      open_pose_source(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_FALSE(error.next().empty()) << text;
      EXPECT_NE(error.kind(), ErrorKind::kDevice) << text;
    }
  }
  Socket taken(SOCK_DGRAM);
  const int port = taken.bound_port();
  try {
    open_pose_source("udp:127.0.0.1:" + std::to_string(port));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
  }
}

// --- people ---

std::string skeleton_line(double x) {
  SkeletonFrame frame;
  frame.stamp = 5;
  frame.people.emplace_back();
  frame.people[0][Joint::kLeftHand] = SeenJoint<Vec3>{Vec3(x, 0.2, 2), 1};
  return to_json_line(frame);
}

TEST(SkeletonSource, ComeByDatagramAndStream) {
  const int udp_port = free_port(SOCK_DGRAM), tcp_port = free_port(SOCK_STREAM);
  const auto udp = open_skeleton_source("udp:127.0.0.1:" + std::to_string(udp_port));
  const auto tcp = open_skeleton_source("tcp-listen:127.0.0.1:" + std::to_string(tcp_port));
  const auto poll = [](SkeletonSource& source, std::size_t count) {
    std::vector<SkeletonFrame> all, arrived;
    for (int i = 0; i < 10000 && all.size() < count; ++i) {
      source.poll(arrived);
      all.insert(all.end(), arrived.begin(), arrived.end());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return all;
  };
  const double before = steady_now();
  const Socket sender(SOCK_DGRAM);
  sender.send_to(udp_port, "garbage");
  sender.send_to(udp_port, skeleton_line(0.1) + skeleton_line(0.2));
  const std::vector<SkeletonFrame> by_udp = poll(*udp, 2);
  ASSERT_EQ(by_udp.size(), 2u);
  EXPECT_EQ(by_udp[1].people.at(0).position(Joint::kLeftHand), Vec3(0.2, 0.2, 2));
  EXPECT_GE(by_udp[0].arrival, before);
  EXPECT_EQ(udp->status().malformed, 1u);

  boost::asio::io_context io;
  boost::asio::ip::tcp::socket stream(io);
  stream.connect({boost::asio::ip::address_v4::loopback(), static_cast<unsigned short>(tcp_port)});
  // A line without end is given up, the next one is read; cuts fall anywhere.
  const std::string bytes = std::string(70000, '[') + "\n" + skeleton_line(0.3) + skeleton_line(0.4);
  boost::asio::write(stream, boost::asio::buffer(bytes.data(), bytes.size() - 30));
  boost::asio::write(stream, boost::asio::buffer(bytes.data() + bytes.size() - 30, 30));
  const std::vector<SkeletonFrame> by_tcp = poll(*tcp, 2);
  ASSERT_EQ(by_tcp.size(), 2u);
  EXPECT_EQ(by_tcp[0].people.at(0).position(Joint::kLeftHand)->x(), 0.3);
  EXPECT_EQ(tcp->status().malformed, 1u);
  EXPECT_ERROR(open_skeleton_source("carrier-pigeon:1"), kInput, "udp:");
  EXPECT_ERROR(open_skeleton_source("udp:127.0.0.1:" + std::to_string(udp_port)), kDevice, "listened");
}

}  // namespace
}  // namespace procam::track
