#include "procam/device/frame_source.hpp"
#include "watched_folder.hpp"

namespace procam::device {

std::unique_ptr<FrameSource> watch_folder(const std::filesystem::path& folder, ReadImage read,
                                          double patience_s) {
  return std::make_unique<internal::WatchedFolder<FrameSource, SeenFrame, ReadImage>>(folder, std::move(read),
                                                                                      patience_s);
}

}  // namespace procam::device
