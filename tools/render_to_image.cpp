/// render-to-image: solved.json + rig.json + content -> the projector's frame or a video of frames (and what
/// the room looks like).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include "common/blend_flags.hpp"
#include "common/cli.hpp"
#include "common/viewer_flags.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/video_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/render/gl.hpp"
#include "procam/render/viewer.hpp"
#include "procam/simulate/preview.hpp"
#include "procam/surface/lay_out.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, surfaces, output, preview, weights, renderer = "cpu";
  std::vector<std::string> content, fit, crop;
  BlendFlags blend;
  ViewerFlags viewer;
  double time_s = 0, seconds = 0, rate_hz = 25, gamma = 0;
  int threads = 0;
  bool encoded = false;
};

std::string kinds_of_content() {
  std::string text;
  for (const device::ContentKind& kind : device::content_kinds())
    text += (text.empty() ? "" : ", ") + kind.name + " (" + kind.example + ")";
  return text;
}

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json, as calibrate-projector writes it")->required();
  app.add_option("--surfaces", flags.surfaces, "solved surfaces, as solve-surfaces writes them")->required();
  app.add_option("--content", flags.content,
                 "SURFACE=WHAT, once a surface; else the surface file's own: " + kinds_of_content());
  app.add_option("--fit", flags.fit, "SURFACE=stretch, contain or cover; else the surface file's own");
  app.add_option("--crop", flags.crop,
                 "SURFACE=LEFT,TOP,RIGHT,BOTTOM, fractions of the picture; else the surface file's own");
  app.add_option("-o,--output", flags.output,
                 "the projector's frame, .png, or its light as floats, .exr; with --seconds frames, "
                 "frame_%04d.png or "
                 ".exr, or a video: .mkv (lossless), .mp4, .avi")
      ->required();
  app.add_option("--time", flags.time_s, "seconds since the content began, of the first frame [0]");
  app.add_option("--seconds", flags.seconds, "how long frames are written")->check(CLI::Range(1e-3, 86400.0));
  app.add_option("--fps", flags.rate_hz, "frames a second, with --seconds [25]")
      ->check(CLI::Range(1e-3, 1e3));
  app.add_option("--preview", flags.preview, "what a person facing the surfaces would see, .png");
  declare_viewer(app, flags.viewer);
  declare_blend(app, flags.blend);
  app.add_option("--weights", flags.weights,
                 "also the projector's share of the light in each pixel, .png (8 bits) or .pfm (floats)");
  app.add_option("--gamma", flags.gamma, "of the projector, light = value^gamma; else sRGB")
      ->check(CLI::Range(0.2, 5.0));
  app.add_option("--threads", flags.threads, "0: as many as the machine has")->check(CLI::NonNegativeNumber);
  app.add_option("--renderer", flags.renderer, "cpu, or gl for OpenGL without a window: the same picture")
      ->check(CLI::IsMember({"cpu", "gl"}))
      ->capture_default_str();
  app.add_flag("--average-numbers", flags.encoded,
               "average pixel values as they stand instead of the light they stand for (codes, masks)");
}

std::vector<std::string> names_of(const SolvedSurfaceSet& solved) {
  std::vector<std::string> names;
  for (const SolvedSurface& surface : solved.surfaces) names.push_back(surface.surface.name);
  return names;
}

ContentLayout layout_of(const Surface& surface, const NamedTexts& fits, const NamedTexts& crops) {
  ContentLayout layout = surface.layout;
  if (const auto fit = fits.find(surface.name); fit != fits.end()) {
    const std::map<std::string, Fit> known{
        {"stretch", Fit::kStretch}, {"contain", Fit::kContain}, {"cover", Fit::kCover}};
    const auto found = known.find(fit->second);
    if (found == known.end())
      throw Error(ErrorKind::kInput, "--fit " + surface.name + "=" + fit->second, "there is no such fit",
                  "give stretch, contain or cover");
    layout.fit = found->second;
  }
  if (const auto crop = crops.find(surface.name); crop != crops.end()) {
    double left = 0, top = 0, right = 0, bottom = 0;
    int end = -1;
    const int read =
        std::sscanf(crop->second.c_str(), "%lf,%lf,%lf,%lf%n", &left, &top, &right, &bottom, &end);
    if (read != 4 || end != int(crop->second.size()) ||
        !(left >= 0 && top >= 0 && right <= 1 && bottom <= 1 && left < right && top < bottom))
      throw Error(ErrorKind::kInput, "--crop " + surface.name + "=" + crop->second,
                  "it is not LEFT,TOP,RIGHT,BOTTOM with an area",
                  "give fractions from 0 to 1: 0.25,0,0.75,1");
    layout.crop_from = {left, top};
    layout.crop_to = {right, bottom};
  }
  return layout;
}

/// What is shown on one surface.
struct Shown {
  std::unique_ptr<device::ContentSource> source;
  Surface surface;
  ImageSize size;  ///< of the pictures
  surface::LaidOut laid;
};

/// The surfaces that have content, and the scene with their places; its pictures are set for each frame.
struct Stage {
  std::vector<Shown> shown;
  Scene scene;
  std::vector<std::string> drawn;

  void show(double time_s) {
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const device::ContentFrame frame = shown[i].source->at(time_s);
      scene.items[i].content = shown[i].laid.part(frame.view);
      scene.items[i].content_revision = frame.revision;
    }
  }
};

/// The surfaces' content is named in the file `named_in`.
Stage set_up(const Flags& flags, const SolvedSurfaceSet& solved, const std::string& named_in,
             Console& console, Diagnostics& diagnostics) {
  const std::vector<std::string> names = names_of(solved);
  const NamedTexts given = named_texts("--content", flags.content, names, "wall=wall.png"),
                   fits = named_texts("--fit", flags.fit, names, "wall=cover"),
                   crops = named_texts("--crop", flags.crop, names, "wall=0.25,0,0.75,1");
  device::ContentOptions options;
  options.pace = device::Pace::kExact;
  Stage stage;
  for (const SolvedSurface& one : solved.surfaces) {
    Surface surface = one.surface;
    const auto own = given.find(surface.name);
    const std::string what =
        own != given.end() ? own->second : device::content_beside(named_in, surface.content);
    if (what.empty()) {
      diagnostics.warn("no_content", "surface '" + surface.name +
                                         "' has no content and stays dark; give --content " + surface.name +
                                         "=picture.png");
      continue;
    }
    surface.layout = layout_of(surface, fits, crops);
    Shown shown{device::open_content(what, options), surface, {}, {}};
    diagnostics.append(shown.source->diagnostics());
    const ImageSize size = shown.source->at(flags.time_s).view.size();
    shown.size = size;
    shown.laid = surface::lay_out(one.placement, surface, size);
    stage.drawn.push_back(surface.name);
    stage.shown.push_back(std::move(shown));
    console.say(surface.name + ": " + what + ", " + std::to_string(size.width) + "x" +
                std::to_string(size.height));
  }
  for (const Shown& shown : stage.shown) {  // they stay where they are from here on
    SceneItem item;
    item.placement = shown.laid.placement;
    item.mask = shown.laid.mask;
    stage.scene.items.push_back(item);
  }
  return stage;
}

/// The real surfaces as they stand in the room; they have no content of their own.
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

/// Draws the virtual things for the eye and projects that picture onto the real surfaces.
class ViewerPass {
 public:
  ViewerPass(const Flags& flags, const RigProjector& projector, const SolvedSurfaceSet& real,
             const render::RenderOptions& options, Diagnostics& diagnostics)
      : room_(real_surfaces(real, laid_)), from_eye_(render_gl::open_renderer(flags.renderer, options)) {
    const auto eye =
        render::viewer_eye(eye_in_projector(flags.viewer, projector, real), room_, projector.projector);
    if (!eye)
      throw Error(ErrorKind::kDegenerate, "--viewer",
                  "none of the projector's light lands on a surface that this eye could see",
                  "check the eye's place, its frame and its units, and that the surfaces are lit");
    diagnostics.append(eye->diagnostics);
    eye_ = eye->viewpoint;
    shown_ = render::viewer_scene(room_, projector.projector, eye_, options);
  }

  const Scene& room() const { return room_; }
  const render::Viewpoint& eye() const { return eye_; }
  /// Of the light that lands, what the eye sees.
  double seen_share() const { return shown_.seen_share; }
  const Scene& scene(const Scene& things) {
    from_eye_->render(render::seen_from(eye_.camera_from_projector, things), Projector{eye_.camera},
                      shown_.picture);
    shown_.picture_changed();
    return shown_.scene;
  }

 private:
  std::vector<surface::LaidOut> laid_;  ///< their masks
  Scene room_;
  std::unique_ptr<render::Renderer> from_eye_;
  render::Viewpoint eye_;
  render::ViewerScene shown_;
};

/// frame_%04d.png -> frame_0017.png; nullopt for a name without a number.
std::optional<std::string> numbered(const std::string& pattern, int number) {
  const std::size_t percent = pattern.find('%');
  const std::size_t d =
      percent == std::string::npos ? percent : pattern.find_first_not_of("0123456789", percent + 1);
  if (d == std::string::npos || pattern[d] != 'd' || d > percent + 4) return std::nullopt;
  const std::string digits = pattern.substr(percent + 1, d - percent - 1);
  const int width = digits.empty() ? 1 : std::stoi(digits);
  std::string text = std::to_string(number);
  if (int(text.size()) < width) text.insert(0, std::size_t(width) - text.size(), '0');
  return pattern.substr(0, percent) + text + pattern.substr(d + 1);
}

/// Where frames go, one after the other.
class Output {
 public:
  Output(const Flags& flags, ImageSize size) : pattern_(flags.output), many_(flags.seconds > 0) {
    std::string extension = std::filesystem::path(pattern_).extension().string();
    holds_light_ = extension == ".exr" || extension == ".EXR";
    if (holds_light_ && many_ && !numbered(pattern_, 0))
      throw Error(ErrorKind::kInput, pattern_, "an .exr holds one frame, and --seconds makes several",
                  "number them: frame_%04d.exr");
    if (holds_light_ && flags.gamma > 0)
      throw Error(ErrorKind::kInput, "--gamma with an .exr", "it holds light, not a projector's values",
                  "leave --gamma out");
    if (many_ && !numbered(pattern_, 0)) video_.emplace(flags.output, size, flags.rate_hz);
  }
  /// Frames of floats, linear.
  bool holds_light() const { return holds_light_; }
  void add(const ImageF& light) { io::save_light(many_ ? *numbered(pattern_, count_++) : pattern_, light); }
  void add(const ImageU8& frame) {
    if (video_)
      video_->add(frame);
    else
      io::save_image(many_ ? *numbered(pattern_, count_) : pattern_, frame);
    ++count_;
  }
  void finish() {
    if (video_) video_->finish();
  }

 private:
  std::string pattern_;
  bool many_, holds_light_ = false;
  int count_ = 0;
  std::optional<device::VideoFile> video_;
};

/// What the other projectors show while `stage` is on, and the lamps of all, in the frame of the first. For a
/// viewer's picture others have scenes of their own: `stage` is nullptr, and the first shines alone.
std::vector<simulate::RoomLight> lights_of(const Flags& flags, const Rig& rig, const SolvedSurfaceSet& solved,
                                           const std::optional<Blending>& blending, const Stage* stage,
                                           ImageU8 frame, const render::RenderOptions& options) {
  // Unless --black says what it is: enough for the picture's reach to show.
  constexpr double kBlack = 0.02;
  const RigProjector& first = rig.projector(solved.projector);
  std::vector<simulate::RoomLight> lights;
  const auto add = [&](std::size_t i, const RigProjector& of_rig, ImageU8 shown) {
    if (blending) surface::apply_blend(blending->maps[i], shown, flags.gamma);
    // The same light falls on fewer square metres where pixels are small.
    const auto density = [](const Projector& projector) {
      const Intrinsics& k = projector.inverse_camera.intrinsics;
      return k.fx * k.fy / (double(projector.size().width) * projector.size().height);
    };
    simulate::RoomLight light{
        of_rig.projector, first.rig_from_projector.inverse() * of_rig.rig_from_projector, {std::move(shown)}};
    light.intensity = density(of_rig.projector) / density(first.projector) *
                      (blending ? blending->brightness[i] / blending->brightness[0] : 1);
    light.gamma = flags.gamma > 0 ? flags.gamma : simulate::kSrgb;
    light.black = blending && blending->black[i] > 0 ? blending->black[i] : kBlack;
    lights.push_back(std::move(light));
  };
  add(0, first, std::move(frame));
  if (!stage || !blending) return lights;
  for (std::size_t i = 1; i < blending->sets.size(); ++i) {
    Scene scene;
    std::vector<surface::LaidOut> laid;
    laid.reserve(stage->shown.size());  // scenes look at the masks
    for (std::size_t k = 0; k < stage->shown.size(); ++k)
      for (const SolvedSurface& one : blending->sets[i].surfaces) {
        if (one.surface.name != stage->drawn[k]) continue;
        laid.push_back(surface::lay_out(one.placement, stage->shown[k].surface, stage->shown[k].size));
        SceneItem item = stage->scene.items[k];
        item.placement = laid.back().placement;
        item.mask = laid.back().mask;
        scene.items.push_back(item);
        break;
      }
    const RigProjector& other = rig.projector(blending->sets[i].projector);
    add(i, other, render::render(scene, other.projector, options));
  }
  return lights;
}

/// The same view with no more pixels than are looked at.
render::Viewpoint for_a_page(render::Viewpoint viewpoint) {
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

void save_weights(const std::string& file, const surface::BlendMap& map) {
  if (std::filesystem::path(file).extension() == ".pfm") return io::save_pfm(file, map.weight);
  ImageU8 weights(map.weight.size());
  for (int y = 0; y < weights.height(); ++y)
    for (int x = 0; x < weights.width(); ++x)
      weights.at(x, y) = std::uint8_t(std::lround(255 * map.weight.at(x, y)));
  io::save_image(file, weights);
}

/// Before long work: what is written at its end can be.
void check_pictures(const Flags& flags) {
  const auto check = [](const std::string& file, std::initializer_list<const char*> kinds) {
    if (file.empty()) return;
    std::string kind = std::filesystem::path(file).extension().string(), names;
    std::transform(kind.begin(), kind.end(), kind.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    for (const char* const known : kinds) {
      if (kind == known) return io::require_writable(file);
      names += (names.empty() ? "" : " or ") + std::string(known);
    }
    throw Error(ErrorKind::kInput, file, "pictures of this kind are not written here",
                "give it a name that ends in " + names);
  };
  check(flags.preview, {".png"});
  check(flags.weights, {".png", ".pfm"});
}

ExitCode draw(const Flags& flags, Console& console) {
  check_pictures(flags);
  check_viewer(flags.viewer);
  const Rig rig = io::load_rig(flags.rig);
  const SolvedSurfaceSet solved = io::load_solved_surfaces(flags.surfaces);
  const RigProjector& of_rig = rig.projector(solved.projector);
  const Projector& projector = of_rig.projector;
  Diagnostics diagnostics;
  Stage stage = flags.viewer.given() ? set_up(flags, solve_things(flags.viewer, of_rig, solved),
                                              flags.viewer.things, console, diagnostics)
                                     : set_up(flags, solved, flags.surfaces, console, diagnostics);
  std::optional<Blending> blending;
  if (flags.blend.given() || flags.gamma > 0 || !flags.weights.empty())
    blending = blend_for(flags.blend, rig, solved, diagnostics);
  const surface::BlendMap* blend = blending ? &blending->maps.front() : nullptr;

  render::RenderOptions options;
  options.threads = flags.threads;
  options.linear_light = !flags.encoded;
  const std::unique_ptr<render::Renderer> renderer = render_gl::open_renderer(flags.renderer, options);
  if (flags.renderer == "gl") console.say("drawn by " + renderer->device());
  std::optional<ViewerPass> viewer;
  if (flags.viewer.given()) {
    viewer.emplace(flags, of_rig, solved, options, diagnostics);
    const ImageSize size = viewer->eye().camera.size;
    console.say(format("the viewer's picture: %dx%d; of the light on the surfaces %.1f %% is in sight",
                       size.width, size.height, 100 * viewer->seen_share()));
    console.summary().set("/viewer/seen_share", viewer->seen_share());
    console.summary().set("/viewer/picture", std::vector<double>{double(size.width), double(size.height)});
  }
  render::require_drawable(projector.size());
  ImageU8 frame(projector.size(), 3);
  Output output(flags, projector.size());
  ImageF light;
  if (output.holds_light()) light = ImageF(projector.size(), 3);
  const int frames = flags.seconds > 0 ? std::max(1, int(std::lround(flags.seconds * flags.rate_hz))) : 1;
  std::optional<ImageU8> view;
  const auto look = [&](const ImageU8& shown) -> std::optional<ImageU8> {
    std::vector<surface::LaidOut> laid;
    const Scene surfaces = real_surfaces(solved, laid);
    const auto eye = viewer ? std::optional(for_a_page(viewer->eye())) : render::facing_viewpoint(surfaces);
    if (!eye) {
      diagnostics.warn("no_preview",
                       "all surfaces are given in projector pixels, so there is no room to look at: the "
                       "preview is not written; place surfaces in metres to see them");
      return std::nullopt;
    }
    simulate::PreviewOptions preview;
    preview.threads = flags.threads;
    return simulate::preview(
        simulate::room_of(surfaces),
        lights_of(flags, rig, solved, blending, viewer ? nullptr : &stage, shown, options), eye->camera,
        eye->camera_from_projector.inverse(), preview);
  };
  for (int n = 0; n < frames; ++n) {
    if (frames > 1) console.progress("frame", n + 1, frames);
    stage.show(flags.time_s + n / flags.rate_hz);
    const Scene& scene = viewer ? viewer->scene(stage.scene) : stage.scene;
    const bool looked_at = n == 0 && !flags.preview.empty();
    if (!output.holds_light() || looked_at) renderer->render(scene, projector, frame);
    if (looked_at) view = look(frame);
    if (output.holds_light()) {
      renderer->render(scene, projector, light);
      if (blend) surface::apply_blend(*blend, light);
      output.add(light);
    } else {
      if (blend) surface::apply_blend(*blend, frame, flags.gamma);
      output.add(frame);
    }
  }
  output.finish();

  std::vector<std::string> written{flags.output};
  if (view) {
    io::save_image(flags.preview, *view);
    written.push_back(flags.preview);
  }
  if (!flags.weights.empty()) {
    save_weights(flags.weights, *blend);
    written.push_back(flags.weights);
  }
  console.report(diagnostics);
  console.summary().set("/projector", solved.projector);
  console.summary().set("/surfaces", stage.drawn);
  console.summary().set("/renderer", renderer->device());
  console.summary().set("/frames", frames);
  console.summary().set("/files", written);
  for (const std::string& file : written) console.say("wrote " + file);
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"render-to-image",
       "draws pictures, videos and colours onto solved surfaces, through the projector's lens, into the "
       "frames it must show; blends them with those of other projectors.",
       "render-to-image --rig rig.json --surfaces solved.json --content wall=picture.png -o frame.png"},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return draw(flags, console); });
}
