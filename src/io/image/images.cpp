#include "procam/io/image/images.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

#include "image/exr.hpp"
#include "image/image_check.hpp"
#include "image/image_decode.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"

namespace procam::io {
namespace {

namespace fs = std::filesystem;

/// OpenCV's codecs log to stderr; a library does not. The last of those that exist at a time restores the
/// level: images are read by several threads.
class QuietOpencv {
 public:
  QuietOpencv() {
    const std::lock_guard<std::mutex> lock(mutex());
    if (count()++ == 0) before() = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  }
  QuietOpencv(const QuietOpencv&) = delete;
  QuietOpencv& operator=(const QuietOpencv&) = delete;
  ~QuietOpencv() {
    const std::lock_guard<std::mutex> lock(mutex());
    if (--count() == 0) cv::utils::logging::setLogLevel(before());
  }

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  static int& count() {
    static int existing = 0;
    return existing;
  }
  static cv::utils::logging::LogLevel& before() {
    static cv::utils::logging::LogLevel level{};
    return level;
  }
};

/// Blue and red change places; three channels or four. Own inverse.
void swap_blue_and_red(std::uint8_t* row, int width, int channels) {
  for (int x = 0; x < width; ++x)
    std::swap(row[std::ptrdiff_t(x) * channels], row[std::ptrdiff_t(x) * channels + 2]);
}

/// Whether less than half of the pixels of a grey image equal their left neighbour (of every eighth row).
bool is_noisy(ViewU8 image) {
  if (image.channels != 1) return false;
  std::int64_t pairs = 0, equal = 0;
  for (int y = 0; y < image.height; y += 8) {
    const std::uint8_t* row = image.row(y);
    for (int x = 1; x < image.width; ++x) equal += row[x] == row[x - 1];
    pairs += image.width - 1;
  }
  return 2 * equal < pairs;
}

/// A copy in the order of OpenCV's encoders.
cv::Mat mat_to_encode(ViewU8 image) {
  cv::Mat mat(image.height, image.width, CV_8UC(image.channels));
  for (int y = 0; y < image.height; ++y) {
    std::copy_n(image.row(y), std::ptrdiff_t(image.width) * image.channels, mat.ptr<std::uint8_t>(y));
    if (image.channels >= 3) swap_blue_and_red(mat.ptr<std::uint8_t>(y), image.width, image.channels);
  }
  return mat;
}

}  // namespace

cv::Mat decode_image(const std::string& bytes, const std::string& file) {
  const char* const next = "capture or copy the picture again";
  const ImageCheck check = check_image(bytes);
  if (check.format == ImageFormat::kUnknown)
    throw Error(ErrorKind::kUnsupported, file, "it is not a PNG, JPEG, BMP or TIFF picture",
                "convert it to PNG");
  if (const std::string why = too_large(check); !why.empty())
    throw Error(ErrorKind::kInput, file, why,
                "give a picture of at most " + std::to_string(limits::kImagePixels) + " pixels and " +
                    std::to_string(limits::kImageBytes >> 20) + " MiB of them");
  if (!check.damage.empty()) throw Error(ErrorKind::kInput, file, check.damage, next);
  if (check.width < 1 || check.height < 1)
    throw Error(
        ErrorKind::kInput, file,
        "its header claims " + std::to_string(check.width) + " x " + std::to_string(check.height) + " pixels",
        next);
  try {
    const QuietOpencv quiet;
    const cv::Mat encoded(1, int(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    cv::Mat decoded = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    if (!decoded.empty()) return decoded;
  } catch (const cv::Exception& exception) {
    throw Error(ErrorKind::kInput, file, "the picture cannot be decoded (" + exception.err + ")", next);
  }
  throw Error(ErrorKind::kInput, file, "the picture cannot be decoded: the file is damaged", next);
}

std::optional<ImageSize> image_size(const fs::path& path) {
  try {
    // A PNG's size is in its first 24 bytes, a JPEG's behind its thumbnail and notes, a TIFF's anywhere.
    procam::internal::require_regular_file(path);
    std::string head(std::size_t(64) << 10, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(head.data(), 32);
    head.resize(std::size_t(file.gcount()));
    ImageCheck check = check_image(head);
    if (check.format == ImageFormat::kPng && head.size() >= 24) {
      const auto side = [&](std::size_t at) {
        long long value = 0;
        for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(head[i]);
        return value;
      };
      check.width = side(16);
      check.height = side(20);
    } else if (check.format == ImageFormat::kJpeg || check.format == ImageFormat::kTiff) {
      const std::size_t begin = head.size();
      head.resize(std::size_t(64) << 10);
      file.read(&head[begin], std::streamsize(head.size() - begin));
      head.resize(begin + std::size_t(file.gcount()));
      check = check_image(head);
      if (check.width < 1 || check.height < 1) check = check_image(read_file(path));
    }
    if (check.width < 1 || check.height < 1 || !too_large(check).empty()) return std::nullopt;
    return ImageSize{int(check.width), int(check.height)};
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<ImageSize> image_size_in(const std::string& bytes) {
  const ImageCheck check = check_image(bytes);
  if (check.width < 1 || check.height < 1) return std::nullopt;
  constexpr long long kMaxSide = std::numeric_limits<int>::max();
  return ImageSize{int(std::min(check.width, kMaxSide)), int(std::min(check.height, kMaxSide))};
}

LoadedImage load_image(const fs::path& path) {
  return read_image(read_file(path), path.string());
}

LoadedImage read_image(const std::string& bytes, const std::string& name) {
  const cv::Mat decoded = decode_image(bytes, name);
  const int channels = decoded.channels(), depth = decoded.depth();
  if ((depth != CV_8U && depth != CV_16U) || (channels != 1 && channels != 3 && channels != 4))
    throw Error(
        ErrorKind::kUnsupported, name,
        "its pixels are " + cv::typeToString(decoded.type()) + ", not 8 or 16 bits in 1, 3 or 4 channels",
        "convert it to an 8-bit PNG");
  LoadedImage out;
  out.image = ImageU8(decoded.cols, decoded.rows, channels);
  for (int y = 0; y < decoded.rows; ++y) {
    std::uint8_t* const row = out.image.row(y);
    const std::ptrdiff_t count = std::ptrdiff_t(decoded.cols) * channels;
    if (depth == CV_8U) {
      std::copy_n(decoded.ptr<std::uint8_t>(y), count, row);
    } else {
      const auto* wide = decoded.ptr<std::uint16_t>(y);
      for (std::ptrdiff_t i = 0; i < count; ++i) row[i] = std::uint8_t((wide[i] + 128) / 257);
    }
    if (channels >= 3) swap_blue_and_red(row, decoded.cols, channels);
  }
  if (depth == CV_16U)
    out.diagnostics.note("reduced_to_8_bit", name +
                                                 ": 16 bits a channel were reduced to 8; pictures of a "
                                                 "10- or 12-bit camera should fill the 16 bits");
  return out;
}

ImageU8 to_gray(ViewU8 image) {
  require(image.channels == 1 || image.channels == 3 || image.channels == 4,
          "to_gray: the image has " + std::to_string(image.channels) + " channels, not 1, 3 or 4");
  ImageU8 gray(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* in = image.row(y);
    std::uint8_t* out = gray.row(y);
    if (image.channels == 1) {
      std::copy_n(in, image.width, out);
      continue;
    }
    // The weights in 16 bits; they add up to 65536, so white stays white.
    for (int x = 0; x < image.width; ++x, in += image.channels)
      out[x] = std::uint8_t((19595u * in[0] + 38470u * in[1] + 7471u * in[2] + 32768u) >> 16);
  }
  return gray;
}

ImageU8 green_channel(ViewU8 image) {
  require(image.channels == 1 || image.channels == 3 || image.channels == 4,
          "green_channel: the image has " + std::to_string(image.channels) + " channels, not 1, 3 or 4");
  ImageU8 green(image.width, image.height);
  const int channel = image.channels == 1 ? 0 : 1;
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* in = image.row(y) + channel;
    std::uint8_t* out = green.row(y);
    for (int x = 0; x < image.width; ++x, in += image.channels) out[x] = *in;
  }
  return green;
}

std::string encode_jpeg(ViewU8 image, int quality) {
  require(!image.empty() && (image.channels == 1 || image.channels == 3),
          "encode_jpeg: the image is empty or has not 1 or 3 channels");
  require(quality >= 1 && quality <= 100, "encode_jpeg: the quality is not within 1 to 100");
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".jpg", mat_to_encode(image), bytes, {cv::IMWRITE_JPEG_QUALITY, quality}))
    throw Error(ErrorKind::kIo, "JPEG picture", "the encoder refused it",
                "report this with the picture's size");
  return std::string(bytes.begin(), bytes.end());
}

std::string encode_png(ViewU8 image) {
  require(!image.empty() && (image.channels == 1 || image.channels == 3 || image.channels == 4),
          "encode_png: the image is empty or has not 1, 3 or 4 channels");
  const cv::Mat mat = mat_to_encode(image);
  std::vector<std::uint8_t> bytes;
  // Stated, so that another version's default does not change files: the level is a middle way between time
  // and size. A camera's grey image has noise in each pixel, and nothing to refer back to: without a search for it, and
  // without a level, which makes OpenCV try five filters on each row, the file is a sixth smaller and takes a quarter of the time.
  const std::vector<int> settings =
      is_noisy(image) ? std::vector<int>{cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY}
                      : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 3, cv::IMWRITE_PNG_STRATEGY,
                                         cv::IMWRITE_PNG_STRATEGY_DEFAULT};
  if (!cv::imencode(".png", mat, bytes, settings))
    throw Error(ErrorKind::kIo, "PNG picture", "the encoder refused it",
                "report this with the picture's size");
  return std::string(bytes.begin(), bytes.end());
}

void save_image(const fs::path& path, ViewU8 image) {
  std::string extension = path.extension().string();
  if (extension != ".png" && extension != ".PNG")
    throw Error(ErrorKind::kUnsupported, path.string(), "pictures are written as PNG",
                "give it a name that ends in .png");
  write_file_atomically(path, encode_png(image));
}

void save_light(const fs::path& path, ViewF light) {
  const std::string extension = path.extension().string();
  if (extension != ".exr" && extension != ".EXR")
    throw Error(ErrorKind::kUnsupported, path.string(), "light is written as OpenEXR",
                "give it a name that ends in .exr");
  write_file_atomically(path, encode_exr(light));
}

}  // namespace procam::io
