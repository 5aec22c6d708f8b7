/// Reads MCAP (https://mcap.dev/spec, version 0): records of an opcode, a length of 8 bytes and contents, little endian.
///
///   magic, Header, data (Schema, Channel, Message, or Chunks of these, ...), DataEnd, summary, Footer, magic
///
/// The data are read from front to back. The summary, where there is one, tells the topics without that, and which chunks
/// hold none of the selected ones. A file without an end is read as far as it goes.
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <optional>

#include "compression.hpp"
#include "mcap_records.hpp"
#include "message_log.hpp"
#include "procam/core/base/bytes.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {
namespace {

constexpr std::size_t kMagicBytes = kMcapMagic.size(), kRecordHeader = 9;
constexpr std::size_t kFooterBytes = kRecordHeader + 20;
constexpr std::size_t kSmallRecord = limits::kMebibyte;  ///< a schema or a channel
constexpr std::size_t kMessageHeader = 22;

std::string_view text(ByteReader& in) {
  return in.take(in.number<std::uint32_t>());
}

/// A name of a topic or a type, shortened to what is compared.
std::string name_of(std::string_view bytes) {
  return std::string(bytes.substr(0, limits::kFrameNameBytes));
}

struct Record {
  std::uint8_t opcode = 0;
  std::uint64_t length = 0;
};

Record record_header(ByteReader& in) {
  Record record;
  record.opcode = in.number<std::uint8_t>();
  record.length = in.number<std::uint64_t>();
  return record;
}

[[noreturn]] void refuse_damaged(const char* why) {
  throw Refusal{"log_damaged", why};
}

class McapLog : public MessageLog {
 public:
  explicit McapLog(const std::filesystem::path& path) : path_(path), file_(path, std::ios::binary) {
    std::error_code failed;
    size_ = std::filesystem::file_size(path, failed);
    if (!file_ || failed)
      throw Error(ErrorKind::kIo, path.string(), errno != 0 ? std::strerror(errno) : "it cannot be read",
                  "give a log that can be read");
    if (!read_summary()) scan();
  }

  void select(const std::vector<std::size_t>& topics) override {
    selected_.assign(topics_.size(), false);
    for (const std::size_t topic : topics) selected_[topic] = true;
    rewind();
  }

  bool next(LoggedMessage& message) override {
    for (;;) {
      if (!in_chunk_.rest.empty()) {
        if (next_in_chunk(message)) return true;
      } else if (const std::optional<bool> found = next_in_file(message)) {
        return *found;
      }
    }
  }

 private:
  struct Indexed {
    std::uint64_t offset = 0;
    std::vector<std::uint16_t> channels;  ///< that have messages in this chunk
  };

  void rewind() {
    at_ = kMagicBytes;
    in_chunk_ = {};
  }

  /// Throws Error(kIo).
  void read(std::uint64_t offset, char* bytes, std::size_t count) {
    if (offset != position_) {  // a seek forgets what the stream has read ahead
      file_.clear();
      file_.seekg(std::streamoff(offset));
    }
    position_ = offset + count;
    if (!file_.read(bytes, std::streamsize(count))) {
      position_ = std::uint64_t(-1);
      throw Error(ErrorKind::kIo, path_.string(), "it could be opened and cannot be read",
                  "check the disk, or whether another program has cut the file");
    }
  }
  /// Bytes of the file; the buffer lasts until the next call. Throws Error(kIo).
  std::string_view bytes_at(std::uint64_t offset, std::size_t count) {
    buffer_.resize(count);
    read(offset, buffer_.data(), count);
    return buffer_;
  }

  /// false where the file has no summary that names its topics.
  bool read_summary() {
    const char* const not_closed =
        "the log has no end, as when its recorder was killed; it is read as far as it goes";
    notice_ = not_closed;
    if (size_ < 2 * kMagicBytes + kFooterBytes) return false;
    const std::uint64_t footer_at = size_ - kMagicBytes - kFooterBytes;
    ByteReader footer{bytes_at(footer_at, kFooterBytes + kMagicBytes)};
    const Record record = record_header(footer);
    if (record.opcode != kFooter || record.length != kFooterBytes - kRecordHeader) return false;
    const auto start = footer.number<std::uint64_t>();
    footer.take(8);
    const auto crc = footer.number<std::uint32_t>();
    if (footer.rest != kMcapMagic) return false;
    notice_.clear();
    if (start < kMagicBytes || start >= footer_at || footer_at - start > limits::kLogSummaryBytes)
      return false;
    const std::string summary(bytes_at(start, std::size_t(footer_at - start) + kFooterBytes - 4));
    if (crc != 0 && crc != crc32_of(summary)) {
      notice_ = "its summary is damaged and is not used";
      return false;
    }
    return take_summary(std::string_view(summary).substr(0, std::size_t(footer_at - start)));
  }

  bool take_summary(std::string_view summary) {
    bool has_statistics = false;
    for (ByteReader in{summary}; !in.rest.empty();) {
      const Record record = record_header(in);
      ByteReader body{in.take(std::size_t(std::min<std::uint64_t>(record.length, in.rest.size() + 1)))};
      if (in.bad) break;
      if (record.opcode == kSchema) take_schema(body);
      if (record.opcode == kChannel) take_channel(body);
      if (record.opcode == kChunkIndex) take_chunk_index(body);
      if (record.opcode != kStatistics) continue;
      body.take(8 + 2 + 4 + 4 + 4 + 4);
      begin_ns_ = std::int64_t(body.number<std::uint64_t>());
      has_statistics = !body.bad;
    }
    std::sort(index_.begin(), index_.end(),
              [](const Indexed& a, const Indexed& b) { return a.offset < b.offset; });
    // Not every writer states the first time.
    return has_statistics && begin_ns_ != 0 && !topics_.empty();
  }

  void take_chunk_index(ByteReader& body) {
    Indexed chunk;
    body.take(16);
    chunk.offset = body.number<std::uint64_t>();
    body.take(8);
    for (ByteReader map{text(body)}; map.rest.size() >= 10; map.take(8))
      chunk.channels.push_back(map.number<std::uint16_t>());
    if (!body.bad) index_.push_back(std::move(chunk));
  }

  /// Of a file that does not tell: its topics and the first time, by reading all of it.
  void scan() {
    std::optional<std::int64_t> begin;
    is_scanning_ = true;
    rewind();
    LoggedMessage message;
    for (bool is_more = true; is_more;) {
      try {
        is_more = next(message);
        if (is_more) begin = std::min(begin.value_or(message.logged_ns), message.logged_ns);
      } catch (const Refusal&) {  // counted when it is played
      }
    }
    is_scanning_ = false;
    begin_ns_ = begin.value_or(0);
  }

  void take_schema(ByteReader& body) {
    const auto id = body.number<std::uint16_t>();
    const std::string name = name_of(text(body));
    if (!body.bad && id != 0 && schemas_.size() < limits::kLogTopics) schemas_[id] = name;
  }

  void take_channel(ByteReader& body) {
    const auto id = body.number<std::uint16_t>(), schema = body.number<std::uint16_t>();
    LogTopic topic;
    topic.name = name_of(text(body));
    topic.encoding = name_of(text(body));
    if (const auto known = schemas_.find(schema); known != schemas_.end()) topic.type = known->second;
    if (body.bad || topic.name.empty()) return;
    const auto same = std::find_if(topics_.begin(), topics_.end(), [&](const LogTopic& one) {
      return one.name == topic.name && one.type == topic.type && one.encoding == topic.encoding;
    });
    const std::size_t index = std::size_t(same - topics_.begin());
    if (same == topics_.end()) {
      if (topics_.size() >= limits::kLogTopics) return;
      topics_.push_back(topic);
      selected_.push_back(false);
    }
    channels_[id] = index;
  }

  bool wants(std::uint16_t channel) const {
    const auto known = channels_.find(channel);
    return known != channels_.end() && (is_scanning_ || selected_[known->second]);
  }

  /// true if the message is of a selected topic.
  bool take_message(std::string_view bytes, LoggedMessage& message) {
    ByteReader body{bytes};
    const auto channel = body.number<std::uint16_t>();
    body.take(4);
    const auto logged = body.number<std::uint64_t>();
    body.take(8);
    if (body.bad) refuse_damaged("a message of the log is shorter than its head");
    if (!wants(channel)) return false;
    message.topic = channels_[channel];
    message.logged_ns =
        std::int64_t(std::min<std::uint64_t>(logged, std::numeric_limits<std::int64_t>::max()));
    message.bytes = body.rest;
    return true;
  }

  bool take_record(std::uint8_t opcode, std::string_view bytes, LoggedMessage& message) {
    ByteReader body{bytes};
    if (opcode == kSchema) take_schema(body);
    if (opcode == kChannel) take_channel(body);
    return opcode == kMessage && take_message(bytes, message);
  }

  bool next_in_chunk(LoggedMessage& message) {
    const Record record = record_header(in_chunk_);
    if (in_chunk_.bad || record.length > in_chunk_.rest.size()) {
      in_chunk_ = {};
      refuse_damaged("a chunk of the log ends within a record");
    }
    return take_record(record.opcode, in_chunk_.take(std::size_t(record.length)), message);
  }

  /// nullopt: nothing yet, a chunk may have been opened.
  std::optional<bool> next_in_file(LoggedMessage& message) {
    if (at_ + kRecordHeader > size_) return false;
    const std::uint64_t offset = at_;
    char head_bytes[kRecordHeader];
    read(offset, head_bytes, kRecordHeader);
    ByteReader head{{head_bytes, kRecordHeader}};
    const Record record = record_header(head);
    if (record.opcode == kDataEnd || record.opcode == kFooter || record.opcode == 0) return false;
    if (record.length > size_ - offset - kRecordHeader) return false;  // cut
    at_ = offset + kRecordHeader + record.length;
    if (record.opcode == kChunk) {
      if (is_wanted(offset)) open_chunk(offset + kRecordHeader, record.length);
      return std::nullopt;
    }
    if (record.opcode != kMessage && record.opcode != kSchema && record.opcode != kChannel)
      return std::nullopt;
    const bool is_message = record.opcode == kMessage;
    if (record.length > (is_message ? limits::kDdsSampleBytes + kMessageHeader : kSmallRecord))
      throw Refusal{"ros2_oversized", "a message of the log is larger than 64 MiB"};
    if (take_record(record.opcode, bytes_at(offset + kRecordHeader, std::size_t(record.length)), message))
      return true;
    return std::nullopt;
  }

  bool is_wanted(std::uint64_t offset) const {
    const auto found =
        std::lower_bound(index_.begin(), index_.end(), offset,
                         [](const Indexed& chunk, std::uint64_t value) { return chunk.offset < value; });
    // One without an index of its messages may hold any.
    if (found == index_.end() || found->offset != offset || found->channels.empty()) return true;
    return std::any_of(found->channels.begin(), found->channels.end(),
                       [this](std::uint16_t channel) { return wants(channel); });
  }

  void open_chunk(std::uint64_t offset, std::uint64_t length) {
    if (length > limits::kLogChunkBytes)
      throw Refusal{"ros2_oversized", "a chunk of the log is larger than 128 MiB"};
    ByteReader body{bytes_at(offset, std::size_t(length))};
    body.take(16);
    const auto size = body.number<std::uint64_t>();
    const auto crc = body.number<std::uint32_t>();
    const std::string compression(text(body));
    const std::string_view packed = body.take(std::size_t(body.number<std::uint64_t>()));
    if (body.bad) refuse_damaged("a chunk of the log contradicts its own lengths");
    if (size > limits::kLogChunkBytes)
      throw Refusal{"ros2_oversized", "a chunk of the log is larger than 128 MiB"};
    std::string_view records = packed;
    if (compression.empty())
      chunk_.clear();
    else if (compression == "zstd")
      chunk_ = unpacked_zstd(packed, std::size_t(size));
    else if (compression == "lz4")
      chunk_ = unpacked_lz4(packed, std::size_t(size));
    else
      refuse_damaged("a chunk of the log is compressed by a method that is neither zstd nor lz4");
    if (!compression.empty()) records = chunk_;
    if (!is_scanning_ && crc != 0 && crc != crc32_of(records))
      refuse_damaged("a chunk of the log has another checksum than it states");
    in_chunk_ = {records};
  }

  const std::filesystem::path path_;
  std::ifstream file_;
  std::uint64_t size_ = 0, at_ = 0;
  std::uint64_t position_ = std::uint64_t(-1);  ///< of the stream
  std::string buffer_, chunk_;
  ByteReader in_chunk_;  ///< records of a chunk that are left, in buffer_ or chunk_
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;  ///< indices into topics_
  std::vector<bool> selected_;
  std::vector<Indexed> index_;  ///< by offset
  bool is_scanning_ = false;
};

}  // namespace

std::unique_ptr<MessageLog> open_mcap(const std::filesystem::path& path) {
  return std::make_unique<McapLog>(path);
}

}  // namespace procam::dds::internal
