#pragma once
/// The control page of a show, as a script uses it.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "procam/core/base/clock.hpp"

namespace procam::test {

class Page {
 public:
  explicit Page(std::string port, std::string address = "127.0.0.1")
      : port_(std::move(port)), address_(std::move(address)) {}
  std::string flags() const { return " --control " + address_ + ":" + port_ + " --token secret-token"; }
  void command(const nlohmann::json& command) const { talk("POST /command", command.dump()); }
  /// Null while there is none.
  nlohmann::json status() const { return nlohmann::json::parse(talk("GET /status"), nullptr, false); }
  std::string metrics() const { return talk("GET /metrics"); }
  /// Of /metrics; NaN: it is not there.
  double metric(const std::string& name) const {
    const std::string text = talk("GET /metrics");
    const std::size_t at = text.find("\n" + name + " ");
    return at == text.npos ? std::nan("") : std::stod(text.substr(at + name.size() + 2));
  }

 private:
  /// The body of the answer; empty: nobody answers.
  std::string talk(const std::string& what, const std::string& body = "") const {
    const int handle = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = inet_addr(address_.c_str());
    to.sin_port = htons(std::uint16_t(std::stoi(port_)));
    // One that is stopped does not answer.
    const timeval patience{2, 0};
    setsockopt(handle, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::string answer;
    if (connect(handle, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
      const std::string request =
          what + " HTTP/1.1\r\nHost: " + address_ + ":" + port_ +
          "\r\nConnection: close\r\nAuthorization: Bearer secret-token\r\nContent-Length: " +
          std::to_string(body.size()) + "\r\n\r\n" + body;
      send(handle, request.data(), request.size(), MSG_NOSIGNAL);
      char bytes[4096];
      for (ssize_t count; (count = recv(handle, bytes, sizeof bytes, 0)) > 0;)
        answer.append(bytes, std::size_t(count));
    }
    close(handle);
    const std::size_t head = answer.find("\r\n\r\n");
    return head == answer.npos ? "" : answer.substr(head + 4);
  }
  std::string port_, address_;
};

inline bool becomes_true(const std::function<bool()>& is_done, double seconds = 15) {
  for (const double begin = steady_now(); steady_now() < begin + seconds;) {
    if (is_done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return is_done();
}

}  // namespace procam::test
