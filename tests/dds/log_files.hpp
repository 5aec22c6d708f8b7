#pragma once
/// Logs of ROS 2 as other programs write them: MCAP from its specification (mcap.dev/spec), .db3 by SQLite.
#include <gtest/gtest.h>

#ifdef PROCAM_HAVE_LZ4
#include <lz4frame.h>
#endif
#ifdef PROCAM_HAVE_ZSTD
#include <zstd.h>
#endif

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace procam::test {

inline std::filesystem::path log_folder() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) /
      (std::string("procam_") + test->test_suite_name() + "_" + test->name());
  std::filesystem::create_directories(folder);
  return folder;
}

inline std::string text_of(const std::vector<std::uint8_t>& bytes) {
  return std::string(bytes.begin(), bytes.end());
}

inline void write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// CRC-32 of IEEE 802.3, bit by bit.
inline std::uint32_t plain_crc(const std::string& bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char letter : bytes) {
    crc ^= std::uint8_t(letter);
    for (int i = 0; i < 8; ++i) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~crc;
}

template <typename T>
std::string number(T value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i) bytes += char(std::uint64_t(value) >> (8 * i));
  return bytes;
}
inline std::string counted_text(const std::string& text) {
  return number(std::uint32_t(text.size())) + text;
}
inline std::string record(int opcode, const std::string& contents) {
  return std::string(1, char(opcode)) + number(std::uint64_t(contents.size())) + contents;
}

/// Nanoseconds of Unix time.
constexpr std::uint64_t kLogStart = 1'700'000'000'000'000'000;

const std::string kMcapMagic("\x89MCAP0\r\n", 8);

/// Messages in the order of their calls; chunk() packs what came since the last one.
class McapFile {
 public:
  McapFile() : bytes_(kMcapMagic + record(1, counted_text("ros2") + counted_text("a test"))) {}

  McapFile& channel(int id, const std::string& topic, const std::string& type,
                    const std::string& encoding = "cdr") {
    const std::string definitions =
        record(3,
               number(std::uint16_t(id)) + counted_text(type) + counted_text("ros2msg") + counted_text("")) +
        record(4, number(std::uint16_t(id)) + number(std::uint16_t(id)) + counted_text(topic) +
                      counted_text(encoding) + counted_text(""));
    definitions_ += definitions;
    open_ += definitions;
    return *this;
  }
  McapFile& message(int channel, std::uint64_t logged_ns, const std::string& data) {
    open_ += record(5, number(std::uint16_t(channel)) + number(std::uint32_t(0)) + number(logged_ns) +
                           number(logged_ns) + data);
    ++counts_[channel];
    first_ = first_ == 0 ? logged_ns : std::min(first_, logged_ns);
    last_ = std::max(last_, logged_ns);
    return *this;
  }
  /// `size`: what the chunk says of its unpacked bytes, if not the truth.
  McapFile& chunk(const std::string& compression, std::uint64_t size = 0) {
    const std::string packed = pack(compression, open_);
    std::string channels;
    for (const auto& [channel, count] : counts_)
      channels += number(std::uint16_t(channel)) + number(std::uint64_t(1));
    index_ += record(8, number(first_) + number(last_) + number(std::uint64_t(bytes_.size())) +
                            number(std::uint64_t(packed.size())) + counted_text(channels) +
                            number(std::uint64_t(0)) + counted_text(compression) +
                            number(std::uint64_t(packed.size())) + number(std::uint64_t(open_.size())));
    bytes_ +=
        record(6, number(first_) + number(last_) + number(size == 0 ? std::uint64_t(open_.size()) : size) +
                      number(plain_crc(open_)) + counted_text(compression) +
                      number(std::uint64_t(packed.size())) + packed);
    open_.clear();
    counts_.clear();
    return *this;
  }
  /// The file with its end.
  std::string closed(bool with_summary = true) {
    std::string file = unclosed() + record(15, number(std::uint32_t(0)));
    const std::uint64_t start = file.size();
    std::string summary;
    if (with_summary)
      summary = definitions_ + index_ +
                record(11, number(std::uint64_t(1)) + number(std::uint16_t(1)) + number(std::uint32_t(1)) +
                               number(std::uint32_t(0)) + number(std::uint32_t(0)) +
                               number(std::uint32_t(1)) + number(first_) + number(last_) + counted_text(""));
    summary += std::string(1, char(2)) + number(std::uint64_t(20)) +
               number(with_summary ? start : std::uint64_t(0)) + number(std::uint64_t(0));
    return file + summary + number(plain_crc(summary)) + kMcapMagic;
  }
  std::string unclosed() {
    bytes_ += open_;
    open_.clear();
    return bytes_;
  }

 private:
  static std::string pack([[maybe_unused]] const std::string& compression, const std::string& bytes) {
    std::string packed = bytes;
#ifdef PROCAM_HAVE_ZSTD
    if (compression == "zstd") {
      packed.resize(ZSTD_compressBound(bytes.size()));
      packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 3));
    }
#endif
#ifdef PROCAM_HAVE_LZ4
    if (compression == "lz4") {
      packed.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
      packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
    }
#endif
    return packed;
  }
  std::string bytes_, definitions_, open_, index_;
  std::map<int, int> counts_;
  std::uint64_t first_ = 0, last_ = 0;
};

}  // namespace procam::test
