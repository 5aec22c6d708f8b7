#include "procam/io/depth_file.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "image_decode.hpp"
#include "procam/io/files.hpp"

namespace procam::io {

Image<std::uint16_t> load_depth(const std::filesystem::path& path) {
  const cv::Mat decoded = decode_image(read_file(path), path.string());
  if (decoded.type() != CV_16UC1)
    throw Error(ErrorKind::kUnsupported, path.string(),
                "its pixels are " + cv::typeToString(decoded.type()) + ", not 16 bits in one channel",
                "give the depth image as the camera wrote it, not a picture of it");
  Image<std::uint16_t> depth(decoded.cols, decoded.rows);
  for (int y = 0; y < decoded.rows; ++y)
    std::copy_n(decoded.ptr<std::uint16_t>(y), decoded.cols, depth.row(y));
  return depth;
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
