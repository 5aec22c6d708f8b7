#pragma once
/// A project-live under test: its process, and what it says of itself at its control page.
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "e2e/running_tool.hpp"

namespace procam::test {

/// Sends bytes to a TCP port of this machine; all that comes back until the other side closes. Empty when nobody
/// listens, or after `timeout_s` without an answer.
std::string talk(int port, const std::string& bytes, double timeout_s = 5);

/// The process' own use of the machine.
struct Resources {
  double memory_mib = 0;  ///< resident
  int descriptors = 0, threads = 0;
};

class ChaosShow {
 public:
  /// Starts project-live with these flags and a control page of its own.
  ChaosShow(std::string name, const std::string& flags, fs::path out);

  const std::string& name() const { return name_; }
  int port() const { return port_; }
  /// "GET /status ..." with the token and further header lines.
  std::string request(const std::string& what, const std::string& lines = "",
                      const std::string& body = "") const;
  /// The body of a GET with the token; empty unless the answer is 200.
  std::string get(const std::string& path) const;
  /// POSTs a command; the HTTP status of the answer, 0 without one.
  int command(const nlohmann::json& command) const;
  /// Counters of /metrics: "procam_frames_total" as "frames", "procam_faults_total{name="save"}" as "faults/save".
  std::map<std::string, double> metrics() const;
  double metric(const std::string& name) const;
  nlohmann::json status() const;

  bool is_running() { return running_->is_running(); }
  pid_t process() const { return running_->process(); }
  Resources resources() const;
  /// Ends it by SIGTERM; the statistics that it printed. Null when it printed none.
  nlohmann::json end(int& exit_code);
  std::string log() const { return slurp(out_.string() + ".err"); }

 private:
  std::string name_;
  fs::path out_;
  int port_;
  std::unique_ptr<Running> running_;
};

}  // namespace procam::test
