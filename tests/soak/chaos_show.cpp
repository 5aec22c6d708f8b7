#include "chaos_show.hpp"

#include <poll.h>
#include <sys/time.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "support/local_socket.hpp"

namespace procam::test {
namespace {

constexpr const char* kToken = "chaos_token_0123";

std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}
int http_status(const std::string& answer) {
  return answer.size() > 12 ? std::atoi(answer.c_str() + 9) : 0;
}

}  // namespace

std::string talk(int port, const std::string& bytes, double timeout_s) {
  const Socket client(SOCK_STREAM);
  const sockaddr_in address = loopback(port);
  timeval patience{};
  patience.tv_sec = time_t(timeout_s);
  setsockopt(client.handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(client.handle(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  if (connect(client.handle(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return "";
  (void)!send(client.handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  std::string answer;
  char some[4096];
  for (ssize_t size = 0; (size = recv(client.handle(), some, sizeof some, 0)) > 0;)
    answer.append(some, std::size_t(size));
  return answer;
}

ChaosShow::ChaosShow(std::string name, const std::string& flags, fs::path out)
    : name_(std::move(name)), out_(std::move(out)), port_(free_port(SOCK_STREAM)) {
  running_ = std::make_unique<Running>(
      "project-live",
      flags + " --json --threads 1 --token " + kToken + " --control 127.0.0.1:" + std::to_string(port_),
      out_);
}

std::string ChaosShow::request(const std::string& what, const std::string& lines,
                               const std::string& body) const {
  return what + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port_) + "\r\nAuthorization: Bearer " +
         kToken + "\r\n" + lines +
         (body.empty() ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n") + "\r\n" + body;
}

std::string ChaosShow::get(const std::string& path) const {
  const std::string answer = talk(port_, request("GET " + path));
  return http_status(answer) == 200 ? body_of(answer) : "";
}

int ChaosShow::command(const nlohmann::json& command) const {
  return http_status(talk(port_, request("POST /command", "", command.dump())));
}

std::map<std::string, double> ChaosShow::metrics() const {
  std::map<std::string, double> found;
  std::istringstream lines(get("/metrics"));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.rfind(' ');
    if (line.rfind("procam_", 0) != 0 || space == std::string::npos) continue;
    std::string name = line.substr(7, space - 7);
    if (const std::size_t label = name.find("{name=\""); label != std::string::npos)
      name = name.substr(0, label) + "/" + name.substr(label + 7, name.rfind('"') - label - 7);
    if (const std::size_t total = name.find("_total"); total != std::string::npos) name.erase(total, 6);
    found[name] = std::atof(line.c_str() + space);
  }
  return found;
}

double ChaosShow::metric(const std::string& name) const {
  const auto all = metrics();
  const auto found = all.find(name);
  return found == all.end() ? 0 : found->second;
}

nlohmann::json ChaosShow::status() const {
  return nlohmann::json::parse(get("/status"), nullptr, false);
}

Resources ChaosShow::resources() const {
  Resources now;
  now.memory_mib = running_->memory() / (1 << 20);
  const std::string proc = "/proc/" + std::to_string(process());
  std::error_code ignored;
  for (fs::directory_iterator entry(proc + "/fd", ignored), end; !ignored && entry != end;
       entry.increment(ignored))
    ++now.descriptors;
  for (fs::directory_iterator entry(proc + "/task", ignored), end; !ignored && entry != end;
       entry.increment(ignored))
    ++now.threads;
  return now;
}

nlohmann::json ChaosShow::end(int& exit_code) {
  running_->tell(SIGTERM);
  for (int i = 0; i < 600 && running_->is_running(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  exit_code = running_->is_running() ? -1 : running_->wait();
  return nlohmann::json::parse(slurp(out_), nullptr, false);
}

}  // namespace procam::test
