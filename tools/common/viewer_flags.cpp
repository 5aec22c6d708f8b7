#include "common/viewer_flags.hpp"

#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/surface/solve.hpp"

namespace procam::tools {
namespace {

/// "0.4m,-120mm,2m"
Vec3 parse_place(const std::string& text) {
  Vec3 place;
  std::size_t from = 0;
  for (int k = 0; k < 3; ++k) {
    const std::size_t comma = text.find(',', from);
    if ((comma == std::string::npos) != (k == 2))
      throw Error(ErrorKind::kInput, "'" + text + "'", "it is not X,Y,Z",
                  "give three lengths with their units: 0.4m,-120mm,2m");
    place[k] = io::parse_length(text.substr(from, comma - from));
    from = comma + 1;
  }
  return place;
}

}  // namespace

void declare_viewer(CLI::App& app, ViewerFlags& flags) {
  add_parsed(
      app, "--viewer", [&](const std::string& text) { flags.eye = parse_place(text); },
      "X,Y,Z of an eye, each with its unit, in the world (in the rig where the surfaces are not placed in a "
      "world): what --virtual holds is drawn so that it stands there for this eye, behind the surfaces or "
      "before them");
  app.add_option("--virtual", flags.things,
                 "with --viewer: surface definitions, .json or .xml, of what is seen; --content, --fit and "
                 "--crop then name these, and the surfaces of --surfaces only catch the light");
}

void check_viewer(const ViewerFlags& flags) {
  if (flags.given() == !flags.things.empty()) return;
  throw Error(ErrorKind::kInput, flags.given() ? "--viewer" : "--virtual",
              flags.given() ? "there is nothing to be seen" : "it is not said who looks",
              flags.given() ? "give --virtual things.json" : "give --viewer X,Y,Z");
}

Vec3 eye_in_projector(const ViewerFlags& flags, const RigProjector& projector, const SolvedSurfaceSet& real) {
  const Pose projector_from_eyes_frame =
      real.projector_from_world ? *real.projector_from_world : projector.rig_from_projector.inverse();
  return projector_from_eyes_frame * *flags.eye;
}

SolvedSurfaceSet solve_things(const ViewerFlags& flags, const RigProjector& projector,
                              const SolvedSurfaceSet& real) {
  const SurfaceSet things = io::load_surfaces(flags.things);
  for (const Surface& thing : things.surfaces)
    if (!place_of(thing.geometry))
      throw Error(ErrorKind::kInput, "surface '" + thing.name + "' of " + flags.things,
                  "it is given in projector pixels and has no place in the room", "define it in metres");
  return surface::solve_surfaces(things, projector, real.projector_from_world);
}

}  // namespace procam::tools
