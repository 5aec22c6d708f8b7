#pragma once
/// What the sinks share.
#include "procam/device/frame_sink.hpp"

namespace procam::device::internal {

/// Throws std::invalid_argument.
void require_frame(ViewU8 picture, ImageSize size);
/// Rows of R G B without gaps; grey becomes three equal channels.
void copy_rgb(ViewU8 picture, std::uint8_t* out);

std::unique_ptr<FrameSink> open_shared(const std::string& name, const SinkOptions& options);
std::unique_ptr<FrameSink> open_video(const std::string& file, const SinkOptions& options);

}  // namespace procam::device::internal
