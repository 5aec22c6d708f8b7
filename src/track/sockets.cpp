// UDP and TCP: everything that needs Asio alone.
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>

#include "inbox.hpp"
#include "procam/core/error.hpp"
#include "sources.hpp"

namespace procam::track::internal {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Failure = boost::system::error_code;

/// Steady, and what a person may read.
std::string name_of(const HostPort& at) {
  return (at.host.empty() ? "*" : at.host) + ":" + std::to_string(at.port);
}

asio::ip::address address_of(const HostPort& at) {
  if (at.host.empty()) return asio::ip::address_v4::any();
  Failure failure;
  const std::string host = at.host == "localhost" ? "127.0.0.1" : at.host;
  const asio::ip::address address = asio::ip::make_address(host, failure);
  if (failure)
    throw Error(ErrorKind::kInput, "'" + at.host + "'", "it is no address of this machine",
                "give a numeric address such as 127.0.0.1, or the port alone for every interface");
  return address;
}

[[noreturn]] void cannot_listen(const std::string& where, const Failure& failure) {
  throw Error(ErrorKind::kDevice, where, "this port cannot be listened on: " + failure.message(),
              "end the program that has it, or choose another");
}

/// A source whose thread runs its io_context until the end.
class ThreadedSource : public PoseSource {
 public:
  explicit ThreadedSource(const SourceOptions& options) : inbox_(options) {}
  ~ThreadedSource() override { stop(); }
  void poll(std::vector<StampedPose>& arrived) override { inbox_.poll(arrived); }
  SourceStatus status() const override { return inbox_.status(); }

 protected:
  void start() {
    thread_ = std::thread([this] { io_.run(); });
  }
  /// Before the members that the handlers use go.
  void stop() {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Inbox inbox_;
  asio::io_context io_{1};

 private:
  std::thread thread_;
};

class UdpSource : public ThreadedSource {
 public:
  using Parser = Parsed (*)(std::string_view);
  UdpSource(const HostPort& at, const asio::ip::address& group, Parser parser, const SourceOptions& options)
      : ThreadedSource(options), parser_(parser), socket_(io_) {
    const bool joins = group.is_multicast();
    const udp::endpoint endpoint(joins ? asio::ip::address(asio::ip::address_v4::any()) : address_of(at),
                                 at.port);
    Failure failure;
    socket_.open(endpoint.protocol(), failure);
    // Several programs may listen to one group; a port of one's own is nobody else's.
    if (!failure && joins) socket_.set_option(udp::socket::reuse_address(true), failure);
    if (!failure) socket_.bind(endpoint, failure);
    if (!failure && joins) socket_.set_option(asio::ip::multicast::join_group(group), failure);
    if (!failure) socket_.non_blocking(true, failure);
    if (failure) cannot_listen("udp " + name_of(at), failure);
    // Room for the bursts of a busy second; less is no failure.
    socket_.set_option(udp::socket::receive_buffer_size(1 << 20), failure);
    inbox_.connected();
    wait();
    start();
  }
  ~UdpSource() override { stop(); }

 private:
  void wait() {
    socket_.async_wait(udp::socket::wait_read, [this](const Failure& failure) {
      if (failure == asio::error::operation_aborted) return;
      // All that is there, but no more than a burst: others wait for this thread as well.
      for (int i = 0; i < 256; ++i) {
        Failure failed;
        udp::endpoint sender;
        const std::size_t size = socket_.receive_from(asio::buffer(datagram_), sender, 0, failed);
        if (failed == asio::error::would_block) break;
        if (failed) {
          inbox_.failed(failed.message());
          break;
        }
        const double arrival = steady_now();
        inbox_.put(parser_(std::string_view(datagram_.data(), size)), arrival, size);
      }
      wait();
    });
  }

  Parser parser_;
  udp::socket socket_;
  std::array<char, 65536> datagram_;
};

/// Reads a stream until it ends.
class TcpReader {
 public:
  TcpReader(tcp::socket socket, Inbox& inbox) : socket_(std::move(socket)), inbox_(inbox) {
    inbox_.connected();
  }
  template <typename Ended>
  void read(Ended ended) {
    socket_.async_read_some(asio::buffer(bytes_), [this, ended](const Failure& failure, std::size_t size) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) {
        inbox_.disconnected(failure == asio::error::eof ? "the sender closed the connection"
                                                        : failure.message());
        ended();
        return;
      }
      const double arrival = steady_now();
      inbox_.put(parser_.parse(std::string_view(bytes_.data(), size)), arrival, size);
      read(ended);
    });
  }

 private:
  tcp::socket socket_;
  Inbox& inbox_;
  StreamParser parser_;
  std::array<char, 16384> bytes_;
};

class TcpSource : public ThreadedSource {
 public:
  TcpSource(HostPort at, const SourceOptions& options)
      : ThreadedSource(options), at_(std::move(at)), resolver_(io_), timer_(io_) {
    connect();
    start();
  }
  ~TcpSource() override { stop(); }

 private:
  void connect() {
    resolver_.async_resolve(at_.host, std::to_string(at_.port),
                            [this](const Failure& failure, const tcp::resolver::results_type& found) {
                              if (failure) return again(failure.message());
                              socket_.emplace(io_);
                              give_up_after_a_while();
                              asio::async_connect(
                                  *socket_, found,
                                  [this](const Failure& failed, const tcp::endpoint&) { connected(failed); });
                            });
  }
  /// A host that swallows packets would hold the system's connect for minutes.
  void give_up_after_a_while() {
    timer_.expires_after(std::chrono::seconds(5));
    timer_.async_wait([this](const Failure& failure) {
      Failure ignored;
      if (!failure && socket_) socket_->close(ignored);
    });
  }
  void connected(const Failure& failure) {
    timer_.cancel();
    if (failure) return again("no connection to " + name_of(at_) + ": " + failure.message());
    back_off_.reset();
    socket_->set_option(asio::socket_base::keep_alive(true));
    reader_ = std::make_unique<TcpReader>(std::move(*socket_), inbox_);
    reader_->read([this] { again({}); });
  }
  void again(const std::string& why) {
    if (!why.empty()) inbox_.failed(why);
    timer_.expires_after(std::chrono::milliseconds(int(1e3 * back_off_.next())));
    timer_.async_wait([this](const Failure& failure) {
      if (!failure) connect();
    });
  }

  HostPort at_;
  tcp::resolver resolver_;
  asio::steady_timer timer_;
  BackOff back_off_;
  std::optional<tcp::socket> socket_;
  std::unique_ptr<TcpReader> reader_;
};

class TcpListener : public ThreadedSource {
 public:
  TcpListener(const HostPort& at, const SourceOptions& options) : ThreadedSource(options), acceptor_(io_) {
    const tcp::endpoint endpoint(address_of(at), at.port);
    Failure failure;
    acceptor_.open(endpoint.protocol(), failure);
    // A port that its last user left a minute ago is free.
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(kMostSenders, failure);
    if (failure) cannot_listen("tcp " + name_of(at), failure);
    accept();
    start();
  }
  ~TcpListener() override { stop(); }

 private:
  static constexpr int kMostSenders = 8;

  void accept() {
    acceptor_.async_accept([this](const Failure& failure, tcp::socket socket) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) {
        inbox_.failed(failure.message());
      } else if (auto* seat = free_seat()) {
        *seat = std::make_unique<TcpReader>(std::move(socket), inbox_);
        (*seat)->read([this, seat] { asio::post(io_, [seat] { seat->reset(); }); });
      } else {
        inbox_.failed("more than 8 senders: the last was sent away");
      }
      accept();
    });
  }
  std::unique_ptr<TcpReader>* free_seat() {
    for (auto& seat : seats_)
      if (!seat) return &seat;
    return nullptr;
  }

  tcp::acceptor acceptor_;
  std::array<std::unique_ptr<TcpReader>, kMostSenders> seats_;
};

}  // namespace

std::unique_ptr<PoseSource> open_udp(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<UdpSource>(parse_host_port(rest), asio::ip::address(), parse_poses, options);
}
std::unique_ptr<PoseSource> open_osc(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<UdpSource>(parse_host_port(rest), asio::ip::address(), parse_osc, options);
}
std::unique_ptr<PoseSource> open_psn(const std::string& rest, const SourceOptions& options) {
  HostPort at = parse_host_port(rest);
  if (at.host.empty()) at.host = "236.10.10.10";  // the standard's group
  const asio::ip::address address = address_of(at);
  return std::make_unique<UdpSource>(at, address.is_multicast() ? address : asio::ip::address(), parse_psn,
                                     options);
}
std::unique_ptr<PoseSource> open_tcp(const std::string& rest, const SourceOptions& options) {
  HostPort at = parse_host_port(rest);
  if (at.host.empty())
    throw Error(ErrorKind::kInput, "tcp:" + rest, "the host is missing",
                "give tcp:HOST:PORT, or tcp-listen:PORT where the sender connects");
  return std::make_unique<TcpSource>(std::move(at), options);
}
std::unique_ptr<PoseSource> open_tcp_listener(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<TcpListener>(parse_host_port(rest), options);
}

}  // namespace procam::track::internal
