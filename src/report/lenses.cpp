#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "pictures.hpp"
#include "procam/calibrate/lens_model.hpp"

namespace procam::report {
namespace {

constexpr double kBarsWidth = 560, kRowHeight = 24, kNames = 190, kNumbers = 190;

}  // namespace

std::string lens_alternatives(const calibrate::CalibrationResult& result) {
  std::string pictures;
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    const std::string& name = result.devices[d].name;
    double longest = 0, usual = 0;
    std::vector<const calibrate::LensAlternative*> rows;
    for (const calibrate::LensAlternative& one : result.lens_alternatives) {
      if (one.device != int(d)) continue;
      rows.push_back(&one);
      if (one.model == calibrate::kUsualLensModel) usual = one.error();
    }
    if (rows.empty()) continue;
    // What falls far behind would shrink all others to nothing: its bar is cut.
    for (const auto* one : rows)
      if (std::isfinite(one->error())) longest = std::max(longest, std::min(one->error(), 3 * usual));
    const double unit = (kBarsWidth - kNames - kNumbers) / std::max(longest, 1e-12);
    std::string content = label(Vec2(0, 14), "class=\"tick\"", "lens model") +
                          label(Vec2(kNames, 14), "class=\"tick\"", "error on held-out views") +
                          label(Vec2(kBarsWidth, 14), "class=\"tick\" text-anchor=\"end\"", "px");
    double y = 22;
    for (const auto* one : rows) {
      const bool known = std::isfinite(one->error());
      const double length = known ? unit * std::min(one->error(), longest) : 0;
      const Vec2 from(kNames, y + 4), to(kNames + length, y + kRowHeight - 6);
      content += element("path",
                         std::string("class=\"held") + (one->chosen ? " taken" : "") +
                             "\" fill=\"currentColor\" d=\"M" + position(from) + "H" + coordinate(to.x()) +
                             "V" + coordinate(to.y()) + "H" + coordinate(from.x()) + "Z\"",
                         element("title", "", escaped(one->model)));
      content += label(Vec2(0, y + 16), std::string("class=\"tick") + (one->chosen ? " accent\"" : "\""),
                       one->model + (one->chosen ? " \u2713" : ""));
      content +=
          label(Vec2(kBarsWidth, y + 16), "class=\"tick\" text-anchor=\"end\"",
                known ? pixels(one->holdout_px) + (one->error() > longest ? " (cut)" : "") : one->ruled_out);
      y += kRowHeight;
    }
    pictures +=
        figure(svg(box(Vec2::Zero(), Vec2(kBarsWidth, y + 4)), "Lens models of " + name, content),
               element("b", "", escaped(name)) +
                   ": bars: RMS error on held-out views, all devices, relative to the usual model's; beside "
                   "them the device's own in pixels. The usual model stays unless one with more terms is "
                   "better by 5 % and by more than chance.");
  }
  if (pictures.empty()) return "";
  return element("div", "class=\"pair\"", "\n" + pictures) + "\n";
}

}  // namespace procam::report
