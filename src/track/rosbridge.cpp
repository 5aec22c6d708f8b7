// ROS through rosbridge_server: JSON in WebSocket frames (rosbridge protocol 2.1).
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <optional>
#include <thread>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/detail/inbox.hpp"
#include "procam/track/wire.hpp"
#include "sources.hpp"
#include "wire_parsers.hpp"

namespace procam::track::internal {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using Failure = boost::system::error_code;
using Socket = beast::websocket::stream<beast::tcp_stream, false>;  // no deflate

class RosbridgeSource : public PoseSource {
 public:
  RosbridgeSource(HostPort at, std::vector<std::string> topics, const SourceOptions& options)
      : inbox_(options), at_(std::move(at)), topics_(std::move(topics)), resolver_(io_), timer_(io_) {
    connect();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~RosbridgeSource() override {
    io_.stop();
    thread_.join();
  }
  void poll(std::vector<StampedPose>& arrived) override { inbox_.poll(arrived); }
  void wait(double seconds) override { inbox_.wait(seconds); }
  SourceStatus status() const override { return inbox_.status(); }

 private:
  void connect() {
    socket_.emplace(io_);
    buffer_.clear();
    resolver_.async_resolve(at_.host, std::to_string(at_.port),
                            [this](const Failure& failure, const tcp::resolver::results_type& found) {
                              if (failure) return again(failure.message());
                              beast::get_lowest_layer(*socket_).expires_after(std::chrono::seconds(5));
                              beast::get_lowest_layer(*socket_).async_connect(
                                  found,
                                  [this](const Failure& failed, const tcp::endpoint&) { connected(failed); });
                            });
  }
  void connected(const Failure& failure) {
    if (failure) return again("no connection: " + failure.message());
    beast::get_lowest_layer(*socket_).expires_never();
    // Pings an idle peer, and gives up one that does not answer.
    auto timeout = beast::websocket::stream_base::timeout::suggested(beast::role_type::client);
    timeout.handshake_timeout = std::chrono::seconds(5);
    timeout.idle_timeout = std::chrono::seconds(10);
    timeout.keep_alive_pings = true;
    socket_->set_option(timeout);
    socket_->read_message_max(limits::kRosbridgeBytes);
    socket_->async_handshake(at_.host + ":" + std::to_string(at_.port), "/", [this](const Failure& failed) {
      if (failed) return again("no WebSocket: " + failed.message());
      back_off_.reset();
      inbox_.connected();
      is_connected_ = true;
      subscribe(0);
    });
  }
  void subscribe(std::size_t i) {
    if (i == topics_.size()) return read();
    request_ =
        "{\"op\":\"subscribe\",\"topic\":\"" + topics_[i] + "\",\"throttle_rate\":0,\"queue_length\":1}";
    socket_->async_write(asio::buffer(request_), [this, i](const Failure& failure, std::size_t) {
      if (failure) return again(failure.message());
      subscribe(i + 1);
    });
  }
  void read() {
    socket_->async_read(buffer_, [this](const Failure& failure, std::size_t size) {
      if (failure) return again(failure.message());
      const double arrival = steady_now();
      const auto bytes = buffer_.cdata();
      try {
        Parsed parsed = parse_rosbridge({static_cast<const char*>(bytes.data()), bytes.size()});
        inbox_.put(parsed, parsed.poses, arrival, size);
      } catch (const std::exception& exception) {
        inbox_.refuse(std::string("a message was dropped: ") + exception.what());
      }
      buffer_.clear();
      read();
    });
  }
  void again(const std::string& why) {
    if (is_connected_) inbox_.disconnected(why);
    is_connected_ = false;
    inbox_.failed("rosbridge " + at_.host + ":" + std::to_string(at_.port) + ": " + why);
    timer_.expires_after(std::chrono::milliseconds(int(1e3 * back_off_.next())));
    timer_.async_wait([this](const Failure& failure) {
      if (!failure) connect();
    });
  }

  Inbox inbox_;
  asio::io_context io_{1};
  HostPort at_;
  std::vector<std::string> topics_;
  tcp::resolver resolver_;
  asio::steady_timer timer_;
  BackOff back_off_;
  std::optional<Socket> socket_;
  beast::flat_buffer buffer_;
  std::string request_;
  bool is_connected_ = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<PoseSource> open_rosbridge(const std::string& rest, const SourceOptions& options) {
  const std::size_t slash = rest.find('/');
  HostPort at = parse_host_port(rest.substr(0, slash));
  if (at.host.empty()) at.host = "127.0.0.1";
  std::vector<std::string> topics = {"/tf", "/amcl_pose", "/odom"};
  if (slash != rest.npos) topics = {rest.substr(slash)};
  for (const std::string& topic : topics)
    if (topic.size() < 2 || topic.find_first_of("\"\\\n") != topic.npos)
      throw Error(ErrorKind::kInput, "rosbridge:" + rest, "'" + topic + "' is no topic",
                  "give e.g. /amcl_pose");
  return std::make_unique<RosbridgeSource>(std::move(at), std::move(topics), options);
}

}  // namespace procam::track::internal
