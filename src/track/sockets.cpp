// UDP and TCP: everything that needs Asio alone.
#include <netinet/tcp.h>

#include <algorithm>
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
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

/// Nothing that a message contains ends the source's thread.
void deliver(ByteHandler& handler, int peer, std::string_view bytes, double arrival) {
  try {
    handler.received(peer, bytes, arrival);
  } catch (const std::exception& exception) {
    handler.failed(std::string("a message was dropped: ") + exception.what());
  }
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
        deliver(handler_, 0, std::string_view(datagram_.data(), size), steady_now());
      }
      wait();
    });
  }

  udp::socket socket_;
  std::array<char, 65536> datagram_;
};

/// The system asks a silent peer after 10 s whether it is there, and gives it up after 15 s without an answer.
void keep_alive(tcp::socket& socket) {
  Failure ignored;  // a connection that has just ended fails here and is seen when it is read
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const int idle_s = 10, interval_s = 5, count = 3;
  (void)::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
  (void)::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPINTVL, &interval_s, sizeof interval_s);
  (void)::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPCNT, &count, sizeof count);
}

/// Reads a stream until it ends. A read that is under way keeps its reader.
class TcpReader : public std::enable_shared_from_this<TcpReader> {
 public:
  TcpReader(tcp::socket socket, int peer, ByteHandler& handler)
      : socket_(std::move(socket)), peer_(peer), handler_(handler) {
    keep_alive(socket_);
    handler_.connected(peer_);
  }
  template <typename Ended>
  void read(Ended ended) {
    socket_.async_read_some(asio::buffer(bytes_), [self = shared_from_this(), ended](const Failure& failure,
                                                                                     std::size_t size) {
      if (failure == asio::error::operation_aborted || !self->socket_.is_open()) return;
      if (failure) {
        self->close(failure == asio::error::eof ? "the sender closed the connection" : failure.message());
        ended();
        return;
      }
      self->last_arrival_ = steady_now();
      deliver(self->handler_, self->peer_, std::string_view(self->bytes_.data(), size), *self->last_arrival_);
      self->read(ended);
    });
  }
  void close(const std::string& why) {
    Failure ignored;
    socket_.close(ignored);
    handler_.disconnected(peer_, why);
  }
  /// Seconds since the last bytes came, and before the first since the connection began.
  double silence_s(double now) const { return now - last_arrival_.value_or(began_); }
  bool has_sent() const { return last_arrival_.has_value(); }

 private:
  tcp::socket socket_;
  int peer_;
  ByteHandler& handler_;
  const double began_ = steady_now();
  std::optional<double> last_arrival_;
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
    reader_ = std::make_shared<TcpReader>(std::move(*socket_), 0, handler_);
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
  std::shared_ptr<TcpReader> reader_;
};

class TcpListener : public ThreadedSource {
 public:
  TcpListener(const internal::HostPort& at, ByteHandler& handler, const internal::Silence& silence)
      : ThreadedSource(handler), silence_(silence), acceptor_(io_), pause_(io_), tick_(io_) {
    const tcp::endpoint endpoint(address_of(at), at.port);
    Failure failure;
    acceptor_.open(endpoint.protocol(), failure);
    // A port that its last user left a minute ago is free.
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(limits::kSenders, failure);
    if (failure) cannot_listen("tcp " + name_of(at), failure);
    accept();
    close_silent();
    start();
  }
  ~TcpListener() override { stop(); }

 private:
  using Seat = std::shared_ptr<TcpReader>;

  void accept() {
    acceptor_.async_accept([this](const Failure& failure, tcp::socket socket) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) {
        // No more descriptors, say: asking again at once would take the whole processor.
        handler_.failed(failure.message());
        pause_.expires_after(std::chrono::milliseconds(100));
        return pause_.async_wait([this](const Failure& stopped) {
          if (!stopped) accept();
        });
      }
      if (Seat* seat = seat_for_another()) {
        *seat = std::make_shared<TcpReader>(std::move(socket), int(seat - seats_.data()), handler_);
        (*seat)->read([seat] { seat->reset(); });
      } else {
        handler_.failed("more than " + std::to_string(limits::kSenders) + " senders: the last was refused");
      }
      accept();
    });
  }

  /// A free seat; else that of a connection that has sent nothing; else the longest silent. nullptr: all are in use.
  Seat* seat_for_another() {
    const double now = steady_now();
    Seat* longest = nullptr;
    const auto is_before = [now](const Seat& a, const Seat& b) {
      if (a->has_sent() != b->has_sent()) return !a->has_sent();
      return a->silence_s(now) > b->silence_s(now);
    };
    for (Seat& seat : seats_) {
      if (!seat) return &seat;
      if (longest == nullptr || is_before(seat, *longest)) longest = &seat;
    }
    if ((*longest)->has_sent() && (*longest)->silence_s(now) < silence_.takeover_s) return nullptr;
    (*longest)->close("it was silent, and another sender took its place");
    longest->reset();
    return longest;
  }

  void close_silent() {
    tick_.expires_after(std::chrono::duration_cast<std::chrono::milliseconds>(
        std::chrono::duration<double>(std::min(1.0, silence_.end_s / 4))));
    tick_.async_wait([this](const Failure& stopped) {
      if (stopped) return;
      for (Seat& seat : seats_)
        if (seat && seat->silence_s(steady_now()) >= silence_.end_s) {
          seat->close("the sender was silent for too long");
          seat.reset();
        }
      close_silent();
    });
  }

  const internal::Silence silence_;
  tcp::acceptor acceptor_;
  asio::steady_timer pause_, tick_;
  std::array<Seat, limits::kSenders> seats_;
};

}  // namespace

std::unique_ptr<ByteSource> internal::listen_tcp(const HostPort& at, ByteHandler& handler,
                                                 const Silence& silence) {
  return std::make_unique<TcpListener>(at, handler, silence);
}

std::unique_ptr<ByteSource> open_byte_source(const std::string& text, ByteHandler& handler) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon), rest = colon == text.npos ? "" : text.substr(colon + 1);
  if (kind == "udp") return std::make_unique<UdpSource>(internal::parse_host_port(rest), handler);
  if (kind == "tcp-listen") return internal::listen_tcp(internal::parse_host_port(rest), handler);
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
