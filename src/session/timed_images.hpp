#pragma once
/// Folders of images that are called after their times, as EuRoC and TUM name theirs.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace procam::session {

struct TimedImage {
  double time = 0;  ///< seconds
  std::filesystem::path file;
};

/// Of a name in seconds ("12.35.png") or, above 1e14, in nanoseconds ("1403636579763555584.png"); nullopt for another name.
std::optional<double> time_of(const std::filesystem::path& file);

/// The files with one of the extensions, by time. Throws Error(kIo) where there is no folder, Error(kInput) for a name that is no
/// time.
std::vector<TimedImage> timed_images(const std::filesystem::path& folder,
                                     const std::vector<std::string>& extensions = {".png", ".jpg", ".jpeg",
                                                                                   ".pgm"});

}  // namespace procam::session
