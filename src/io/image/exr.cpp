#include "image/exr.hpp"

#include <cstdint>
#include <cstring>

namespace procam::io {
namespace {

/// Numbers lowest byte first, as the format has them.
class ExrBytes {
 public:
  std::string bytes;

  void number(std::uint64_t value, int count) {
    for (int k = 0; k < count; ++k) bytes += char(value >> (8 * k) & 0xff);
  }
  void int32(std::int64_t value) { number(std::uint64_t(value), 4); }
  void float32(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, 4);
    number(bits, 4);
  }
  void text(const char* characters) { bytes.append(characters, std::strlen(characters) + 1); }
  void attribute(const char* name, const char* type, std::int64_t size) {
    text(name);
    text(type);
    int32(size);
  }
  void box(const char* name, ViewF image) {
    attribute(name, "box2i", 16);
    for (const int corner : {0, 0, image.width - 1, image.height - 1}) int32(corner);
  }
};

}  // namespace

std::string encode_exr(ViewF image) {
  require(!image.empty() && image.channels == 3, "encode_exr: the picture is empty or has not 3 channels");
  ExrBytes file;
  file.number(20000630, 4);  // the magic number
  file.number(2, 4);         // version 2, scan lines
  file.attribute("channels", "chlist", 3 * 18 + 1);
  for (const char* name : {"B", "G", "R"}) {  // in the order of the alphabet
    file.text(name);
    file.int32(2);  // float
    file.int32(0);  // not perceptually linear
    file.int32(1);  // every pixel, across
    file.int32(1);  // and down
  }
  file.number(0, 1);
  file.attribute("compression", "compression", 1);
  file.number(0, 1);
  file.box("dataWindow", image);
  file.box("displayWindow", image);
  file.attribute("lineOrder", "lineOrder", 1);
  file.number(0, 1);  // top row first
  file.attribute("pixelAspectRatio", "float", 4);
  file.float32(1);
  file.attribute("screenWindowCenter", "v2f", 8);
  file.float32(0);
  file.float32(0);
  file.attribute("screenWindowWidth", "float", 4);
  file.float32(1);
  file.number(0, 1);

  const std::size_t line_data = std::size_t(image.width) * 12, line = 8 + line_data;
  const std::size_t first_line = file.bytes.size() + 8 * std::size_t(image.height);
  file.bytes.reserve(first_line + line * std::size_t(image.height));
  for (int y = 0; y < image.height; ++y) file.number(first_line + line * std::size_t(y), 8);
  for (int y = 0; y < image.height; ++y) {
    file.int32(y);
    file.int32(std::int64_t(line_data));
    for (const int channel : {2, 1, 0})
      for (int x = 0; x < image.width; ++x) file.float32(image.at(x, y, channel));
  }
  return std::move(file.bytes);
}

}  // namespace procam::io
