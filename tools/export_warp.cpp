/// export-warp: solved.json + rig.json -> one surface's warp as a file for another program.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "common/blend_flags.hpp"
#include "common/cli.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/io/exchange/mpcdi.hpp"
#include "procam/io/exchange/warp_file.hpp"
#include "procam/io/exchange/world_axes.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/surface/warp.hpp"

namespace procam::tools {
namespace {

struct Flags {
  BlendFlags blend;
  std::string rig, surfaces, surface, output;
  std::optional<io::MpcdiProfile> profile;
  std::optional<io::WorldUp> up;
  std::optional<surface::MeshGrid> grid;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  app.add_option("--surfaces", flags.surfaces, "Solved surfaces of solve-surfaces")->required();
  app.add_option("--surface", flags.surface,
                 "Name of the surface, for a file with several; without it an .mpcdi of positions holds all");
  app.add_option("-o,--output", flags.output,
                 "A map (.pfm, .png as 16-bit ST map, or .exr), a mesh (.obj), or an archive (.mpcdi)")
      ->required();
  add_parsed(
      app, "--profile", [&](const std::string& text) { flags.profile = io::parse_mpcdi_profile(text); },
      "Profile of an .mpcdi: 2d (content of each pixel), sl (shader lamp: frustum, pose and "
      "positions) or a3 (positions) [2d]");
  add_parsed(
      app, "--world-up", [&](const std::string& text) { flags.up = io::parse_world_up(text); },
      "Upward axis of the world, for an .mpcdi with positions: z (as in ROS), y or -y [z; -y if the "
      "surfaces are in the frame of the rig]");
  add_parsed(
      app, "--grid",
      [&](const std::string& text) {
        const ImageSize cells = io::parse_size(text);
        if (cells.width > 1024 || cells.height > 1024)
          throw Error(ErrorKind::kInput, "'" + text + "'", "it has more than 1024 cells a side",
                      "give e.g. 64x36");
        flags.grid = surface::MeshGrid{cells.width, cells.height};
      },
      "Cells of an .obj of a plane: across and down [64x36]");
  app.add_option("--blend-with", flags.blend.others,
                 "Solved surfaces of another projector of the rig, once for each: the alpha of an .mpcdi is "
                 "this projector's share of the light");
}

std::string extension_of(const Flags& flags) {
  std::string extension = std::filesystem::path(flags.output).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return extension;
}

/// Flags that the file's kind would ignore are refused: whoever gave them expects something of them.
void require_fitting_flags(const Flags& flags, const std::string& extension) {
  const auto refuse = [](const char* flag, const char* extension_wanted) {
    throw Error(ErrorKind::kInput, flag, std::string("it is for ") + extension_wanted + " files alone",
                "leave it out, or name another output");
  };
  if (flags.profile && extension != ".mpcdi") refuse("--profile", ".mpcdi");
  if (flags.up && extension != ".mpcdi") refuse("--world-up", ".mpcdi");
  if (flags.grid && extension != ".obj") refuse("--grid", ".obj");
  if (flags.blend.given() && extension != ".mpcdi") refuse("--blend-with", ".mpcdi");
}

const SolvedSurface& pick(const SolvedSurfaceSet& solved, const std::string& name) {
  std::string known;
  for (const SolvedSurface& candidate : solved.surfaces) {
    if (candidate.surface.name == name || (name.empty() && solved.surfaces.size() == 1)) return candidate;
    known += (known.empty() ? "" : ", ") + candidate.surface.name;
  }
  throw Error(ErrorKind::kInput, name.empty() ? "solved surfaces" : "surface '" + name + "'",
              name.empty() ? "there is not exactly one, and such a file holds the coordinates of one content"
                           : "there is none of that name",
              "give --surface with one of: " + known +
                  (name.empty() ? "; an .mpcdi of positions (--profile sl or a3) holds all of them" : ""));
}

/// Where the projector stands in the axes of MPCDI files: x right, y up, z backward.
Pose mpcdi_from_projector(const Flags& flags, const SolvedSurfaceSet& solved, const RigProjector& projector,
                          Diagnostics& diagnostics) {
  Pose world_from_projector = projector.rig_from_projector;
  io::WorldUp up = io::WorldUp::kMinusY;
  if (solved.projector_from_world) {
    world_from_projector = solved.projector_from_world->inverse();
    up = io::WorldUp::kZ;
  } else {
    diagnostics.note("rig_is_world",
                     "no surface is placed in a world: the positions in the file are those of the rig");
  }
  const Mat3 mpcdi_from_world =
      io::program_from_world({Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitZ()}, flags.up.value_or(up));
  return Pose(mpcdi_from_world, Vec3::Zero()) * world_from_projector;
}

void write_mpcdi(const Flags& flags, const Rig& rig, const surface::VisiblePart& part,
                 const RigProjector& projector, Diagnostics& diagnostics) {
  io::Mpcdi mpcdi;
  mpcdi.profile = flags.profile.value_or(io::MpcdiProfile::k2d);
  mpcdi.date = utc_now();
  io::MpcdiRegion region;
  region.buffer = region.id = projector.name;
  region.size = projector.projector.size();
  std::optional<surface::BlendMap> blend;
  if (flags.blend.given())
    blend = std::move(blend_for(flags.blend, rig, part.solved, diagnostics).maps.front());
  region.alpha = surface::alpha_map(part, blend ? &blend->weight : nullptr);
  if (mpcdi.profile == io::MpcdiProfile::k2d) {
    region.warp = surface::warp_map(part, projector.projector);
  } else {
    const Pose file_from_projector = mpcdi_from_projector(flags, part.solved, projector, diagnostics);
    region.positions = surface::position_map(part, projector.projector, file_from_projector);
    if (mpcdi.profile == io::MpcdiProfile::kShaderLamps)
      diagnostics.append(io::set_projector(region, projector.projector, file_from_projector));
  }
  mpcdi.regions.push_back(std::move(region));
  io::save_mpcdi(flags.output, mpcdi);
}

void write_mesh(const Flags& flags, const Placement& placement, const Projector& projector, Console& console,
                Diagnostics& diagnostics) {
  const auto [mesh, error_px] =
      surface::warp_mesh(placement, projector, flags.grid.value_or(surface::MeshGrid{}));
  io::save_warp_mesh(flags.output, mesh);
  console.say(
      format("%zu triangles, between their corners right to %.3f px", mesh.triangles.size(), error_px));
  console.summary().set("/triangles", int(mesh.triangles.size()));
  console.summary().set("/mesh_error_px", error_px);
  if (error_px > 0.25)
    diagnostics.warn("coarse_mesh",
                     format("between the mesh's corners pixels are up to %.2f off", error_px) +
                         (std::holds_alternative<PlacedMesh>(placement) ? "; draw through a map instead"
                                                                        : "; give a finer --grid"));
}

ExitCode export_warp(const Flags& flags, Console& console) {
  const std::string extension = extension_of(flags);
  require_fitting_flags(flags, extension);
  const Rig rig = io::load_rig(flags.rig);
  const SolvedSurfaceSet solved = io::load_solved_surfaces(flags.surfaces);
  const RigProjector& projector = rig.projector(solved.projector);
  const bool positions = flags.profile && *flags.profile != io::MpcdiProfile::k2d;
  const SolvedSurface* const chosen =
      positions && flags.surface.empty() ? nullptr : &pick(solved, flags.surface);
  const std::string what = chosen ? chosen->surface.name : "all surfaces";

  Diagnostics diagnostics;
  const surface::VisiblePart part(solved, projector.projector, chosen);
  const double share = part.share();
  if (share == 0)
    throw Error(ErrorKind::kDegenerate, chosen ? "surface '" + what + "'" : what,
                "none of the projector's pixels shows anything of it",
                "see what solve-surfaces says of it, and move the projector or the surface");
  if (extension == ".obj")
    write_mesh(flags, chosen->placement, projector.projector, console, diagnostics);
  else if (extension == ".mpcdi")
    write_mpcdi(flags, rig, part, projector, diagnostics);
  else
    io::save_warp_map(flags.output, surface::warp_map(part, projector.projector));

  console.say(format("%s: %.1f %% of the projector's pixels show it", what.c_str(), 100 * share));
  console.say("wrote " + flags.output);
  console.report(diagnostics);
  console.summary().set("/projector", projector.name);
  console.summary().set("/surface", what);
  console.summary().set("/shown_share", share);
  console.summary().set("/files", std::vector<std::string>{flags.output});
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"export-warp",
       "Writes the warp of a solved surface for another program: a map, a mesh or an MPCDI archive."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return export_warp(flags, console); });
}
