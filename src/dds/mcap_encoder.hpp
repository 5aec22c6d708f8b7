#pragma once
/// Bytes of an MCAP file (https://mcap.dev/spec): chunks with checksums and indices of their messages, and a summary.
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace procam::dds::internal {

struct McapChannel {
  std::string topic, type;  ///< "/odom", "nav_msgs/msg/Odometry"
  std::string definition;   ///< of its messages, as ROS 2 writes them together (ros2msg)
};

class McapEncoder {
 public:
  /// Messages of channel i are of channels[i].
  explicit McapEncoder(std::vector<McapChannel> channels) : channels_(std::move(channels)) {}

  std::string begin();
  void add(std::size_t channel, std::int64_t time_ns, const std::string& message);
  std::size_t waiting() const { return open_.size(); }
  std::string chunk();
  std::string end();

 private:
  std::string definitions() const;

  std::vector<McapChannel> channels_;
  std::uint64_t offset_ = 0;  ///< of the next byte in the file
  std::string open_, chunk_indices_;
  std::map<std::uint16_t, std::string> message_indices_;  ///< of the open chunk
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::uint64_t first_ = 0, last_ = 0, open_first_ = 0, open_last_ = 0;
  std::uint32_t chunks_ = 0;
};

}  // namespace procam::dds::internal
