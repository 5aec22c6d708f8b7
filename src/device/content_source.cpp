#include "procam/device/content_source.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "camera_kinds.hpp"
#include "content_files.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"

namespace procam::device {

namespace {

namespace fs = std::filesystem;

class Still : public ContentSource {
 public:
  explicit Still(ImageU8 picture, Diagnostics remarks = {})
      : picture_(std::move(picture)), remarks_(std::move(remarks)) {}
  ContentFrame at(double) override { return {picture_.view(), 0}; }
  Diagnostics diagnostics() const override { return remarks_; }

 private:
  const ImageU8 picture_;
  const Diagnostics remarks_;
};

class Drawn : public ContentSource {
 public:
  Drawn(ImageSize size, int channels, DrawContent draw) : picture_(size, channels), draw_(std::move(draw)) {}
  ContentFrame at(double time_s) override {
    if (draw_(time_s, picture_.view())) ++revision_;
    return {picture_.view(), revision_};
  }

 private:
  ImageU8 picture_;
  DrawContent draw_;
  std::uint64_t revision_ = 0;
};

bool begins_with(const std::string& text, const char* beginning) {
  return text.rfind(beginning, 0) == 0;
}

bool exists(const std::string& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

/// "clip.mp4@30" -> "clip.mp4", 30; no rate is 0. A file whose own name ends so is that file.
std::pair<std::string, double> split_rate(const std::string& what) {
  const std::size_t at = what.rfind('@');
  if (at == std::string::npos || at == 0 || at + 1 == what.size() || exists(what)) return {what, 0};
  double rate = 0;
  const char *const begin = what.data() + at + 1, *const end = what.data() + what.size();
  const auto [stop, error] = std::from_chars(begin, end, rate);
  if (stop != end || error != std::errc()) return {what, 0};
  if (!(rate >= 1e-3 && rate <= 1e3))
    throw Error(ErrorKind::kInput, what, "its rate is not between 0.001 and 1000 pictures a second",
                "write e.g. @25");
  return {what.substr(0, at), rate};
}

std::unique_ptr<ContentSource> open_color(const std::string& what, const ContentOptions&) {
  const bool with_alpha = what.size() == 9;
  std::array<std::uint8_t, 4> rgba{};
  bool good = (with_alpha || what.size() == 7) && what[0] == '#';
  for (std::size_t k = 0; good && k < (with_alpha ? 4U : 3U); ++k) {
    const char* const digits = what.data() + 1 + 2 * k;
    const auto [stop, error] = std::from_chars(digits, digits + 2, rgba[k], 16);
    good = stop == digits + 2 && error == std::errc();
  }
  if (!good)
    throw Error(ErrorKind::kInput, "colour '" + what + "'", "it is not # and 6 or 8 digits of 0-9, a-f",
                "write #rrggbb, or #rrggbbaa with alpha, e.g. #ff8000");
  ImageU8 picture(1, 1, with_alpha ? 4 : 3);
  std::copy_n(rgba.begin(), picture.channels(), picture.data());
  return still_content(std::move(picture));
}

std::unique_ptr<ContentSource> open_image(const std::string& what, const ContentOptions&) {
  io::LoadedImage loaded = io::load_image(what);
  return std::make_unique<Still>(std::move(loaded.image), std::move(loaded.diagnostics));
}

std::unique_ptr<ContentSource> open_images(const std::string& what, const ContentOptions& options) {
  const auto [files, rate] = split_rate(what);
  return internal::open_sequence(files, rate, options);
}

std::unique_ptr<ContentSource> open_video(const std::string& what, const ContentOptions& options) {
  const auto [file, rate] = split_rate(what);
  return internal::open_video(file, rate, options);
}

bool looks_like_images(const std::string& what) {
  const std::string files = split_rate(what).first;
  std::error_code ignored;
  if (fs::exists(files, ignored)) return fs::is_directory(files, ignored);
  return fs::path(files).filename().string().find_first_of("%*?") != std::string::npos;
}

struct Kind {
  const char *name, *example;
  bool names_file;  ///< what follows the kind is a file, a folder or a pattern
  /// Asked in the table's order.
  bool (*claims)(const std::string& what);
  std::unique_ptr<ContentSource> (*open)(const std::string& what, const ContentOptions& options);
};

bool is_address(const std::string& what) {
  return begins_with(what, "rtsp://") || begins_with(what, "http://") || begins_with(what, "https://");
}

/// A show makes it itself, where there are heights.
std::unique_ptr<ContentSource> refuse_heights(const std::string& what, const ContentOptions&) {
  throw Error(ErrorKind::kInput, "content 'height:" + what + "'",
              "there is no live shape whose heights it could show",
              "use project-live with --surfaces depth-shape:SOURCE");
}

// One row a kind.
constexpr std::array<Kind, 9> kKinds{{
    {"color", "#ff8000", false,
     [](const std::string& what) { return begins_with(what, "#") && !exists(what); }, open_color},
    {"camera", "camera:0", false, is_address, internal::open_live},
    {"shm", "shm:game", false, [](const std::string&) { return false; }, internal::open_shared_content},
    {"ros2", "ros2:/camera/image_raw", false, [](const std::string&) { return false; },
     internal::open_ros2_content},
    {"log", "log:run.mcap+/camera/image_raw", true, [](const std::string&) { return false; },
     internal::open_log_content},
    {"height", "height:colours,contours=20mm", false, [](const std::string&) { return false; },
     refuse_heights},
    {"images", "shots/*.png@12.5", true, looks_like_images, open_images},
    {"image", "wall.png", true, [](const std::string& what) { return internal::is_picture(what); },
     open_image},
    {"video", "clip.mp4", true, [](const std::string&) { return true; }, open_video},
}};

/// The kind that is named before a colon; nullptr where the text begins with none.
const Kind* named_kind(const std::string& what) {
  const std::size_t colon = what.find(':');
  for (const Kind& kind : kKinds)
    if (colon != std::string::npos && what.compare(0, colon, kind.name) == 0 && colon + 1 < what.size())
      return &kind;
  return nullptr;
}

/// What follows the kind, if one is named.
std::size_t beginning(const std::string& what) {
  return named_kind(what) != nullptr ? what.find(':') + 1 : 0;
}

}  // namespace

std::unique_ptr<ContentSource> open_content(const std::string& what, const ContentOptions& options) {
  if (what.empty())
    throw Error(ErrorKind::kInput, "content", "it is empty", "name a picture, a video, a camera or a colour");
  if (const Kind* named = named_kind(what)) return named->open(what.substr(beginning(what)), options);
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& row) { return row.claims(what); });
  return kind->open(what, options);  // the last claims all
}

std::vector<ContentKind> content_kinds() {
  std::vector<ContentKind> kinds;
  for (const Kind& kind : kKinds) kinds.push_back({kind.name, kind.example});
  return kinds;
}

std::optional<std::string> content_file(const std::string& what) {
  const Kind* named = named_kind(what);
  const bool is_file = named != nullptr
                           ? named->names_file
                           : !what.empty() && what[0] != '#' && what.find("://") == std::string::npos;
  if (!is_file) return std::nullopt;
  return what.substr(beginning(what));
}

std::string with_content_file(const std::string& what, const std::string& file) {
  require(content_file(what).has_value(), "with_content_file: '" + what + "' names no file");
  return what.substr(0, beginning(what)) + file;
}

std::string content_beside(const std::filesystem::path& named_in, const std::string& what) {
  const std::optional<std::string> file = content_file(what);
  return file ? with_content_file(what, (named_in.parent_path() / *file).string()) : what;
}

std::vector<std::string> content_files(const std::filesystem::path& folder, std::size_t max_count) {
  std::vector<std::string> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (found.size() < max_count && (internal::is_picture(entry.path()) || internal::is_video(entry.path())))
      found.push_back(entry.path().filename().string());
  std::sort(found.begin(), found.end(), io::natural_less);
  return found;
}

std::unique_ptr<ContentSource> still_content(ImageU8 picture) {
  const int channels = picture.channels();
  require(!picture.empty() && (channels == 1 || channels == 3 || channels == 4),
          "still_content: the picture is empty or has not 1, 3 or 4 channels");
  return std::make_unique<Still>(std::move(picture));
}

std::unique_ptr<ContentSource> drawn_content(ImageSize size, int channels, DrawContent draw) {
  require(size.width > 0 && size.height > 0 && (channels == 1 || channels == 3 || channels == 4) && draw,
          "drawn_content: it needs a size, 1, 3 or 4 channels and a function");
  return std::make_unique<Drawn>(size, channels, std::move(draw));
}

}  // namespace procam::device
