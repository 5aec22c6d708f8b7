// The control page: requests, commands and WebSocket frames through its own port; and the editor behind it.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "draws.hpp"
#include "fuzz_target.hpp"
#include "io/examples.hpp"
#include "procam/io/surface_file.hpp"
#include "show/control_page.hpp"
#include "show/editor.hpp"
#include "targets.hpp"

namespace procam::fuzz {
namespace {

constexpr const char* kToken = "fuzzing-it";

int port_of(const std::string& url) {
  return std::stoi(url.substr(url.rfind(':') + 1));
}

/// A connection that sends everything, ends its side, and reads to the end.
class PageClient {
 public:
  explicit PageClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(std::uint16_t(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    // A dead page must not stop the search; a living one answers far sooner.
    const timeval patience{20, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    check(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0,
          "the page takes no connection");
  }
  PageClient(const PageClient&) = delete;
  PageClient& operator=(const PageClient&) = delete;
  ~PageClient() { ::close(socket_); }

  void send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;  // refused before the end
      bytes.remove_prefix(std::size_t(sent));
    }
  }
  void end() { ::shutdown(socket_, SHUT_WR); }
  /// The next bytes of the answer; empty at its end.
  std::string receive() {
    char buffer[4096];
    const ssize_t count = ::recv(socket_, buffer, sizeof buffer, 0);
    check(count >= 0 || errno == ECONNRESET, "the page neither answers nor closes");
    return count > 0 ? std::string(buffer, std::size_t(count)) : "";
  }

 private:
  int socket_;
};

std::string with_head(const std::string& first_line, int port, const std::string& more) {
  return first_line + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\nAuthorization: Bearer " +
         kToken + "\r\n" + more + "\r\n";
}

}  // namespace

/// The first byte chooses: a whole request, a command, or frames of a WebSocket.
void http(std::string_view bytes) {
  static show::ControlPage page({"127.0.0.1", 0, kToken});
  static const int port = [] {
    const std::string url = page.url();
    return port_of(url.substr(0, url.find("/?")));
  }();
  Draws draws(bytes);
  const std::size_t kind = draws.below(3);
  const std::string rest(draws.rest().substr(0, 20000));
  PageClient client(port);
  if (kind == 0) {
    client.send(rest);
  } else if (kind == 1) {
    client.send(with_head("POST /command", port, "Content-Length: " + std::to_string(rest.size()) + "\r\n") +
                rest);
  } else {
    client.send(with_head("GET /ws", port,
                          "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                          "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"));
    check(client.receive().rfind("HTTP/1.1 101", 0) == 0, "the page refuses a WebSocket");
    client.send(rest);
  }
  client.end();
  while (!client.receive().empty()) continue;
  for (const show::Command& command : page.take()) check(!command.verb.empty(), "a command without a verb");
}

/// Drawn commands. Whatever was asked for, the surfaces can be written and read.
void editor(std::string_view bytes) {
  constexpr const char* kVerbs[] = {"move", "nudge", "add",    "remove", "rename", "content",
                                    "mask", "hole",  "unmask", "shape",  "other"};
  static const Projector projector = test::example_rig().projectors[0].projector;
  store("roof.obj", test::kRoof);
  SurfaceSet few = test::example_surfaces();
  few.surfaces.resize(2);
  show::Editor editor(few);
  Draws draws(bytes);
  for (int i = 0; i < 40 && !draws.empty(); ++i) {
    SolvedSurfaceSet solved;
    for (const Surface& surface : editor.surfaces().surfaces) {
      const bool is_plane = std::holds_alternative<PlanarSurface>(surface.geometry);
      SolvedSurface placed;
      placed.surface = surface;
      if (is_plane) placed.placement = PlacedPlane{Mat3::Identity(), test::lopsided_pose(0.1)};
      solved.surfaces.push_back(placed);
    }
    show::Command command;
    command.verb = kVerbs[draws.below(11)];
    const auto name = [&] { return draws.yes() ? std::string("wall") : std::string(draws.piece()); };
    command.surface = name();
    command.point = int(draws.below(8)) - 2;
    command.pixels = Vec2(draws.number(), draws.number());
    command.text = name();
    command.gesture = draws.yes() ? "drag" : "";
    if (command.verb == "shape" && draws.yes()) command.text = draws.yes() ? "grid 4x3" : "bezier 16x2";
    for (std::size_t corners = draws.below(6); corners > 0; --corners)
      command.ring.emplace_back(draws.number(), draws.number());
    try {
      editor.apply(command, projector, solved);
    } catch (const Error&) {
      draws.yes() ? editor.undo() : editor.redo();
    }
  }
  const std::string text = io::surfaces_to_text(editor.surfaces());
  must("reading the edited surfaces",
       [&] { return io::surfaces_from_text(text, folder() / "surfaces.json"); });
}

}  // namespace procam::fuzz
