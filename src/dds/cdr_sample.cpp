#include "cdr_sample.hpp"

#include <algorithm>
#include <cstring>

#include "dds/ddsi/ddsi_cdrstream.h"

namespace procam::dds::internal {
namespace {

constexpr std::uint32_t kXcdr1 = 1;  // what ROS 2 writes
constexpr std::size_t kCdrHeader = 4;

std::size_t words(std::size_t bytes) {
  return (bytes + 7) / 8;
}

}  // namespace

CdrSample::CdrSample(const dds_topic_descriptor_t& type) : type_(type), sample_(words(type.m_size)) {}

CdrSample::~CdrSample() {
  dds_sample_free(sample_.data(), &type_, DDS_FREE_CONTENTS);
}

const void* CdrSample::read(std::string_view bytes) {
  const Refusal undecodable{"ros2_undecodable", "a message of the log is no CDR of its type"};
  if (bytes.size() <= kCdrHeader || bytes[0] != 0 || (bytes[1] != 0 && bytes[1] != 1)) throw undecodable;
  const bool is_little_endian = bytes[1] == 1;
  const std::uint16_t one = 1;
  const bool is_little_machine = *reinterpret_cast<const unsigned char*>(&one) == 1;
  const std::size_t size = bytes.size() - kCdrHeader;
  if (size > 0x7fffffff) throw undecodable;
  payload_.resize(words(size));
  std::memcpy(payload_.data(), bytes.data() + kCdrHeader, size);
  // Checks every length and text, and brings the numbers into the order of this machine.
  std::uint32_t end = 0;
  if (dds_stream_normalize_data(reinterpret_cast<char*>(payload_.data()), &end, std::uint32_t(size),
                                is_little_endian != is_little_machine, kXcdr1, type_.m_ops) == nullptr)
    throw undecodable;
  dds_sample_free(sample_.data(), &type_, DDS_FREE_CONTENTS);
  std::fill(sample_.begin(), sample_.end(), 0);
  dds_istream_t stream;
  dds_istream_init(&stream, std::uint32_t(size), payload_.data(), kXcdr1);
  dds_stream_read(&stream, reinterpret_cast<char*>(sample_.data()), type_.m_ops);
  return sample_.data();
}

std::string cdr_bytes(const dds_topic_descriptor_t& type, const void* sample) {
  dds_ostreamLE_t stream;
  dds_ostreamLE_init(&stream, 0, kXcdr1);
  std::string bytes("\0\1\0\0", kCdrHeader);
  if (dds_stream_writeLE(&stream, static_cast<const char*>(sample), type.m_ops) != nullptr)
    bytes.append(reinterpret_cast<const char*>(stream.x.m_buffer), stream.x.m_index);
  dds_ostreamLE_fini(&stream);
  return bytes;
}

}  // namespace procam::dds::internal
