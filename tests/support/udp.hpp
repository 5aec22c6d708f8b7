#pragma once
/// Datagrams to a port of this machine.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace procam::test {

/// A port that was free a moment ago.
inline std::string free_udp_port() {
  const int handle = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  bind(handle, reinterpret_cast<sockaddr*>(&address), sizeof address);
  socklen_t size = sizeof address;
  getsockname(handle, reinterpret_cast<sockaddr*>(&address), &size);
  close(handle);
  return std::to_string(ntohs(address.sin_port));
}

class UdpSender {
 public:
  explicit UdpSender(const std::string& port) : port_(port), handle_(socket(AF_INET, SOCK_DGRAM, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to_.sin_port = htons(std::uint16_t(std::stoi(port)));
  }
  ~UdpSender() { close(handle_); }
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;

  void send(const std::string& bytes) {
    sendto(handle_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
    ++sent_;
  }
  const std::string& port() const { return port_; }
  std::uint64_t sent() const { return sent_; }

 private:
  std::string port_;
  int handle_;
  sockaddr_in to_{};
  std::uint64_t sent_ = 0;
};

}  // namespace procam::test
