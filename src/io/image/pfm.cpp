#include "procam/io/image/pfm.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "document/number.hpp"
#include "image/pfm_bytes.hpp"
#include "procam/core/base/bytes.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

const char* const kNextPfm = "export the map again, or copy the whole file";

bool is_pfm_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// Walks through the header; every number is followed by one blank, and the last one's blank ends the header.
class PfmHeader {
 public:
  PfmHeader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  double number(const char* what) {
    while (at_ < bytes_.size() && is_pfm_blank(bytes_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_pfm_blank(bytes_[at_]) && at_ - begin < 40) ++at_;
    const std::optional<double> value = parse_number(bytes_.substr(begin, at_ - begin));
    if (!value || at_ == bytes_.size() || !is_pfm_blank(bytes_[at_]))
      throw Error(ErrorKind::kInput, file_, std::string("its header has no ") + what, kNextPfm);
    ++at_;
    return *value;
  }
  int size(const char* what) {
    const double value = number(what);
    if (!(value >= 1 && value <= limits::kSizeSide && value == std::floor(value)))
      throw Error(ErrorKind::kInput, file_,
                  std::string("its header's ") + what + " is " + format_number(value), kNextPfm);
    return int(value);
  }
  void skip(std::size_t count) { at_ += count; }
  std::string_view rest() const { return bytes_.substr(at_); }

 private:
  std::string_view bytes_;
  const std::string& file_;
  std::size_t at_ = 0;
};

}  // namespace

ImageF decode_pfm(std::string_view bytes, const std::string& file) {
  const std::string_view magic = bytes.substr(0, 2);
  if ((magic != "PF" && magic != "Pf") || bytes.size() < 3 || !is_pfm_blank(bytes[2]))
    throw Error(ErrorKind::kInput, file, "it is not a PFM: it does not begin with PF or Pf",
                "give a float map in the PFM format");
  const int channels = magic == "PF" ? 3 : 1;
  PfmHeader header(bytes, file);
  header.skip(2);
  const int width = header.size("width"), height = header.size("height");
  const double scale = header.number("scale");
  if (scale == 0)
    throw Error(ErrorKind::kInput, file, "its header's scale is 0, which has no byte order", kNextPfm);

  const std::string_view pixels = header.rest();
  const std::size_t row_bytes = std::size_t(width) * std::size_t(channels) * 4;  // below 2^24
  const std::size_t expected = row_bytes * std::size_t(height);
  if (pixels.size() != expected)
    throw Error(ErrorKind::kInput, file,
                "its header claims " + std::to_string(width) + " x " + std::to_string(height) + " pixels, " +
                    std::to_string(expected) + " bytes, and " + std::to_string(pixels.size()) + " follow",
                kNextPfm);
  ImageF image(width, height, channels);
  for (int y = 0; y < height; ++y) {
    ByteReader from{pixels.substr(row_bytes * std::size_t(height - 1 - y), row_bytes)};
    float* to = image.row(y);
    for (int i = 0; i < width * channels; ++i) to[i] = real_of_bits(from.number<std::uint32_t>(scale > 0));
  }
  return image;
}

ImageF load_pfm(const std::filesystem::path& path) {
  return decode_pfm(read_file(path), path.string());
}

std::string encode_pfm(ViewF image) {
  require(!image.empty() && (image.channels == 1 || image.channels == 3),
          "encode_pfm: the picture is empty or has not 1 or 3 channels");
  std::string bytes = image.channels == 3 ? "PF\n" : "Pf\n";
  bytes += std::to_string(image.width) + " " + std::to_string(image.height) + "\n-1.0\n";
  bytes.reserve(bytes.size() +
                std::size_t(image.width) * std::size_t(image.height) * std::size_t(image.channels) * 4);
  for (int y = image.height - 1; y >= 0; --y)
    for (int i = 0; i < image.width * image.channels; ++i) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, image.row(y) + i, 4);
      for (int k = 0; k < 4; ++k) bytes += char(bits >> (8 * k) & 0xff);
    }
  return bytes;
}

void save_pfm(const std::filesystem::path& path, ViewF image) {
  write_file_atomically(path, encode_pfm(image));
}

}  // namespace procam::io
