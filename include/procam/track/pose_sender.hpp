#pragma once
/// The other end of a pose source: sends messages in every form that a socket source reads (pose_source.hpp).
#include <memory>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

class PROCAM_EXPORT PoseSender {
 public:
  virtual ~PoseSender() = default;
  /// As it is, one datagram or a piece of the stream.
  virtual void send(const std::string& bytes) = 0;
  /// The message in this sender's form.
  virtual std::string encoded(const track::StampedPose& message) const = 0;
  /// Whether somebody could have received what was sent; always for datagrams.
  virtual bool has_receiver() const { return true; }
};

/// "udp:HOST:PORT", "osc:HOST:PORT", "psn:[GROUP:]PORT", "tcp:HOST:PORT" (connects, again when it ends),
/// "tcp-listen:PORT" (everybody who connects gets all). `binary`: udp and tcp send the binary form. Throws
/// Error(kInput), Error(kDevice).
PROCAM_EXPORT std::unique_ptr<PoseSender> open_pose_sender(const std::string& text, bool binary);

}  // namespace procam::track
