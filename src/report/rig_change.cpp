#include <cmath>
#include <optional>

#include "heat.hpp"
#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

constexpr int kMapColumns = 17, kMapRows = 13;

/// Root of the mean square; 0 of nothing.
double rms_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / double(values.size()));
}

/// Where the lens images the direction that the earlier one imaged at a pixel: the distance between the two pixels.
FrameMap lens_change(const Camera& lens, const Camera& earlier) {
  FrameMap map{lens.size, kMapColumns, kMapRows, {}, {}, "px"};
  for (int row = 0; row < kMapRows; ++row)
    for (int column = 0; column < kMapColumns; ++column) {
      const Vec2 pixel((lens.size.width - 1) * column / (kMapColumns - 1.0),
                       (lens.size.height - 1) * row / (kMapRows - 1.0));
      const auto direction = earlier.unproject(pixel);
      const auto now = direction ? lens.project(*direction) : std::nullopt;
      if (!now) continue;
      map.pixels.push_back(pixel);
      map.values.push_back((*now - pixel).norm());
    }
  return map;
}

std::string lens_change_figure(const std::string& name, const Camera& lens, const Camera& earlier) {
  if (lens.size != earlier.size) return "";
  const FrameMap map = lens_change(lens, earlier);
  if (map.pixels.empty()) return "";
  return figure(
      frame_map(map, "Change of the lens of " + name),
      element("b", "", escaped(name)) +
          ", lens: " + element("b", "", significant(rms_of(map.values), 2) + " px RMS") +
          ". Each cell: the distance between the pixels of one direction by both lenses. A rotation of the "
          "device can compensate a common displacement.");
}

std::string light_change_figure(const Rig& rig, const Rig& earlier, const std::string& name, double wall) {
  const analyze::LightErrorMap map = analyze::true_error_map(rig, earlier, wall, name);
  if (map.pixels.empty()) return "";
  const RigProjector& device = rig.projector(name);
  return figure(frame_map({device.projector.size(), map.columns, map.rows, map.pixels, map.rms_mm, "mm"},
                          "Change of the light of " + device.name),
                element("b", "", escaped(device.name)) +
                    ", lens and pose: " + element("b", "", significant(map.error.rms_mm, 2) + " mm RMS") +
                    " on a wall at " + shortest(wall) +
                    "\u00a0m. Each cell: the distance between the projected points of this pixel "
                    "by both rigs, in the rig's frame.");
}

template <typename List>
bool has_named(const List& list, const std::string& name) {
  for (const auto& one : list)
    if (one.name == name) return true;
  return false;
}

}  // namespace

std::string rig_change(const Rig& rig, const Rig& earlier, double wall) {
  std::string figures;
  for (const RigProjector& device : rig.projectors)
    if (has_named(earlier.projectors, device.name) &&
        earlier.projector(device.name).projector.size() == device.projector.size())
      figures += light_change_figure(rig, earlier, device.name, wall) +
                 lens_change_figure(device.name, device.projector.inverse_camera,
                                    earlier.projector(device.name).projector.inverse_camera);
  for (const RigCamera& device : rig.cameras)
    if (has_named(earlier.cameras, device.name))
      figures += lens_change_figure(device.name, device.camera, earlier.camera(device.name).camera);
  if (figures.empty())
    return element("p", "class=\"hint\"", "The earlier rig has no device of the same name and size.") + "\n";
  return element("div", "class=\"pair\"", "\n" + figures) + "\n";
}

}  // namespace procam::report
