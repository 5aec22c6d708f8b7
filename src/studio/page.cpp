#include "page.hpp"

#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "studio_html.hpp"

namespace procam::studio {
namespace {

constexpr int kImageWidth = 1280;
constexpr std::size_t kLongestPage = 32;

/// "/projector.png" is the first one's frame, "/projector_2.png" the second one's.
std::optional<std::size_t> projector_of(const std::string& path) {
  const std::string first = "/projector", last = ".png";
  if (path == first + last) return 0;
  for (std::size_t i = 1; i < 16; ++i)
    if (path == first + "_" + std::to_string(i + 1) + last) return i;
  return std::nullopt;
}

}  // namespace

std::optional<StudioCommand> to_studio_command(const std::string& text) {
  using nlohmann::json;
  const json document = json::parse(text, nullptr, false);
  if (!document.is_object()) return std::nullopt;
  StudioCommand command;
  for (const auto& [key, value] : document.items()) {
    constexpr std::size_t kLongest = 1024, kNumbers = 64;
    std::string* into = key == "do"     ? &command.verb
                        : key == "name" ? &command.name
                        : key == "text" ? &command.text
                        : key == "page" ? &command.page
                                        : nullptr;
    if (into != nullptr && value.is_string()) {
      *into = value.get<std::string>();
      if (into->size() > kLongest) return std::nullopt;
    } else if (key == "numbers" && value.is_array() && value.size() <= kNumbers) {
      for (const json& number : value) {
        if (!number.is_number() || !std::isfinite(number.get<double>())) return std::nullopt;
        command.numbers.push_back(number.get<double>());
      }
    } else if (key == "seen" && value.is_number()) {
      command.seen = value.get<double>();
    } else {
      return std::nullopt;
    }
  }
  if (command.verb.empty() || command.page.size() > kLongestPage) return std::nullopt;
  return command;
}

const char* StudioPage::html() {
  return kStudioHtml;
}

bool StudioPage::take(const std::string& message) {
  std::optional<StudioCommand> command = to_studio_command(message);
  if (!command) return false;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (commands_.size() >= limits::kPageCommands) return false;
  commands_.push_back(std::move(*command));
  return true;
}

void StudioPage::update_state(show::PageData& state) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state.number == state_number_) return;
  state = {state_, state_number_};
}

void StudioPage::update_image(show::PageData& image) {
  std::shared_ptr<const ImageU8> changed;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (image.number == image_number_ || !image_) return;
    changed = image_;
    image.number = image_number_;
  }
  image.bytes = show::to_jpeg(*changed, kImageWidth);
}

std::optional<show::PageFile> StudioPage::file(const std::string& path) {
  try {
    if (path == "/report") return show::PageFile{"text/html; charset=utf-8", io::read_file(report_)};
    if (path == "/board.pdf") return show::PageFile{"application/pdf", io::read_file(board_sheet_)};
    if (const auto projector = projector_of(path)) {
      std::shared_ptr<const ImageU8> frame;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (*projector < frames_.size()) frame = frames_[*projector];
      }
      if (frame) return show::PageFile{"image/png", io::encode_png(*frame)};
    }
  } catch (const std::exception&) {  // not written yet
  }
  return std::nullopt;
}

std::vector<StudioCommand> StudioPage::take_commands() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(commands_, {});
}

void StudioPage::publish(std::string state) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state == state_) return;
  state_ = std::move(state);
  ++state_number_;
}

void StudioPage::publish(std::shared_ptr<const ImageU8> image) {
  const std::lock_guard<std::mutex> lock(mutex_);
  image_ = std::move(image);
  ++image_number_;
}

void StudioPage::publish_frame(std::size_t projector, std::shared_ptr<const ImageU8> frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (frames_.size() <= projector) frames_.resize(projector + 1);
  frames_[projector] = std::move(frame);
}

}  // namespace procam::studio
