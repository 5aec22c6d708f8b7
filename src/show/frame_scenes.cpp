#include "frame_scenes.hpp"

#include "procam/io/surface_file.hpp"
#include "procam/surface/solve.hpp"

namespace procam::show {
namespace {

/// The virtual surfaces, placed for the projector of the real ones; whether its light reaches them does not
/// matter.
SolvedSurfaceSet solve_things(const std::filesystem::path& file, const RigProjector& projector,
                              const SolvedSurfaceSet& real) {
  const SurfaceSet things = io::load_surfaces(file);
  for (const Surface& thing : things.surfaces)
    if (!place_of(thing.geometry))
      throw Error(ErrorKind::kInput, "surface '" + thing.name + "' of " + file.string(),
                  "it is given in projector pixels and has no place in the room", "define it in metres");
  return surface::solve_surfaces(things, projector, real.projector_from_world);
}

}  // namespace

void Stage::show(double time_s) {
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const device::ContentFrame frame = shown[i].source->at(time_s);
    scene.items[i].content = shown[i].laid.part(frame.view);
    scene.items[i].content_revision = frame.revision;
  }
}

Stage set_stage(const FrameFilesOptions& options, const RigProjector& projector,
                const SolvedSurfaceSet& solved, FrameFilesReport& report) {
  std::filesystem::path named_in = options.folder / "surfaces.json";
  std::optional<SolvedSurfaceSet> things;
  if (options.viewer) {
    named_in = options.viewer->things;
    things = solve_things(named_in, projector, solved);
  }
  device::ContentOptions exact;
  exact.pace = device::Pace::kExact;
  Stage stage;
  for (const SolvedSurface& one : (things ? *things : solved).surfaces) {
    Surface surface = one.surface;
    const auto own = options.contents.find(surface.name);
    const std::string content =
        own != options.contents.end() ? own->second : device::content_beside(named_in, surface.content);
    if (content.empty()) {
      report.diagnostics.warn("no_content", "surface '" + surface.name +
                                                "' has no content and stays dark; give --content " +
                                                surface.name + "=picture.png");
      continue;
    }
    if (const auto layout = options.layouts.find(surface.name); layout != options.layouts.end())
      surface.layout = layout->second;
    Stage::Shown shown{device::open_content(content, exact), surface, {}, {}};
    report.diagnostics.append(shown.source->diagnostics());
    shown.size = shown.source->at(options.time_s).view.size();
    shown.laid = surface::lay_out(one.placement, surface, shown.size);
    report.surfaces.push_back(surface.name);
    report.contents.push_back(content + ", " + std::to_string(shown.size.width) + "x" +
                              std::to_string(shown.size.height));
    stage.shown.push_back(std::move(shown));
  }
  if (stage.shown.empty())
    report.diagnostics.fail("nothing_drawn",
                            "no surface has content, so every frame is black; give --content");
  for (const Stage::Shown& shown : stage.shown) {  // they stay where they are from here on
    SceneItem item;
    item.placement = shown.laid.placement;
    item.mask = shown.laid.mask;
    stage.scene.items.push_back(item);
  }
  return stage;
}

Scene real_surfaces(const SolvedSurfaceSet& solved, std::vector<surface::LaidOut>& laid) {
  static const ImageU8 grey(1, 1, 1, 128);
  Scene room;
  for (const SolvedSurface& one : solved.surfaces) {
    Surface surface = one.surface;
    surface.layout = {};
    laid.push_back(surface::lay_out(one.placement, surface, grey.size()));
  }
  for (const surface::LaidOut& one : laid) {
    SceneItem item;
    item.placement = one.placement;
    item.content = grey;
    item.mask = one.mask;
    room.items.push_back(item);
  }
  return room;
}

ViewerPass::ViewerPass(const FrameFilesOptions& options, const RigProjector& projector,
                       const SolvedSurfaceSet& real, Diagnostics& diagnostics)
    : room_(real_surfaces(real, laid_)),
      from_eye_(render_gl::open_renderer(options.renderer, options.rendering)) {
  const Pose projector_from_eyes_frame =
      real.projector_from_world ? *real.projector_from_world : projector.rig_from_projector.inverse();
  const auto eye =
      render::viewer_eye(projector_from_eyes_frame * options.viewer->eye, room_, projector.projector);
  if (!eye)
    throw Error(ErrorKind::kDegenerate, "viewer",
                "none of the projector's light lands on a surface that this eye could see",
                "check the eye's position, its frame and its units, and that the surfaces are lit");
  diagnostics.append(eye->diagnostics);
  eye_ = eye->viewpoint;
  shown_ = render::viewer_scene(room_, projector.projector, eye_, options.rendering);
}

const Scene& ViewerPass::scene(const Scene& things) {
  from_eye_->render(render::seen_from(eye_.camera_from_projector, things), Projector{eye_.camera},
                    shown_.picture);
  shown_.picture_changed();
  return shown_.scene;
}

}  // namespace procam::show
