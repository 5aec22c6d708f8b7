#pragma once
/// Parsers of the other forms in which poses arrive, and of streams.
#include "procam/track/wire.hpp"

namespace procam::track {

/// An OSC message, or a bundle of them (its time tag is the stamp of those that have none).
Parsed parse_osc(std::string_view datagram);

/// A PosiStageNet packet. Names of trackers come in packets of their own and are not waited for: the child
/// is "tracker ID".
Parsed parse_psn(std::string_view datagram);

/// One text frame of rosbridge: tf2_msgs/TFMessage, PoseWithCovarianceStamped, PoseStamped or Odometry,
/// recognised by their fields.
Parsed parse_rosbridge(std::string_view text);

/// A stream of JSON lines and binary messages, cut where it likes. Garbage is skipped up to the next line
/// that begins with a brace or the next magic, and counted once.
class StreamParser {
 public:
  Parsed parse(std::string_view bytes);

 private:
  std::string rest_;
  bool skipping_ = false;
};

}  // namespace procam::track
