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

json displays(const SimulatedStage* stage) {
  json list = json::array();
  if (stage != nullptr) {
    for (const ChosenProjector& one : stage->all_projectors())
      list.push_back({{"text", one.display}, {"words", one.display + " projector, 1024x768"}});
    return list;
  }
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

/// With the newest image of each, where they are looked at.
json cameras(const std::vector<ListedCamera>& listed, const std::vector<CameraPreviews::Preview>& previews) {
  json list = json::array();
  for (const ListedCamera& camera : listed) {
    json& entry = list.emplace_back(json{{"text", camera.text}, {"words", camera.words}});
    for (std::size_t i = 0; i < previews.size(); ++i) {
      if (previews[i].text != camera.text) continue;
      entry["preview"] = i + 1;
      entry["images"] = previews[i].images;
      entry["fault"] = previews[i].fault;
    }
  }
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
json surface_entry(const Surface& one, const std::optional<Rig>& rig, const std::string& framed,
                   const SimulatedStage* stage) {
  const Vec2 sides = side_lengths(one);
  json entry = {{"name", one.name},
                {"content", one.content},
                {"width", finite(sides.x())},
                {"height", finite(sides.y())}};
  entry["corners"] = rig ? points(corners_in_camera(one, *rig)) : json::array();
  entry["outline"] = rig ? points(outline_in_camera(one, *rig)) : json::array();
  entry["in_frame"] = rig ? points(corners_in_frame(one, *rig, framed)) : json::array();
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
                       {"projector", wall.projector},
                       {"rms_mm", finite(wall.rms_mm)},
                       {"checked", wall.checked},
                       {"moved", wall.moved},
                       {"words", to_sentence(wall)}});
  return {{"walls", std::move(walls)}, {"can_correct", drift && drift->corrected}};
}

}  // namespace

/// Parts of the state, by page.
struct Desk::StateParts {
  const Desk& desk;

  json progress() const {
    json steps = json::array();
    for (int i = 0; i < kSteps; ++i)
      steps.push_back({{"id", to_string(Step(i))}, {"done", desk.project_.is_done(Step(i))}});
    constexpr const char* kJobs[] = {"",      "identify", "check", "capture", "scan",
                                     "drift", "show",     "map",   "look"};
    const auto [calibrating, percent] = desk.calibration_.progress();
    const bool is_calibrating = desk.calibration_.is_running();
    return {
        {"project", desk.project_.folder().string()},
        {"simulated", desk.stage_ != nullptr},
        {"step", to_string(desk.project_.choices.step)},
        {"steps", std::move(steps)},
        {"job", is_calibrating ? "calibrate" : kJobs[int(desk.job_)]},
        {"doing", is_calibrating ? calibrating : desk.doing_},
        {"done", is_calibrating ? percent : desk.done_},
        {"total", is_calibrating ? 100 : desk.total_},
        {"messages", desk.messages_},
    };
  }

  json camera() const {
    const Choices& choices = desk.project_.choices;
    json camera = {{"chosen", choices.camera},
                   {"open", desk.camera_ != nullptr},
                   {"size", {desk.image_size_.width, desk.image_size_.height}},
                   {"wanted_size", choices.camera_size},
                   {"exposure", choices.exposure},
                   {"images_per_s", finite(desk.images_per_s_)},
                   {"saturated", finite(100 * desk.saturated_share_)},
                   {"brightness", finite(desk.brightness_)},
                   {"sharpness", finite(desk.sharpness_)}};
    if (choices.step == Step::kCamera)
      camera["list"] =
          cameras(listed_cameras(desk.stage_ != nullptr, choices.camera), desk.previews_.previews());
    return camera;
  }

  json capture() const {
    json capture = {{"views", desk.project_.views_captured()},
                    {"wanted", desk.project_.choices.views},
                    {"camera_coverage", finite(100 * desk.camera_coverage_)},
                    {"projector_coverage", finite(100 * desk.projector_coverage_)}};
    add_spotted(desk.spotter_, capture);
    const auto& guided = desk.guided_;
    if (guided && desk.board_ && desk.image_size_.width > 0)
      capture["next"] = {
          {"outline", points(outline(*desk.board_, guided->camera_from_board, guided->camera))},
          {"in_frame", points(guided->in_frame)},
          {"words", guided->words}};
    capture["thinking"] = desk.next_pose_.is_running();
    return capture;
  }

  json surfaces() const {
    const Choices& choices = desk.project_.choices;
    json list = json::array();
    for (const Surface& one : desk.surfaces_.surfaces)
      list.push_back(surface_entry(one, desk.rig_, desk.framed_name(), desk.stage_.get()));
    json surfaces = {{"list", std::move(list)},
                     {"scanned", desk.project_.is_wall_measured()},
                     {"measure_by", choices.measure_by},
                     {"depth", choices.depth},
                     {"marker", choices.marker}};
    if (choices.step == Step::kSurfaces) surfaces["files"] = desk.project_.surface_files();
    return surfaces;
  }
};

std::string Desk::state_text() const {
  const Choices& choices = project_.choices;
  const StateParts parts{*this};
  json state = parts.progress();
  state["revision"] = edits_.revision();
  state["edit"] = {{"revision", edits_.newest().revision},
                   {"page", edits_.newest().page},
                   {"thing", edits_.newest().thing}};
  state["held"] = held_edits(edits_);
  state["error"] = error_
                       ? json{{"what", error_->subject()}, {"why", error_->why()}, {"next", error_->next()}}
                       : json(nullptr);
  state["display"] = {
      {"chosen", choices.display}, {"further", choices.further_displays}, {"open", screens_.is_open()}};
  if (rig_) {
    const ImageSize frame = rig_->projector(framed_name()).projector.size();
    state["frame"] = {frame.width, frame.height};
  }
  state["outlines"] = outlines_shown_;
  state["framed"] = framed_;
  if (choices.step == Step::kDisplay) state["display"]["list"] = displays(stage_.get());
  state["camera"] = parts.camera();
  state["lit"] = json::array();
  for (const auto& lit : lit_)
    state["lit"].push_back(lit ? json::array({point(lit->low), point(lit->high)}) : json(nullptr));
  state["board"] = {{"text", board_ ? io::format_board(*board_) : ""},
                    {"paper", choices.paper},
                    {"measured", choices.measured}};
  state["capture"] = parts.capture();
  state["rig"] = {{"there", rig_.has_value()},
                  {"passed", rig_passed_},
                  {"predicted_mm", optional(predicted_mm_)},
                  {"true_mm", optional(true_rig_mm_)},
                  {"accept_mm", finite(choices.accept_mm)},
                  {"lines", headline_}};
  state["surfaces"] = parts.surfaces();
  if (choices.step == Step::kContent) state["contents"] = device::content_files(project_.folder(), 200);
  state["drift"] = drift_of(drift_);
  std::error_code ignored;
  const bool has_service = std::filesystem::exists(project_.service(), ignored);
  state["service"] = has_service ? std::filesystem::absolute(project_.service()).string() : "";
  state["show"] = {{"running", job_ == Job::kShow},
                   {"frozen", frozen_},
                   {"url", show_url_},
                   {"frames", job_ == Job::kShow || job_ == Job::kMapping ? done_ : 0}};
  return state.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace procam::studio
