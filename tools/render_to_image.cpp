/// render-to-image: solved.json + rig.json + pictures -> the projector's frame (and what the room looks
/// like).
#include <CLI/CLI.hpp>
#include <deque>
#include <filesystem>
#include <map>

#include "common/cli.hpp"
#include "procam/io/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/render/preview.hpp"
#include "procam/render_gl/gl.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, surfaces, output, preview, renderer = "cpu";
  std::vector<std::string> content;
  int threads = 0;
  bool encoded = false;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json, as calibrate-projector writes it")->required();
  app.add_option("--surfaces", flags.surfaces, "solved surfaces, as solve-surfaces writes them")->required();
  app.add_option(
      "--content", flags.content,
      "SURFACE=PICTURE, once a surface (png, jpg, bmp, tif; alpha is kept); else the surface file's own");
  app.add_option("-o,--output", flags.output, "the projector's frame, .png")->required();
  app.add_option("--preview", flags.preview, "what a person facing the surfaces would see, .png");
  app.add_option("--threads", flags.threads, "0: as many as the machine has")->check(CLI::NonNegativeNumber);
  app.add_option("--renderer", flags.renderer, "cpu, or gl for OpenGL without a window: the same picture")
      ->check(CLI::IsMember({"cpu", "gl"}))
      ->capture_default_str();
  app.add_flag("--average-numbers", flags.encoded,
               "average pixel values as they stand instead of the light they stand for (codes, masks)");
}

/// Surface name -> picture file: from --content, else from the surface file (relative to it).
std::map<std::string, std::string> content_files(const Flags& flags, const SolvedSurfaceSet& solved) {
  std::map<std::string, std::string> files;
  for (const SolvedSurface& surface : solved.surfaces) {
    const std::filesystem::path file = surface.surface.content;
    files[surface.surface.name] =
        file.empty() ? "" : (std::filesystem::path(flags.surfaces).parent_path() / file).string();
  }
  std::map<std::string, bool> given;
  for (const std::string& item : flags.content) {
    const std::size_t equals = item.find('=');
    const std::string name = item.substr(0, equals);
    const std::string what = "--content " + item;
    if (equals == std::string::npos || equals == 0 || equals + 1 == item.size())
      throw Error(ErrorKind::kInput, what, "it does not read SURFACE=PICTURE",
                  "write e.g. --content wall=wall.png");
    if (files.count(name) == 0) {
      std::string known;
      for (const auto& [surface, file] : files) known += (known.empty() ? "" : ", ") + surface;
      throw Error(ErrorKind::kInput, what, "no surface is named '" + name + "'", "name one of: " + known);
    }
    if (given[name])
      throw Error(ErrorKind::kInput, what, "the surface is given two pictures", "give one a surface");
    given[name] = true;
    files[name] = item.substr(equals + 1);
  }
  return files;
}

ExitCode draw(const Flags& flags, Console& console) {
  const Rig rig = io::load_rig(flags.rig);
  const SolvedSurfaceSet solved = io::load_solved_surfaces(flags.surfaces);
  const Projector& projector = rig.projector(solved.projector).projector;
  const std::map<std::string, std::string> files = content_files(flags, solved);

  std::deque<ImageU8> pictures;  // stay where they are while the scene looks at them
  Scene scene;
  Diagnostics diagnostics;
  std::vector<std::string> drawn;
  for (const SolvedSurface& surface : solved.surfaces) {
    const std::string& name = surface.surface.name;
    const std::string& file = files.at(name);
    if (file.empty()) {
      diagnostics.warn("no_content", "surface '" + name + "' has no picture and stays dark; give --content " +
                                         name + "=picture.png");
      continue;
    }
    io::LoadedImage loaded = io::load_image(file);
    diagnostics.append(loaded.diagnostics);
    pictures.push_back(std::move(loaded.image));
    scene.items.push_back({surface.placement, pictures.back().view()});
    drawn.push_back(name);
    console.say(name + ": " + file + ", " + std::to_string(pictures.back().width()) + "x" +
                std::to_string(pictures.back().height()));
  }

  render::RenderOptions options;
  options.threads = flags.threads;
  options.linear_light = !flags.encoded;
  ImageU8 frame(projector.size(), 3);
  std::string drawn_by = "cpu";
  if (flags.renderer == "gl") {
    render_gl::GlRenderer renderer(options);
    renderer.render(scene, projector, frame);
    drawn_by = renderer.device();
    console.say("drawn by " + drawn_by);
  } else {
    render::render(scene, projector, frame, options);
  }
  std::optional<ImageU8> view;
  if (!flags.preview.empty()) {
    if (const auto viewpoint = render::facing_viewpoint(scene))
      view = render::preview(scene, projector, frame, *viewpoint, options);
    else
      diagnostics.warn("no_preview",
                       "no planar surface is drawn, so there is no room to look at: the preview is "
                       "not written; place surfaces in metres to see them");
  }

  std::vector<std::string> written{flags.output};
  io::save_image(flags.output, frame);
  if (view) {
    io::save_image(flags.preview, *view);
    written.push_back(flags.preview);
  }
  console.report(diagnostics);
  console.summary().set("/projector", solved.projector);
  console.summary().set("/surfaces", drawn);
  console.summary().set("/renderer", drawn_by);
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
       "draws pictures onto solved surfaces, through the projector's lens, into the frame it must show.",
       "render-to-image --rig rig.json --surfaces solved.json --content wall=picture.png -o frame.png"},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return draw(flags, console); });
}
