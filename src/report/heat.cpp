#include "heat.hpp"

#include <algorithm>
#include <cmath>

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

namespace {

/// Pixels that carry their number: every fourth column and every third row, from the third and the second.
bool numbered(const FrameMap& map, const Vec2& share) {
  constexpr int kColumns = 4, kRows = 3;
  const int column = int(std::lround(share.x() * (map.columns - 1))),
            row = int(std::lround(share.y() * (map.rows - 1)));
  return column % kColumns == kColumns / 2 && row % kRows == kRows / 2;
}

}  // namespace

std::string frame_map(const FrameMap& map, const std::string& description) {
  constexpr double kMapWidth = 480, kScaleWidth = 240;
  constexpr double kDark = 0.6;  // of the colours: white text from here on
  const Vec2 frame(kMapWidth, kMapWidth * map.size.height / map.size.width),
      last(map.size.width - 1, map.size.height - 1);
  const Vec2 half = 0.5 * frame.cwiseQuotient(Vec2(map.columns - 1, map.rows - 1));
  double max = 0;
  for (const double value : map.values) max = std::max(max, value);
  std::string cells, numbers;
  for (std::size_t i = 0; i < map.pixels.size(); ++i) {
    const Vec2 share = map.pixels[i].cwiseQuotient(last), at = share.cwiseProduct(frame);
    const Vec2 low = (at - half).cwiseMax(Vec2::Zero()), high = (at + half).cwiseMin(frame);
    const double of_max = max > 0 ? map.values[i] / max : 0;
    const std::string value = significant(map.values[i], 2);
    cells += filled(low, high - low, heat(of_max),
                    "pixel (" + fixed(map.pixels[i].x(), 0) + ", " + fixed(map.pixels[i].y(), 0) +
                        "): " + value + " " + map.unit);
    if (numbered(map, share))
      numbers += label(
          at + Vec2(0, 4),
          std::string("class=\"tick on-heat") + (of_max > kDark ? " dark" : "") + "\" text-anchor=\"middle\"",
          value);
  }
  const Vec2 margin(6, 6);
  return svg(box(-margin, frame + 2 * margin + Vec2(0, 42)), description,
             cells + rectangle("class=\"frame\"", Vec2::Zero(), frame) + numbers +
                 heat_scale(Vec2(0, frame.y() + 12), kScaleWidth, significant(max, 2) + " " + map.unit));
}

}  // namespace procam::report
