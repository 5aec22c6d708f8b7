#pragma once
/// The protocol of systemd's services (sd_notify(3)): READY=1, WATCHDOG=1 and STOPPING=1 as datagrams to the socket
/// that NOTIFY_SOCKET names. Without this variable nothing is sent.
#include <string>

namespace procam::tools {

class ServiceNotifier {
 public:
  /// Reads NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceNotifier();
  /// Sends STOPPING=1 after READY=1.
  ~ServiceNotifier();
  ServiceNotifier(const ServiceNotifier&) = delete;
  ServiceNotifier& operator=(const ServiceNotifier&) = delete;

  /// After each frame: READY=1 at the first, then WATCHDOG=1 four times in the watchdog's period. A show that
  /// hangs sends nothing, and the service manager starts it again.
  void frame_shown();

 private:
  void send(const std::string& state) const;

  std::string socket_;
  double period_s_ = 0;  ///< between two WATCHDOG=1; 0: no watchdog
  double sent_s_ = 0;
  bool ready_ = false;
};

}  // namespace procam::tools
