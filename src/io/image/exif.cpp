#include "procam/io/image/exif.hpp"

#include <algorithm>
#include <cmath>

#include "image/exif_bytes.hpp"
#include "image/image_check.hpp"
#include "procam/core/base/bytes.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

constexpr double kFilmDiagonal = 43.2666;  // mm, of 36 x 24
constexpr std::string_view kExifMark("Exif\0\0", 6);

/// The TIFF block of a JPEG's first APP1 segment of EXIF; empty: none.
std::string_view block_of_jpeg(std::string_view picture) {
  ByteReader bytes{picture};
  bytes.take(2);
  while (!bytes.bad) {
    const auto marker = bytes.number<std::uint16_t>(true);
    if (marker < 0xff01 || marker == 0xffda || marker == 0xffd9) break;  // coded data begin
    if (marker == 0xffff) {  // a fill byte: the marker begins with the second one
      bytes.rest = picture.substr(picture.size() - bytes.rest.size() - 1);
      continue;
    }
    const auto length = bytes.number<std::uint16_t>(true);
    const std::string_view segment = bytes.take(length < 2 ? 0 : length - 2);
    if (length < 2) break;
    if (marker == 0xffe1 && segment.substr(0, kExifMark.size()) == kExifMark)
      return segment.substr(kExifMark.size());
  }
  return {};
}

/// The chunk eXIf of a PNG; empty: none.
std::string_view block_of_png(std::string_view picture) {
  ByteReader bytes{picture};
  bytes.take(8);
  while (!bytes.bad && !bytes.rest.empty()) {
    const auto length = bytes.number<std::uint32_t>(true);
    const std::string_view type = bytes.take(4), data = bytes.take(length);
    bytes.take(4);  // the checksum
    if (bytes.bad) break;
    if (type == "eXIf") return data;
  }
  return {};
}

/// A TIFF block's directories (TIFF 6.0, section 2). Every read is within the block.
class ExifBlock {
 public:
  explicit ExifBlock(std::string_view block) : block_(block), big_endian_(block.substr(0, 2) == "MM") {}

  bool begins_well() const { return (block_.substr(0, 2) == "II" || big_endian_) && number(2, 2) == 42u; }
  std::optional<std::size_t> first_directory() const { return number(4, 4); }

  /// The first value of a field, of the types SHORT, LONG and RATIONAL; nullopt: not stated, or no number.
  std::optional<double> value(std::size_t directory, unsigned tag) const {
    constexpr unsigned kShort = 3, kLong = 4, kRational = 5;
    const std::size_t entries = number(directory, 2).value_or(0);  // 65535 at most
    for (std::size_t i = 0; i < entries; ++i) {
      const std::size_t entry = directory + 2 + 12 * i;
      const auto found = number(entry, 2);
      if (!found) return std::nullopt;
      if (*found != tag || number(entry + 4, 4).value_or(0) < 1) continue;
      const auto type = number(entry + 2, 2);
      if (type == kShort) return real(number(entry + 8, 2));
      if (type == kLong) return real(number(entry + 8, 4));
      if (type != kRational) return std::nullopt;
      const auto at = number(entry + 8, 4);
      if (!at) return std::nullopt;
      const auto above = number(*at, 4), below = number(*at + 4, 4);
      if (!above || !below || *below == 0) return std::nullopt;
      return double(*above) / double(*below);
    }
    return std::nullopt;
  }

 private:
  static std::optional<double> real(const std::optional<std::size_t>& number) {
    return number ? std::optional<double>(double(*number)) : std::nullopt;
  }
  std::optional<std::size_t> number(std::size_t offset, std::size_t count) const {
    const auto value = unsigned_at(block_, offset, count, big_endian_);
    return value ? std::optional<std::size_t>(std::size_t(*value)) : std::nullopt;
  }
  std::string_view block_;
  bool big_endian_;
};

/// Pixels per millimetre; 0: not stated.
double plane_resolution(const ExifBlock& block, std::size_t directory) {
  constexpr double kMillimetres[] = {25.4, 10, 1, 1e-3};  // of the units 2 to 5; an inch where none is stated
  const double unit = block.value(directory, 0xa210).value_or(2);
  if (!(unit >= 2 && unit <= 5)) return 0;
  return block.value(directory, 0xa20e).value_or(0) / kMillimetres[int(unit) - 2];
}

std::optional<ExifFocal> focal_of(const ExifBlock& block, double width, double height) {
  if (!block.begins_well()) return std::nullopt;
  const auto first = block.first_directory();
  if (!first) return std::nullopt;
  const auto exif = block.value(*first, 0x8769);
  if (!exif) return std::nullopt;
  const auto directory = std::size_t(*exif);
  const auto at = [&](unsigned tag) { return block.value(directory, tag).value_or(0); };
  const double longer = std::max(width, height), shorter = std::min(width, height);
  const double stated_longer = std::max(at(0xa002), at(0xa003)),
               stated_shorter = std::min(at(0xa002), at(0xa003));
  constexpr double kSameRatio = 0.02, kNoZoom = 1.02;
  if (stated_shorter > 0 && std::abs(stated_longer / stated_shorter * shorter / longer - 1) > kSameRatio)
    return std::nullopt;
  if (at(0xa404) > kNoZoom) return std::nullopt;
  ExifFocal out;
  out.equivalent_mm = at(0xa405);
  out.focal_mm = at(0x920a);
  if (out.equivalent_mm > 0)
    out.focal_px = std::hypot(width, height) * out.equivalent_mm / kFilmDiagonal;
  else
    out.focal_px =
        out.focal_mm * plane_resolution(block, directory) * (stated_longer > 0 ? longer / stated_longer : 1);
  // Lenses from a fisheye's to a telescope's; anything else is no measurement.
  constexpr double kShortest = 0.1, kLongest = 100;
  if (!(out.focal_px > kShortest * longer && out.focal_px < kLongest * longer)) return std::nullopt;
  return out;
}

}  // namespace

std::string ExifFocal::description() const {
  return equivalent_mm > 0 ? shortest(equivalent_mm, 4) + " mm equivalent" : shortest(focal_mm, 4) + " mm";
}

std::optional<ExifFocal> exif_focal_in(std::string_view picture) {
  const ImageCheck check = check_image(picture);
  if (!check.damage.empty() || check.width < 1 || check.height < 1) return std::nullopt;
  const std::string_view block = check.format == ImageFormat::kJpeg  ? block_of_jpeg(picture)
                                 : check.format == ImageFormat::kPng ? block_of_png(picture)
                                                                     : std::string_view();
  return focal_of(ExifBlock(block), double(check.width), double(check.height));
}

std::optional<ExifFocal> exif_focal(const std::filesystem::path& picture) {
  try {
    return exif_focal_in(read_file(picture));
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace procam::io
