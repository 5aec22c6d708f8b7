#include "edit_log.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace procam::studio {
namespace {

constexpr std::size_t kHeldPages = 64, kThings = 4096;

constexpr std::array<std::pair<const char*, const char*>, 14> kSettings = {{
    {"display", "the display"},
    {"further_display", "the further projectors"},
    {"remove_display", "the further projectors"},
    {"camera", "the camera"},
    {"camera_size", "the camera's size"},
    {"exposure", "the exposure"},
    {"board", "the board"},
    {"paper", "the paper"},
    {"measured", "the measured length of the ruler"},
    {"views", "the number of poses"},
    {"accept", "the accepted error"},
    {"measure_by", "what measures the wall"},
    {"depth", "the depth camera"},
    {"marker", "the marker on the wall"},
}};

std::string corner_of(const std::string& surface, int corner) {
  return "corner " + std::to_string(corner + 1) + " of '" + surface + "'";
}
std::string masks_of(const std::string& surface) {
  return "the masks of '" + surface + "'";
}
std::string content_of(const std::string& surface) {
  return "the content of '" + surface + "'";
}

}  // namespace

std::vector<std::string> edited_things(const StudioCommand& command) {
  const std::string& verb = command.verb;
  if ((verb == "corner" || verb == "corner_in_frame") && !command.numbers.empty())
    return {corner_of(command.name, int(std::clamp(command.numbers[0], 0.0, 3.0)))};
  if (verb == "content") return {content_of(command.name)};
  if (verb == "mask" || verb == "unmask") return {masks_of(command.name)};
  if (verb == "remove" || verb == "surface") {
    std::vector<std::string> things = {content_of(command.name), masks_of(command.name)};
    for (int i = 0; i < 4; ++i) things.push_back(corner_of(command.name, i));
    return things;
  }
  for (const auto& [name, words] : kSettings)
    if (verb == name) return {words};
  return {};
}

std::optional<std::string> EditLog::conflict(const StudioCommand& command) const {
  if (!command.seen || command.page.empty()) return std::nullopt;
  for (const std::string& thing : edited_things(command)) {
    const auto known = changed_.find(thing);
    if (known == changed_.end()) continue;
    for (const auto& [page, revision] : known->second)
      if (page != command.page && double(revision) > *command.seen) return thing;
  }
  return std::nullopt;
}

void EditLog::record(const StudioCommand& command) {
  const std::vector<std::string> things = edited_things(command);
  if (things.empty()) return;
  ++revision_;
  if (changed_.size() > kThings) changed_.clear();
  for (const std::string& thing : things) changed_[thing][command.page] = revision_;
  const bool whole = command.verb == "remove" || command.verb == "surface";
  newest_ = {revision_, command.page, whole ? "'" + command.name + "'" : things.front()};
}

void EditLog::hold(const StudioCommand& command, const std::string& thing) {
  if (held_.size() >= kHeldPages) held_.erase(held_.begin());
  held_[command.page] = {command, thing};
}

std::optional<EditLog::Held> EditLog::take_held(const std::string& page) {
  const auto known = held_.find(page);
  if (known == held_.end()) return std::nullopt;
  Held held = std::move(known->second);
  held_.erase(known);
  return held;
}

}  // namespace procam::studio
