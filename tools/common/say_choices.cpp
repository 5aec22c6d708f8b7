#include "common/say_choices.hpp"

#include <algorithm>
#include <map>

#include "procam/analyze/light_error.hpp"

namespace procam::tools {

void say_lens_models(Console& console, const calibrate::CalibrationResult& result, double wall) {
  std::map<int, int> rows;
  for (const calibrate::LensAlternative& one : result.lens_alternatives) {
    const std::string& device = result.devices[std::size_t(one.device)].name;
    const int row = rows[one.device]++;
    if (row == 0)
      console.say(format("%-31s terms   error on held-out views, px", (device + "'s lens").c_str()));
    const bool known = !one.by_view.empty();
    double mm = 0;  // of the projector that it serves worst
    if (known)
      for (const RigProjector& projector : one.rig.projectors)
        mm = std::max(mm, analyze::predicted_light_error(one.rig, wall, projector.name).rms_mm);
    const std::string note = one.chosen ? "selected" : one.ruled_out;
    console.say(format("  %-29s %5d", one.model.c_str(), one.terms) +
                (known ? format("%13.3f   ", one.holdout_px) : format("%16s", "")) + note);
    const std::string at = "/lens_models/" + device + "/" + std::to_string(row) + "/";
    console.summary().set(at + "model", one.model);
    console.summary().set(at + "terms", one.terms);
    if (known) {
      console.summary().set(at + "holdout_px", one.holdout_px);
      console.summary().set(at + "holdout_error", one.error());
      if (!one.rig.projectors.empty()) console.summary().set(at + "wall_rms_mm", mm);
    }
    if (!one.ruled_out.empty()) console.summary().set(at + "ruled_out", one.ruled_out);
    console.summary().set(at + "chosen", one.chosen);
  }
}

void say_views(Console& console, const calibrate::CalibrationResult& result,
               const std::optional<analyze::NextView>& next, analyze::SurfaceLocated located) {
  const std::vector<std::string> verdicts = analyze::view_verdicts(result);
  for (std::size_t v = 0; v < verdicts.size(); ++v) {
    if (verdicts[v] != "fine")
      console.say(format("view       %s: %s", result.views[v].name.c_str(), verdicts[v].c_str()));
    const std::string at = "/view_verdicts/" + std::to_string(v) + "/";
    console.summary().set(at + "view", result.views[v].name);
    console.summary().set(at + "share", result.views[v].share);
    console.summary().set(at + "verdict", verdicts[v]);
  }
  if (!next) return;
  const analyze::LightError &now = next->now.of(located), &then = next->then.of(located);
  console.say(format("add next   the board %s: predicted error %s -> %s mm (surface located %s)",
                     next->words.c_str(), two_digits(now.rms_mm).c_str(), two_digits(then.rms_mm).c_str(),
                     analyze::to_string(then.located)));
  console.summary().set("/next_view/words", next->words);
  console.summary().set("/next_view/surface_located", analyze::to_string(then.located));
  console.summary().set("/next_view/rms_mm", then.rms_mm);
  if (next->then.by_camera) {
    console.summary().set("/next_view/externally_rms_mm", next->then.externally.rms_mm);
    console.summary().set("/next_view/by_camera_rms_mm", next->then.by_camera->rms_mm);
  }
}

void say_board_shape(Console& console, const calibrate::CalibrationResult& result) {
  if (result.shape.free) {
    console.say(format("board      not flat: %.2f mm along and %.2f mm off its plane (rms), at most %.2f mm",
                       1e3 * result.shape.in_plane_rms, 1e3 * result.shape.out_of_plane_rms,
                       1e3 * result.shape.largest));
    console.summary().set("/board/in_plane_rms_mm", 1e3 * result.shape.in_plane_rms);
    console.summary().set("/board/out_of_plane_rms_mm", 1e3 * result.shape.out_of_plane_rms);
    console.summary().set("/board/largest_mm", 1e3 * result.shape.largest);
  }
  console.summary().set("/board/free_shape", result.shape.free);
}

void say_size_to_measure(Console& console, const calibrate::CalibrationResult& result) {
  console.say("measure    " + result.size_to_measure);
  console.summary().set("/board/size_to_measure", result.size_to_measure);
}

}  // namespace procam::tools
