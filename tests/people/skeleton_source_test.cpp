// Skeletons over real sockets of this machine.
#include "procam/people/skeleton_source.hpp"

#include <gtest/gtest.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <thread>

#include "support/expect_error.hpp"
#include "support/local_socket.hpp"

namespace procam::people {
namespace {

using test::free_port;
using test::Socket;

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
  const double before = track::steady_now();
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
}  // namespace procam::people
