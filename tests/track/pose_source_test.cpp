// Sources on real sockets of this machine. What every kind reads is tested end to end with simulate-robot;
// here is what needs a peer that misbehaves.
#include "procam/track/pose_source.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/byte_source.hpp"
#include "procam/track/wire.hpp"
#include "sources.hpp"
#include "support/expect_error.hpp"
#include "support/local_socket.hpp"

namespace procam::track {
namespace {

using test::free_port;
using test::loopback;
using test::Socket;

StampedPose message_of(std::uint32_t sequence) {
  StampedPose message;
  message.sequence = sequence;
  message.frame = "map";
  message.child = "base";
  message.frame_from_child.translation = Vec3(0.1, -0.2, 0.3);
  return message;
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

TEST(PoseSource, WaitEndsWithTheMessage) {
  const int port = free_port(SOCK_DGRAM);
  const auto source = open_pose_source("udp:127.0.0.1:" + std::to_string(port));
  std::vector<StampedPose> arrived;
  source->wait(1e-3);  // nothing came
  source->poll(arrived);
  EXPECT_TRUE(arrived.empty());
  const double before = steady_now();
  std::thread sender([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    Socket(SOCK_DGRAM).send_to(port, to_json_line(message_of(7)));
  });
  source->wait(100);
  source->poll(arrived);
  sender.join();
  ASSERT_EQ(arrived.size(), 1u);
  EXPECT_EQ(arrived[0].sequence, 7u);
  EXPECT_LT(steady_now() - before, 50);
  PoseQueue queue;
  queue.push(message_of(8));
  queue.wait(NAN);  // one is there: any limit will do
  queue.wait(1e300);
  queue.poll(arrived);
  EXPECT_EQ(arrived.size(), 1u);
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

/// Collects the calls of one source.
class Recorder : public ByteHandler {
 public:
  struct Piece {
    int peer;
    std::string bytes;
    double arrival;
  };
  void received(int peer, std::string_view bytes, double arrival) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    pieces_.push_back(Piece{peer, std::string(bytes), arrival});
  }
  void disconnected(int peer, const std::string&) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    gone_.push_back(peer);
  }
  /// Waits for `count` pieces and `gone` ended streams, at most ten seconds.
  std::vector<Piece> wait_for(std::size_t count, std::size_t gone = 0) {
    for (int i = 0; i < 10000; ++i) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (pieces_.size() >= count && gone_.size() >= gone) break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    return pieces_;
  }

 private:
  std::mutex mutex_;
  std::vector<Piece> pieces_;
  std::vector<int> gone_;
};

/// Connects, sends what there is to send, and stays.
class Sender : public Socket {
 public:
  Sender(int port, const std::string& bytes) : Socket(SOCK_STREAM) {
    const sockaddr_in to = loopback(port);
    EXPECT_EQ(connect(handle(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    if (!bytes.empty())
      EXPECT_EQ(send(handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
  }
  /// Waits for the other side to close, at most ten seconds.
  bool is_closed() const {
    const timeval patience = {10, 0};
    setsockopt(handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    char byte = 0;
    return recv(handle(), &byte, 1, 0) == 0 || errno == ECONNRESET;
  }
};

TEST(ByteSource, SilentConnectionsKeepNobodyOut) {
  const int port = free_port(SOCK_STREAM);
  const auto source = open_pose_source("tcp-listen:127.0.0.1:" + std::to_string(port));
  std::vector<StampedPose> all;
  // One that has sent keeps its place before those that never did.
  const Sender active(port, to_binary(message_of(1)));
  ASSERT_TRUE(poll_until(*source, all, [&] { return all.size() == 1; }));
  std::vector<std::unique_ptr<Sender>> silent;
  for (int i = 1; i < limits::kSenders; ++i) silent.push_back(std::make_unique<Sender>(port, ""));
  ASSERT_TRUE(poll_until(*source, all, [&] { return source->status().connections == limits::kSenders; }));
  const Sender localiser(port, to_binary(message_of(2)));
  ASSERT_TRUE(poll_until(*source, all, [&] { return all.size() == 2; }));
  EXPECT_TRUE(silent[0]->is_closed()) << "the one that was silent for longest";
  const std::string again = to_binary(message_of(3));
  EXPECT_EQ(send(active.handle(), again.data(), again.size(), MSG_NOSIGNAL), ssize_t(again.size()));
  ASSERT_TRUE(poll_until(*source, all, [&] { return all.size() == 3; }));
  EXPECT_TRUE(source->status().connected);
}

TEST(ByteSource, ANinthSenderWaitsForSilence) {
  const auto fill = [](Recorder& recorder, int port) {
    std::vector<std::unique_ptr<Sender>> senders;
    for (std::size_t i = 1; i <= std::size_t(limits::kSenders); ++i) {
      senders.push_back(std::make_unique<Sender>(port, "x"));
      EXPECT_EQ(recorder.wait_for(i).size(), i);  // one after the other: the first is silent for longest
    }
    return senders;
  };
  {
    Recorder recorder;
    const int port = free_port(SOCK_STREAM);
    const auto source =
        internal::listen_tcp({"127.0.0.1", static_cast<unsigned short>(port)}, recorder, {1000, 1000});
    const auto senders = fill(recorder, port);
    EXPECT_TRUE(Sender(port, "").is_closed()) << "all eight have sent something just now";
  }
  Recorder recorder;
  const int port = free_port(SOCK_STREAM);
  const auto source =
      internal::listen_tcp({"127.0.0.1", static_cast<unsigned short>(port)}, recorder, {0, 1000});
  const auto senders = fill(recorder, port);
  const Sender ninth(port, "y");
  EXPECT_EQ(recorder.wait_for(limits::kSenders + 1).back().bytes, "y");
  EXPECT_TRUE(senders[0]->is_closed());
}

TEST(ByteSource, AConnectionEndsAfterLongSilence) {
  Recorder recorder;
  const int port = free_port(SOCK_STREAM);
  const auto source =
      internal::listen_tcp({"127.0.0.1", static_cast<unsigned short>(port)}, recorder, {1000, 0.1});
  const Sender sender(port, "x");
  EXPECT_TRUE(sender.is_closed());
  recorder.wait_for(1, 1);
  EXPECT_EQ(Sender(port, "y").is_closed(), true) << "and its place is free again";
}

TEST(ByteSource, AHandlerThatThrowsDoesNotEndTheSource) {
  struct Throwing : Recorder {
    void received(int peer, std::string_view bytes, double arrival) override {
      Recorder::received(peer, bytes, arrival);
      if (bytes == "bad") throw std::runtime_error("no such message");
    }
  } handler;
  const int port = free_port(SOCK_DGRAM);
  const auto source = open_byte_source("udp:127.0.0.1:" + std::to_string(port), handler);
  const Socket sender(SOCK_DGRAM);
  for (const char* bytes : {"bad", "bad", "good"}) sender.send_to(port, bytes);
  EXPECT_EQ(handler.wait_for(3).size(), 3u);
}

TEST(ByteSource, KeepsDatagramsWholeAndSendersApart) {
  const int udp_port = free_port(SOCK_DGRAM), tcp_port = free_port(SOCK_STREAM);
  Recorder datagrams, streams;
  const auto udp = open_byte_source("udp:127.0.0.1:" + std::to_string(udp_port), datagrams);
  auto tcp = open_byte_source("tcp-listen:127.0.0.1:" + std::to_string(tcp_port), streams);
  const double before = steady_now();
  const Socket sender(SOCK_DGRAM);
  sender.send_to(udp_port, "one");
  sender.send_to(udp_port, std::string("\0two", 4));
  const auto whole = datagrams.wait_for(2);
  ASSERT_EQ(whole.size(), 2u);
  EXPECT_EQ(whole[0].bytes, "one");
  EXPECT_EQ(whole[1].bytes, std::string("\0two", 4));
  for (const Recorder::Piece& piece : whole) {
    EXPECT_EQ(piece.peer, 0);
    EXPECT_GE(piece.arrival, before);
    EXPECT_LE(piece.arrival, steady_now());
  }

  const sockaddr_in to = loopback(tcp_port);
  const auto join = [&](const Socket& stream, const std::string& bytes) {
    ASSERT_EQ(connect(stream.handle(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    EXPECT_EQ(send(stream.handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
  };
  const Socket first(SOCK_STREAM);
  join(first, "a");
  ASSERT_EQ(streams.wait_for(1).size(), 1u);
  {
    const Socket second(SOCK_STREAM);
    join(second, "b");
    const auto seen = streams.wait_for(2);
    ASSERT_EQ(seen.size(), 2u);
    EXPECT_EQ(seen[0].peer, 0);
    EXPECT_EQ(seen[1].peer, 1);
  }
  streams.wait_for(2, 1);
  tcp.reset();  // ends its thread: the port is free again
  tcp = open_byte_source("tcp-listen:127.0.0.1:" + std::to_string(tcp_port), streams);
  EXPECT_ERROR(open_byte_source("log:x", streams), kInput, "udp:");
}

}  // namespace
}  // namespace procam::track
