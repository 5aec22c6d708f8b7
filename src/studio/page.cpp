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

constexpr int kPreviewWidth = 320;
constexpr std::size_t kDevices = 20;

/// The device of "STEM_3.ENDING": 2.
std::optional<std::size_t> device_of(const std::string& path, const std::string& stem,
                                     const std::string& ending) {
  for (std::size_t i = 0; i < kDevices; ++i)
    if (path == stem + "_" + std::to_string(i + 1) + ending) return i;
  return std::nullopt;
}

/// "/projector.png" is the first one's frame, "/projector_2.png" the second one's.
std::optional<std::size_t> projector_of(const std::string& path) {
  return path == "/projector.png" ? std::optional<std::size_t>(0) : device_of(path, "/projector", ".png");
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
      if (const auto frame = newest(frames_, *projector))
        return show::PageFile{"image/png", io::encode_png(*frame)};
    }
    if (const auto camera = device_of(path, "/camera", ".jpg"))
      if (const auto image = newest(previews_, *camera))
        return show::PageFile{"image/jpeg", show::to_jpeg(*image, kPreviewWidth)};
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

std::shared_ptr<const ImageU8> StudioPage::newest(const std::vector<std::shared_ptr<const ImageU8>>& of,
                                                  std::size_t device) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return device < of.size() ? of[device] : nullptr;
}

static void keep_newest(std::vector<std::shared_ptr<const ImageU8>>& of, std::size_t device,
                        std::shared_ptr<const ImageU8> image) {
  if (of.size() <= device) of.resize(device + 1);
  of[device] = std::move(image);
}

void StudioPage::publish_preview(std::size_t camera, std::shared_ptr<const ImageU8> image) {
  const std::lock_guard<std::mutex> lock(mutex_);
  keep_newest(previews_, camera, std::move(image));
}

void StudioPage::publish_frame(std::size_t projector, std::shared_ptr<const ImageU8> frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  keep_newest(frames_, projector, std::move(frame));
}

}  // namespace procam::studio
