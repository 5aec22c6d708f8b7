#include "procam/io/image/depth_file.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "image/image_decode.hpp"
#include "image/pfm_bytes.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/pfm.hpp"

namespace procam::io {

namespace {

template <typename Pixel>
Image<Pixel> copy_of(const cv::Mat& decoded) {
  Image<Pixel> depth(decoded.cols, decoded.rows);
  for (int y = 0; y < decoded.rows; ++y) std::copy_n(decoded.ptr<Pixel>(y), decoded.cols, depth.row(y));
  return depth;
}

Error no_depth(const std::filesystem::path& path, const std::string& pixels, const std::string& wanted) {
  return Error(ErrorKind::kUnsupported, path.string(), "its pixels are " + pixels + ", not " + wanted,
               "give the depth image as the camera wrote it, not a picture of it");
}

}  // namespace

Image<std::uint16_t> load_depth(const std::filesystem::path& path) {
  const cv::Mat decoded = decode_image(read_file(path), path.string());
  if (decoded.type() != CV_16UC1)
    throw no_depth(path, cv::typeToString(decoded.type()), "16 bits in one channel");
  return copy_of<std::uint16_t>(decoded);
}

Image<std::uint16_t> load_packed_depth(const std::filesystem::path& path, DepthPacking packing) {
  DepthPixels pixels = load_depth_pixels(path);
  auto* const numbers = std::get_if<Image<std::uint16_t>>(&pixels);
  if (numbers == nullptr)
    throw Error(ErrorKind::kInput, path.string(), "its pixels are floats, in which nothing is packed",
                "read it without a packing: floats are metres");
  Image<std::uint16_t> depth = std::move(*numbers);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      std::uint16_t& value = depth.at(x, y);
      if (packing == DepthPacking::kSunRgbd) {
        value = std::uint16_t(value >> 3 | value << 13);
      } else {
        const double metres = value < 1092 ? 351.3 / (1092.5 - value) : 0;
        value = metres < 20 ? std::uint16_t(std::lround(1000 * metres)) : std::uint16_t(0);
      }
    }
  return depth;
}

DepthPixels load_depth_pixels(const std::filesystem::path& path) {
  constexpr const char* kWanted = "16 bits or floats in one channel";
  const std::string bytes = read_file(path);
  if (bytes.compare(0, 2, "Pf") == 0) return decode_pfm(bytes, path.string());
  if (bytes.compare(0, 2, "PF") == 0) throw no_depth(path, "floats in three channels", kWanted);
  const cv::Mat decoded = decode_image(bytes, path.string());
  if (decoded.type() == CV_32FC1) return copy_of<float>(decoded);
  if (decoded.type() == CV_16UC1) return copy_of<std::uint16_t>(decoded);
  throw no_depth(path, cv::typeToString(decoded.type()), kWanted);
}

void save_depth(const std::filesystem::path& path, ImageView<const std::uint16_t> depth) {
  require(!depth.empty() && depth.channels == 1, "save_depth: a depth image has pixels and one channel");
  if (path.extension() != ".png")
    throw Error(ErrorKind::kUnsupported, path.string(), "depth images are written as PNG",
                "give it a name that ends in .png");
  cv::Mat mat(depth.height, depth.width, CV_16UC1);
  for (int y = 0; y < depth.height; ++y) std::copy_n(depth.row(y), depth.width, mat.ptr<std::uint16_t>(y));
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", mat, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3}))
    throw Error(ErrorKind::kIo, path.string(), "the encoder refused it", "report this with the image's size");
  write_file_atomically(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace procam::io
