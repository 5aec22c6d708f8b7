#include <algorithm>
#include <cmath>

#include "frame_scenes.hpp"
#include "procam/render/cpu.hpp"
#include "procam/render/viewpoint.hpp"

namespace procam::show {
namespace {

/// What the other projectors show while the stage is on, and the lamps of all, in the frame of the first.
class RoomLights {
 public:
  RoomLights(const FrameFilesOptions& options, const Rig& rig, const SolvedSurfaceSet& solved)
      : options_(options), rig_(rig), first_(rig.projector(solved.projector)) {}

  void add(std::size_t i, const RigProjector& of_rig, ImageU8 shown) {
    // Unless it is stated: enough for the reach of the picture to show.
    constexpr double kBlack = 0.02;
    const auto& blend = options_.blend;
    if (blend) surface::apply_blend(blend->maps[i], shown, options_.gamma);
    simulate::RoomLight light{of_rig.projector,
                              first_.rig_from_projector.inverse() * of_rig.rig_from_projector,
                              {std::move(shown)}};
    light.intensity = density(of_rig.projector) / density(first_.projector) *
                      (blend ? blend->brightness[i] / blend->brightness[0] : 1);
    light.gamma = options_.gamma > 0 ? options_.gamma : simulate::kSrgb;
    light.black = blend && blend->black[i] > 0 ? blend->black[i] : kBlack;
    lights_.push_back(std::move(light));
  }

  void add_others(const Stage& stage) {
    if (!options_.blend) return;
    for (std::size_t i = 1; i < options_.blend->sets.size(); ++i) {
      const SolvedSurfaceSet& set = options_.blend->sets[i];
      Scene scene;
      std::vector<surface::LaidOut> laid;
      laid.reserve(stage.shown.size());  // scenes look at the masks
      for (std::size_t k = 0; k < stage.shown.size(); ++k)
        for (const SolvedSurface& one : set.surfaces) {
          if (one.surface.name != stage.shown[k].surface.name) continue;
          laid.push_back(surface::lay_out(one.placement, stage.shown[k].surface, stage.shown[k].size));
          SceneItem item = stage.scene.items[k];
          item.placement = laid.back().placement;
          item.mask = laid.back().mask;
          scene.items.push_back(item);
          break;
        }
      const RigProjector& other = rig_.projector(set.projector);
      add(i, other, render::render(scene, other.projector, options_.rendering));
    }
  }

  const std::vector<simulate::RoomLight>& lights() const { return lights_; }

 private:
  /// The same light falls on fewer square metres where pixels are small.
  static double density(const Projector& projector) {
    const Intrinsics& k = projector.inverse_camera.intrinsics;
    return k.fx * k.fy / (double(projector.size().width) * projector.size().height);
  }

  const FrameFilesOptions& options_;
  const Rig& rig_;
  const RigProjector& first_;
  std::vector<simulate::RoomLight> lights_;
};

/// The same view with no more pixels than a page shows.
render::Viewpoint for_page(render::Viewpoint viewpoint) {
  constexpr int kMaxAcross = 1280;
  Camera& camera = viewpoint.camera;
  const double scale = std::min(1.0, double(kMaxAcross) / camera.size.width);
  camera.size = {int(std::ceil(scale * camera.size.width)), int(std::ceil(scale * camera.size.height))};
  Intrinsics& k = camera.intrinsics;
  k.fx *= scale;
  k.fy *= scale;
  k.cx = scale * (k.cx + 0.5) - 0.5;
  k.cy = scale * (k.cy + 0.5) - 0.5;
  return viewpoint;
}

}  // namespace

std::optional<ImageU8> room_preview(const FrameFilesOptions& options, const Rig& rig,
                                    const SolvedSurfaceSet& solved, const ShownFrame& shown,
                                    Diagnostics& diagnostics) {
  std::vector<surface::LaidOut> laid;
  const Scene surfaces = real_surfaces(solved, laid);
  const auto eye =
      shown.viewer ? std::optional(for_page(shown.viewer->eye())) : render::facing_viewpoint(surfaces);
  if (!eye) {
    diagnostics.warn("no_preview",
                     "all surfaces are given in projector pixels, so there is no room to look at: the "
                     "preview is not written; place surfaces in metres to see them");
    return std::nullopt;
  }
  RoomLights lights(options, rig, solved);
  lights.add(0, rig.projector(solved.projector), shown.frame);
  if (!shown.viewer) lights.add_others(shown.stage);
  simulate::PreviewOptions preview;
  preview.threads = options.rendering.threads;
  return simulate::preview(simulate::room_of(surfaces), lights.lights(), eye->camera,
                           eye->camera_from_projector.inverse(), preview);
}

}  // namespace procam::show
