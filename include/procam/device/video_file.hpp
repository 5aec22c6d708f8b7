#pragma once
/// A video file that is written picture by picture.
#include <filesystem>
#include <memory>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::device {

/// The file appears under its name when finish() is called, whole; without it nothing is left behind.
///
/// | .mkv | FFV1: every value as it was given; large |
/// | .mp4 | MPEG-4: plays everywhere; values change by some steps, colours have half the resolution |
/// | .avi | Motion JPEG: as .mp4, every picture by itself |
class PROCAM_EXPORT VideoFile {
 public:
  /// Throws Error(kUnsupported) for another extension, for .mp4 with an odd side, and where OpenCV has no
  /// such encoder; Error(kIo) when the file cannot be written. std::invalid_argument for an empty size or a
  /// rate outside 0.001 .. 1000 pictures a second.
  VideoFile(const std::filesystem::path& path, ImageSize size, double rate_hz);
  ~VideoFile();
  VideoFile(VideoFile&&) noexcept;
  VideoFile& operator=(VideoFile&&) noexcept;

  /// RGB, of the file's size; else std::invalid_argument.
  void add(ViewU8 picture);
  /// Throws Error(kIo).
  void finish();

 private:
  class Writer;
  std::unique_ptr<Writer> writer_;
};

}  // namespace procam::device
