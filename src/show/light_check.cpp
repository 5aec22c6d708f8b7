#include "light_check.hpp"

#include <algorithm>
#include <utility>

#include "procam/show/run.hpp"

namespace procam::show {
namespace {

constexpr double kCheckPeriod = 1;  // seconds

/// A sentence with the next step.
std::string dark_reason(const Projection& projection) {
  const Show& show = projection.show();
  const bool has_picture = projection.picture() != TestPattern::kContent ||
                           std::any_of(show.contents.begin(), show.contents.end(),
                                       [](const auto& content) { return content != nullptr; });
  if (!has_picture) return "no surface has content that could be opened; name it with --content SURFACE=FILE";
  const SolvedSurfaceSet solved = projection.solve_again();
  const SolvedSurface* outside = nullptr;
  for (const SolvedSurface& surface : solved.surfaces) {
    if (surface.visibility.covered_share > 0)
      return "'" + surface.surface.name +
             "' is in the projector's picture, so its content is black or "
             "transparent; check the content";
    if (outside == nullptr && !surface.diagnostics.items.empty()) outside = &surface;
  }
  std::string reason = "0 % of each surface is in the projector's picture";
  if (outside == nullptr) return reason + "; check the surfaces and the pose";
  // The likely units come first, where they explain it.
  const Diagnostic* first = outside->diagnostics.find("implausible_units");
  if (first == nullptr) first = &outside->diagnostics.items.front();
  return reason + "; '" + outside->surface.name + "': " + first->message;
}

}  // namespace

std::string waiting_reason(const std::vector<track::PoseSource*>& sources, const std::string& names) {
  if (sources.empty()) return "no pose is given; start with --pose FILE or --pose-source";
  std::string reason = "waiting for a pose from " + names;
  for (const track::PoseSource* source : sources)
    if (const track::SourceStatus status = source->status(); !status.last_error.empty())
      reason +=
          " (" + std::to_string(status.malformed) + " malformed, last error: " + status.last_error + ")";
  return reason;
}

std::optional<std::string> LightCheck::check(double now, const DrawnFrame& drawn,
                                             const Projection& projection, const ImageU8& frame,
                                             Metrics& metrics) {
  if (drawn.blanked || drawn.unseen > 0 || projection.show().surfaces.surfaces.empty()) return std::nullopt;
  if (checked_ == 0) checked_ = now;  // contents may come a moment later
  if (now - checked_ < kCheckPeriod) return std::nullopt;
  checked_ = now;
  ++metrics.checked;
  const std::uint8_t* begin = frame.data();
  const std::uint8_t* end = begin + std::ptrdiff_t(frame.width()) * frame.height() * frame.channels();
  if (std::any_of(begin, end, [](std::uint8_t value) { return value != 0; })) return std::nullopt;
  ++metrics.dark;
  if (std::exchange(reported_, true)) return std::nullopt;
  return "no light on any surface: " + dark_reason(projection);
}

Diagnostics darkness(const ShowReport& report, const ShowOptions& options) {
  const Metrics& m = report.metrics;
  Diagnostics diagnostics;
  if (m.frames > 0 && m.waiting == m.frames) {
    std::string sources;
    for (const std::string& source : options.poses) sources += (sources.empty() ? "" : ", ") + source;
    if (options.marker) sources = "the markers before camera " + options.marker->camera;
    diagnostics.warn("no_pose",
                     sources.empty()
                         ? "surfaces in the world were dark in every frame, because no pose is given; "
                           "start with --pose FILE or --pose-source"
                         : "surfaces in the world were dark in every frame, because no pose came from " +
                               sources + "; check that its sender runs and its address");
  }
  if (m.checked > 0 && m.dark == m.checked)
    diagnostics.warn("no_light",
                     "no frame that was checked (one a second) had light on any surface; check the surfaces' "
                     "units and content with solve-surfaces and --output frames:FOLDER");
  return diagnostics;
}

}  // namespace procam::show
