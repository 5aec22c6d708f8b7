#include "uncalibrated.hpp"

#include <algorithm>

#include "procam/device/frame_sink.hpp"

namespace procam::show {
namespace {

/// Shares of the frame: round the surfaces, and between two of them, where that leaves the surfaces wide enough.
constexpr double kMargin = 0.1, kLargestGap = 0.1;

}  // namespace

PixelSurface pixel_rectangle(const Vec2& corner, const Vec2& size) {
  PixelSurface surface;
  surface.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec2& uv : surface.content) surface.pixels.push_back(corner + uv.cwiseProduct(size));
  return surface;
}

void require_no_rig_needed(const ShowOptions& options) {
  const auto refuse_if = [](bool given, const char* what) {
    if (given)
      throw Error(ErrorKind::kInput, what, "only a calibrated rig gives it a meaning, and there is none",
                  "give --rig rig.json, or leave it out");
  };
  refuse_if(!options.projector.empty(), "projector");
  refuse_if(is_depth_source(options.surfaces), "surfaces from a depth camera");
  refuse_if(!options.poses.empty(), "pose source");
  refuse_if(options.marker.has_value(), "marker camera");
  refuse_if(!options.pose.empty(), "pose");
  refuse_if(!options.mount.empty(), "mount");
  refuse_if(options.people.has_value(), "people");
  refuse_if(options.watch.has_value(), "watch");
  refuse_if(options.track.has_value(), "track");
  refuse_if(options.blend.has_value(), "blend");
  refuse_if(!options.screens.empty(), "screens");
  refuse_if(options.depth.silhouettes, "silhouettes");
  refuse_if(!options.record.empty(), "record");
}

void require_pixel_surfaces(const SurfaceSet& set, const std::string& file) {
  for (const Surface& surface : set.surfaces)
    if (!std::holds_alternative<PixelSurface>(surface.geometry))
      throw Error(ErrorKind::kInput, file + ": surface '" + surface.name + "'",
                  "it is placed in metres, and no calibrated rig says how the projector sees it",
                  "give --rig rig.json, or use surfaces in projector pixels (\"pixels\")");
}

ImageSize frame_size_without_rig(const ShowOptions& options) {
  if (options.output.empty()) {
    const std::vector<device::Display> list = device::displays();
    return device::choose_display(list, options.display).size;
  }
  if (!options.size)
    throw Error(ErrorKind::kInput, "output " + options.output,
                "neither a rig nor a display states the frame's size", "give --size, e.g. 1280x800");
  return *options.size;
}

Rig stand_in_rig(ImageSize size) {
  Rig rig;
  RigProjector& projector = rig.projectors.emplace_back();
  Camera& lens = projector.projector.inverse_camera;
  lens.size = size;
  lens.intrinsics = {1.5 * size.width, 1.5 * size.width, 0.5 * size.width, 0.5 * size.height, 0};
  return rig;
}

SurfaceSet first_surfaces(std::map<std::string, std::string> contents, ImageSize size) {
  if (contents.empty()) contents["wall"] = "#ffffff";
  const auto count = double(contents.size());
  const double span = 1 - 2 * kMargin, gap = std::min(kLargestGap, span / (4 * count));
  const Vec2 frame(size.width, size.height), share((span - (count - 1) * gap) / count, span);
  SurfaceSet set;
  Vec2 corner(kMargin, kMargin);
  for (const auto& [name, content] : contents) {
    const PixelSurface geometry = pixel_rectangle(corner.cwiseProduct(frame), share.cwiseProduct(frame));
    set.surfaces.push_back({name, geometry, {}, content});
    corner.x() += share.x() + gap;
  }
  return set;
}

}  // namespace procam::show
