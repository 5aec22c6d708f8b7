#include "common/stated_surface.hpp"

#include "procam/analyze/error_sources.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/surface/solve.hpp"
#include "procam/track/locate.hpp"

namespace procam::tools {
namespace {

/// Printed markers in the flat-lit picture.
KnownWorld world_by_markers(const std::string& file, const RigCamera& camera, const ImageU8& flat_lit) {
  const MarkerMap map = io::load_marker_map(file);
  const MarkerDetections detections =
      detect::detect_marker_edges(flat_lit, detect::marker_cells(map.dictionary), {camera.camera});
  const track::LocateResult seen = track::locate(detections, camera.camera, map);
  const Mat6 to_rig = adjoint(camera.rig_from_camera);
  KnownWorld world{
      {camera.rig_from_camera * seen.camera_from_world, to_rig * seen.covariance * to_rig.transpose()},
      MatX(6, seen.jacobian_lens.cols() + 6),
      detections.diagnostics};
  world.jacobian_camera << to_rig * seen.jacobian_lens, Mat6::Identity();
  world.diagnostics.append(seen.diagnostics);
  return world;
}

}  // namespace

/// The surface that the light falls on, in the file's set.
Surface& pick_surface(SurfaceSet& set, const std::string& wanted, const std::string& file) {
  std::string names;
  for (Surface& surface : set.surfaces) {
    if (surface.name == wanted || (wanted.empty() && set.surfaces.size() == 1)) return surface;
    names += (names.empty() ? "" : ", ") + surface.name;
  }
  throw Error(ErrorKind::kInput, file,
              wanted.empty() ? "it has " + std::to_string(set.surfaces.size()) + " surfaces"
                             : "it has no surface '" + wanted + "'",
              "name with --surface the one that the light falls on" + (names.empty() ? "" : ": " + names));
}

PlanarSurface& plane_of(Surface& surface) {
  auto* plane = std::get_if<PlanarSurface>(&surface.geometry);
  const char* why = !plane ? "it is given in projector pixels and has no place in the room"
                    : plane->frame == "projector"
                        ? "it is placed in the projector's own frame and moves with it"
                        : nullptr;
  if (why)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", why,
                "use a surface with points in metres, placed in the world or the rig");
  return *plane;
}

KnownWorld frame_of(const Surface& surface, const WorldFiles& files, const Rig& rig, const RigCamera& camera,
                    const RigProjector& projector, const ImageU8& flat_lit) {
  const std::string& frame = std::get<PlanarSurface>(surface.geometry).frame;
  if (frame == "rig" && files.markers.empty()) return {};
  if (frame == "rig")
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "it is placed in the rig, and --markers measure where the world is",
                "place it in the world of the markers, or leave --markers out");
  if (frame != "world")
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", "its frame '" + frame + "' is unknown",
                "place it in world or rig");
  if (!files.markers.empty()) return world_by_markers(files.markers, camera, flat_lit);
  if (files.pose.empty())
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", "it is placed in the world",
                "give its pose: --pose pose.json, or --markers markers.json when some show in the captures");
  return {room_frames(rig, projector, io::load_pose(files.pose)).get("rig", "world"), {}, {}};
}

analyze::StatedSurface state_surface(const Surface& surface, const PlanarSurface& plane,
                                     const KnownWorld& world, const io::LengthAndAngle& sigma) {
  analyze::StatedSurface stated{surface.name,
                                compose(world.rig_from_world, {plane.frame_from_surface, Mat6::Zero()}),
                                world.jacobian_camera};
  const Mat6 to_rig = adjoint(stated.rig_from_surface.pose);
  stated.rig_from_surface.covariance +=
      to_rig * analyze::isotropic_pose_covariance(sigma.length, sigma.angle) * to_rig.transpose();
  return stated;
}

/// Corners of the content on the surface, metres.
Points2 content_outline(const Surface& surface, const RigProjector& projector, const Pose& rig_from_world) {
  const SolvedSurfaceSet solved = surface::solve_surfaces(
      {{surface}}, projector, projector.rig_from_projector.inverse() * rig_from_world);
  const Mat3& map = std::get<PlacedPlane>(solved.surfaces.front().placement).plane_from_content;
  Points2 corners;
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)})
    corners.push_back(Vec3(map * Vec3(uv.x(), uv.y(), 1)).hnormalized());
  return corners;
}

}  // namespace procam::tools
