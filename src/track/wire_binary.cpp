#include <boost/crc.hpp>
#include <cmath>
#include <cstring>

#include "procam/core/base/limits.hpp"
#include "procam/track/detail/message_check.hpp"
#include "procam/track/detail/wire_bytes.hpp"
#include "procam/track/wire.hpp"
#include "wire_json.hpp"
#include "wire_parsers.hpp"

namespace procam::track {
namespace {

constexpr std::string_view kMagic = "PCPO";
constexpr std::uint8_t kVersion = 1;
enum Flag : std::uint8_t {
  kHasStamp = 1,
  kHasCovariance = 2,
  kHasTwist = 4,
  kHasRate = 8,
  kHasSequence = 16
};
constexpr std::size_t kHeaderSize = 8, kShortest = 8 + 8 + 4 + 56 + 2 + 4;

template <typename Unsigned>
void put(std::string& bytes, Unsigned value, bool big = false) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    bytes += char(std::uint8_t(value >> (8 * (big ? sizeof value - 1 - i : i))));
}
void put_double(std::string& bytes, double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  put(bytes, bits);
}
void put_float(std::string& bytes, double value, bool big) {
  const auto single = float(value);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &single, sizeof bits);
  put(bytes, bits, big);
}

using internal::osc_text;

std::uint32_t crc32(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

/// A whole binary message, magic to CRC.
const char* read_binary(std::string_view bytes, StampedPose& message) {
  ByteReader crc{bytes.substr(bytes.size() - 4)};
  const std::string_view covered = bytes.substr(0, bytes.size() - 4);
  if (crc.number<std::uint32_t>() != crc32(covered)) return "the checksum is wrong";
  ByteReader in{covered};
  in.take(kMagic.size());
  if (in.number<std::uint8_t>() != kVersion) return "a binary message of another version";
  const auto flags = in.number<std::uint8_t>();
  in.number<std::uint16_t>();
  const double stamp = in.real64();
  const auto sequence = in.number<std::uint32_t>();
  if (flags & kHasStamp) message.stamp = stamp;
  if (flags & kHasSequence) message.sequence = sequence;
  for (Eigen::Index i = 0; i < 3; ++i) message.frame_from_child.translation[i] = in.real64();
  for (Eigen::Index i = 0; i < 4; ++i) message.frame_from_child.rotation.coeffs()[i] = in.real64();
  if (flags & kHasCovariance) {
    message.covariance = Mat6();
    for (Eigen::Index r = 0; r < 6; ++r)
      for (Eigen::Index c = r; c < 6; ++c)
        (*message.covariance)(r, c) = (*message.covariance)(c, r) = in.real64();
  }
  if (flags & kHasTwist) {
    message.twist = Vec6();
    for (Eigen::Index i = 0; i < 6; ++i) (*message.twist)[i] = in.real64();
  }
  if (flags & kHasRate) {
    message.angular_rate = Vec3();
    for (Eigen::Index i = 0; i < 3; ++i) (*message.angular_rate)[i] = in.real64();
  }
  message.frame = in.take(in.number<std::uint8_t>());
  message.child = in.take(in.number<std::uint8_t>());
  if (in.bad || !in.rest.empty() || flags > 31) return "the length does not match the fields";
  return internal::why_malformed(message);
}

void refuse(Parsed& parsed, const char* why) {
  ++parsed.malformed;
  parsed.why = why;
}

void keep_checked(StampedPose& message, Parsed& parsed) {
  internal::make_unit(message.frame_from_child.rotation);
  parsed.poses.push_back(std::move(message));
}

/// Where a message may begin again: at a magic, or at a line that begins with a brace.
std::size_t end_of_garbage(std::string_view bytes) {
  const std::size_t magic = bytes.find(kMagic), line = bytes.find("\n{");
  return std::min(magic, line == bytes.npos ? line : line + 1);
}

/// Takes what is whole off the front and returns how much that is; `ends`: nothing will follow.
std::size_t take_messages(std::string_view bytes, bool ends, bool& skipping, Parsed& parsed) {
  std::size_t at = 0;
  while (at < bytes.size()) {
    if (ends && parsed.malformed >= limits::kMalformedPerDatagram) return bytes.size();
    const std::string_view rest = bytes.substr(at);
    const std::string_view start = rest.substr(0, kMagic.size());
    if (start == kMagic.substr(0, start.size())) {
      std::size_t length = kHeaderSize;
      if (rest.size() >= kHeaderSize) {
        length = std::uint8_t(rest[6]) + 256u * std::uint8_t(rest[7]);
        if (length < kShortest || length > limits::kMessageBytes) {
          if (!skipping) refuse(parsed, "a binary message of impossible length");
          skipping = true;
          at += kMagic.size();
          continue;
        }
      }
      if (rest.size() < length) {
        if (!ends) return at;
        if (!skipping) refuse(parsed, "a message is cut short");
        return bytes.size();
      }
      StampedPose message;
      if (const char* why = read_binary(rest.substr(0, length), message)) {
        if (!skipping) refuse(parsed, why);
        skipping = true;
        at += kMagic.size();
        continue;
      }
      skipping = false;
      keep_checked(message, parsed);
      at += length;
      continue;
    }
    const std::size_t text = rest.find_first_not_of(" \t\r\n");
    if (!skipping && text != 0) {
      at += std::min(text, rest.size());
      continue;
    }
    if (skipping || rest[0] != '{') {
      if (!skipping) refuse(parsed, "neither a JSON line nor a binary message");
      skipping = true;
      const std::size_t next = end_of_garbage(rest);
      if (next == rest.npos) {
        if (ends) return bytes.size();
        // The last bytes may be the beginning of an end.
        const std::size_t kept = rest.back() == '\n' ? 1 : std::min(rest.size() - 1, kMagic.size() - 1);
        return bytes.size() - kept;
      }
      if (rest[next] == '{') skipping = false;
      at += next;
      continue;
    }
    const std::size_t line_end = rest.find('\n');
    if (line_end == rest.npos && !ends && rest.size() <= limits::kMessageBytes) return at;
    const std::string_view line = rest.substr(0, line_end);
    StampedPose message;
    const char* why = line.size() > limits::kMessageBytes ? "a line is longer than 8192 bytes"
                                                          : internal::read_json_message(line, false, message);
    if (why != nullptr) {
      refuse(parsed, why);
      skipping = line_end == rest.npos;
    } else {
      keep_checked(message, parsed);
    }
    at += line_end == rest.npos ? rest.size() : line_end + 1;
  }
  return at;
}

}  // namespace

Parsed parse_poses(std::string_view datagram) {
  Parsed parsed;
  bool skipping = false;
  take_messages(datagram, true, skipping, parsed);
  return parsed;
}

Parsed StreamParser::parse(std::string_view bytes) {
  Parsed parsed;
  rest_ += bytes;
  rest_.erase(0, take_messages(rest_, false, skipping_, parsed));
  return parsed;
}

std::string to_binary(const StampedPose& message) {
  std::string bytes(kMagic);
  put(bytes, kVersion);
  put(bytes, std::uint8_t((message.stamp ? kHasStamp : 0) | (message.covariance ? kHasCovariance : 0) |
                          (message.twist ? kHasTwist : 0) | (message.angular_rate ? kHasRate : 0) |
                          (message.sequence ? kHasSequence : 0)));
  put(bytes, std::uint16_t(0));
  put_double(bytes, message.stamp.value_or(0));
  put(bytes, message.sequence.value_or(0));
  for (Eigen::Index i = 0; i < 3; ++i) put_double(bytes, message.frame_from_child.translation[i]);
  for (Eigen::Index i = 0; i < 4; ++i) put_double(bytes, message.frame_from_child.rotation.coeffs()[i]);
  if (message.covariance)
    for (Eigen::Index r = 0; r < 6; ++r)
      for (Eigen::Index c = r; c < 6; ++c) put_double(bytes, (*message.covariance)(r, c));
  if (message.twist)
    for (Eigen::Index i = 0; i < 6; ++i) put_double(bytes, (*message.twist)[i]);
  if (message.angular_rate)
    for (Eigen::Index i = 0; i < 3; ++i) put_double(bytes, (*message.angular_rate)[i]);
  for (const std::string& name : {message.frame, message.child}) {
    const std::string kept = name.substr(0, 255);
    put(bytes, std::uint8_t(kept.size()));
    bytes += kept;
  }
  const std::size_t length = bytes.size() + 4;
  bytes[6] = char(std::uint8_t(length));
  bytes[7] = char(std::uint8_t(length >> 8));
  put(bytes, crc32(bytes));
  return bytes;
}

// --- OSC 1.0: big-endian, everything padded to four bytes ---

namespace {

constexpr double kUnixInNtp = 2208988800.0;  // seconds from 1900 to 1970

/// 64 bits of NTP time; 1 means "now".
std::optional<double> osc_time(std::uint64_t tag) {
  if (tag <= 1) return std::nullopt;
  return double(tag >> 32) - kUnixInNtp + double(tag & 0xffffffffu) * 0x1p-32;
}

void read_osc_message(std::string_view bytes, const std::optional<double>& bundle_stamp, Parsed& parsed) {
  ByteReader in{bytes};
  std::string_view address = osc_text(in);
  const std::string_view types = osc_text(in);
  constexpr std::string_view kEnd = "/pose";
  if (in.bad || address.empty() || address[0] != '/') return refuse(parsed, "it is no OSC message");
  if (address.size() < kEnd.size() || address.substr(address.size() - kEnd.size()) != kEnd)
    return refuse(parsed, "an OSC address that does not end in /pose");
  if (types.size() < 8 || types.size() > 9 || types[0] != ',')
    return refuse(parsed, "an OSC pose has 7 numbers, or 8 with the stamp first");
  StampedPose message;
  message.stamp = bundle_stamp;
  std::array<double, 7> numbers = {};
  const bool stamped = types.size() == 9;
  for (std::size_t i = 1; i < types.size(); ++i) {
    double value = 0;
    if (types[i] == 'f') {
      value = in.real32(true);
    } else if (types[i] == 'd') {
      value = in.real64(true);
    } else if (types[i] == 'i') {
      value = double(std::int32_t(in.number<std::uint32_t>(true)));
    } else if (types[i] == 't' && stamped && i == 1) {
      message.stamp = osc_time(in.number<std::uint64_t>(true));
      continue;
    } else {
      return refuse(parsed, "an OSC argument that is no number");
    }
    if (stamped && i == 1)
      message.stamp = value;
    else
      numbers[i - 1 - (stamped ? 1 : 0)] = value;
  }
  if (in.bad || !in.rest.empty()) return refuse(parsed, "the length does not match the OSC types");
  message.frame_from_child.translation = Eigen::Map<const Vec3>(numbers.data());
  message.frame_from_child.rotation = Eigen::Quaterniond(numbers[6], numbers[3], numbers[4], numbers[5]);
  // "/map/base/pose", "/base/pose" or "/pose".
  address.remove_suffix(kEnd.size());
  const std::size_t last = address.rfind('/');
  message.child = last == address.npos ? "base" : std::string(address.substr(last + 1));
  message.frame = last == address.npos || last == 0 ? "map" : std::string(address.substr(1, last - 1));
  if (message.child.empty() || message.child.size() > 255 || message.frame.size() > 255)
    return refuse(parsed, "a frame's name is empty or longer than 255 bytes");
  if (const char* why = internal::why_malformed(message)) return refuse(parsed, why);
  keep_checked(message, parsed);
}

void read_osc(std::string_view bytes, const std::optional<double>& stamp, int depth, Parsed& parsed) {
  if (bytes.substr(0, internal::kOscBundle.size()) != internal::kOscBundle)
    return read_osc_message(bytes, stamp, parsed);
  if (depth == limits::kOscDepth) return refuse(parsed, "OSC bundles are nested too deeply");
  ByteReader in{bytes.substr(internal::kOscBundle.size())};
  const std::optional<double> bundle_stamp = osc_time(in.number<std::uint64_t>(true));
  if (in.bad) return refuse(parsed, "an OSC bundle is cut short");
  while (!in.rest.empty()) {
    const std::string_view element = in.take(in.number<std::uint32_t>(true));
    if (in.bad) return refuse(parsed, "an OSC bundle is cut short");
    read_osc(element, bundle_stamp, depth + 1, parsed);
  }
}

void put_osc_text(std::string& bytes, const std::string& text) {
  bytes += text;
  bytes.append(4 - text.size() % 4, '\0');
}

}  // namespace

Parsed parse_osc(std::string_view datagram) {
  Parsed parsed;
  read_osc(datagram, std::nullopt, 0, parsed);
  return parsed;
}

std::string to_osc(const StampedPose& message) {
  std::string bytes;
  put_osc_text(bytes, "/" + message.frame + "/" + message.child + "/pose");
  put_osc_text(bytes, message.stamp ? ",dddddddd" : ",ddddddd");
  const auto put_big = [&](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    put(bytes, bits, true);
  };
  if (message.stamp) put_big(*message.stamp);
  for (Eigen::Index i = 0; i < 3; ++i) put_big(message.frame_from_child.translation[i]);
  for (Eigen::Index i = 0; i < 4; ++i) put_big(message.frame_from_child.rotation.coeffs()[i]);
  return bytes;
}

// --- PosiStageNet 2: little-endian chunks of (id, length, has_subchunks) ---

namespace {

constexpr std::uint32_t kPsnData = 0x6755, kPsnInfo = 0x6756;
constexpr std::uint32_t kPsnHeader = 0, kPsnTrackers = 1;
constexpr std::uint32_t kPsnPosition = 0, kPsnOrientation = 2, kPsnTime = 6;

struct Chunk {
  std::uint32_t id = 0;
  ByteReader data;
};
/// nullopt at the end and when it is cut short (in.bad).
std::optional<Chunk> next_chunk(ByteReader& in) {
  if (in.rest.empty()) return std::nullopt;
  const auto head = in.number<std::uint32_t>();
  Chunk chunk;
  chunk.id = head & 0xffff;
  chunk.data.rest = in.take((head >> 16) & 0x7fff);
  if (in.bad) return std::nullopt;
  return chunk;
}

void read_tracker(std::uint32_t id, ByteReader in, std::optional<double> stamp, Parsed& parsed) {
  StampedPose message;
  message.frame = "psn";
  message.child = "tracker " + std::to_string(id);
  bool has_position = false, has_orientation = false;
  while (auto chunk = next_chunk(in)) {
    ByteReader& data = chunk->data;
    if (chunk->id == kPsnPosition || chunk->id == kPsnOrientation) {
      const double x = data.real32(), y = data.real32(), z = data.real32();
      const Vec3 v(x, y, z);
      if (data.bad) return refuse(parsed, "a PosiStageNet chunk is cut short");
      if (chunk->id == kPsnPosition) {
        message.frame_from_child.translation = v;
        has_position = true;
      } else {
        // About the vector, by its length in radians.
        if (!(v.norm() <= 100)) return refuse(parsed, "an orientation that is no rotation vector");
        message.frame_from_child.rotation = so3_exp(v);
        has_orientation = true;
      }
    } else if (chunk->id == kPsnTime) {
      stamp = 1e-6 * double(data.number<std::uint64_t>());
    }
  }
  if (in.bad) return refuse(parsed, "a PosiStageNet chunk is cut short");
  if (!has_position) return refuse(parsed, "a tracker without a position");
  if (!has_orientation)
    return refuse(parsed,
                  "a tracker sends a position without an orientation, and a pose needs both: let the "
                  "server send orientations too");
  message.stamp = stamp;
  if (const char* why = internal::why_malformed(message)) return refuse(parsed, why);
  keep_checked(message, parsed);
}

void put_chunk(std::string& bytes, std::uint32_t id, const std::string& data, bool has_subchunks) {
  put(bytes, std::uint32_t(id | std::uint32_t(data.size()) << 16 | (has_subchunks ? 0x80000000u : 0u)));
  bytes += data;
}

}  // namespace

Parsed parse_psn(std::string_view datagram) {
  Parsed parsed;
  ByteReader in{datagram};
  auto packet = next_chunk(in);
  if (packet && packet->id == kPsnInfo) return parsed;
  if (!packet || packet->id != kPsnData) {
    refuse(parsed, "it is no PosiStageNet packet");
    return parsed;
  }
  std::optional<double> stamp;
  while (auto part = next_chunk(packet->data)) {
    if (part->id == kPsnHeader) {
      const auto microseconds = part->data.number<std::uint64_t>();
      if (!part->data.bad) stamp = 1e-6 * double(microseconds);
    } else if (part->id == kPsnTrackers) {
      while (auto tracker = next_chunk(part->data)) read_tracker(tracker->id, tracker->data, stamp, parsed);
      if (part->data.bad) refuse(parsed, "a PosiStageNet chunk is cut short");
    }
  }
  if (packet->data.bad) refuse(parsed, "a PosiStageNet chunk is cut short");
  return parsed;
}

std::string to_psn(const StampedPose& message) {
  const auto vector_bytes = [](const Vec3& v) {
    std::string bytes;
    for (Eigen::Index i = 0; i < 3; ++i) put_float(bytes, v[i], false);
    return bytes;
  };
  std::string tracker;
  put_chunk(tracker, kPsnPosition, vector_bytes(message.frame_from_child.translation), false);
  put_chunk(tracker, kPsnOrientation, vector_bytes(so3_log(message.frame_from_child.rotation)), false);
  const std::string prefix = "tracker ";
  std::uint32_t id = 0;
  if (message.child.compare(0, prefix.size(), prefix) == 0)
    for (const char c : message.child.substr(prefix.size()))
      if (c >= '0' && c <= '9') id = (id * 10 + std::uint32_t(c - '0')) & 0xffff;
  std::string trackers, header, body, packet;
  put_chunk(trackers, id, tracker, true);
  put(header, std::uint64_t(std::llround(1e6 * std::max(0.0, message.stamp.value_or(0)))));
  header += {char(2), char(0), char(std::uint8_t(message.sequence.value_or(0))), char(1)};
  put_chunk(body, kPsnHeader, header, false);
  put_chunk(body, kPsnTrackers, trackers, true);
  put_chunk(packet, kPsnData, body, true);
  return packet;
}

}  // namespace procam::track
