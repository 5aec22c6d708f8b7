#pragma once
/// The kinds of content that come from files and cameras.
#include "procam/device/content_source.hpp"

namespace procam::device::internal {

/// `rate_hz` 0: as the header of content_source.hpp says.
std::unique_ptr<ContentSource> open_sequence(const std::string& what, double rate_hz,
                                             const ContentOptions& options);
std::unique_ptr<ContentSource> open_video(const std::string& file, double rate_hz,
                                          const ContentOptions& options);
std::unique_ptr<ContentSource> open_live(const std::string& camera, const ContentOptions& options);

std::unique_ptr<ContentSource> open_shared_content(const std::string& name, const ContentOptions& options);

/// By its extension, of those that a reader of pictures can be expected to know.
bool is_picture(const std::filesystem::path& file);
/// Likewise of the common kinds of video.
bool is_video(const std::filesystem::path& file);
}  // namespace procam::device::internal
