#pragma once
/// Bytes from the network with the time of their arrival: UDP datagrams or TCP streams. Pose and skeleton sources are
/// built on it, and so is the source of a format that procam does not read:
///
///   struct Handler : track::ByteHandler {
///     void received(int peer, std::string_view bytes, double arrival) override { ... }
///   } handler;
///   const auto source = track::open_byte_source("udp:9000", handler);   // the handler must outlive the source
///
/// | text | what |
/// |---|---|
/// | udp:9000, udp:127.0.0.1:9000, udp:[::1]:9000 | datagrams; the group is joined if the address is multicast |
/// | tcp:HOST:PORT | a stream; connects, and again after 0.1 s, 0.2 s, ... 3 s when the connection ends |
/// | tcp-listen:[ADDRESS:]PORT | streams of up to 8 senders that connect; a ninth takes a silent one's place |
///
/// A connection to a listener ends after ten minutes of silence, and any TCP connection when its peer is gone
/// (keep-alive).
///
/// A source has one thread. It calls the handler directly, in the order of arrival, and copies nothing: the bytes are
/// valid during the call only. The thread has ended when the source is destroyed.
#include <memory>
#include <string>
#include <string_view>

#include "procam/core/base/export.hpp"

namespace procam::track {

/// Called on the source's thread. What received() throws goes to failed(), and the source continues; the others must
/// not throw.
class PROCAM_EXPORT ByteHandler {
 public:
  virtual ~ByteHandler() = default;
  /// A datagram (peer 0) or the next piece of the stream of `peer`, 0 .. limits::kSenders - 1. `arrival`:
  /// steady_now() when the bytes were read, seconds.
  virtual void received(int peer, std::string_view bytes, double arrival) = 0;
  /// The stream of `peer` begins; for datagrams: the port is bound (called from open_byte_source()).
  virtual void connected(int) {}
  virtual void disconnected(int, const std::string& /*why*/) {}
  /// A connection attempt or a read failed; the source continues.
  virtual void failed(const std::string& /*why*/) {}
};

class PROCAM_EXPORT ByteSource {
 public:
  virtual ~ByteSource() = default;
};

/// Throws Error(kInput) for a text of no such form, Error(kDevice) for a port that cannot be bound. A TCP peer that is
/// not there yet is no error.
PROCAM_EXPORT std::unique_ptr<ByteSource> open_byte_source(const std::string& text, ByteHandler& handler);

}  // namespace procam::track
