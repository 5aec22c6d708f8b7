#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "html.hpp"
#include "pictures.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::report {
namespace {

using calibrate::CalibrationResult;

constexpr double kViewBarsWidth = 470, kViewRow = 20, kBarsLeft = 116, kBarsRight = 316, kBarsTop = 26;
constexpr double kFarAbove = 2;  // times the median
constexpr double kOverNoise =
    1.5;                      // RMS of the whitened residuals: less is explained by the noise of the view
constexpr double kCutAt = 5;  // times the median: longer bars are cut
constexpr double kManyPoints = 0.2;  // share of a view's points that were rejected
constexpr std::size_t kMaxRows = 40;

struct ViewBar {
  std::size_t view = 0;
  double rms_px = 0, holdout_px = std::nan("");
  double over_noise = std::nan("");  ///< RMS of the whitened residuals, 1: as expected
  int points = 0, rejected = 0;
  bool used = true;
};

std::vector<ViewBar> bars(const CalibrationResult& result, std::size_t device) {
  std::vector<ViewBar> all(result.views.size());
  for (std::size_t v = 0; v < all.size(); ++v) {
    const calibrate::ViewResult& view = result.views[v];
    all[v].view = v;
    all[v].used = view.used;
    all[v].rms_px = view.rms_px[device];
    if (device < view.holdout_px.size()) all[v].holdout_px = view.holdout_px[device];
  }
  std::vector<double> squares(all.size());
  for (const calibrate::Residual& r : result.residuals) {
    if (r.device != int(device)) continue;
    ViewBar& bar = all[std::size_t(r.view)];
    ++bar.points;
    bar.rejected += !r.used;
    if (r.used) squares[bar.view] += r.whitened.squaredNorm();
  }
  for (ViewBar& bar : all)
    if (squares[bar.view] > 0)
      bar.over_noise = std::sqrt(squares[bar.view] / (2.0 * (bar.points - bar.rejected)));
  const auto size = [](const ViewBar& bar) {
    return !bar.used ? HUGE_VAL : std::isfinite(bar.rms_px) ? bar.rms_px : -1.0;
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const ViewBar& a, const ViewBar& b) { return size(a) > size(b); });
  return all;
}

/// Of the RMS of the views that have points of this device in use.
double median_rms(const std::vector<ViewBar>& bars) {
  std::vector<double> values;
  for (const ViewBar& bar : bars)
    if (bar.used && bar.points > bar.rejected && std::isfinite(bar.rms_px)) values.push_back(bar.rms_px);
  return median_or(std::move(values), 0.0);
}

/// Why a view is suspicious, in the words beside its bar; empty when it is not.
std::string suspicion(const ViewBar& bar, double median) {
  if (!bar.used) return "view rejected";
  std::string words;
  // A view with more noise of its own (far away, out of focus) is none.
  const bool is_noise = bar.over_noise < kOverNoise;
  if (median > 0 && bar.rms_px > kFarAbove * median && !is_noise)
    words = fixed(bar.rms_px / median, 1) + " × median";
  if (bar.rejected > kManyPoints * bar.points)
    words += (words.empty() ? "" : ", ") + std::to_string(bar.rejected) + " of " +
             std::to_string(bar.points) + " rejected";
  return words;
}

/// The name, the bar and its numbers; `unit` is the bar's length of a pixel.
std::string row(const CalibrationResult& result, const ViewBar& bar, double y, double unit, double median) {
  const calibrate::ViewResult& view = result.views[bar.view];
  const std::string why = suspicion(bar, median);
  const std::string color = !bar.used ? " bad" : why.empty() ? "" : " warn";
  const double longest = kBarsRight - kBarsLeft;
  const bool known = bar.used && std::isfinite(bar.rms_px) && bar.points > bar.rejected;
  const double length = known ? std::min(unit * bar.rms_px, longest) : 0;
  std::string tip = view.name + ": " + (known ? pixels(bar.rms_px) + " px RMS" : "no RMS");
  if (std::isfinite(bar.holdout_px)) tip += ", held-out " + pixels(bar.holdout_px) + " px";
  tip += ", " + std::to_string(bar.rejected) + " of " + std::to_string(bar.points) + " points rejected";
  if (!view.note.empty()) tip += "; " + view.note;
  std::string name = view.name;
  if (name.size() > 18) name = name.substr(0, 8) + "..." + name.substr(name.size() - 7);
  std::string content = label(Vec2(6, y + 14), "class=\"tick" + color + "\"", name);
  content += element("path",
                     "class=\"rms" + color + "\" fill=\"currentColor\" d=\"M" +
                         position(Vec2(kBarsLeft, y + 3)) + "h" + coordinate(length) + "v" +
                         coordinate(kViewRow - 6) + "h" + coordinate(-length) + "Z\"",
                     element("title", "", escaped(tip)));
  if (known && std::isfinite(bar.holdout_px)) {
    const double x = kBarsLeft + std::min(unit * bar.holdout_px, longest);
    Marks tick;
    tick.line(Vec2(x, y + 1), Vec2(x, y + kViewRow - 1));
    content += tick.path("class=\"bar\"");
  }
  std::string numbers = known ? pixels(bar.rms_px) : "-";
  if (known && unit * bar.rms_px > longest) numbers += " (cut)";
  return content + label(Vec2(kBarsRight + 8, y + 14), "class=\"tick" + color + "\"",
                         numbers + (why.empty() ? "" : " · " + why));
}

}  // namespace

std::string view_bars(const CalibrationResult& result, int device) {
  std::vector<ViewBar> all = bars(result, std::size_t(device));
  const double middle = median_rms(all);
  std::size_t suspicious = 0, held_out = 0;
  double largest = 0;
  for (const ViewBar& bar : all) {
    suspicious += !suspicion(bar, middle).empty();
    held_out += std::isfinite(bar.holdout_px);
    for (const double px : {bar.rms_px, bar.holdout_px})
      if (bar.used && std::isfinite(px)) largest = std::max(largest, px);
  }
  if (middle > 0) largest = std::min(largest, kCutAt * middle);
  const double unit = (kBarsRight - kBarsLeft) / std::max(largest, 1e-12);
  const std::size_t hidden = all.size() - std::min(all.size(), kMaxRows);
  all.resize(all.size() - hidden);

  std::string content;
  double y = kBarsTop;
  for (const ViewBar& bar : all) {
    content += row(result, bar, y, unit, middle);
    y += kViewRow;
  }
  if (middle > 0) {
    const double x = kBarsLeft + unit * middle;
    Marks line;
    line.line(Vec2(x, kBarsTop - 4), Vec2(x, y));
    content += line.path("class=\"ring\"") + label(Vec2(x, kBarsTop - 10),
                                                   "class=\"tick accent\" text-anchor=\"middle\"",
                                                   "median " + pixels(middle));
  }
  const std::string& name = result.devices[std::size_t(device)].name;
  std::string caption = element("b", "", escaped(name)) + ": RMS residual of each view, px, largest first.";
  if (held_out > 0) caption += " Ticks: the error of the view in a solve without it.";
  caption += suspicious > 0
                 ? " Coloured: " + std::to_string(suspicious) + " of " + std::to_string(result.views.size()) +
                       " views that were rejected, have more than " + shortest(kFarAbove) +
                       " times the median and more than their noise explains, or lost many points."
                 : " No view stands out.";
  if (hidden > 0) caption += " " + std::to_string(hidden) + " views with a smaller RMS are not drawn.";
  return figure(svg(box(Vec2::Zero(), Vec2(kViewBarsWidth, y + 6)), "RMS by view of " + name, content),
                caption);
}

}  // namespace procam::report
