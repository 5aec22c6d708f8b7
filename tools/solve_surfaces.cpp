/// solve-surfaces: surfaces.json + rig.json (+ pose.json) -> solved.json.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/cli.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/device/content_source.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/surface/solve.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, surfaces, pose, projector, output;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  app.add_option("--surfaces", flags.surfaces, "Surface definitions, .json or .xml")->required();
  app.add_option(
      "--pose", flags.pose,
      "pose.json between 'world' and 'projector', 'rig' or a camera of the rig; needed for surfaces "
      "in the world");
  app.add_option("--projector", flags.projector, "Name of the device, for a rig with several");
  app.add_option("-o,--output", flags.output, "Solved surfaces, .json or .xml")->required();
}

void print_table(const SolvedSurfaceSet& solved, Console& console) {
  console.say(format("%-20s %8s %10s %16s %12s  %s", "surface", "covered", "incidence", "mm per pixel", "rms",
                     "remarks"));
  for (const SolvedSurface& surface : solved.surfaces) {
    const bool in_room = !std::holds_alternative<PlacedPixels>(surface.placement);
    const Visibility& look = surface.visibility;
    const std::string incidence = in_room ? format("%.1f deg", look.incidence_deg) : "-";
    const std::string size = in_room && look.mm_per_pixel_max > 0
                                 ? format("%.3f..%.3f", look.mm_per_pixel_min, look.mm_per_pixel_max)
                                 : "-";
    const std::string rms = surface.residuals.empty() ? "-"
                            : in_room                 ? format("%.3f mm", 1e3 * surface.rms)
                                                      : format("%.3f px", surface.rms);
    std::string remarks;
    for (const Diagnostic& item : surface.diagnostics.items)
      remarks += (remarks.empty() ? "" : ", ") + item.code;
    console.say(format("%-20s %6.1f %% %10s %16s %12s  ", surface.surface.name.c_str(),
                       100 * look.covered_share, incidence.c_str(), size.c_str(), rms.c_str()) +
                (remarks.empty() ? "ok" : remarks));
  }
}

void summarize(const SolvedSurfaceSet& solved, const Flags& flags, Summary& summary) {
  summary.set("/projector", solved.projector);
  for (std::size_t i = 0; i < solved.surfaces.size(); ++i) {
    const SolvedSurface& surface = solved.surfaces[i];
    const std::string at = "/surfaces/" + std::to_string(i);
    summary.set(at + "/name", surface.surface.name);
    summary.set(at + "/covered_share", surface.visibility.covered_share);
    if (std::holds_alternative<PlacedPlane>(surface.placement))
      summary.set(at + "/rms_mm", 1e3 * surface.rms);
    if (std::holds_alternative<PlacedPixels>(surface.placement)) {
      if (!surface.residuals.empty()) summary.set(at + "/rms_px", surface.rms);
      continue;
    }
    summary.set(at + "/incidence_deg", surface.visibility.incidence_deg);
    summary.set(at + "/facing", surface.visibility.facing);
    summary.set(at + "/mm_per_pixel", std::vector<double>{surface.visibility.mm_per_pixel_min,
                                                          surface.visibility.mm_per_pixel_max});
  }
  summary.set("/files", std::vector<std::string>{flags.output});
}

/// Files are named beside the file that names them, which is now another one.
std::string beside(const std::string& file, const std::string& from, const std::string& to) {
  const std::filesystem::path path = file;
  if (file.empty() || path.is_absolute()) return file;
  const auto folder_of = [](const std::string& name) {
    return std::filesystem::absolute(name).parent_path().lexically_normal();
  };
  return (folder_of(from) / path).lexically_normal().lexically_relative(folder_of(to)).generic_string();
}

ExitCode solve(const Flags& flags, Console& console) {
  const Rig rig = io::load_rig(flags.rig);
  const RigProjector& projector = rig.projector(flags.projector);
  SurfaceSet surfaces = io::load_surfaces(flags.surfaces);
  for (Surface& surface : surfaces.surfaces) {
    if (const auto file = device::content_file(surface.content))
      surface.content =
          device::with_content_file(surface.content, beside(*file, flags.surfaces, flags.output));
    surface.shape.mask_file = beside(surface.shape.mask_file, flags.surfaces, flags.output);
    if (auto* mesh = std::get_if<MeshSurface>(&surface.geometry))
      mesh->file = beside(mesh->file, flags.surfaces, flags.output);
  }
  std::optional<Pose> pose;
  if (!flags.pose.empty())
    pose = room_frames(rig, projector, io::load_pose(flags.pose)).get(projector.name, "world").pose;

  const SolvedSurfaceSet solved = surface::solve_surfaces(surfaces, projector, pose);
  const Diagnostics diagnostics = surface::diagnostics_of(solved);
  io::save_solved_surfaces(flags.output, solved);

  print_table(solved, console);
  summarize(solved, flags, console.summary());
  console.report(diagnostics);
  console.say("wrote " + flags.output);
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"solve-surfaces",
       "Computes the homography, the pose and the lit share of each surface for a projector."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return solve(flags, console); });
}
