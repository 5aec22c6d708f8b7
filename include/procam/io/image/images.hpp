#pragma once
/// Pictures in files <-> 8-bit pixels in memory, channels in the order grey | R G B | R G B A.
///
/// Reads PNG, JPEG, BMP and TIFF by their contents, not by name. A picture whose file is cut short
/// or damaged is refused: a half-decoded frame would look like a dark one. (PNG is checked to the last bit;
/// damage inside the coded data of a JPEG does not show in its pixels.) Pixels are those of the sensor:
/// an orientation note in the file is not applied.
#include <filesystem>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::io {

struct LoadedImage {
  ImageU8 image;
  Diagnostics diagnostics;  ///< "reduced_to_8_bit" when the file has 16 bits a channel
};

/// 16-bit pictures are reduced by v / 257, rounded. Throws Error(kIo) when the file cannot be read,
/// Error(kInput) when it is damaged, cut short or too large, Error(kUnsupported) for another format or depth.
PROCAM_EXPORT LoadedImage load_image(const std::filesystem::path& path);

/// The same of a picture in memory; `name` is how errors call it.
PROCAM_EXPORT LoadedImage read_image(const std::string& bytes, const std::string& name);

/// Width and height as the file's header states them, without decoding; nullopt where it is no such image or
/// cannot be read (load_image() says why).
PROCAM_EXPORT std::optional<ImageSize> image_size(const std::filesystem::path& path);
/// The same of a picture in memory, however large; nullopt where it is no image.
PROCAM_EXPORT std::optional<ImageSize> image_size_in(const std::string& bytes);

/// Grey from R G B (A ignored): ITU-R BT.601 luma, 0.299 R + 0.587 G + 0.114 B, rounded. One channel is
/// copied.
PROCAM_EXPORT ImageU8 to_gray(ViewU8 image);

/// G of R G B (A ignored): the grey image that is measured where a camera's image has colour. One channel is copied.
/// A colour sensor has a green filter on every second pixel and a red or a blue one on every fourth, so interpolated
/// red and blue displace edges by their place among the pixels; and a lens with lateral colour has another
/// magnification in each. Luma mixes all three.
PROCAM_EXPORT ImageU8 green_channel(ViewU8 image);

/// The picture as the bytes of a PNG file; the same pixels give the same bytes.
PROCAM_EXPORT std::string encode_png(ViewU8 image);

/// The picture as the bytes of a JPEG file, for reports; quality 1 to 100. Grey or R G B.
PROCAM_EXPORT std::string encode_jpeg(ViewU8 image, int quality = 80);

/// Writes a PNG, at once or not at all. Throws Error(kUnsupported) unless the name ends in .png.
PROCAM_EXPORT void save_image(const std::filesystem::path& path, ViewU8 image);

/// Writes R G B light as an OpenEXR picture of 32-bit floats, uncompressed, linear, at once or not at all.
/// Throws Error(kUnsupported) unless the name ends in .exr.
PROCAM_EXPORT void save_light(const std::filesystem::path& path, ViewF light);

}  // namespace procam::io
