#include "common/service_notify.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace procam::tools {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

ServiceNotifier::ServiceNotifier() : socket_(variable("NOTIFY_SOCKET")) {
  const std::string pid = variable("WATCHDOG_PID");
  const double period_us = std::atof(variable("WATCHDOG_USEC").c_str());
  if (period_us > 0 && (pid.empty() || pid == std::to_string(getpid()))) period_s_ = 0.25e-6 * period_us;
}

ServiceNotifier::~ServiceNotifier() {
  if (ready_) send("STOPPING=1");
}

void ServiceNotifier::frame_shown() {
  if (socket_.empty()) return;
  if (!ready_) send("READY=1");
  ready_ = true;
  const double now = steady_s();
  if (period_s_ <= 0 || now - sent_s_ < period_s_) return;
  sent_s_ = now;
  send("WATCHDOG=1");
}

void ServiceNotifier::send(const std::string& state) const {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (socket_.empty() || socket_.size() >= sizeof address.sun_path) return;
  std::memcpy(address.sun_path, socket_.data(), socket_.size());
  if (socket_[0] == '@') address.sun_path[0] = '\0';  // an abstract name
  const int handle = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (handle < 0) return;
  // A manager that does not listen is no fault of the show.
  (void)!sendto(handle, state.data(), state.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
                reinterpret_cast<const sockaddr*>(&address),
                socklen_t(offsetof(sockaddr_un, sun_path) + socket_.size()));
  close(handle);
}

}  // namespace procam::tools
