#include "frame_output.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"

namespace procam::show {
namespace {

/// frame_%04d.png -> frame_0017.png; nullopt for a name without a number.
std::optional<std::string> numbered(const std::string& pattern, int number) {
  const std::size_t percent = pattern.find('%');
  const std::size_t d =
      percent == std::string::npos ? percent : pattern.find_first_not_of("0123456789", percent + 1);
  if (d == std::string::npos || pattern[d] != 'd' || d > percent + 4) return std::nullopt;
  const std::string digits = pattern.substr(percent + 1, d - percent - 1);
  const int width = digits.empty() ? 1 : std::stoi(digits);
  std::string text = std::to_string(number);
  if (int(text.size()) < width) text.insert(0, std::size_t(width) - text.size(), '0');
  return pattern.substr(0, percent) + text + pattern.substr(d + 1);
}

}  // namespace

FrameOutput::FrameOutput(const FrameFilesOptions& options, ImageSize size)
    : pattern_(options.output), many_(options.seconds > 0) {
  std::string extension = std::filesystem::path(pattern_).extension().string();
  holds_light_ = extension == ".exr" || extension == ".EXR";
  if (holds_light_ && many_ && !numbered(pattern_, 0))
    throw Error(ErrorKind::kInput, pattern_, "an .exr holds one frame, and --duration makes several",
                "number them: frame_%04d.exr");
  if (holds_light_ && options.gamma > 0)
    throw Error(ErrorKind::kInput, "--gamma with an .exr", "it holds light, not a projector's values",
                "leave --gamma out");
  if (many_ && !numbered(pattern_, 0)) video_.emplace(options.output, size, options.fps);
}

void FrameOutput::add(const ImageF& light) {
  io::save_light(many_ ? *numbered(pattern_, count_++) : pattern_, light);
}
void FrameOutput::add(const ImageU8& frame) {
  if (video_)
    video_->add(frame);
  else
    io::save_image(many_ ? *numbered(pattern_, count_) : pattern_, frame);
  ++count_;
}
void FrameOutput::finish() {
  if (video_) video_->finish();
}

void save_weights(const std::string& file, const surface::BlendMap& map) {
  if (std::filesystem::path(file).extension() == ".pfm") return io::save_pfm(file, map.weight);
  ImageU8 weights(map.weight.size());
  for (int y = 0; y < weights.height(); ++y)
    for (int x = 0; x < weights.width(); ++x)
      weights.at(x, y) = std::uint8_t(std::lround(255 * map.weight.at(x, y)));
  io::save_image(file, weights);
}

void check_extra_files(const FrameFilesOptions& options) {
  const auto check = [](const std::string& file, std::initializer_list<const char*> kinds) {
    if (file.empty()) return;
    std::string kind = std::filesystem::path(file).extension().string(), names;
    std::transform(kind.begin(), kind.end(), kind.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    for (const char* const known : kinds) {
      if (kind == known) return io::require_writable(file);
      names += (names.empty() ? "" : " or ") + std::string(known);
    }
    throw Error(ErrorKind::kInput, file, "pictures of this kind are not written here",
                "give it a name that ends in " + names);
  };
  check(options.preview, {".png"});
  check(options.weights, {".png", ".pfm"});
}

}  // namespace procam::show
