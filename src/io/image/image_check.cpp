#include "image/image_check.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "procam/core/base/bytes.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {

/// Eight bytes at a time (M. E. Kounavis and F. L. Berry, "A systematic approach to building high performance
/// software-based CRC generators", 2005): tables[k][n] is what the byte n becomes k bytes later.
std::uint32_t crc32(std::string_view bytes) {
  using Tables = std::array<std::array<std::uint32_t, 256>, 8>;
  static const Tables tables = [] {
    Tables t{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      std::uint32_t c = n;
      for (int k = 0; k < 8; ++k) c = (c & 1) ? 0xedb88320u ^ (c >> 1) : c >> 1;
      t[0][n] = c;
    }
    for (std::size_t later = 1; later < t.size(); ++later)
      for (std::size_t n = 0; n < 256; ++n)
        t[later][n] = t[0][t[later - 1][n] & 0xff] ^ (t[later - 1][n] >> 8);
    return t;
  }();
  std::uint32_t c = 0xffffffffu;
  const auto* byte = reinterpret_cast<const unsigned char*>(bytes.data());
  std::size_t left = bytes.size();
  for (; left >= 8; left -= 8, byte += 8)
    c = tables[7][(c ^ byte[0]) & 0xff] ^ tables[6][((c >> 8) ^ byte[1]) & 0xff] ^
        tables[5][((c >> 16) ^ byte[2]) & 0xff] ^ tables[4][(c >> 24) ^ byte[3]] ^ tables[3][byte[4]] ^
        tables[2][byte[5]] ^ tables[1][byte[6]] ^ tables[0][byte[7]];
  for (; left > 0; --left, ++byte) c = tables[0][(c ^ *byte) & 0xff] ^ (c >> 8);
  return c ^ 0xffffffffu;
}

namespace {

const char* const kCutShort = "the file is cut short";

/// Bytes with bounds: reading past the end gives zero and is remembered.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}
  std::size_t size() const { return bytes_.size(); }
  bool overrun() const { return overrun_; }
  std::uint32_t number(std::size_t offset, std::size_t count) {
    const auto value = unsigned_at(bytes_, offset, count, big_endian_);
    overrun_ = overrun_ || !value;
    return std::uint32_t(value.value_or(0));
  }

 private:
  std::string_view bytes_;
  bool big_endian_;
  bool overrun_ = false;
};

ImageCheck check_png(std::string_view bytes) {
  ImageCheck check;
  check.format = ImageFormat::kPng;
  Bytes data(bytes, true);
  long long bits_a_pixel = 0, compressed = 0;
  for (std::size_t at = 8;;) {
    const std::size_t length = data.number(at, 4);
    if (data.overrun() || bytes.size() - at < 12 || bytes.size() - at - 12 < length) {
      check.damage = kCutShort;
      return check;
    }
    const std::string_view type = bytes.substr(at + 4, 4);
    if (crc32(bytes.substr(at + 4, 4 + length)) != data.number(at + 8 + length, 4)) {
      check.damage = "a part of the file fails its checksum at byte " + std::to_string(at);
      return check;
    }
    if (at == 8) {
      if (type != "IHDR" || length != 13) {
        check.damage = "its header is not a PNG header";
        return check;
      }
      check.width = data.number(at + 8, 4);
      check.height = data.number(at + 12, 4);
      const std::uint32_t bits = data.number(at + 16, 1), color = data.number(at + 17, 1);
      // Grey, grey and alpha, R G B; a palette's entries may have alpha.
      const long long stored = color == 2 ? 3 : color == 4 ? 2 : color == 6 ? 4 : 1;
      const long long decoded = color == 0 ? 1 : color == 2 ? 3 : 4;
      bits_a_pixel = stored * bits;
      check.bytes_a_pixel = decoded * (bits == 16 ? 2 : 1);
    }
    if (type == "IDAT") compressed += static_cast<long long>(length);
    if (type == "IEND") {
      // Deflate makes a byte of at most 1032; the headers are the rest.
      constexpr long long kMaxRatio = 1040;
      if (check.width > 0 && check.height > limits::kImagePixels / check.width) return check;
      if (check.width * check.height * bits_a_pixel / 8 > kMaxRatio * compressed) check.damage = kCutShort;
      return check;
    }
    at += 12 + length;
  }
}

ImageCheck check_jpeg(std::string_view bytes) {
  ImageCheck check;
  check.format = ImageFormat::kJpeg;
  Bytes data(bytes, true);
  bool in_scan = false;
  for (std::size_t at = 2;;) {
    if (in_scan) {  // coded data: 0xff is followed by 0 (stuffing) or a restart marker until the next segment
      at = bytes.find('\xff', at);
      if (at == std::string_view::npos || at + 1 >= bytes.size()) break;
      const auto next = static_cast<unsigned char>(bytes[at + 1]);
      if (next == 0 || (next >= 0xd0 && next <= 0xd7)) {
        at += 2;
        continue;
      }
      in_scan = false;
    }
    const std::uint32_t marker = data.number(at, 2);
    if (data.overrun()) break;
    if (marker == 0xffff) {  // a fill byte
      ++at;
      continue;
    }
    if (marker == 0xffd9) {
      if (check.width == 0 || check.height == 0) check.damage = "it ends before its picture begins";
      return check;
    }
    if (marker < 0xff01) {
      check.damage = "a segment does not begin where it should, at byte " + std::to_string(at);
      return check;
    }
    const std::size_t length = data.number(at + 2, 2);
    if (data.overrun() || bytes.size() - at - 2 < length) break;
    // Start of frame: 0xffc0 to 0xffcf but for DHT, JPG and DAC.
    if ((marker & 0xfff0) == 0xffc0 && marker != 0xffc4 && marker != 0xffc8 && marker != 0xffcc) {
      check.height = data.number(at + 5, 2);
      check.width = data.number(at + 7, 2);
      check.bytes_a_pixel = data.number(at + 9, 1) == 1 ? 1 : 3;
    }
    in_scan = marker == 0xffda;
    at += 2 + length;
  }
  check.damage = kCutShort;
  return check;
}

ImageCheck check_bmp(std::string_view bytes) {
  ImageCheck check;
  check.format = ImageFormat::kBmp;
  Bytes data(bytes, false);
  const std::uint32_t pixels_at = data.number(10, 4), header_size = data.number(14, 4);
  long long bits = 0;
  bool compressed = false;
  if (header_size == 12) {  // the OS/2 header
    check.width = data.number(18, 2);
    check.height = data.number(20, 2);
    bits = data.number(24, 2);
  } else {
    check.width = std::int32_t(data.number(18, 4));
    const long long height = std::int32_t(data.number(22, 4));
    check.height = height < 0 ? -height : height;  // negative: the top row comes first
    bits = data.number(28, 2);
    const std::uint32_t compression = data.number(30, 4);
    compressed = compression != 0 && compression != 3;  // 3: masks before plain pixels
  }
  if (check.width < 1 || bits > 32) {
    check.damage = "its header is not a BMP header";
    return check;
  }
  check.bytes_a_pixel = bits == 32 ? 4 : 3;
  if (check.height > limits::kImagePixels / check.width) return check;  // too_large() refuses it
  const long long row = (check.width * bits + 31) / 32 * 4;
  const auto size = static_cast<long long>(bytes.size());
  if (data.overrun() ||
      (compressed ? data.number(2, 4) > bytes.size() : pixels_at + row * check.height > size))
    check.damage = kCutShort;
  return check;
}

/// One field of a TIFF directory as whole numbers (TIFF 6.0, section 2).
std::vector<std::uint32_t> tiff_values(Bytes& data, std::size_t entry) {
  const std::uint32_t type = data.number(entry + 2, 2);
  const std::size_t count = data.number(entry + 4, 4);
  const std::size_t bytes_each = type == 3 ? 2 : type == 4 ? 4 : type == 1 ? 1 : 0;
  std::vector<std::uint32_t> values;
  if (bytes_each == 0) return values;
  const std::size_t at = count * bytes_each <= 4 ? entry + 8 : data.number(entry + 8, 4);
  for (std::size_t i = 0; i < count && !data.overrun(); ++i)
    values.push_back(data.number(at + i * bytes_each, bytes_each));
  return values;
}

ImageCheck check_tiff(std::string_view bytes) {
  ImageCheck check;
  check.format = ImageFormat::kTiff;
  Bytes data(bytes, bytes[0] == 'M');
  const std::size_t directory = data.number(4, 4);
  const std::size_t entries = data.number(directory, 2);
  std::map<std::uint32_t, std::vector<std::uint32_t>> tags;
  for (std::size_t i = 0; i < entries && !data.overrun(); ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    const std::uint32_t tag = data.number(entry, 2);
    // Width, height, bits (258) of each sample, color (262), samples a pixel (277), and where strips (273, 279) or
    // tiles (324, 325) lie; other fields may have any type.
    if (tags.count(tag) != 0) continue;
    if ((tag >= 256 && tag <= 258) || tag == 262 || tag == 273 || tag == 277 || tag == 279 || tag == 324 ||
        tag == 325)
      tags[tag] = tiff_values(data, entry);
  }
  const auto single = [&](std::uint32_t tag) { return tags[tag].empty() ? 0 : tags[tag].front(); };
  check.width = single(256);
  check.height = single(257);
  // Gray is one channel; a palette and all else become three or four.
  const long long samples = single(277), bits = single(258);
  const bool is_gray = samples <= 1 && single(262) != 3;
  check.bytes_a_pixel = (is_gray ? 1 : std::max(3LL, samples)) * std::max(1LL, bits / 8);
  const bool tiled = !tags[324].empty();
  const auto& offsets = tags[tiled ? 324 : 273];
  const auto& lengths = tags[tiled ? 325 : 279];
  if (data.overrun() || offsets.empty() || offsets.size() != lengths.size()) {
    check.damage = data.overrun() ? kCutShort : "its directory does not say where the picture lies";
    return check;
  }
  for (std::size_t i = 0; i < offsets.size(); ++i)
    if (offsets[i] > bytes.size() || bytes.size() - offsets[i] < lengths[i]) check.damage = kCutShort;
  return check;
}

}  // namespace

std::string too_large(const ImageCheck& check) {
  const bool fits =
      check.width < 1 || (check.height <= limits::kImagePixels / check.width &&
                          check.width * check.height <= limits::kImageBytes / check.bytes_a_pixel);
  return fits ? ""
              : "its header claims " + std::to_string(check.width) + " x " + std::to_string(check.height) +
                    " pixels of " + std::to_string(check.bytes_a_pixel) + " bytes";
}

ImageCheck check_image(std::string_view bytes) {
  const auto begins = [&](std::string_view magic) { return bytes.substr(0, magic.size()) == magic; };
  if (begins("\x89PNG\r\n\x1a\n")) return check_png(bytes);
  if (begins("\xff\xd8\xff")) return check_jpeg(bytes);
  if (begins("BM")) return check_bmp(bytes);
  if (begins(std::string_view("II*\0", 4)) || begins(std::string_view("MM\0*", 4))) return check_tiff(bytes);
  return {};
}

}  // namespace procam::io
