// UDP and TCP: everything that needs Asio alone.
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <thread>

#include "inbox.hpp"
#include "procam/core/base/error.hpp"
#include "procam/track/vmc.hpp"
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

/// What travels: who is to be handed what, and how a stream of it is cut.
struct Poses {
  using Source = PoseSource;
  using Message = StampedPose;
  using Parsed = track::Parsed;
  using Stream = StreamParser;
};
struct Skeletons {
  using Source = SkeletonSource;
  using Message = SkeletonFrame;
  using Parsed = ParsedSkeletons;
  using Stream = SkeletonStream;
};

/// A source whose thread runs its io_context until the end.
template <typename Wire>
class ThreadedSource : public Wire::Source {
 public:
  explicit ThreadedSource(const SourceOptions& options) : inbox_(options) {}
  ~ThreadedSource() override { this->stop(); }
  void poll(std::vector<typename Wire::Message>& arrived) override { inbox_.poll(arrived); }
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

  InboxOf<typename Wire::Message> inbox_;
  asio::io_context io_{1};

 private:
  std::thread thread_;
};

template <typename Wire>
class UdpSource : public ThreadedSource<Wire> {
  using Base = ThreadedSource<Wire>;
  using Base::inbox_;
  using Base::io_;

 public:
  using Parser = std::function<typename Wire::Parsed(std::string_view)>;
  UdpSource(const HostPort& at, const asio::ip::address& group, Parser parser, const SourceOptions& options)
      : Base(options), parser_(std::move(parser)), socket_(io_) {
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
    this->start();
  }
  ~UdpSource() override { this->stop(); }

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
template <typename Wire>
class TcpReader {
 public:
  using Inbox = InboxOf<typename Wire::Message>;
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
  typename Wire::Stream parser_;
  std::array<char, 16384> bytes_;
};

template <typename Wire>
class TcpSource : public ThreadedSource<Wire> {
  using Base = ThreadedSource<Wire>;
  using Base::inbox_;
  using Base::io_;

 public:
  TcpSource(HostPort at, const SourceOptions& options)
      : Base(options), at_(std::move(at)), resolver_(io_), timer_(io_) {
    connect();
    this->start();
  }
  ~TcpSource() override { this->stop(); }

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
    reader_ = std::make_unique<TcpReader<Wire>>(std::move(*socket_), inbox_);
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
  std::unique_ptr<TcpReader<Wire>> reader_;
};

template <typename Wire>
class TcpListener : public ThreadedSource<Wire> {
  using Base = ThreadedSource<Wire>;
  using Base::inbox_;
  using Base::io_;

 public:
  TcpListener(const HostPort& at, const SourceOptions& options) : Base(options), acceptor_(io_) {
    const tcp::endpoint endpoint(address_of(at), at.port);
    Failure failure;
    acceptor_.open(endpoint.protocol(), failure);
    // A port that its last user left a minute ago is free.
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(kMostSenders, failure);
    if (failure) cannot_listen("tcp " + name_of(at), failure);
    accept();
    this->start();
  }
  ~TcpListener() override { this->stop(); }

 private:
  static constexpr int kMostSenders = 8;

  void accept() {
    acceptor_.async_accept([this](const Failure& failure, tcp::socket socket) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) {
        inbox_.failed(failure.message());
      } else if (auto* seat = free_seat()) {
        *seat = std::make_unique<TcpReader<Wire>>(std::move(socket), inbox_);
        (*seat)->read([this, seat] { asio::post(io_, [seat] { seat->reset(); }); });
      } else {
        inbox_.failed("more than 8 senders: the last was sent away");
      }
      accept();
    });
  }
  std::unique_ptr<TcpReader<Wire>>* free_seat() {
    for (auto& seat : seats_)
      if (!seat) return &seat;
    return nullptr;
  }

  tcp::acceptor acceptor_;
  std::array<std::unique_ptr<TcpReader<Wire>>, kMostSenders> seats_;
};

template <typename Wire>
std::unique_ptr<typename Wire::Source> connect_to(const std::string& rest, const SourceOptions& options) {
  HostPort at = parse_host_port(rest);
  if (at.host.empty())
    throw Error(ErrorKind::kInput, "tcp:" + rest, "the host is missing",
                "give tcp:HOST:PORT, or tcp-listen:PORT where the sender connects");
  return std::make_unique<TcpSource<Wire>>(std::move(at), options);
}

}  // namespace

std::unique_ptr<PoseSource> open_udp(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<UdpSource<Poses>>(parse_host_port(rest), asio::ip::address(), parse_poses, options);
}
std::unique_ptr<PoseSource> open_osc(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<UdpSource<Poses>>(parse_host_port(rest), asio::ip::address(), parse_osc, options);
}
std::unique_ptr<PoseSource> open_psn(const std::string& rest, const SourceOptions& options) {
  HostPort at = parse_host_port(rest);
  if (at.host.empty()) at.host = "236.10.10.10";  // the standard's group
  const asio::ip::address address = address_of(at);
  return std::make_unique<UdpSource<Poses>>(at, address.is_multicast() ? address : asio::ip::address(),
                                            parse_psn, options);
}
std::unique_ptr<PoseSource> open_tcp(const std::string& rest, const SourceOptions& options) {
  return connect_to<Poses>(rest, options);
}
std::unique_ptr<PoseSource> open_tcp_listener(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<TcpListener<Poses>>(parse_host_port(rest), options);
}

std::unique_ptr<SkeletonSource> open_skeletons_udp(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<UdpSource<Skeletons>>(parse_host_port(rest), asio::ip::address(), parse_skeletons,
                                                options);
}
std::unique_ptr<SkeletonSource> open_skeletons_vmc(const std::string& rest, const SourceOptions& options) {
  return std::make_unique<UdpSource<Skeletons>>(
      parse_host_port(rest), asio::ip::address(),
      [reader = VmcReader()](std::string_view datagram) mutable { return reader.parse(datagram); }, options);
}
std::unique_ptr<SkeletonSource> open_skeletons_tcp(const std::string& rest, const SourceOptions& options) {
  return connect_to<Skeletons>(rest, options);
}
std::unique_ptr<SkeletonSource> open_skeletons_tcp_listener(const std::string& rest,
                                                            const SourceOptions& options) {
  return std::make_unique<TcpListener<Skeletons>>(parse_host_port(rest), options);
}

}  // namespace procam::track::internal
