#pragma once
/// procam-studio as a program of its own, and a person at its page.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "support/browser.hpp"
#include "support/local_socket.hpp"

namespace procam::test {

/// Ends by kill -9 with the object.
class RunningStudio {
 public:
  RunningStudio(const std::filesystem::path& project, const std::vector<std::string>& more)
      : port_(free_port(SOCK_STREAM)) {
    const std::string tool = std::string(PROCAM_TOOLS) + "/procam-studio";
    std::vector<std::string> words = {
        tool,  project.string(), "--simulate", "--control", "127.0.0.1:" + std::to_string(port_), "--token",
        kToken};
    words.insert(words.end(), more.begin(), more.end());
    process_ = fork();
    if (process_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (std::freopen((project.string() + ".log").c_str(), "a", stdout) == nullptr) _exit(126);
    dup2(STDOUT_FILENO, STDERR_FILENO);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execv(tool.c_str(), arguments.data());
    _exit(127);
  }
  ~RunningStudio() { kill_now(); }
  RunningStudio(const RunningStudio&) = delete;
  RunningStudio& operator=(const RunningStudio&) = delete;

  void kill_now() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  bool is_running() {
    if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) == process_) process_ = -1;
    return process_ > 0;
  }
  int port() const { return port_; }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/?token=" + kToken; }

  static constexpr const char* kToken = "studio-test-token";

 private:
  int port_;
  pid_t process_ = -1;
};

/// A script at the studio's door: curl, as an operator types it.
class Script {
 public:
  explicit Script(const RunningStudio& studio) : studio_(studio) {}

  /// The status of the answer, 0 without one.
  int status(const std::string& path, const std::string& more = "") const {
    return std::atoi(run("-o /dev/null -w '%{http_code}' " + more, path).c_str());
  }
  int authorised(const std::string& path, const std::string& more = "") const {
    return status(path, std::string("-H 'Authorization: Bearer ") + RunningStudio::kToken + "' " + more);
  }
  void command(const nlohmann::json& message) const {
    EXPECT_EQ(authorised("/command", "-d '" + message.dump() + "'"), 202) << message;
  }
  nlohmann::json state() const {
    return nlohmann::json::parse(
        run(std::string("-H 'Authorization: Bearer ") + RunningStudio::kToken + "'", "/status"), nullptr,
        false);
  }
  bool wait(const std::function<bool(const nlohmann::json&)>& holds, int seconds = 60) const {
    for (int i = 0; i < 10 * seconds; ++i) {
      const nlohmann::json now = state();
      if (now.is_object() && now.contains("step") && holds(now)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }
  std::string page() const {
    return run(std::string("-H 'Authorization: Bearer ") + RunningStudio::kToken + "'", "/");
  }
  std::string projector_frame() const {
    return run(std::string("-H 'Authorization: Bearer ") + RunningStudio::kToken + "'", "/projector.png");
  }
  bool wait_for_start() const {
    return wait([](const nlohmann::json&) { return true; });
  }

 private:
  std::string run(const std::string& options, const std::string& path) const {
    const std::string line =
        "curl -s " + options + " http://127.0.0.1:" + std::to_string(studio_.port()) + path + " </dev/null";
    std::string out;
    std::FILE* pipe = popen(line.c_str(), "r");
    if (pipe == nullptr) return out;
    char bytes[4096];
    for (std::size_t count = 0; (count = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;)
      out.append(bytes, count);
    pclose(pipe);
    return out;
  }
  const RunningStudio& studio_;
};

/// Clicks, drags and keys alone; what the page shows is read from its script's state.
class Person {
 public:
  Person(int width, int height) : browser_(width, height) {}
  bool has_browser() const { return browser_.is_running(); }
  Browser& browser() { return browser_; }

  bool open(const RunningStudio& studio) {
    const auto end = now() + std::chrono::seconds(kPatience);
    while (now() < end) {
      browser_.open(studio.url());
      if (browser_.wait_for("document.readyState === 'complete'") &&
          browser_.evaluate("typeof state") == "\"object\"" &&
          browser_.wait_for("state !== null && state.step !== undefined"))
        return true;
    }
    return false;
  }
  nlohmann::json state(const std::string& field) {
    return nlohmann::json::parse(browser_.evaluate("state." + field));
  }
  /// Until a JavaScript condition is true.
  bool wait(const std::string& condition, int seconds = kPatience) {
    const auto end = now() + std::chrono::seconds(seconds);
    while (browser_.evaluate(condition) != "true") {
      if (now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
  }
  /// Until a condition is true, or the step has made no progress for that long.
  bool wait_while_it_goes_on(const std::string& condition, int seconds_without) {
    auto end = now() + std::chrono::seconds(seconds_without);
    for (std::string last; browser_.evaluate(condition) != "true";) {
      const std::string progress = browser_.evaluate(
          "JSON.stringify([state.job, state.doing, state.done, state.capture.views, state.messages])");
      if (progress != last) end = now() + std::chrono::seconds(seconds_without);
      last = progress;
      if (now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
  }
  /// Sets window.NAME once a state that the page has drawn fulfils the condition, however short.
  void note(const std::string& name, const std::string& condition) {
    browser_.evaluate("draw = (drawn => () => { drawn(); if (" + condition + ") window." + name +
                      " = true; })(draw)");
  }
  /// The middle of the element that the expression names, in the page's pixels, scrolled into view.
  std::pair<double, double> place(const std::string& element) {
    const auto at = nlohmann::json::parse(
        browser_.evaluate("(() => { const e = " + element +
                          "; e.scrollIntoView({block: 'nearest'}); const b = e.getBoundingClientRect(); "
                          "return [b.x + b.width / 2, b.y + b.height / 2]; })()"));
    if (!at.is_array()) return {-1, -1};
    return {at[0].get<double>(), at[1].get<double>()};
  }
  /// Clicks an element once it is shown, may be clicked, and nothing covers it. false: something else got the click.
  bool click(const std::string& element) {
    const auto end = now() + std::chrono::seconds(kPatience);
    for (; now() < end; std::this_thread::sleep_for(std::chrono::milliseconds(100))) {
      const auto at = nlohmann::json::parse(browser_.evaluate(
          "(() => { const e = " + element +
          "; if (!e || e.disabled || e.getBoundingClientRect().width === 0) return null;"
          " e.scrollIntoView({block: 'nearest'}); const b = e.getBoundingClientRect();"
          " const x = b.x + b.width / 2, y = b.y + b.height / 2; if (!e.contains(document.elementFromPoint(x, y))) return null;"
          " window.aimed = e; window.struck = null;"
          " addEventListener('click', event => { window.struck = event.target; }, {capture: true, once: true});"
          " return [x, y]; })()"));
      if (!at.is_array()) continue;
      click_at(at[0], at[1]);
      return browser_.evaluate("aimed.contains(struck)") == "true";
    }
    return false;
  }
  void click_at(double x, double y) {
    browser_.mouse("mouseMoved", x, y);
    browser_.mouse("mousePressed", x, y);
    browser_.mouse("mouseReleased", x, y);
  }
  /// Chooses the option by arrow keys, as a person at the keyboard does.
  bool choose(const std::string& id, const std::string& value) {
    if (!wait("[...$('" + id + "').options].some(o => o.value === '" + value + "')")) return false;
    browser_.evaluate("$('" + id + "').focus()");
    for (int i = 0; i < 10; ++i) {
      if (browser_.evaluate("$('" + id + "').value") == "\"" + value + "\"") return true;
      browser_.press("ArrowDown");
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }
  bool enter(const std::string& id, const std::string& text) {
    if (!click("$('" + id + "')")) return false;
    browser_.evaluate("$('" + id + "').select()");
    browser_.type(text);
    browser_.press("Tab");
    browser_.evaluate("$('" + id + "').blur()");
    return true;
  }
  /// Does the page take no clicks?
  bool is_inert() {
    return browser_.evaluate("[...document.querySelectorAll('nav, #panel')].every(part => part.inert)") ==
           "true";
  }
  /// A pixel of the camera's image in the page's pixels.
  std::pair<double, double> in_image(double x, double y) {
    const auto box = nlohmann::json::parse(browser_.evaluate(
        "(() => { const b = $('marks').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()"));
    const nlohmann::json size = state("camera.size");
    return {box[0].get<double>() + (x + 0.5) / size[0].get<double>() * box[2].get<double>(),
            box[1].get<double>() + (y + 0.5) / size[1].get<double>() * box[3].get<double>()};
  }

 private:
  static constexpr int kPatience = 120;  ///< seconds; on a busy machine the page's answers are slow
  static std::chrono::steady_clock::time_point now() { return std::chrono::steady_clock::now(); }
  Browser browser_;
};

}  // namespace procam::test
