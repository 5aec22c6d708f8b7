/// render-to-image: solved.json + rig.json + content -> the projector's frame or a video of frames (and a
/// preview of the room).
#include <CLI/CLI.hpp>

#include "common/blend_flags.hpp"
#include "common/cli.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/device/content_source.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/show/frame_files.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, surfaces, things;
  std::vector<std::string> content, fit, crop;
  BlendFlags blend;
  std::optional<Vec3> eye;
  show::FrameFilesOptions frames;
  bool encoded = false;
};

std::string kinds_of_content() {
  std::string text;
  for (const device::ContentKind& kind : device::content_kinds())
    text += (text.empty() ? "" : ", ") + kind.name + " (" + kind.example + ")";
  return text;
}

void declare(CLI::App& app, Flags& flags) {
  show::FrameFilesOptions& frames = flags.frames;
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  app.add_option("--surfaces", flags.surfaces, "Solved surfaces of solve-surfaces")->required();
  app.add_option(
      "--content", flags.content,
      "Content of a surface, once for each (default: as in the surface file): " + kinds_of_content());
  app.add_option("--fit", flags.fit,
                 "How content fits its surface: stretch, contain or cover (default: as in the surface file)");
  app.add_option("--crop", flags.crop,
                 "Part of the content: LEFT,TOP,RIGHT,BOTTOM as fractions (default: as in the surface file)");
  app.add_option("-o,--output", frames.output,
                 "Frame of the projector, .png, or its light as floats, .exr; with --duration frames, "
                 "frame_%04d.png or .exr, or a video: .mkv (lossless), .mp4, .avi")
      ->required();
  add_parsed(
      app, "--time", [&](const std::string& text) { frames.time_s = io::parse_duration(text); },
      "Time in the content of the first frame, e.g. 2.5s (default: 0s)");
  add_parsed(
      app, "--duration",
      [&](const std::string& text) {
        frames.seconds = io::parse_duration(text);
        if (frames.seconds < 1e-3 || frames.seconds > 86400)
          throw Error(ErrorKind::kInput, "duration '" + text + "'", "it is not from 1 ms to 86400 s",
                      "write the time that the frames last, e.g. 10s");
      },
      "Duration of the written frames, e.g. 10s");
  app.add_option("--fps", frames.fps, "Frames a second, with --duration [25]")->check(within(1e-3, 1e3));
  app.add_option("--preview", frames.preview, "View of a person who faces the surfaces, .png");
  add_parsed(
      app, "--viewer", [&](const std::string& text) { flags.eye = io::parse_position(text); },
      "Position of the viewer's eye, each number with a unit, in the world (in the rig if no "
      "surface is in the world): objects of --virtual are drawn with the right parallax for this "
      "eye, behind or in front of the surfaces");
  app.add_option("--virtual", flags.things,
                 "With --viewer: definitions of the virtual surfaces, .json or .xml; --content, --fit and "
                 "--crop then name these, and --surfaces are what the light falls on");
  declare_blend(app, flags.blend);
  app.add_option(
      "--weights", frames.weights,
      "Also write the projector's share of the light in each pixel, .png (8 bits) or .pfm (floats)");
  app.add_option("--gamma", frames.gamma, "Gamma of the projector: light = value^gamma (default: sRGB)")
      ->check(within(0.2, 5));
  app.add_option("--threads", frames.rendering.threads, "Number of threads; 0: one for each core")
      ->check(CLI::Range(0, limits::kThreads));
  app.add_option("--renderer", frames.renderer, "cpu, or gl for OpenGL without a window: the same frame")
      ->check(CLI::IsMember({"cpu", "gl"}))
      ->capture_default_str();
  app.add_flag("--average-numbers", flags.encoded,
               "Average pixel values instead of light (for codes and masks)");
}

/// The surfaces that content lies on.
std::vector<Surface> surfaces_of(const Flags& flags, const SolvedSurfaceSet& solved) {
  if (!flags.things.empty()) return io::load_surfaces(flags.things).surfaces;
  std::vector<Surface> surfaces;
  for (const SolvedSurface& one : solved.surfaces) surfaces.push_back(one.surface);
  return surfaces;
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

ExitCode draw(Flags flags, Console& console) {
  if (flags.eye.has_value() == flags.things.empty())
    throw Error(ErrorKind::kInput, flags.eye ? "--viewer" : "--virtual",
                flags.eye ? "no virtual surfaces are given" : "no viewer is given",
                flags.eye ? "add --virtual things.json" : "add --viewer X,Y,Z");
  const Rig rig = io::load_rig(flags.rig);
  const SolvedSurfaceSet solved = io::load_solved_surfaces(flags.surfaces);
  Diagnostics diagnostics;
  show::FrameFilesOptions& frames = flags.frames;
  const std::vector<Surface> surfaces = surfaces_of(flags, solved);
  std::vector<std::string> names;
  for (const Surface& surface : surfaces) names.push_back(surface.name);
  frames.contents = named_texts("--content", flags.content, names, "wall=wall.png");
  const NamedTexts fits = named_texts("--fit", flags.fit, names, "wall=cover"),
                   crops = named_texts("--crop", flags.crop, names, "wall=0.25,0,0.75,1");
  for (const Surface& surface : surfaces) frames.layouts[surface.name] = layout_of(surface, fits, crops);
  frames.folder = std::filesystem::absolute(flags.surfaces).parent_path();
  if (flags.eye) frames.viewer = show::ViewerInput{*flags.eye, flags.things};
  frames.rendering.linear_light = !flags.encoded;
  if (flags.blend.given() || frames.gamma > 0 || !frames.weights.empty())
    frames.blend = blend_for(flags.blend, rig, solved, diagnostics);
  show::FrameFilesReport report = show::write_frames(rig, solved, frames, [&](int done, int total) {
    if (total > 1) console.progress("frame", done + 1, total);
  });
  report.diagnostics.append(diagnostics);

  Summary& summary = console.summary();
  for (std::size_t i = 0; i < report.surfaces.size(); ++i)
    console.say(report.surfaces[i] + ": " + report.contents[i]);
  if (frames.renderer == "gl") console.say("drawn by " + report.device);
  if (report.seen_share) {
    const ImageSize size = report.viewer_size;
    console.say(format("the viewer's image: %dx%d; of the light on the surfaces %.1f %% is in sight",
                       size.width, size.height, 100 * *report.seen_share));
    summary.set("/viewer/seen_share", *report.seen_share);
    summary.set("/viewer/picture", std::vector<double>{double(size.width), double(size.height)});
  }
  console.report(report.diagnostics);
  summary.set("/projector", solved.projector);
  summary.set("/surfaces", report.surfaces);
  summary.set("/renderer", report.device);
  summary.set("/frames", report.frames);
  summary.set("/files", report.files);
  for (const std::string& file : report.files) console.say("wrote " + file);
  return exit_code(report.diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"render-to-image",
       "Draws the frames that a projector must show so that images, videos and colours appear "
       "undistorted on solved surfaces; blends them with those of other projectors."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return draw(flags, console); });
}
