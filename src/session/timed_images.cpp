#include "timed_images.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/core/base/words.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

std::optional<double> time_of(const fs::path& file) {
  const std::string name = file.stem().string();
  double time = 0;
  const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), time);
  if (failed != std::errc() || end != name.data() + name.size() || !std::isfinite(time)) return std::nullopt;
  constexpr double kNanoseconds = 1e14;
  return std::abs(time) > kNanoseconds ? 1e-9 * time : time;
}

}  // namespace

std::vector<std::pair<double, fs::path>> timed_images(const fs::path& folder,
                                                      const std::vector<std::string>& extensions) {
  if (!fs::is_directory(folder))
    throw Error(ErrorKind::kIo, folder.string(), "it is no folder", "give a folder of images");
  std::vector<std::pair<double, fs::path>> images;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end()) continue;
    const auto time = time_of(entry.path());
    if (!time)
      throw Error(ErrorKind::kInput, entry.path().string(), "its name is no time",
                  "name the images after their times: seconds (12.35.png) or nanoseconds");
    images.emplace_back(*time, entry.path());
  }
  if (images.empty())
    throw Error(ErrorKind::kNotEnoughData, folder.string(),
                "it holds no image (" + and_list(extensions) + ")",
                "give the folder with the images of the drive");
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace procam::session
