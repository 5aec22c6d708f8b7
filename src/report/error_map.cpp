#include <cmath>

#include "heat.hpp"
#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

using analyze::LightError;
using analyze::SurfaceLocated;

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
  const std::string name =
      "Predicted error of " + map->error.projector + " located " + to_string(error.located);
  return figure(frame_map({rig.projector(error.projector).projector.size(), map->columns, map->rows,
                           map->pixels, map->rms_mm, "mm"},
                          name),
                words(map->error));
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
