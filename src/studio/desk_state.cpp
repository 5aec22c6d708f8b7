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

/// By page, the edit that waits for its answer.
json held_edits(const EditLog& edits) {
  json held = json::object();
  for (const auto& [page, one] : edits.held()) held[page] = one.thing;
  return held;
}

/// `captured`: the state of the capture so far; the camera's newest board joins it.
void add_spotted(const BoardSpotter& spotter, json& captured) {
  captured["corners"] = json::array();
  captured["still_s"] = 0;
  const auto spotted = spotter.newest();
  if (!spotted) return;
  for (const Observation& corner : spotted->found.observations)
    captured["corners"].push_back(point(corner.pixel));
  captured["still_s"] = finite(spotted->still_s);
  if (spotted->found.observations.empty() && !spotted->found.diagnostics.items.empty())
    captured["why_not"] = spotted->found.diagnostics.items.front().message;
}

/// The surface in the images of the camera and of the projector; nothing of both without a rig.
json surface_entry(const Surface& one, const std::optional<Rig>& rig, const SimulatedStage* stage) {
  const Vec2 sides = side_lengths(one);
  json entry = {{"name", one.name},
                {"content", one.content},
                {"width", finite(sides.x())},
                {"height", finite(sides.y())}};
  entry["corners"] = rig ? points(corners_in_camera(one, *rig)) : json::array();
  entry["outline"] = rig ? points(outline_in_camera(one, *rig)) : json::array();
  entry["in_frame"] = rig ? points(corners_in_frame(one, *rig)) : json::array();
  entry["masks"] = json::array();
  if (rig)
    for (const std::vector<Vec2>& mask : masks_in_camera(one, *rig)) entry["masks"].push_back(points(mask));
  entry["round"] = std::holds_alternative<GridSurface>(one.geometry);
  if (stage && rig && sides != Vec2::Zero()) {
    const TrueLanding truth =
        true_landing(one, *rig, stage->truth(), [&](const Ray& ray) { return stage->on_wall(ray); });
    entry["true_mm"] = finite(truth.rms_mm);
    entry["true_worst_mm"] = finite(truth.worst_mm);
  }
  return entry;
}

json drift_of(const std::optional<Drift>& drift) {
  json walls = json::array();
  if (drift)
    for (const WallDrift& wall : drift->walls)
      walls.push_back({{"name", wall.surface},
                       {"rms_mm", finite(wall.rms_mm)},
                       {"checked", wall.checked},
                       {"moved", wall.moved},
                       {"words", to_sentence(wall)}});
  return {{"walls", std::move(walls)}, {"can_correct", drift && drift->corrected}};
}

}  // namespace

std::string Desk::state_text() const {
  const Choices& choices = project_.choices;
  json steps = json::array();
  for (int i = 0; i < kSteps; ++i)
    steps.push_back({{"id", to_string(Step(i))}, {"done", project_.is_done(Step(i))}});
  constexpr const char* kJobs[] = {"", "identify", "check", "capture", "scan", "drift", "show", "map"};
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
  state["held"] = held_edits(edits_);
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
                  {"projector_coverage", finite(100 * projector_coverage_)}};
  add_spotted(spotter_, capture);
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
  for (const Surface& one : surfaces_.surfaces) surfaces.push_back(surface_entry(one, rig_, stage_.get()));
  std::error_code ignored;
  state["surfaces"] = {{"list", std::move(surfaces)},
                       {"scanned", project_.is_wall_measured()},
                       {"measure_by", choices.measure_by},
                       {"depth", choices.depth},
                       {"marker", choices.marker}};
  if (choices.step == Step::kSurfaces) state["surfaces"]["files"] = project_.surface_files();
  if (choices.step == Step::kContent) state["contents"] = device::content_files(project_.folder(), 200);
  state["drift"] = drift_of(drift_);
  const bool has_service = std::filesystem::exists(project_.service(), ignored);
  state["service"] = has_service ? std::filesystem::absolute(project_.service()).string() : "";
  state["show"] = {{"running", job_ == Job::kShow},
                   {"frozen", frozen_},
                   {"url", show_url_},
                   {"frames", job_ == Job::kShow || job_ == Job::kMapping ? done_ : 0}};
  return state.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace procam::studio
