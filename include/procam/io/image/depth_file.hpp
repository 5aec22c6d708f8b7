#pragma once
/// Depth images in files.
#include <cstdint>
#include <filesystem>

#include "procam/core/base/depth_pixels.hpp"
#include "procam/core/base/export.hpp"

namespace procam::io {

/// A 16-bit PNG or TIFF of one channel, as it is: the unit of its numbers is in no file. Throws Error(kIo)
/// when the file cannot be read, Error(kInput) when it is damaged, cut short or too large,
/// Error(kUnsupported) for pictures of other pixels.
PROCAM_EXPORT Image<std::uint16_t> load_depth(const std::filesystem::path& path);

/// The same, and floats in metres: a TIFF of 32-bit floats or a PFM, of one channel.
PROCAM_EXPORT DepthPixels load_depth_pixels(const std::filesystem::path& path);

/// 16-bit numbers that stand for something else than a multiple of a length.
enum class DepthPacking {
  kSunRgbd,  ///< SUN RGB-D: millimetres whose bits are rotated left by three
  kNyu       ///< NYU Depth's raw frames: z = 351.3 / (1092.5 - value) metres, 2047 where there is none
};

/// As load_depth(), in millimetres.
PROCAM_EXPORT Image<std::uint16_t> load_packed_depth(const std::filesystem::path& path, DepthPacking packing);

/// Written at once or not at all, as PNG. Throws Error(kUnsupported) unless the name ends in .png.
PROCAM_EXPORT void save_depth(const std::filesystem::path& path, ImageView<const std::uint16_t> depth);

}  // namespace procam::io
