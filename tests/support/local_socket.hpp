#pragma once
/// Sockets of this machine for tests of sources.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace procam::test {

inline sockaddr_in loopback(int port) {
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
inline int free_port(int type) {
  return Socket(type).bound_port();
}

}  // namespace procam::test
