#include "procam/device/depth_source.hpp"

#include <algorithm>
#include <charconv>

#include "camera_kinds.hpp"
#include "depth_kinds.hpp"
#include "depth_listener.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "watched_folder.hpp"

namespace procam::device {
namespace {

namespace fs = std::filesystem;
using internal::depth_error;

bool is_depth_file(const fs::path& file) {
  return internal::is_picture(file) || (file.extension() == ".pfm" && file.filename().string()[0] != '.');
}

class Played : public internal::DepthListener {
 public:
  Played(const std::string& folder, double rate) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), last; !error && entry != last; entry.increment(error))
      if (is_depth_file(entry->path())) files.push_back(entry->path());
    if (error || files.empty())
      throw depth_error("folder:" + folder, error ? error.message() : "no picture is in it",
                        "name the folder with its depth pictures (.png, .tif, .pfm)");
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
      return io::natural_less(a.filename().string(), b.filename().string());
    });
    listen([this, folder, files, rate] {
      const double begin = now_s();
      for (std::size_t i = 0; i < files.size(); ++i) {
        SeenDepth seen{io::load_depth_pixels(files[i]), 0};
        while (!ends_ && now_s() < begin + double(i) / rate)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (ends_) return;
        seen.time_s = now_s();
        queue_.push(std::move(seen));
      }
      throw depth_error("folder:" + folder, "its last picture was shown", "record more, or start again");
    });
  }
  ~Played() override { end(); }
};

std::unique_ptr<DepthSource> open_watched(const std::string& rest, const DepthOptions&) {
  constexpr double kPatience = 5;  // seconds for a file to become readable
  if (!fs::is_directory(rest))
    throw depth_error("watch:" + rest, "there is no such folder",
                      "name the folder into which the sensor's pictures come");
  return std::make_unique<internal::WatchedFolder<DepthSource, SeenDepth, io::load_depth_pixels>>(
      rest, kPatience, is_depth_file);
}

std::unique_ptr<DepthSource> open_played(const std::string& rest, const DepthOptions&) {
  const std::size_t at = rest.rfind('@');
  double rate = 30;
  if (at != std::string::npos) {
    const char *const begin = rest.data() + at + 1, *const end = rest.data() + rest.size();
    const auto [stop, error] = std::from_chars(begin, end, rate);
    if (stop != end || error != std::errc() || !(rate >= 1e-2 && rate <= 1e3))
      throw Error(ErrorKind::kInput, "depth:folder:" + rest, "its rate is no number between 0.01 and 1000",
                  "write e.g. depth:folder:recorded@30");
  }
  return std::make_unique<Played>(rest.substr(0, at), rate);
}

}  // namespace

const std::vector<DepthKind>& depth_kinds() {
  static const std::vector<DepthKind> kinds{{"watch", "watch:FOLDER", open_watched},
                                            {"folder", "folder:FOLDER[@HZ]", open_played},
                                            {"openni2", "openni2:[URI]", internal::open_openni2},
                                            {"ros2", "ros2:/TOPIC", internal::open_ros2_depth},
                                            {"log", "log:FILE+/TOPIC[@SPEED]", internal::open_log_depth}};
  return kinds;
}

std::unique_ptr<DepthSource> open_depth(const std::string& what, const DepthOptions& options) {
  const std::size_t colon = what.find(':');
  std::string forms;
  for (const DepthKind& kind : depth_kinds()) {
    if (colon != std::string::npos && what.compare(0, colon, kind.name) == 0)
      return kind.open(what.substr(colon + 1), options);
    forms += (forms.empty() ? "" : ", ") + std::string(kind.form);
  }
  throw Error(ErrorKind::kInput, "depth source '" + what + "'", "none is called so", "use one of " + forms);
}

}  // namespace procam::device
