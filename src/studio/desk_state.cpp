/// The state that the page draws: one JSON object.
#include <cmath>
#include <nlohmann/json.hpp>

#include "desk.hpp"
#include "desk_devices.hpp"
#include "procam/device/content_source.hpp"
#include "procam/io/text.hpp"

namespace procam::studio {
namespace {

using nlohmann::json;

json finite(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * 1000) / 1000;
}
json optional(const std::optional<double>& value) {
  return value ? finite(*value) : json(nullptr);
}
json point(const Vec2& p) {
  return {finite(p.x()), finite(p.y())};
}
template <typename Points>
json points(const Points& all) {
  json list = json::array();
  for (const Vec2& p : all) list.push_back(point(p));
  return list;
}

json displays(bool simulated) {
  if (simulated) return json::array({{{"text", "simulated"}, {"words", "simulated projector, 1024x768"}}});
  json list = json::array();
  try {
    for (const device::Display& display : device::displays())
      list.push_back(
          {{"text", std::to_string(display.number)},
           {"words",
            std::to_string(display.number) + ": " + display.name + ", " + io::format_size(display.size) +
                (display.is_primary ? ", primary" : "") +
                (display.size == display.largest ? "" : "; it offers " + io::format_size(display.largest))}});
  } catch (const Error&) {  // no graphics: an empty list
  }
  return list;
}

/// The devices of this machine, and what was typed: a topic, an address, a folder.
json cameras(bool simulated, const std::string& chosen) {
  if (simulated) return json::array({{{"text", "simulated"}, {"words", "simulated camera"}}});
  json list = json::array();
  constexpr int kDevices = 16;
  for (int i = 0; i < kDevices; ++i) {
    std::error_code ignored;
    const std::string path = "/dev/video" + std::to_string(i);
    if (std::filesystem::exists(path, ignored)) list.push_back({{"text", path}, {"words", path}});
  }
  const std::string device = "/dev/video";  // one that is gone is shown as not found
  if (!chosen.empty() && chosen.compare(0, device.size(), device) != 0)
    list.push_back({{"text", chosen}, {"words", chosen}});
  return list;
}

}  // namespace

std::string Desk::state_text() const {
  const Choices& choices = project_.choices;
  json steps = json::array();
  for (int i = 0; i < kSteps; ++i)
    steps.push_back({{"id", to_string(Step(i))}, {"done", project_.is_done(Step(i))}});
  constexpr const char* kJobs[] = {"", "identify", "check", "capture", "scan", "drift", "show"};
  const auto [calibrating, percent] = calibration_.progress();
  json state = {
      {"project", project_.folder().string()},
      {"simulated", stage_ != nullptr},
      {"step", to_string(choices.step)},
      {"steps", std::move(steps)},
      {"job", calibration_.is_running() ? "calibrate" : kJobs[int(job_)]},
      {"doing", calibration_.is_running() ? calibrating : doing_},
      {"done", calibration_.is_running() ? percent : done_},
      {"total", calibration_.is_running() ? 100 : total_},
      {"messages", messages_},
  };
  state["revision"] = edits_.revision();
  state["edit"] = {{"revision", edits_.newest().revision},
                   {"page", edits_.newest().page},
                   {"thing", edits_.newest().thing}};
  json held = json::object();
  for (const auto& [page, one] : edits_.held()) held[page] = one.thing;
  state["held"] = std::move(held);
  state["error"] = error_
                       ? json{{"what", error_->subject()}, {"why", error_->why()}, {"next", error_->next()}}
                       : json(nullptr);
  state["display"] = {{"chosen", choices.display}, {"open", bool(sink_)}};
  if (rig_) {
    const ImageSize frame = rig_->projector().projector.size();
    state["frame"] = {frame.width, frame.height};
  }
  state["outlines"] = outlines_shown_;
  if (choices.step == Step::kDisplay) state["display"]["list"] = displays(stage_ != nullptr);
  state["camera"] = {{"chosen", choices.camera},
                     {"open", camera_ != nullptr},
                     {"size", {image_size_.width, image_size_.height}},
                     {"wanted_size", choices.camera_size},
                     {"exposure", choices.exposure},
                     {"images_per_s", finite(images_per_s_)},
                     {"saturated", finite(100 * saturated_share_)},
                     {"brightness", finite(brightness_)},
                     {"sharpness", finite(sharpness_)}};
  if (choices.step == Step::kCamera) state["camera"]["list"] = cameras(stage_ != nullptr, choices.camera);
  state["lit"] = lit_ ? json::array({point(lit_->low), point(lit_->high)}) : json(nullptr);
  state["board"] = {{"text", board_ ? io::format_board(*board_) : ""},
                    {"paper", choices.paper},
                    {"measured", choices.measured}};
  json capture = {{"views", project_.views_captured()},
                  {"wanted", choices.views},
                  {"camera_coverage", finite(100 * camera_coverage_)},
                  {"projector_coverage", finite(100 * projector_coverage_)},
                  {"corners", json::array()},
                  {"still_s", 0}};
  if (const auto spotted = spotter_.newest()) {
    for (const Observation& corner : spotted->found.observations)
      capture["corners"].push_back(point(corner.pixel));
    capture["still_s"] = finite(spotted->still_s);
    if (spotted->found.observations.empty() && !spotted->found.diagnostics.items.empty())
      capture["why_not"] = spotted->found.diagnostics.items.front().message;
  }
  if (guided_ && board_ && image_size_.width > 0)
    capture["next"] = {{"outline", points(outline(*board_, guided_->camera_from_board, guided_->camera))},
                       {"words", guided_->words}};
  capture["thinking"] = next_pose_.is_running();
  state["capture"] = std::move(capture);
  state["rig"] = {{"there", rig_.has_value()},
                  {"passed", rig_passed_},
                  {"predicted_mm", optional(predicted_mm_)},
                  {"true_mm", optional(true_rig_mm_)},
                  {"accept_mm", finite(choices.accept_mm)},
                  {"lines", headline_}};
  json surfaces = json::array();
  for (const Surface& one : surfaces_.surfaces) {
    const Vec2 sides = side_lengths(one);
    json entry = {{"name", one.name},
                  {"content", one.content},
                  {"width", finite(sides.x())},
                  {"height", finite(sides.y())}};
    entry["corners"] = rig_ ? points(corners_in_camera(one, *rig_)) : json::array();
    entry["outline"] = rig_ ? points(outline_in_camera(one, *rig_)) : json::array();
    entry["in_frame"] = rig_ ? points(corners_in_frame(one, *rig_)) : json::array();
    entry["masks"] = json::array();
    if (rig_)
      for (const std::vector<Vec2>& mask : masks_in_camera(one, *rig_))
        entry["masks"].push_back(points(mask));
    entry["round"] = std::holds_alternative<GridSurface>(one.geometry);
    if (stage_ && rig_ && side_lengths(one) != Vec2::Zero()) {
      const TrueLanding truth =
          true_landing(one, *rig_, stage_->truth(), [this](const Ray& ray) { return stage_->on_wall(ray); });
      entry["true_mm"] = finite(truth.rms_mm);
      entry["true_worst_mm"] = finite(truth.worst_mm);
    }
    surfaces.push_back(std::move(entry));
  }
  std::error_code ignored;
  state["surfaces"] = {{"list", std::move(surfaces)},
                       {"scanned", std::filesystem::exists(project_.scan() / "view_00", ignored)}};
  if (choices.step == Step::kContent) state["contents"] = device::content_files(project_.folder(), 200);
  json walls = json::array();
  if (drift_)
    for (const WallDrift& wall : drift_->walls)
      walls.push_back({{"name", wall.surface},
                       {"rms_mm", finite(wall.rms_mm)},
                       {"checked", wall.checked},
                       {"moved", wall.moved},
                       {"words", to_sentence(wall)}});
  state["drift"] = {{"walls", std::move(walls)}, {"can_correct", drift_ && drift_->corrected}};
  const bool has_service = std::filesystem::exists(project_.service(), ignored);
  state["service"] = has_service ? std::filesystem::absolute(project_.service()).string() : "";
  state["show"] = {{"running", job_ == Job::kShow},
                   {"frozen", frozen_},
                   {"url", show_url_},
                   {"frames", job_ == Job::kShow ? done_ : 0}};
  return state.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace procam::studio
