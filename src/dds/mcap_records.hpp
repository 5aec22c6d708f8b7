#pragma once
/// What the reader and the writer of MCAP files share.
#include <boost/crc.hpp>
#include <cstdint>
#include <string_view>

namespace procam::dds::internal {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kDataEnd = 0x0f
};

/// CRC-32 of IEEE 802.3.
inline std::uint32_t crc32_of(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace procam::dds::internal
