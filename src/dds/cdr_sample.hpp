#pragma once
/// Bytes of a log -> a message of the graph's types, by Cyclone's own decoder.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dds/dds.h"
#include "refusal.hpp"

namespace procam::dds::internal {

/// A message in memory, which is given back with it.
class CdrSample {
 public:
  explicit CdrSample(const dds_topic_descriptor_t& type);
  ~CdrSample();
  CdrSample(const CdrSample&) = delete;
  CdrSample& operator=(const CdrSample&) = delete;

  /// CDR with its header of four bytes, of either byte order. The message lasts until the next call. Throws Refusal
  /// (ros2_undecodable).
  const void* read(std::string_view bytes);

 private:
  const dds_topic_descriptor_t& type_;
  std::vector<std::uint64_t> payload_, sample_;  ///< aligned for any member
};

/// A message as CDR with its header, little endian.
std::string cdr_bytes(const dds_topic_descriptor_t& type, const void* sample);

}  // namespace procam::dds::internal
