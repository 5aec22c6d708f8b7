#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/device/content_source.hpp"
#include "procam/render/gl.hpp"
#include "procam/render/viewer.hpp"
#include "procam/show/frame_files.hpp"
#include "procam/simulate/preview.hpp"
#include "procam/surface/lay_out.hpp"

namespace procam::show {

/// The surfaces that have content, and the scene with their places; its pictures are set for each frame.
struct Stage {
  struct Shown {
    std::unique_ptr<device::ContentSource> source;
    Surface surface;
    ImageSize size;  ///< of the pictures
    surface::LaidOut laid;
  };
  std::vector<Shown> shown;
  Scene scene;

  void show(double time_s);
};

/// Adds the surfaces with content to the report. Contents of a viewer's things are relative to their file.
Stage set_stage(const FrameFilesOptions& options, const RigProjector& projector,
                const SolvedSurfaceSet& solved, FrameFilesReport& report);

/// The real surfaces as they stand in the room; they have no content of their own. `laid` holds their masks.
Scene real_surfaces(const SolvedSurfaceSet& solved, std::vector<surface::LaidOut>& laid);

/// Draws virtual surfaces for an eye and projects that picture onto the real surfaces.
class ViewerPass {
 public:
  /// Throws Error(kDegenerate) when the eye sees none of the light.
  ViewerPass(const FrameFilesOptions& options, const RigProjector& projector, const SolvedSurfaceSet& real,
             Diagnostics& diagnostics);

  const render::Viewpoint& eye() const { return eye_; }
  /// Of the light that lands, what the eye sees.
  double seen_share() const { return shown_.seen_share; }
  const Scene& scene(const Scene& things);

 private:
  std::vector<surface::LaidOut> laid_;
  Scene room_;
  std::unique_ptr<render::Renderer> from_eye_;
  render::Viewpoint eye_;
  render::ViewerScene shown_;
};

/// A frame of the first projector, the scenes of the others, and the eye of a viewer where there is one.
struct ShownFrame {
  const ImageU8& frame;
  const Stage& stage;
  const std::optional<ViewerPass>& viewer;
};

/// The room while the first projector shows its frame and the others what the stage has for them, as the viewer
/// sees it, or without one a person facing the surfaces. With a viewer the first shines alone: the others' scenes
/// are their own. nullopt with a warning where no surface has a place in the room.
std::optional<ImageU8> room_preview(const FrameFilesOptions& options, const Rig& rig,
                                    const SolvedSurfaceSet& solved, const ShownFrame& shown,
                                    Diagnostics& diagnostics);

}  // namespace procam::show
