#pragma once
/// Hosts on one network, each with a network and a steady clock of its own: namespaces of Linux, joined by a bridge. It needs the
/// rights to make them (root).
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "running_tool.hpp"

namespace procam::test {

class NetworkHosts {
 public:
  explicit NetworkHosts(int count) : id_(1 + int(getpid() % 200)), count_(count) {
    run("ip link add " + bridge() + " type bridge");
    run("ip addr add " + address(-1) + "/24 dev " + bridge());
    run("ip link set " + bridge() + " up");
    for (int host = 0; host < count; ++host) {
      run("ip netns add " + name(host));
      run("ip link add " + cable(host) + " type veth peer name eth0 netns " + name(host));
      run("ip link set " + cable(host) + " master " + bridge() + " up");
      for (const std::string& command : {"addr add " + address(host) + "/24 dev eth0",
                                         std::string("link set eth0 up"), std::string("link set lo up")})
        run("ip -n " + name(host) + " " + command);
    }
  }
  ~NetworkHosts() {
    for (int host = 0; host < count_; ++host) {
      run("ip link del " + cable(host));
      run("ip netns del " + name(host));
    }
    run("ip link del " + bridge());
  }
  NetworkHosts(const NetworkHosts&) = delete;
  NetworkHosts& operator=(const NetworkHosts&) = delete;

  /// -1: where the test is.
  std::string address(int host) const {
    return "10.213." + std::to_string(id_) + "." + std::to_string(host < 0 ? 254 : host + 1);
  }
  /// Its steady clock less that of the test, seconds.
  static double clock_offset(int host) { return 1000.0 * (host + 1); }
  void plug(int host, bool is_plugged) const {
    run("ip link set " + cable(host) + (is_plugged ? " up" : " down"));
  }
  /// Bytes that a host has sent, in frames of Ethernet.
  double sent_bytes(int host) const {
    double bytes = 0;
    std::ifstream("/sys/class/net/" + cable(host) + "/statistics/rx_bytes") >> bytes;
    return bytes;
  }
  /// A shell command on a host, also without its cable.
  void run_on(int host, const std::string& command) const {
    run("ip netns exec " + name(host) + " bash -c '" + command + "'");
  }
  /// The command before a program that is to run on a host; it becomes that program.
  std::string on(int host) const {
    return "unshare --time --monotonic " + std::to_string(int(clock_offset(host))) +
           " --fork --kill-child ip netns exec " + name(host) + " ";
  }

 private:
  static void run(const std::string& command) {
    EXPECT_EQ(std::system((command + " 2>/tmp/procam-network-hosts").c_str()), 0) << command;
  }
  std::string bridge() const { return "procam" + std::to_string(id_); }
  std::string cable(int host) const { return bridge() + "." + std::to_string(host); }
  std::string name(int host) const { return "procam-" + std::to_string(id_) + "-" + std::to_string(host); }
  int id_, count_;
};

/// A tool on a host: a child of `unshare`, which waits for it.
class HostedTool {
 public:
  HostedTool(const NetworkHosts& hosts, int host, const std::string& tool, const std::string& arguments,
             const fs::path& out)
      : parent_("/usr/bin/env", hosts.on(host) + PROCAM_TOOLS + "/" + tool + " " + arguments, out) {}
  /// To the tool itself.
  void tell(int signal) {
    pid_t child = 0;
    const std::string process = std::to_string(parent_.process());
    std::ifstream("/proc/" + process + "/task/" + process + "/children") >> child;
    if (child > 0) kill(child, signal);
  }
  int wait() { return parent_.wait(); }

 private:
  Running parent_;
};

}  // namespace procam::test
