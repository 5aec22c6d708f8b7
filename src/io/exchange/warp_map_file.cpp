// Warp maps <-> PFM, 16-bit PNG, EXR.
#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "extension.hpp"
#include "image/exr.hpp"
#include "image/image_decode.hpp"
#include "image/pfm_bytes.hpp"
#include "procam/io/exchange/warp_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/pfm.hpp"

namespace procam::io {
namespace {

const char* const kNextWarp = "export the warp again";

/// u, v, shown <-> s, t, shown: t runs upwards. Its own inverse.
ImageF with_v_turned(ViewF map) {
  ImageF turned(map.size(), 3);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const bool shown = map.at(x, y, 2) != 0;
      turned.at(x, y, 0) = map.at(x, y, 0);
      turned.at(x, y, 1) = shown ? 1 - map.at(x, y, 1) : 0;
      turned.at(x, y, 2) = map.at(x, y, 2);
    }
  return turned;
}

std::string encode_png16(ViewF st_map) {
  cv::Mat pixels(st_map.height, st_map.width, CV_16UC3);
  for (int y = 0; y < st_map.height; ++y) {
    auto* to = pixels.ptr<std::uint16_t>(y);
    for (int x = 0; x < st_map.width; ++x)
      for (const int c : {2, 1, 0}) *to++ = std::uint16_t(std::lround(65535.0 * double(st_map.at(x, y, c))));
  }
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", pixels, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3}))
    throw Error(ErrorKind::kIo, "PNG picture", "the encoder refused it",
                "report this with the picture's size");
  return std::string(bytes.begin(), bytes.end());
}

ImageF decode_png16(const std::filesystem::path& path) {
  const cv::Mat pixels = decode_image(read_file(path), path.string());
  if (pixels.type() != CV_16UC3)
    throw Error(
        ErrorKind::kUnsupported, path.string(),
        "its pixels are " + cv::typeToString(pixels.type()) + ", and an ST map has 3 channels of 16 bits",
        kNextWarp);
  ImageF st_map(pixels.cols, pixels.rows, 3);
  for (int y = 0; y < pixels.rows; ++y) {
    const auto* from = pixels.ptr<std::uint16_t>(y);
    for (int x = 0; x < pixels.cols; ++x)
      for (const int c : {2, 1, 0}) st_map.at(x, y, c) = float(*from++ / 65535.0);
  }
  return st_map;
}

/// A file's numbers as a warp map, with those of pixels that show nothing set to 0.
WarpMap checked(ImageF content, const std::filesystem::path& path) {
  if (content.channels() != 3)
    throw Error(ErrorKind::kInput, path.string(), "it has one channel, and a warp map has three", kNextWarp);
  for (int y = 0; y < content.height(); ++y)
    for (int x = 0; x < content.width(); ++x) {
      float& u = content.at(x, y, 0);
      float& v = content.at(x, y, 1);
      float& shown = content.at(x, y, 2);
      const bool inside = u >= 0 && u <= 1 && v >= 0 && v <= 1;
      if (!(shown == 0 || (shown > 0 && shown <= 1 && inside)))
        throw Error(ErrorKind::kInput, path.string(),
                    "at pixel " + std::to_string(x) + ", " + std::to_string(y) +
                        " it is no warp map: content coordinates lie between 0 and 1",
                    kNextWarp);
      if (shown == 0) u = v = 0;
    }
  return {std::move(content)};
}

}  // namespace

void save_warp_map(const std::filesystem::path& path, const WarpMap& map) {
  require(!map.content.empty() && map.content.channels() == 3,
          "save_warp_map: the map is empty or has not 3 channels");
  const std::string extension = lower_extension(path);
  if (extension == ".pfm")
    save_pfm(path, map.content);
  else if (extension == ".png")
    write_file_atomically(path, encode_png16(with_v_turned(map.content)));
  else if (extension == ".exr")
    write_file_atomically(path, encode_exr(with_v_turned(map.content)));
  else
    throw Error(ErrorKind::kUnsupported, path.string(), "warp maps are written as PFM, PNG or EXR",
                "give it a name that ends in .pfm, .png or .exr");
}

WarpMap load_warp_map(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".pfm") return checked(load_pfm(path), path);
  if (extension == ".png") return checked(with_v_turned(decode_png16(path)), path);
  throw Error(ErrorKind::kUnsupported, path.string(), "warp maps are read from PFM and 16-bit PNG",
              "give a .pfm or .png");
}

}  // namespace procam::io
