#include "mcap_encoder.hpp"

#include <algorithm>

#include "compression.hpp"
#include "mcap_records.hpp"

namespace procam::dds::internal {
namespace {

template <typename Unsigned>
std::string number(Unsigned value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i) bytes += char(std::uint64_t(value) >> (8 * i) & 0xff);
  return bytes;
}

/// A text, or anything else whose bytes are counted before it.
std::string counted_bytes(const std::string& bytes) {
  return number(std::uint32_t(bytes.size())) + bytes;
}

std::string record(Opcode opcode, const std::string& contents) {
  return char(opcode) + number(std::uint64_t(contents.size())) + contents;
}

}  // namespace

std::string McapEncoder::definitions() const {
  std::string bytes;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const McapChannel& one = channels_[i];
    const auto id = std::uint16_t(i + 1);  // a schema's 0 is none
    bytes += record(kSchema, number(id) + counted_bytes(one.type) + counted_bytes("ros2msg") +
                                 counted_bytes(one.definition));
    bytes += record(kChannel, number(id) + number(id) + counted_bytes(one.topic) + counted_bytes("cdr") +
                                  counted_bytes(""));
  }
  return bytes;
}

std::string McapEncoder::begin() {
  *this = McapEncoder(std::move(channels_));
  const std::string bytes = std::string(kMcapMagic) +
                            record(kHeader, counted_bytes("ros2") + counted_bytes("procam")) + definitions();
  offset_ = bytes.size();
  return bytes;
}

void McapEncoder::add(std::size_t channel, std::int64_t time_ns, const std::string& message) {
  const auto id = std::uint16_t(channel + 1);
  const auto time = std::uint64_t(std::max<std::int64_t>(time_ns, 0));
  open_first_ = open_.empty() ? time : std::min(open_first_, time);
  open_last_ = open_.empty() ? time : std::max(open_last_, time);
  message_indices_[id] += number(time) + number(std::uint64_t(open_.size()));
  const auto sequence = std::uint32_t(++counts_[id]);
  open_ += record(kMessage, number(id) + number(sequence) + number(time) + number(time) + message);
}

std::string McapEncoder::chunk() {
  if (open_.empty()) return {};
  const std::string compression = has_zstd() ? "zstd" : "";
  const std::string packed = has_zstd() ? packed_zstd(open_) : open_;
  std::string bytes =
      record(kChunk, number(open_first_) + number(open_last_) + number(std::uint64_t(open_.size())) +
                         number(crc32_of(open_)) + counted_bytes(compression) +
                         number(std::uint64_t(packed.size())) + packed);
  const std::uint64_t chunk_length = bytes.size();
  std::string offsets;
  for (const auto& [channel, entries] : message_indices_) {
    offsets += number(channel) + number(offset_ + bytes.size());
    bytes += record(kMessageIndex, number(channel) + counted_bytes(entries));
  }
  chunk_indices_ +=
      record(kChunkIndex, number(open_first_) + number(open_last_) + number(offset_) + number(chunk_length) +
                              counted_bytes(offsets) + number(std::uint64_t(bytes.size()) - chunk_length) +
                              counted_bytes(compression) + number(std::uint64_t(packed.size())) +
                              number(std::uint64_t(open_.size())));
  first_ = chunks_ == 0 ? open_first_ : std::min(first_, open_first_);
  last_ = std::max(last_, open_last_);
  ++chunks_;
  offset_ += bytes.size();
  open_.clear();
  message_indices_.clear();
  return bytes;
}

std::string McapEncoder::end() {
  const std::string last_chunk = chunk();  // moves offset_ behind it
  const std::string data_end = record(kDataEnd, number(std::uint32_t(0)));
  const std::uint64_t start = offset_ + data_end.size();
  std::string counts;
  std::uint64_t all = 0;
  for (const auto& [channel, count] : counts_) {
    counts += number(channel) + number(count);
    all += count;
  }
  std::string summary =
      definitions() + chunk_indices_ +
      record(kStatistics, number(all) + number(std::uint16_t(channels_.size())) +
                              number(std::uint32_t(channels_.size())) + number(std::uint32_t(0)) +
                              number(std::uint32_t(0)) + number(chunks_) + number(first_) + number(last_) +
                              counted_bytes(counts));
  // The checksum is that of the summary and of the footer up to it.
  summary += char(kFooter) + number(std::uint64_t(20)) + number(start) + number(std::uint64_t(0));
  return last_chunk + data_end + summary + number(crc32_of(summary)) + std::string(kMcapMagic);
}

}  // namespace procam::dds::internal
