#include "procam/device/frame_source.hpp"
#include "procam/io/image/images.hpp"
#include "watched_folder.hpp"

namespace procam::device {
namespace {

ImageU8 load_grey(const std::filesystem::path& file) {
  return io::green_channel(io::load_image(file).image);
}

}  // namespace

std::unique_ptr<FrameSource> watch_folder(const std::filesystem::path& folder, double patience_s) {
  return std::make_unique<internal::WatchedFolder<FrameSource, SeenFrame, load_grey>>(folder, patience_s);
}

}  // namespace procam::device
