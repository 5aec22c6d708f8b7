#include "procam/surface/solve.hpp"

#include <set>

#include "pairs.hpp"
#include "visibility.hpp"

namespace procam::surface {

namespace {

void require_names(const SurfaceSet& set) {
  std::set<std::string> names;
  for (const Surface& surface : set.surfaces) {
    if (surface.name.empty())
      throw Error(ErrorKind::kInput, "surface " + std::to_string(&surface - set.surfaces.data()),
                  "it has no name", "give every surface a name of its own");
    if (!names.insert(surface.name).second)
      throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", "two surfaces have this name",
                  "give every surface a name of its own");
  }
}

Pose projector_from_frame(const Surface& surface, const std::string& frame, const RigProjector& projector,
                          const std::optional<Pose>& projector_from_world) {
  if (frame == "projector") return Pose::identity();
  if (frame == "rig") return projector.rig_from_projector.inverse();
  if (frame != "world")
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "it is placed in the unknown frame '" + frame + "'", "use world, rig or projector");
  if (!projector_from_world)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "it is in world coordinates, but the projector's pose is unknown",
                "give --pose pose.json with projector_from_world; locate-projector writes it");
  return *projector_from_world;
}

Pose projector_from(const Surface& surface, const InRoom& place, const RigProjector& projector,
                    const std::optional<Pose>& projector_from_world) {
  const Pose projector_from_surface =
      projector_from_frame(surface, place.frame, projector, projector_from_world) * place.frame_from_surface;
  if (!projector_from_surface.is_finite())
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", "its pose is not finite",
                "correct the pose");
  return projector_from_surface.normalized();
}

SolvedSurface solve(const Surface& surface, const PlanarSurface& planar, const RigProjector& projector,
                    const std::optional<Pose>& projector_from_world, const SolveOptions& options) {
  const Pose projector_from_surface = projector_from(surface, planar, projector, projector_from_world);
  const SolvedPairs pairs = solve_pairs(surface, planar.content, planar.points);
  SolvedSurface solved;
  solved.placement = PlacedPlane{pairs.destination_from_content, projector_from_surface};
  solved.rms = pairs.rms;
  solved.residuals = pairs.residuals;
  warn_of_outlying_pair(surface, planar.content, planar.points,
                        {1e-3, "mm", options.smallest_outlier_mm, options.false_alarm_rate},
                        solved.diagnostics);
  return solved;
}

SolvedSurface solve(const Surface& surface, const PixelSurface& pixel, const RigProjector&,
                    const std::optional<Pose>&, const SolveOptions& options) {
  SolvedSurface solved;
  if (pixel.is_curved()) {
    solved.placement = PlacedPixels{Mat3::Identity(), mesh_of(surface)};
    return solved;
  }
  const SolvedPairs pairs = solve_pairs(surface, pixel.content, pixel.pixels);
  solved.placement = PlacedPixels{pairs.destination_from_content};
  solved.rms = pairs.rms;
  solved.residuals = pairs.residuals;
  warn_of_outlying_pair(surface, pixel.content, pixel.pixels,
                        {1, "px", options.smallest_outlier_px, options.false_alarm_rate}, solved.diagnostics);
  return solved;
}

/// Every other shape has its own content coordinates.
template <typename Shape>
SolvedSurface solve(const Surface& surface, const Shape& shape, const RigProjector& projector,
                    const std::optional<Pose>& projector_from_world, const SolveOptions&) {
  SolvedSurface solved;
  solved.placement =
      PlacedMesh{mesh_of(surface), projector_from(surface, shape, projector, projector_from_world)};
  return solved;
}

/// Of the surfaces in this frame. Returns whether there is one.
bool move_surfaces(SolvedSurfaceSet& solved, const char* frame, const RigProjector& projector,
                   const std::optional<Pose>& projector_from_world) {
  bool is_any = false;
  for (SolvedSurface& surface : solved.surfaces) {
    const InRoom* place = place_of(surface.surface.geometry);
    if (place == nullptr || place->frame != frame) continue;
    const Pose moved = projector_from(surface.surface, *place, projector, projector_from_world);
    if (auto* plane = std::get_if<PlacedPlane>(&surface.placement)) plane->projector_from_surface = moved;
    if (auto* mesh = std::get_if<PlacedMesh>(&surface.placement)) mesh->projector_from_surface = moved;
    is_any = true;
  }
  return is_any;
}

}  // namespace

SolvedSurfaceSet solve_surfaces(const SurfaceSet& set, const RigProjector& projector,
                                const std::optional<Pose>& projector_from_world,
                                const SolveOptions& options) {
  require_names(set);
  SolvedSurfaceSet result;
  result.projector = projector.name;
  for (const Surface& surface : set.surfaces) {
    if (const auto fault = fault_of(surface.shape))
      throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", *fault,
                  "correct its outline, holes and mask");
    SolvedSurface solved = std::visit(
        [&](const auto& geometry) {
          return solve(surface, geometry, projector, projector_from_world, options);
        },
        surface.geometry);
    solved.surface = surface;
    if (options.visibility) look_at(projector.projector, options, solved);
    const InRoom* place = place_of(surface.geometry);
    if (place && place->frame == "world") result.projector_from_world = projector_from_world;
    result.surfaces.push_back(std::move(solved));
  }
  return result;
}

void move_in_rig(SolvedSurfaceSet& solved, const RigProjector& projector) {
  require(projector.rig_from_projector.is_finite(), "move_in_rig: the pose is not finite");
  move_surfaces(solved, "rig", projector, std::nullopt);
}

void move_to(SolvedSurfaceSet& solved, const RigProjector& projector, const Pose& projector_from_world) {
  require(projector_from_world.is_finite(), "move_to: the pose is not finite");
  if (move_surfaces(solved, "world", projector, projector_from_world))
    solved.projector_from_world = projector_from_world;
}

Diagnostics diagnostics_of(const SolvedSurfaceSet& solved) {
  Diagnostics all;
  for (const SolvedSurface& surface : solved.surfaces)
    for (Diagnostic item : surface.diagnostics.items) {
      item.message = "surface '" + surface.surface.name + "': " + item.message;
      all.items.push_back(std::move(item));
    }
  const auto is_unlit = [](const SolvedSurface& surface) {
    return surface.diagnostics.find("outside_picture") != nullptr;
  };
  if (!solved.surfaces.empty() && std::all_of(solved.surfaces.begin(), solved.surfaces.end(), is_unlit))
    all.fail("nothing_lit",
             "the projector lights none of the surfaces; check the pose, the rig and the surfaces' frame");
  return all;
}

}  // namespace procam::surface
