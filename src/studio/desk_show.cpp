/// The shows of the desk: on the measured surfaces by all projectors, and mapped by hand.
#include <utility>

#include "desk.hpp"
#include "desk_devices.hpp"
#include "procam/show/run.hpp"

namespace procam::studio {

show::ShowOptions Desk::show_options(const std::filesystem::path& surfaces) const {
  show::ShowOptions options;
  options.surfaces = surfaces.string();
  const std::vector<ChosenProjector> projectors = project_.choices.projectors();
  if (projectors.size() == 1 && !stage_) options.display = projectors.front().display;
  if (projectors.size() > 1)
    for (const ChosenProjector& one : projectors)
      options.screens.push_back(
          {one.name, stage_ ? std::nullopt : std::optional(one.display), stage_ ? "none" : ""});
  return options;
}

void Desk::run_show() {
  if (surfaces_.surfaces.empty())
    throw Error(ErrorKind::kInput, "show", "there is no surface", "make one in the step 'surfaces'");
  show::ShowOptions options = show_options(project_.surfaces());
  show::save_options(project_.show(), options);
  serve_beside(options);
  ShowFollower follower(*this);
  if (screens_.size() < 2) {
    show::run(rig(), options, screens_.at(), &follower);
    return;
  }
  std::vector<show::ScreenSink> sinks;
  for (std::size_t i = 0; i < screens_.size(); ++i) sinks.push_back({screens_.name(i), screens_.at(i)});
  show::run(rig(), options, sinks, &follower);
}

/// Neither board nor camera: corners in the first projector's pixels, dragged at the control page.
void Desk::map_by_hand() {
  show::ShowOptions options = show_options(project_.mapping());
  options.screens.clear();
  options.autosave = true;
  serve_beside(options);
  ShowFollower follower(*this);
  show::run(options, screens_.at(), &follower);
}

/// The show's control page has a port of its own.
void Desk::serve_beside(show::ShowOptions& options) {
  const std::size_t colon = options_.control.rfind(':');
  options.control = (colon == std::string::npos ? "" : options_.control.substr(0, colon + 1)) + "0";
  options.token = options_.token;
  if (stage_) options.fps = options_.simulate->frames_per_s;
  frozen_ = false;
  doing_ = "frames shown";
}

}  // namespace procam::studio
