#include "common/depth_room.hpp"

#include <CLI/CLI.hpp>
#include <sstream>

#include "common/cli.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

constexpr const char* kBeginning = "depth:";

}  // namespace

void declare_depth_room(CLI::App& app, DepthRoomFlags& flags) {
  app.add_option("--depth-camera", flags.camera, "with --surfaces depth: its name in the rig, for several");
  add_parsed(
      app, "--depth-scale",
      [&](const std::string& text) {
        flags.scale = io::parse_length(text);
        if (!(flags.scale > 0 && flags.scale < 1))
          throw Error(ErrorKind::kInput, "'" + text + "'", "one step of a depth picture cannot be that long",
                      "give the unit of its numbers, e.g. 1mm, or 0.2mm for 1/5000 m");
      },
      "unit of a depth picture's 16-bit numbers, where no sensor states it (default: 1mm)");
  add_parsed(
      app, "--depth-delay",
      [&](const std::string& text) {
        flags.delay = io::parse_duration(text);
        if (!(flags.delay >= 0 && flags.delay < 10))
          throw Error(ErrorKind::kInput, "'" + text + "'", "no camera is that late", "give e.g. 30ms");
      },
      "from a depth picture's exposure to its arrival, e.g. 30ms");
  add_parsed(
      app, "--up",
      [&](const std::string& text) {
        std::istringstream in(text);
        Vec3 up;
        char first = 0, second = 0;
        if (!(in >> up.x() >> first >> up.y() >> second >> up.z()) || first != ',' || second != ',' ||
            !in.eof() || !up.allFinite() || !(up.norm() > 1e-6))
          throw Error(ErrorKind::kInput, "'" + text + "'", "it is not a direction",
                      "give three numbers, e.g. 0,0,1 for a world whose z points up");
        flags.up = up;
      },
      "which way is up in the world, x,y,z (default: 0,0,1; without poses 0,-1,0, the rig's)");
  app.add_flag("--silhouettes", flags.silhouettes,
               "with --surfaces depth: objects in front of the room are masked, people as a "
               "whole; dark while depth is silent");
}

bool is_depth_room(const std::string& surfaces) {
  return surfaces.rfind(kBeginning, 0) == 0;
}

std::unique_ptr<show::DepthSurfaceSource> watch_room(const std::string& surfaces, const DepthRoomFlags& flags,
                                                     const Rig& rig,
                                                     const show::ProjectionOptions& projection,
                                                     bool rig_is_world) {
  show::DepthSurfaceSourceOptions options;
  options.room.camera = rig.camera(flags.camera);
  options.room.metres_per_unit = flags.scale;
  options.room.delay = flags.delay;
  options.room.track = projection.track;
  options.room.child_from_rig = projection.child_from_rig;
  if (projection.projector_from_world)
    options.room.world_from_rig =
        (rig.projector(projection.projector).rig_from_projector * *projection.projector_from_world).inverse();
  options.room.map.up_in_world = flags.up.value_or(rig_is_world ? Vec3(0, -1, 0) : Vec3(0, 0, 1));
  if (flags.silhouettes) options.room.silhouettes.emplace();
  options.lost_after = projection.track.stale_after;
  options.blank_on_loss = projection.blank_on_stale;
  const std::string source = surfaces.substr(std::string(kBeginning).size());
  device::DepthOptions opening;
  opening.size = options.room.camera.camera.size;
  return std::make_unique<show::DepthSurfaceSource>(
      [source, opening] { return device::open_depth(source, opening); }, options);
}

}  // namespace procam::tools
