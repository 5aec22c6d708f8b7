#include "procam/track/pose_sender.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/write.hpp>
#include <list>
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/track/wire.hpp"

namespace procam::track {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Failure = boost::system::error_code;
using Encode = std::string (*)(const track::StampedPose&);

class Sender : public PoseSender {
 public:
  explicit Sender(Encode encode) : encode_(encode) {}
  std::string encoded(const track::StampedPose& message) const override { return encode_(message); }

 protected:
  asio::io_context io_{1};

 private:
  Encode encode_;
};

struct Target {
  std::string host, port;
};
Target target_of(const std::string& text, const std::string& default_host) {
  const std::size_t colon = text.rfind(':');
  Target target{colon == text.npos ? default_host : text.substr(0, colon),
                colon == text.npos ? text : text.substr(colon + 1)};
  if (target.host.size() > 1 && target.host.front() == '[')
    target.host = target.host.substr(1, target.host.size() - 2);
  if (target.port.empty() || target.port.size() > 5 ||
      target.port.find_first_not_of("0123456789") != target.port.npos)
    throw Error(ErrorKind::kInput, "'" + text + "'", "'" + target.port + "' is no port",
                "give e.g. 127.0.0.1:9000");
  return target;
}

class UdpSender : public Sender {
 public:
  UdpSender(const Target& target, Encode encode) : Sender(encode), socket_(io_) {
    Failure failure;
    const auto found = udp::resolver(io_).resolve(target.host, target.port, failure);
    if (!failure && found.empty()) failure = asio::error::host_not_found;
    if (!failure) {
      to_ = found.begin()->endpoint();
      socket_.open(to_.protocol(), failure);
    }
    if (!failure && to_.address().is_multicast())
      socket_.set_option(asio::ip::multicast::enable_loopback(true), failure);
    if (failure)
      throw Error(ErrorKind::kDevice, target.host + ":" + target.port, failure.message(),
                  "give a host that is there");
  }
  // Nobody listening is no error: a localiser does not know who listens either.
  void send(const std::string& bytes) override {
    Failure ignored;
    socket_.send_to(asio::buffer(bytes), to_, 0, ignored);
  }

 private:
  udp::socket socket_;
  udp::endpoint to_;
};

class TcpSender : public Sender {
 public:
  TcpSender(Target target, Encode encode) : Sender(encode), target_(std::move(target)) {
    if (const Failure failure = connect())
      throw Error(ErrorKind::kDevice, target_.host + ":" + target_.port, failure.message(),
                  "start the receiver first, or let it connect with tcp-listen:PORT");
  }
  void send(const std::string& bytes) override {
    if (!socket_ && connect()) return;
    Failure failure;
    asio::write(*socket_, asio::buffer(bytes), failure);
    if (failure) socket_.reset();
  }
  bool has_receiver() const override { return socket_.has_value(); }

 private:
  Failure connect() {
    Failure failure;
    const auto found = tcp::resolver(io_).resolve(target_.host, target_.port, failure);
    if (failure) return failure;
    socket_.emplace(io_);
    asio::connect(*socket_, found, failure);
    if (!failure) socket_->set_option(tcp::no_delay(true), failure);
    if (failure) socket_.reset();
    return failure;
  }

  Target target_;
  std::optional<tcp::socket> socket_;
};

class TcpServer : public Sender {
 public:
  TcpServer(const Target& target, Encode encode) : Sender(encode), acceptor_(io_) {
    Failure failure;
    const auto address = asio::ip::make_address(target.host, failure);
    const tcp::endpoint endpoint(address, static_cast<unsigned short>(std::stoi(target.port)));
    if (!failure) acceptor_.open(endpoint.protocol(), failure);
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(8, failure);
    if (!failure) acceptor_.non_blocking(true, failure);
    if (failure)
      throw Error(ErrorKind::kDevice, "tcp-listen:" + target.port, failure.message(), "choose another port");
  }
  void send(const std::string& bytes) override {
    Failure failure;
    for (;;) {
      tcp::socket socket(io_);
      acceptor_.accept(socket, failure);
      if (failure) break;
      socket.set_option(tcp::no_delay(true), failure);
      receivers_.push_back(std::move(socket));
    }
    receivers_.remove_if([&](tcp::socket& receiver) {
      Failure failed;
      asio::write(receiver, asio::buffer(bytes), failed);
      return bool(failed);
    });
  }
  bool has_receiver() const override { return !receivers_.empty(); }

 private:
  tcp::acceptor acceptor_;
  std::list<tcp::socket> receivers_;
};

}  // namespace

std::unique_ptr<PoseSender> open_pose_sender(const std::string& text, bool binary) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon), rest = colon == text.npos ? "" : text.substr(colon + 1);
  const Encode encode = binary ? Encode(track::to_binary)
                               : [](const track::StampedPose& pose) { return track::to_json_line(pose); };
  if (kind == "udp") return std::make_unique<UdpSender>(target_of(rest, "127.0.0.1"), encode);
  if (kind == "osc") return std::make_unique<UdpSender>(target_of(rest, "127.0.0.1"), track::to_osc);
  if (kind == "psn") return std::make_unique<UdpSender>(target_of(rest, "236.10.10.10"), track::to_psn);
  if (kind == "tcp") return std::make_unique<TcpSender>(target_of(rest, "127.0.0.1"), encode);
  if (kind == "tcp-listen") return std::make_unique<TcpServer>(target_of(rest, "0.0.0.0"), encode);
  throw Error(ErrorKind::kInput, "'" + text + "'", "poses cannot be sent there",
              "use udp:HOST:PORT, osc:HOST:PORT, psn:PORT, tcp:HOST:PORT or tcp-listen:PORT");
}

}  // namespace procam::track
