#pragma once
/// Pictures with EXIF, made byte by byte.
#include <cstdint>
#include <string>
#include <vector>

namespace procam::test {

inline std::string bytes_of(std::uint64_t value, int count, bool big_endian) {
  std::string out;
  for (int i = 0; i < count; ++i) out += char(value >> 8 * (big_endian ? count - 1 - i : i));
  return out;
}

struct ExifField {
  unsigned tag = 0;
  double value = 0;
  int type = 3;  ///< 3 SHORT, 4 LONG, 5 RATIONAL (in thousandths)
};

/// A TIFF block whose first directory points to one with `fields`.
inline std::string exif_block(const std::vector<ExifField>& fields, bool big_endian) {
  const auto number = [&](std::uint64_t value, int count) { return bytes_of(value, count, big_endian); };
  constexpr std::size_t kExif = 8 + 2 + 12 + 4;
  std::string out = (big_endian ? "MM" : "II") + number(42, 2) + number(8, 4);
  out += number(1, 2) + number(0x8769, 2) + number(4, 2) + number(1, 4) + number(kExif, 4) + number(0, 4);
  std::string rationals;
  out += number(fields.size(), 2);
  const std::size_t behind = kExif + 2 + 12 * fields.size() + 4;
  for (const ExifField& field : fields) {
    out += number(field.tag, 2) + number(std::uint64_t(field.type), 2) + number(1, 4);
    if (field.type == 5) {
      out += number(behind + rationals.size(), 4);
      rationals += number(std::uint64_t(1000 * field.value + 0.5), 4) + number(1000, 4);
    } else if (field.type == 3) {
      out += number(std::uint64_t(field.value), 2) + number(0, 2);
    } else {
      out += number(std::uint64_t(field.value), 4);
    }
  }
  return out + number(0, 4) + rationals;
}

/// The segments of a grey JPEG with little behind them; decoders refuse it.
inline std::string jpeg_with(const std::string& block, int width, int height) {
  const auto number = [](std::uint64_t value, int count) { return bytes_of(value, count, true); };
  const std::string app1 = std::string("Exif\0\0", 6) + block;
  std::string out = "\xff\xd8\xff\xe0" + number(4, 2) + "JF";
  out += "\xff\xff\xff\xe1" + number(app1.size() + 2, 2) + app1;  // 0xff 0xff: a fill byte
  out += "\xff\xc0" + number(11, 2) + number(8, 1) + number(std::uint64_t(height), 2) +
         number(std::uint64_t(width), 2) + number(1, 1) + std::string("\1\x11\0", 3);
  return out + "\xff\xda" + number(8, 2) + std::string("\1\1\0\0\x3f\0", 6) + "data\xff\xd9";
}

/// A PNG with a chunk eXIf before its pixels. `crc`: io::crc32.
template <typename Crc>
std::string png_with(const std::string& block, const std::string& png, const Crc& crc) {
  constexpr std::size_t kBehindHeader = 8 + 12 + 13;
  const std::string chunk = "eXIf" + block;
  return png.substr(0, kBehindHeader) + bytes_of(block.size(), 4, true) + chunk +
         bytes_of(crc(chunk), 4, true) + png.substr(kBehindHeader);
}

}  // namespace procam::test
