#include "heat.hpp"

#include <algorithm>

#include "html.hpp"

namespace procam::report {

std::string heat(double share) {
  constexpr double kStops[][3] = {{255, 247, 205}, {252, 190, 96}, {226, 96, 58}, {120, 20, 50}};
  const double at = 3 * std::clamp(share, 0.0, 1.0);
  const int stop = std::min(int(at), 2);
  std::string color = "rgb(";
  for (int c = 0; c < 3; ++c)
    color += (c > 0 ? "," : "") +
             fixed(kStops[stop][c] + (at - stop) * (kStops[stop + 1][c] - kStops[stop][c]), 0);
  return color + ")";
}

std::string filled(const Vec2& corner, const Vec2& size, const std::string& fill, const std::string& tip) {
  return element("path",
                 "shape-rendering=\"crispEdges\" fill=\"" + fill + "\" d=\"M" + position(corner) + "h" +
                     coordinate(size.x()) + "v" + coordinate(size.y()) + "h" + coordinate(-size.x()) + "Z\"",
                 tip.empty() ? "" : element("title", "", escaped(tip)));
}

std::string heat_scale(const Vec2& corner, double width, const std::string& max) {
  constexpr int kSteps = 60;
  constexpr double kHeight = 12, kBelow = 28;
  const Vec2 step(width / kSteps, 0);
  std::string content;
  for (int i = 0; i < kSteps; ++i)
    content += filled(corner + i * step, Vec2(step.x(), kHeight), heat((i + 0.5) / kSteps), "");
  content += label(corner + Vec2(0, kBelow), "class=\"tick\"", "0");
  return content + label(corner + Vec2(width, kBelow), "class=\"tick\" text-anchor=\"end\"", max);
}

}  // namespace procam::report
