#pragma once
/// Zip archives written byte by byte, valid and invalid (APPNOTE.TXT 4.3), for the tests of their reader.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace procam::test {

struct ZipMember {
  std::string name, bytes;
  std::optional<std::uint32_t> declared_size = std::nullopt;  ///< of the unpacked bytes; unset: the truth
  std::optional<std::uint32_t> checksum = std::nullopt;       ///< unset: the truth
  std::uint16_t method = 0;                                   ///< 0: stored, 8: deflated
};

inline std::uint32_t zip_checksum(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

inline std::string hand_made_zip(const std::vector<ZipMember>& members) {
  std::string zip, directory;
  const auto put = [](std::string& to, std::uint64_t value, int count) {
    for (int k = 0; k < count; ++k, value >>= 8) to += char(value & 0xff);
  };
  for (const ZipMember& member : members) {
    const auto about = [&](std::string& to) {  // the fields that both headers share
      put(to, 20, 2);
      put(to, 0, 2);
      put(to, member.method, 2);
      put(to, 0, 4);
      put(to, member.checksum.value_or(zip_checksum(member.bytes)), 4);
      put(to, member.bytes.size(), 4);
      put(to, member.declared_size.value_or(std::uint32_t(member.bytes.size())), 4);
      put(to, member.name.size(), 2);
      put(to, 0, 2);
    };
    const std::size_t local = zip.size();
    put(zip, 0x04034b50, 4);
    about(zip);
    zip += member.name + member.bytes;
    put(directory, 0x02014b50, 4);
    put(directory, 20, 2);
    about(directory);
    put(directory, 0, 10);
    put(directory, local, 4);
    directory += member.name;
  }
  const std::size_t directory_at = zip.size();
  zip += directory;
  put(zip, 0x06054b50, 4);
  put(zip, 0, 4);
  put(zip, members.size(), 2);
  put(zip, members.size(), 2);
  put(zip, directory.size(), 4);
  put(zip, directory_at, 4);
  put(zip, 0, 2);
  return zip;
}

}  // namespace procam::test
