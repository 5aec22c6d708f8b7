#pragma once
#include <optional>
#include <string>

#include "procam/device/video_file.hpp"
#include "procam/show/frame_files.hpp"

namespace procam::show {

/// Where frames go, one after the other.
class FrameOutput {
 public:
  /// Throws Error(kInput) for a name that cannot hold the frames.
  FrameOutput(const FrameFilesOptions& options, ImageSize size);
  /// Frames of floats, linear.
  bool holds_light() const { return holds_light_; }
  void add(const ImageF& light);
  void add(const ImageU8& frame);
  void finish();

 private:
  std::string pattern_;
  bool many_, holds_light_ = false;
  int count_ = 0;
  std::optional<device::VideoFile> video_;
};

void save_weights(const std::string& file, const surface::BlendMap& map);

/// Before long work: throws Error(kInput) for names of other kinds of file, Error(kIo) where none can be written.
void check_extra_files(const FrameFilesOptions& options);

}  // namespace procam::show
