#pragma once
/// A small web server for one page that several people may have open: the page, its state as JSON and its newest image go
/// out, messages come in.
///
///   class Counter : public show::ServedPage { ... };
///   Counter counter;
///   show::PageServer server(counter, {});
///   std::cout << server.url() << "\n";                // http://127.0.0.1:8737/?token=...
///
/// | request | answer |
/// |---|---|
/// | GET / | the page: one file, nothing from elsewhere |
/// | GET /ws | WebSocket: states (text) and images (binary) out, messages in; the page answers an image with "seen" |
/// | GET /frame.jpg | the newest image |
/// | GET /status | the newest state, JSON |
/// | POST /command | one message, JSON: for scripts |
/// | GET another path | ServedPage::file() |
///
/// Every request needs the token, as ?token= or as "Authorization: Bearer". On loopback the Host must be one
/// of loopback's names (a page elsewhere that has its name pointed here gets nothing), and an Origin, if
/// there is one, must be this server. Headers are limited to 8 KB and three seconds, bodies and messages to
/// 16 KB, each request to ten seconds more, and connections to 32; what is over is refused or closed. When all
/// 32 are taken, the oldest one that has not given the token is closed for the next.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::show {

struct PageServerOptions {
  std::string address = "127.0.0.1";  ///< to listen on; another machine needs this one's, or 0.0.0.0
  int port = 8737;                    ///< 0: a free one
  std::string token;                  ///< 8 to 256 letters of a-z A-Z 0-9 - _; empty: 128 random bits
  double period_s = 0.1;              ///< between two states or images of one client, at least
  std::string name = "control page";  ///< in errors
};

/// Address, port and token of "[ADDRESS:]PORT". Throws Error(kInput) for other text.
PROCAM_EXPORT PageServerOptions parse_page_address(const std::string& text);

/// The bytes that go out and their number, another one after each change.
struct PageData {
  std::string bytes;
  std::uint64_t number = 0;
};

struct PageFile {
  std::string type;  ///< "text/html; charset=utf-8"
  std::string bytes;
};

/// What is served. All functions are called in the server's thread.
class PROCAM_EXPORT ServedPage {
 public:
  virtual ~ServedPage() = default;
  virtual const char* html() = 0;
  /// A message of a page or a script. false: it is invalid, or too many wait; the sender is refused.
  virtual bool take(const std::string& message) = 0;
  /// Replaces the state (JSON) and its number where it has changed.
  virtual void update_state(PageData& state) = 0;
  /// The same for the image (JPEG).
  virtual void update_image(PageData& image) = 0;
  /// The answer to GET `path`; nullopt: there is no such page.
  virtual std::optional<PageFile> file(const std::string& path) = 0;
  /// Called every PageServerOptions::period_s.
  virtual void tick() {}
};

/// Counted since the begin.
struct PageFaults {
  std::uint64_t failed = 0;   ///< requests that failed in the server, connections that it could not accept
  std::uint64_t evicted = 0;  ///< connections that were closed for others
  /// Requests and messages without the token, too large, incomplete after their time, or invalid.
  std::uint64_t refused = 0;
};

/// An image (grey or RGB) as JPEG, reduced to that width. Two threads may call it at once.
PROCAM_EXPORT std::string to_jpeg(ViewU8 image, int max_width = 960);

/// Serves in a thread of its own.
class PROCAM_EXPORT PageServer {
 public:
  /// Throws Error(kDevice) when the address cannot be listened on, Error(kInput) for an invalid one. `page` must outlive
  /// the server.
  PageServer(ServedPage& page, const PageServerOptions& options);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::string url() const;
  PageFaults faults() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace procam::show
