#pragma once
/// Private to session: folders of images that are called after their times.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace procam::session {

/// By time, seconds: "12.35.png", or nanoseconds above 1e14 ("1403636579763555584.png"). Files of other `extensions` (with
/// their dots) are skipped. Throws Error(kIo) for no folder, Error(kInput) for a name that is no
/// time, Error(kNotEnoughData) for no image.
std::vector<std::pair<double, std::filesystem::path>> timed_images(
    const std::filesystem::path& folder, const std::vector<std::string>& extensions);

}  // namespace procam::session
