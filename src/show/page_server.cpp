#include "procam/show/page_server.hpp"

#include <atomic>
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <list>
#include <optional>
#include <set>
#include <thread>

#include "control_messages.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::show {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;

constexpr std::chrono::seconds kHeadPatience(limits::kPageHeadS), kRequestPatience(limits::kPageRequestS);

bool is_loopback(const tcp::endpoint& endpoint) {
  return endpoint.address().is_loopback();
}

}  // namespace

/// All of it runs in the one thread of `io`.
class PageServer::Server {
 public:
  Server(ServedPage& page, const PageServerOptions& options)
      : page_(page),
        period_(std::max(1, int(1000 * options.period_s))),
        token_(options.token.empty() ? random_token() : options.token),
        acceptor_(io_),
        timer_(io_) {
    const std::string what = options.name + " " + options.address + ":" + std::to_string(options.port);
    beast::error_code failed;
    const asio::ip::address address = asio::ip::make_address(options.address, failed);
    if (failed || options.port < 0 || options.port > 65535)
      throw Error(ErrorKind::kInput, what, "it is no address to listen on",
                  "give e.g. 127.0.0.1:8737, or 0.0.0.0:8737");
    for (const unsigned char letter : token_)
      if (std::isalnum(letter) == 0 && letter != '-' && letter != '_')
        throw Error(ErrorKind::kInput, what, "its token has other letters than a-z A-Z 0-9 - _",
                    "give another token");
    if (token_.size() < limits::kMinTokenBytes || token_.size() > limits::kMaxTokenBytes)
      throw Error(ErrorKind::kInput, what,
                  "its token has " + std::to_string(token_.size()) + " letters, and 8 to 256 are allowed",
                  "give a longer token, or none for a random one");
    const tcp::endpoint wanted(address, static_cast<unsigned short>(options.port));
    acceptor_.open(wanted.protocol(), failed);
    if (!failed) acceptor_.set_option(asio::socket_base::reuse_address(true), failed);
    if (!failed) acceptor_.bind(wanted, failed);
    if (!failed) acceptor_.listen(asio::socket_base::max_listen_connections, failed);
    if (failed)
      throw Error(ErrorKind::kDevice, what, failed.message(), "give another port, or 0 for a free one");
    endpoint_ = acceptor_.local_endpoint();
    accept();
    tick();
    thread_ = std::thread([this] { run(); });
  }

  ~Server() {
    io_.stop();
    thread_.join();
  }

  std::string url() const {
    const bool any = endpoint_.address().is_unspecified();
    const std::string host = any                           ? "localhost"
                             : endpoint_.address().is_v6() ? "[" + endpoint_.address().to_string() + "]"
                                                           : endpoint_.address().to_string();
    return "http://" + host + ":" + std::to_string(endpoint_.port()) + "/?token=" + token_;
  }

  PageFaults faults() const { return {failed_, evicted_, refused_}; }

 private:
  class WebSocketClient;
  class Request;
  friend class WebSocketClient;
  friend class Request;

  void accept();
  void tick();

  /// A request that fails is counted and ends; the others go on.
  void run() {
    while (true) try {
        io_.run();
        return;
      } catch (const std::exception&) {
        ++failed_;
      }
  }

  /// Why a request is refused; nullptr when it is fine.
  const char* refusal(const http::fields& fields, std::string_view target) const {
    const std::string host(fields[http::field::host]);
    const std::string port = ":" + std::to_string(endpoint_.port());
    if (is_loopback(endpoint_) && host != "localhost" + port && host != "127.0.0.1" + port &&
        host != "[::1]" + port)
      return "the Host is not this machine";
    const std::string origin(fields[http::field::origin]);
    if (!origin.empty() && origin != "http://" + host) return "the Origin is another site";
    if (!same_secret(token_of(target, std::string(fields[http::field::authorization])), token_))
      return "the token is missing or wrong";
    return nullptr;
  }

  const std::string& state() {
    page_.update_state(state_);
    return state_.bytes;
  }
  const std::string& image() {
    page_.update_image(image_);
    return image_.bytes;
  }

  ServedPage& page_;
  const std::chrono::milliseconds period_;
  const std::string token_;
  // What requests and lookers use at their end comes before `io_`, whose end is theirs.
  std::set<WebSocketClient*> clients_;
  std::list<Request*> strangers_;  ///< requests without the token so far, the oldest first
  std::size_t connections_ = 0;
  PageData state_, image_;
  std::atomic<std::uint64_t> failed_{0}, evicted_{0}, refused_{0};

  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  tcp::endpoint endpoint_;
  std::thread thread_;
};

/// One who has a WebSocket open.
class PageServer::Server::WebSocketClient : public std::enable_shared_from_this<WebSocketClient> {
 public:
  WebSocketClient(Server& server, beast::tcp_stream stream) : server_(server), socket_(std::move(stream)) {
    ++server_.connections_;
    server_.clients_.insert(this);
  }
  ~WebSocketClient() {
    --server_.connections_;
    server_.clients_.erase(this);
  }
  WebSocketClient(const WebSocketClient&) = delete;
  WebSocketClient& operator=(const WebSocketClient&) = delete;

  void begin(const http::request<http::string_body>& request) {
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.read_message_max(limits::kPageBodyBytes);
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code failed) {
      if (failed) return;
      self->open_ = true;
      self->read();
    });
  }

  bool is_ready_for_image() const { return open_ && has_seen_; }

  /// Sends what is new: the state first, an image when the last one has been seen.
  void send() {
    if (!open_ || writing_) return;
    if (state_sent_ != server_.state_.number || state_sent_ == 0) {
      message_ = server_.state();
      state_sent_ = std::max<std::uint64_t>(1, server_.state_.number);
      write(true);
    } else if (has_seen_ && image_sent_ != server_.image_.number && !server_.image_.bytes.empty()) {
      message_ = server_.image_.bytes;
      image_sent_ = server_.image_.number;
      has_seen_ = false;
      write(false);
    }
  }

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code failed, std::size_t) {
      if (failed) return;  // gone: nobody holds it any more
      const std::string text = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      if (text == "seen")
        self->has_seen_ = true;
      else if (!self->server_.page_.take(text)) {
        ++self->server_.refused_;
        return self->socket_.async_close(websocket::close_code::policy_error, [self](beast::error_code) {});
      }
      self->read();
    });
  }
  void write(bool is_text) {
    writing_ = true;
    socket_.text(is_text);
    socket_.async_write(asio::buffer(message_),
                        [self = shared_from_this()](beast::error_code failed, std::size_t) {
                          self->writing_ = false;
                          if (failed)
                            self->open_ = false;
                          else
                            self->send();
                        });
  }

  Server& server_;
  websocket::stream<beast::tcp_stream, false> socket_;  // no deflate
  beast::flat_buffer buffer_;
  std::string message_;
  bool open_ = false, writing_ = false, has_seen_ = true;
  std::uint64_t state_sent_ = 0, image_sent_ = 0;
};

class PageServer::Server::Request : public std::enable_shared_from_this<Request> {
 public:
  Request(Server& server, tcp::socket socket)
      : server_(server),
        stream_(std::move(socket)),
        buffer_(limits::kPageHeaderBytes + limits::kPageBodyBytes) {
    ++server_.connections_;
    place_ = server_.strangers_.insert(server_.strangers_.end(), this);
  }
  ~Request() {
    --server_.connections_;
    is_no_stranger();
  }
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;

  void read() {
    parser_.emplace();
    parser_->header_limit(limits::kPageHeaderBytes);
    parser_->body_limit(limits::kPageBodyBytes);
    stream_.expires_after(kHeadPatience);
    http::async_read_header(stream_, buffer_, *parser_,
                            [self = shared_from_this()](beast::error_code failed, std::size_t bytes) {
                              // The parser checks its limit only while the end of the head is missing.
                              if (!failed && bytes > limits::kPageHeaderBytes)
                                failed = http::error::header_limit;
                              if (failed) return self->refuse(failed);
                              if (self->refusal() == nullptr) self->is_no_stranger();
                              self->read_body();
                            });
  }

  /// Its place is needed for another.
  void evict() {
    is_no_stranger();
    stream_.close();
  }

 private:
  void read_body() {
    stream_.expires_after(kRequestPatience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code failed, std::size_t) {
                       if (failed) return self->refuse(failed);
                       self->handle();
                     });
  }

  void refuse(beast::error_code failed) {
    if (failed == http::error::body_limit)
      return answer(http::status::payload_too_large, "text/plain", "too large\n");
    if (failed == http::error::header_limit)
      return answer(http::status::request_header_fields_too_large, "text/plain", "too large\n");
    if (failed == beast::error::timeout) ++server_.refused_;
    if (failed == http::error::end_of_stream || failed == beast::error::timeout ||
        failed == asio::error::operation_aborted)
      return;
    answer(http::status::bad_request, "text/plain", "no request\n");
  }

  void is_no_stranger() {
    if (place_ == server_.strangers_.end()) return;
    server_.strangers_.erase(place_);
    place_ = server_.strangers_.end();
  }

  const char* refusal() const {
    const http::request<http::string_body>& request = parser_->get();
    return server_.refusal(request, std::string(request.target()));
  }

  void handle() {
    const http::request<http::string_body>& request = parser_->get();
    const std::string target(request.target());
    const std::string path = target.substr(0, target.find('?'));
    if (const char* why = refusal())
      return answer(http::status::forbidden, "text/plain", std::string("refused: ") + why + "\n");
    if (path == "/command") {
      if (request.method() != http::verb::post)
        return answer(http::status::method_not_allowed, "text/plain", "POST it\n");
      const bool good = server_.page_.take(request.body());
      return good ? answer(http::status::accepted, "text/plain", "accepted\n")
                  : answer(http::status::bad_request, "text/plain", "no command\n");
    }
    if (request.method() != http::verb::get)
      return answer(http::status::method_not_allowed, "text/plain", "GET it\n");
    if (path == "/ws") {
      if (!websocket::is_upgrade(request))
        return answer(http::status::upgrade_required, "text/plain", "a WebSocket\n");
      stream_.expires_never();
      std::make_shared<WebSocketClient>(server_, std::move(stream_))->begin(request);
      return;
    }
    if (path == "/") return answer(http::status::ok, "text/html; charset=utf-8", server_.page_.html());
    if (path == "/status") return answer(http::status::ok, "application/json", server_.state());
    if (path == "/frame.jpg") {
      const std::string& picture = server_.image();
      return picture.empty() ? answer(http::status::service_unavailable, "text/plain", "no frame yet\n")
                             : answer(http::status::ok, "image/jpeg", picture);
    }
    if (const std::optional<PageFile> file = server_.page_.file(path))
      return answer(http::status::ok, file->type.c_str(), file->bytes);
    answer(http::status::not_found, "text/plain", "there is no such page\n");
  }

  void answer(http::status status, const char* type, const std::string& body) {
    if (http::to_status_class(status) == http::status_class::client_error &&
        status != http::status::not_found)
      ++server_.refused_;
    response_.emplace(status, 11);
    response_->set(http::field::content_type, type);
    response_->set(http::field::cache_control, "no-store");
    response_->set(http::field::x_frame_options, "DENY");
    response_->set("Referrer-Policy", "no-referrer");
    response_->set("X-Content-Type-Options", "nosniff");
    response_->set("Content-Security-Policy",
                   "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src "
                   "'self' blob: data:; "
                   "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    response_->body() = body;
    response_->keep_alive(false);
    response_->prepare_payload();
    stream_.expires_after(kRequestPatience);
    http::async_write(stream_, *response_, [self = shared_from_this()](beast::error_code, std::size_t) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  Server& server_;
  std::list<Request*>::iterator place_;  ///< among the strangers; their end(): it has the token
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<http::response<http::string_body>> response_;
};

void PageServer::Server::accept() {
  acceptor_.async_accept([this](beast::error_code failed, tcp::socket socket) {
    // Whoever has the token keeps a place; of the others the oldest gives way to the newest.
    if (!failed && connections_ >= limits::kPageConnections && !strangers_.empty()) {
      ++evicted_;
      strangers_.front()->evict();
      std::make_shared<Request>(*this, std::move(socket))->read();
    } else if (!failed && connections_ < limits::kPageConnections)
      std::make_shared<Request>(*this, std::move(socket))->read();
    else if (!failed)
      ++refused_;
    // Out of files: the next try must not spin.
    if (failed && failed != asio::error::operation_aborted) {
      ++failed_;
      auto later = std::make_shared<asio::steady_timer>(io_, std::chrono::milliseconds(100));
      later->async_wait([this, later](beast::error_code) { accept(); });
    } else if (!failed) {
      accept();
    }
  });
}

void PageServer::Server::tick() {
  timer_.expires_after(period_);
  timer_.async_wait([this](beast::error_code failed) {
    if (failed) return;
    tick();  // first, so that a fault below does not end it
    page_.tick();
    if (!clients_.empty()) {
      state();
      bool wanted = false;
      for (WebSocketClient* client : clients_) wanted = wanted || client->is_ready_for_image();
      if (wanted) image();
      for (WebSocketClient* client : clients_) client->send();
    }
  });
}

PageServerOptions parse_page_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  PageServerOptions options;
  if (colon != std::string::npos) options.address = text.substr(0, colon);
  if (options.address.size() > 2 && options.address.front() == '[')
    options.address = options.address.substr(1, options.address.size() - 2);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos)
    throw Error(ErrorKind::kInput, "control " + text, "it does not end in a port",
                "give e.g. 8737, 0.0.0.0:8737 or off");
  options.port = std::stoi(port);
  return options;
}

PageServer::PageServer(ServedPage& page, const PageServerOptions& options)
    : server_(std::make_unique<Server>(page, options)) {}
PageServer::~PageServer() = default;
std::string PageServer::url() const {
  return server_->url();
}
PageFaults PageServer::faults() const {
  return server_->faults();
}

}  // namespace procam::show
