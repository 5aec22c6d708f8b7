#pragma once
/// What an image file says of itself, and whether the file is whole, before a decoder sees it: decoders fill
/// what is missing with grey or black and call it a success.
#include <cstdint>
#include <string>
#include <string_view>

namespace procam::io {

enum class ImageFormat { kPng, kJpeg, kBmp, kTiff, kUnknown };

struct ImageCheck {
  ImageFormat format = ImageFormat::kUnknown;
  long long width = 0, height = 0;  ///< as the header declares
  long long bytes_a_pixel = 1;      ///< once decoded, at most
  std::string damage;               ///< what is wrong with the file; empty when nothing is
};

/// Why nobody should decode it: too many pixels, or bytes once decoded; empty when all is well.
std::string too_large(const ImageCheck& check);

/// PNG: every chunk whole with the right checksum, up to IEND, and enough compressed bytes for the pixels. JPEG: every segment whole, and the end marker
/// after the last scan. BMP: as many bytes as the header implies. TIFF: the first picture's strips or tiles
/// inside the file.
ImageCheck check_image(std::string_view bytes);

/// CRC-32 of the PNG specification, annex D.
std::uint32_t crc32(std::string_view bytes);

}  // namespace procam::io
