#include <cmath>

#include "heat.hpp"
#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

using analyze::LightError;
using analyze::LightErrorMap;
using analyze::SurfaceLocated;

/// Pixels that carry their number: every fourth column from the first, every third row.
bool numbered(const LightErrorMap& map, const Vec2& cell) {
  constexpr int kColumns = 4, kRows = 3;
  const int column = int(std::lround(cell.x() * (map.columns - 1))),
            row = int(std::lround(cell.y() * (map.rows - 1)));
  return column % kColumns == kColumns / 2 && row % kRows == kRows / 2;
}

/// The frame with a cell round each pixel of the grid; those at the edge are cut by it.
std::string map_of_frame(const LightErrorMap& map, ImageSize size) {
  constexpr double kMapWidth = 480, kScaleWidth = 240;
  constexpr double kDark = 0.6;  // of the colours: white text from here on
  const Vec2 frame(kMapWidth, kMapWidth * size.height / size.width), last(size.width - 1, size.height - 1);
  const Vec2 half = 0.5 * frame.cwiseQuotient(Vec2(map.columns - 1, map.rows - 1));
  std::string cells, numbers;
  for (std::size_t i = 0; i < map.pixels.size(); ++i) {
    const Vec2 share = map.pixels[i].cwiseQuotient(last), at = share.cwiseProduct(frame);
    const Vec2 low = (at - half).cwiseMax(Vec2::Zero()), high = (at + half).cwiseMin(frame);
    const double error = map.rms_mm[i] / map.error.worst_mm;
    const std::string mm = significant(map.rms_mm[i], 2) + " mm";
    cells +=
        filled(low, high - low, heat(error),
               "pixel (" + fixed(map.pixels[i].x(), 0) + ", " + fixed(map.pixels[i].y(), 0) + "): " + mm);
    if (numbered(map, share))
      numbers += label(
          at + Vec2(0, 4),
          std::string("class=\"tick on-heat") + (error > kDark ? " dark" : "") + "\" text-anchor=\"middle\"",
          significant(map.rms_mm[i], 2));
  }
  const Vec2 margin(6, 6);
  const std::string name =
      "Predicted error of " + map.error.projector + " located " + to_string(map.error.located);
  return svg(
      box(-margin, frame + 2 * margin + Vec2(0, 42)), name,
      cells + rectangle("class=\"frame\"", Vec2::Zero(), frame) + numbers +
          heat_scale(Vec2(0, frame.y() + 12), kScaleWidth, significant(map.error.worst_mm, 2) + " mm"));
}

std::string words(const LightError& error) {
  const bool by_camera = error.located == SurfaceLocated::kByCamera;
  return element("b", "", escaped(error.projector)) + ", surface located " + to_string(error.located) + ": " +
         element("b", "", significant(error.rms_mm, 2) + " mm RMS") + " at " + shortest(error.distance) +
         "\u00a0m, max " + significant(error.worst_mm, 2) +
         " mm. Each cell: the predicted RMS distance on the wall at this pixel of the frame, mm." +
         (by_camera && error.share < 1 ? " Without colour: not seen by " + escaped(error.camera) + "." : "");
}

std::string error_map(const Rig& rig, const LightError& error) {
  const auto map = analyze::predicted_error_map(rig, error.distance, error.projector, error.located);
  if (!map || !std::isfinite(map->error.worst_mm) || map->error.worst_mm <= 0) return "";
  return figure(map_of_frame(*map, rig.projector(error.projector).projector.size()), words(map->error));
}

}  // namespace

std::string error_maps(const Rig& rig, const std::vector<analyze::LightErrors>& predicted) {
  if (rig.covariance.empty()) return "";
  std::string figures;
  for (const analyze::LightErrors& errors : predicted) {
    figures += error_map(rig, errors.externally);
    if (errors.by_camera) figures += error_map(rig, *errors.by_camera);
  }
  if (figures.empty()) return "";
  return element("div", "class=\"pair\"", "\n" + figures) + "\n" +
         element("p", "class=\"hint\"", "Every map has its own colour scale, from 0 to its maximum.") + "\n";
}

}  // namespace procam::report
