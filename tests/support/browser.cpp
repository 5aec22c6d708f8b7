#include "support/browser.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

namespace procam::test {

namespace asio = boost::asio;
namespace beast = boost::beast;
using nlohmann::json;

struct Browser::State {
  std::filesystem::path profile;
  pid_t process = -1;
  asio::io_context io;
  std::optional<beast::websocket::stream<asio::ip::tcp::socket>> socket;
  std::string session, console;
  int next = 0;

  /// Sends a command and waits for its answer; events on the way are read for the console.
  json call(const std::string& method, json parameters) {
    json message = {{"id", ++next}, {"method", method}, {"params", std::move(parameters)}};
    if (!session.empty()) message["sessionId"] = session;
    socket->write(asio::buffer(message.dump()));
    while (true) {
      beast::flat_buffer buffer;
      socket->read(buffer);
      const json answer = json::parse(beast::buffers_to_string(buffer.data()));
      if (answer.value("id", 0) == next) return answer.value("result", json::object());
      const std::string event = answer.value("method", "");
      if (event == "Runtime.consoleAPICalled" || event == "Runtime.exceptionThrown" ||
          event == "Log.entryAdded")
        console += answer["params"].dump() + "\n";
    }
  }
};

Browser::Browser(int width, int height) : state_(std::make_unique<State>()) {
  std::string name = (std::filesystem::temp_directory_path() / "procam_browser_XXXXXX").string();
  state_->profile = mkdtemp(name.data());
  int lines[2];
  if (pipe(lines) != 0) return;
  state_->process = fork();
  if (state_->process == 0) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(lines[1], STDERR_FILENO);
    close(lines[0]);
    const std::string profile = "--user-data-dir=" + state_->profile.string();
    const std::string size = "--window-size=" + std::to_string(width) + "," + std::to_string(height);
    execlp("chromium", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
           "--no-first-run", "--remote-debugging-port=0", profile.c_str(), size.c_str(), "about:blank",
           static_cast<char*>(nullptr));
    _exit(127);
  }
  close(lines[1]);
  // "DevTools listening on ws://127.0.0.1:PORT/devtools/browser/ID"
  std::string said, address;
  for (char letter = 0; address.empty();) {
    pollfd waits{lines[0], POLLIN, 0};
    if (::poll(&waits, 1, 30000) <= 0 || ::read(lines[0], &letter, 1) != 1) break;
    if (letter != '\n') {
      said += letter;
      continue;
    }
    const std::size_t at = said.find("ws://");
    if (at != std::string::npos) address = said.substr(at + 5);
    said.clear();
  }
  // Its later words are not to stop it at a full pipe.
  std::thread([from = lines[0]] {
    char rest[4096];
    while (::read(from, rest, sizeof rest) > 0) {
    }
    close(from);
  }).detach();
  if (address.empty()) return;
  const std::string host = address.substr(0, address.find('/'));
  const std::string port = host.substr(host.find(':') + 1);
  state_->socket.emplace(state_->io);
  asio::ip::tcp::resolver resolver(state_->io);
  asio::connect(state_->socket->next_layer(), resolver.resolve("127.0.0.1", port));
  state_->socket->read_message_max(64 << 20);
  state_->socket->handshake(host, address.substr(address.find('/')));
  const json target = state_->call("Target.createTarget", {{"url", "about:blank"}});
  state_->session =
      state_->call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})
          .value("sessionId", "");
  for (const char* domain : {"Page.enable", "Runtime.enable", "Log.enable"})
    state_->call(domain, json::object());
  state_->call("Emulation.setDeviceMetricsOverride",
               {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

Browser::~Browser() {
  if (state_->process > 0) {
    kill(-state_->process, SIGKILL);
    kill(state_->process, SIGKILL);
    waitpid(state_->process, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(state_->profile, ignored);
}

bool Browser::is_running() const {
  return !state_->session.empty();
}
void Browser::open(const std::string& url) {
  state_->call("Page.navigate", {{"url", url}});
}
std::string Browser::evaluate(const std::string& expression) {
  const json answer = state_->call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}});
  if (answer.contains("exceptionDetails") || !answer.contains("result")) return "null";
  return answer["result"].value("value", json(nullptr)).dump();
}
bool Browser::wait_for(const std::string& expression) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (evaluate(expression) != "true") {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}
void Browser::mouse(const std::string& what, double x, double y) {
  state_->call("Input.dispatchMouseEvent", {{"type", what},
                                            {"x", x},
                                            {"y", y},
                                            {"button", "left"},
                                            {"buttons", what == "mouseReleased" ? 0 : 1},
                                            {"clickCount", 1}});
}
void Browser::press(const std::string& key) {
  // The browser's own elements go by the number of the key.
  const int number = key == "ArrowLeft"    ? 37
                     : key == "ArrowUp"    ? 38
                     : key == "ArrowRight" ? 39
                     : key == "ArrowDown"  ? 40
                     : key == "Tab"        ? 9
                     : key == "Escape"     ? 27
                                           : 0;
  for (const char* type : {"keyDown", "keyUp"})
    state_->call("Input.dispatchKeyEvent",
                 {{"type", type}, {"key", key}, {"code", key}, {"windowsVirtualKeyCode", number}});
}
void Browser::type(const std::string& text) {
  state_->call("Input.insertText", {{"text", text}});
}
void Browser::screenshot(const std::filesystem::path& png) {
  const std::string text = state_->call("Page.captureScreenshot", {{"format", "png"}}).value("data", "");
  std::string bytes(beast::detail::base64::decoded_size(text.size()), '\0');
  bytes.resize(beast::detail::base64::decode(bytes.data(), text.data(), text.size()).first);
  std::ofstream(png, std::ios::binary) << bytes;
}
const std::string& Browser::console() const {
  return state_->console;
}

}  // namespace procam::test
