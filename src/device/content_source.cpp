#include "procam/device/content_source.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "content_files.hpp"

namespace procam::device {

namespace {

namespace fs = std::filesystem;

class Still : public ContentSource {
 public:
  explicit Still(ImageU8 picture) : picture_(std::move(picture)) {}
  ContentFrame at(double) override { return {picture_.view(), 0}; }

 private:
  const ImageU8 picture_;
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

std::unique_ptr<ContentSource> open_image(const std::string& what, const ContentOptions& options) {
  require(options.read != nullptr, "open_content: ContentOptions::read is needed for pictures");
  return still_content(options.read(what));
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
  /// Asked in the table's order.
  bool (*claims)(const std::string& what);
  std::unique_ptr<ContentSource> (*open)(const std::string& what, const ContentOptions& options);
};

// One row a kind.
constexpr std::array<Kind, 6> kKinds{{
    {"color", "#ff8000", [](const std::string& what) { return begins_with(what, "#") && !exists(what); },
     open_color},
    {"camera", "camera:0",
     [](const std::string& what) {
       return begins_with(what, "rtsp://") || begins_with(what, "http://") || begins_with(what, "https://");
     },
     internal::open_live},
    {"shm", "shm:game", [](const std::string&) { return false; }, internal::open_shared_content},
    {"images", "shots/*.png@12.5", looks_like_images, open_images},
    {"image", "wall.png", [](const std::string& what) { return internal::is_picture(what); }, open_image},
    {"video", "clip.mp4", [](const std::string&) { return true; }, open_video},
}};

}  // namespace

std::unique_ptr<ContentSource> open_content(const std::string& what, const ContentOptions& options) {
  if (what.empty())
    throw Error(ErrorKind::kInput, "content", "it is empty", "name a picture, a video, a camera or a colour");
  const std::size_t colon = what.find(':');
  for (const Kind& kind : kKinds)
    if (colon != std::string::npos && what.compare(0, colon, kind.name) == 0 && colon + 1 < what.size())
      return kind.open(what.substr(colon + 1), options);
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& row) { return row.claims(what); });
  return kind->open(what, options);  // the last claims all
}

std::vector<ContentKind> content_kinds() {
  std::vector<ContentKind> kinds;
  for (const Kind& kind : kKinds) kinds.push_back({kind.name, kind.example});
  return kinds;
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
