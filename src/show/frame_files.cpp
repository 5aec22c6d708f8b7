#include "procam/show/frame_files.hpp"

#include <algorithm>
#include <cmath>

#include "frame_output.hpp"
#include "frame_scenes.hpp"
#include "procam/io/image/images.hpp"
#include "procam/render/cpu.hpp"

namespace procam::show {
namespace {

/// Draws the frames, one after the other, into their files.
class FrameWriter {
 public:
  FrameWriter(const Rig& rig, const SolvedSurfaceSet& solved, const FrameFilesOptions& options)
      : rig_(rig),
        solved_(solved),
        options_(options),
        projector_(rig.projector(solved.projector)),
        stage_(set_stage(options, projector_, solved, report_)),
        renderer_(render_gl::open_renderer(options.renderer, options.rendering)) {
    report_.device = renderer_->device();
    if (options.viewer) {
      viewer_.emplace(options, projector_, solved, report_.diagnostics);
      report_.seen_share = viewer_->seen_share();
      report_.viewer_size = viewer_->eye().camera.size;
    }
  }

  FrameFilesReport run(const FrameProgress& progress) {
    const Projector& projector = projector_.projector;
    render::require_drawable(projector.size());
    FrameOutput output(options_, projector.size());
    ImageU8 frame(projector.size(), 3);
    ImageF light;
    if (output.holds_light()) light = ImageF(projector.size(), 3);
    const surface::BlendMap* blend = options_.blend ? &options_.blend->maps.front() : nullptr;
    report_.frames =
        options_.seconds > 0 ? std::max(1, int(std::lround(options_.seconds * options_.fps))) : 1;
    for (int n = 0; n < report_.frames; ++n) {
      if (progress) progress(n, report_.frames);
      stage_.show(options_.time_s + n / options_.fps);
      const Scene& scene = viewer_ ? viewer_->scene(stage_.scene) : stage_.scene;
      const bool looked_at = n == 0 && !options_.preview.empty();
      if (!output.holds_light() || looked_at) renderer_->render(scene, projector, frame);
      if (looked_at)
        preview_ = room_preview(options_, rig_, solved_, {frame, stage_, viewer_}, report_.diagnostics);
      if (output.holds_light()) {
        renderer_->render(scene, projector, light);
        if (blend) surface::apply_blend(*blend, light);
        output.add(light);
      } else {
        if (blend) surface::apply_blend(*blend, frame, options_.gamma);
        output.add(frame);
      }
    }
    output.finish();
    save_others(blend);
    return std::move(report_);
  }

 private:
  void save_others(const surface::BlendMap* blend) {
    report_.files.push_back(options_.output);
    if (preview_) {
      io::save_image(options_.preview, *preview_);
      report_.files.push_back(options_.preview);
    }
    if (!options_.weights.empty()) {
      save_weights(options_.weights, *blend);
      report_.files.push_back(options_.weights);
    }
  }

  const Rig& rig_;
  const SolvedSurfaceSet& solved_;
  const FrameFilesOptions& options_;
  const RigProjector& projector_;
  FrameFilesReport report_;
  Stage stage_;
  std::unique_ptr<render::Renderer> renderer_;
  std::optional<ViewerPass> viewer_;
  std::optional<ImageU8> preview_;
};

}  // namespace

FrameFilesReport write_frames(const Rig& rig, const SolvedSurfaceSet& solved,
                              const FrameFilesOptions& options, const FrameProgress& progress) {
  check_extra_files(options);
  if (!options.weights.empty() && !options.blend)
    throw Error(ErrorKind::kInput, options.weights, "weights are those of a blend, and none is given",
                "leave it out, or give FrameFilesOptions::blend");
  return FrameWriter(rig, solved, options).run(progress);
}

}  // namespace procam::show
