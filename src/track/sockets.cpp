// UDP and TCP: everything that needs Asio alone.
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>

#include "procam/core/base/error.hpp"
#include "procam/track/byte_source.hpp"
#include "procam/track/stamped_pose.hpp"
#include "sources.hpp"

namespace procam::track {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Failure = boost::system::error_code;

/// host:port for messages.
std::string name_of(const internal::HostPort& at) {
  return (at.host.empty() ? "*" : at.host) + ":" + std::to_string(at.port);
}

asio::ip::address address_of(const internal::HostPort& at) {
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
class ThreadedSource : public ByteSource {
 public:
  explicit ThreadedSource(ByteHandler& handler) : handler_(handler) {}
  ~ThreadedSource() override { stop(); }

 protected:
  void start() {
    thread_ = std::thread([this] { io_.run(); });
  }
  /// To be called before the members that the callbacks use are destroyed.
  void stop() {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }

  ByteHandler& handler_;
  asio::io_context io_{1};

 private:
  std::thread thread_;
};

class UdpSource : public ThreadedSource {
 public:
  UdpSource(const internal::HostPort& at, ByteHandler& handler) : ThreadedSource(handler), socket_(io_) {
    const asio::ip::address group = address_of(at);
    const bool joins = group.is_multicast();
    const udp::endpoint endpoint(joins ? asio::ip::address(asio::ip::address_v4::any()) : group, at.port);
    Failure failure;
    socket_.open(endpoint.protocol(), failure);
    // SO_REUSEADDR for multicast only: a unicast port must be exclusive.
    if (!failure && joins) socket_.set_option(udp::socket::reuse_address(true), failure);
    if (!failure) socket_.bind(endpoint, failure);
    if (!failure && joins) socket_.set_option(asio::ip::multicast::join_group(group), failure);
    if (!failure) socket_.non_blocking(true, failure);
    if (failure) cannot_listen("udp " + name_of(at), failure);
    // For bursts; a smaller buffer is no failure.
    socket_.set_option(udp::socket::receive_buffer_size(1 << 20), failure);
    handler_.connected(0);
    wait();
    start();
  }
  ~UdpSource() override { stop(); }

 private:
  void wait() {
    socket_.async_wait(udp::socket::wait_read, [this](const Failure& failure) {
      if (failure == asio::error::operation_aborted) return;
      // At most 256 datagrams, then the other callbacks of this thread get their turn.
      for (int i = 0; i < 256; ++i) {
        Failure failed;
        udp::endpoint sender;
        const std::size_t size = socket_.receive_from(asio::buffer(datagram_), sender, 0, failed);
        if (failed == asio::error::would_block) break;
        if (failed) {
          handler_.failed(failed.message());
          break;
        }
        handler_.received(0, std::string_view(datagram_.data(), size), steady_now());
      }
      wait();
    });
  }

  udp::socket socket_;
  std::array<char, 65536> datagram_;
};

/// Reads a stream until it ends.
class TcpReader {
 public:
  TcpReader(tcp::socket socket, int peer, ByteHandler& handler)
      : socket_(std::move(socket)), peer_(peer), handler_(handler) {
    handler_.connected(peer_);
  }
  template <typename Ended>
  void read(Ended ended) {
    socket_.async_read_some(asio::buffer(bytes_), [this, ended](const Failure& failure, std::size_t size) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) {
        handler_.disconnected(
            peer_, failure == asio::error::eof ? "the sender closed the connection" : failure.message());
        ended();
        return;
      }
      handler_.received(peer_, std::string_view(bytes_.data(), size), steady_now());
      read(ended);
    });
  }

 private:
  tcp::socket socket_;
  int peer_;
  ByteHandler& handler_;
  std::array<char, 16384> bytes_;
};

class TcpSource : public ThreadedSource {
 public:
  TcpSource(internal::HostPort at, ByteHandler& handler)
      : ThreadedSource(handler), at_(std::move(at)), resolver_(io_), timer_(io_) {
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
    reader_ = std::make_unique<TcpReader>(std::move(*socket_), 0, handler_);
    reader_->read([this] { again({}); });
  }
  void again(const std::string& why) {
    if (!why.empty()) handler_.failed(why);
    timer_.expires_after(std::chrono::milliseconds(int(1e3 * back_off_.next())));
    timer_.async_wait([this](const Failure& failure) {
      if (!failure) connect();
    });
  }

  internal::HostPort at_;
  tcp::resolver resolver_;
  asio::steady_timer timer_;
  internal::BackOff back_off_;
  std::optional<tcp::socket> socket_;
  std::unique_ptr<TcpReader> reader_;
};

class TcpListener : public ThreadedSource {
 public:
  TcpListener(const internal::HostPort& at, ByteHandler& handler) : ThreadedSource(handler), acceptor_(io_) {
    const tcp::endpoint endpoint(address_of(at), at.port);
    Failure failure;
    acceptor_.open(endpoint.protocol(), failure);
    // A port that its last user left a minute ago is free.
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(kMaxPeers, failure);
    if (failure) cannot_listen("tcp " + name_of(at), failure);
    accept();
    start();
  }
  ~TcpListener() override { stop(); }

 private:
  void accept() {
    acceptor_.async_accept([this](const Failure& failure, tcp::socket socket) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) {
        handler_.failed(failure.message());
      } else if (auto* seat = free_seat()) {
        *seat = std::make_unique<TcpReader>(std::move(socket), int(seat - seats_.data()), handler_);
        (*seat)->read([this, seat] { asio::post(io_, [seat] { seat->reset(); }); });
      } else {
        handler_.failed("more than 8 senders: the last was sent away");
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
  std::array<std::unique_ptr<TcpReader>, kMaxPeers> seats_;
};

}  // namespace

std::unique_ptr<ByteSource> open_byte_source(const std::string& text, ByteHandler& handler) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon), rest = colon == text.npos ? "" : text.substr(colon + 1);
  if (kind == "udp") return std::make_unique<UdpSource>(internal::parse_host_port(rest), handler);
  if (kind == "tcp-listen") return std::make_unique<TcpListener>(internal::parse_host_port(rest), handler);
  if (kind != "tcp")
    throw Error(ErrorKind::kInput, "byte source '" + text + "'", "this kind of source is unknown",
                "give udp:[ADDRESS:]PORT, tcp:HOST:PORT or tcp-listen:[ADDRESS:]PORT");
  internal::HostPort at = internal::parse_host_port(rest);
  if (at.host.empty())
    throw Error(ErrorKind::kInput, text, "the host is missing",
                "give tcp:HOST:PORT, or tcp-listen:PORT where the sender connects");
  return std::make_unique<TcpSource>(std::move(at), handler);
}

}  // namespace procam::track
