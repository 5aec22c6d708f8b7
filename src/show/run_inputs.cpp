#include "run_inputs.hpp"

#include <filesystem>

#include "depth_surfaces.hpp"
#include "marker_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/text.hpp"
#include "procam/track/head_angles.hpp"
#include "run_options.hpp"

namespace procam::show {
namespace {

namespace fs = std::filesystem;

/// The region of a shape, which the camera must have.
std::optional<depth::PixelRegion> shape_region(const DepthSurfaces& named, const RigCamera& camera) {
  if (!named.region) return std::nullopt;
  const depth::PixelRegion& r = *named.region;
  const ImageSize size = camera.camera.size;
  if (r.width < 8 || r.height < 8 || r.x + r.width > size.width || r.y + r.height > size.height || r.x < 0 ||
      r.y < 0)
    throw Error(ErrorKind::kInput,
                "region of " + std::to_string(r.width) + "x" + std::to_string(r.height) + " pixels",
                "it is smaller than 8x8 pixels, or not inside of the " + io::format_size(size) +
                    " pixels of camera '" + camera.name + "'",
                "give region=X:Y:WIDTHxHEIGHT inside of the depth image");
  return r;
}

const SolvedSurface& solved_surface(const SolvedSurfaceSet& solved, const std::string& name) {
  for (const SolvedSurface& surface : solved.surfaces)
    if (surface.surface.name == name) return surface;
  throw Error(ErrorKind::kInput, "track '" + name + "'", "the surface file has no surface of this name",
              "name one of its surfaces");
}

/// An edge of the content, as the surface file has it.
track::Hinge hinge_of(const SolvedSurface& surface, const std::string& edge, const RigProjector& projector,
                      bool projector_stands) {
  const auto* plane = std::get_if<PlacedPlane>(&surface.placement);
  const InRoom* place = place_of(surface.surface.geometry);
  if (plane == nullptr || place == nullptr || (place->frame == "world" && !projector_stands))
    throw Error(ErrorKind::kInput, "hinge of '" + surface.surface.name + "'",
                "it is no plane with a fixed place before the rig",
                "place it in the rig, or in the world with --pose");
  const bool is_upright = edge == "left" || edge == "right";
  const Vec2 begin(edge == "right" ? 1 : 0, edge == "bottom" ? 1 : 0);
  const Vec2 end = begin + (is_upright ? Vec2(0, 1) : Vec2(1, 0));
  const auto on_plane = [&](const Vec2& uv) {
    const Vec3 h = plane->plane_from_content * uv.homogeneous();
    return Vec3(h.x() / h.z(), h.y() / h.z(), 0);
  };
  track::Hinge hinge;
  hinge.rig_from_closed = projector.rig_from_projector * plane->projector_from_surface;
  hinge.point = on_plane(begin);
  hinge.direction = (on_plane(end) - hinge.point).normalized();
  return hinge;
}

}  // namespace

std::unique_ptr<DepthSurfaceSource> watch_room(const ShowOptions& options, const Rig& rig,
                                               const ProjectionOptions& projection) {
  const DepthInput& depth = options.depth;
  DepthSurfaceSourceOptions watch;
  watch.room.camera = rig.camera(depth.camera);
  watch.room.metres_per_unit = depth.metres_per_unit;
  watch.room.delay = depth.delay_s;
  watch.room.track = projection.track;
  watch.room.child_from_rig = projection.child_from_rig;
  if (projection.projector_from_world)
    watch.room.world_from_rig =
        (rig.projector(projection.projector).rig_from_projector * *projection.projector_from_world).inverse();
  watch.room.map.up_in_world = depth.up.value_or(rig_is_world(options) ? Vec3(0, -1, 0) : Vec3(0, 0, 1));
  if (depth.silhouettes)
    watch.room.silhouettes =
        is_shape_source(options.surfaces) ? shape_silhouettes() : people::SilhouetteOptions();
  // The loss of the camera is handled as that of the poses.
  watch.lost_after = projection.track.stale_after;
  watch.blank_on_loss = projection.blank_on_stale;
  const DepthSurfaces named = parse_depth_surfaces(options.surfaces);
  if (named.is_shape) watch.room.shape.emplace().region = shape_region(named, watch.room.camera);
  device::DepthOptions opening;
  opening.size = watch.room.camera.camera.size;
  return std::make_unique<DepthSurfaceSource>(
      [source = named.source, opening] { return device::open_depth(source, opening); }, watch);
}

std::unique_ptr<track::PoseSource> open_poses(const ShowOptions& options, const std::string& text) {
  const io::Mount mount = options.mount.empty() ? io::Mount() : io::load_mount(options.mount);
  const std::string angles = "pan-tilt:";
  const bool of_head = text.rfind(angles, 0) == 0;
  if (of_head && !mount.axes)
    throw Error(ErrorKind::kInput, "pose source '" + text + "'",
                options.mount.empty() ? "the axes of the head are not given"
                                      : options.mount + " has no axes of a head",
                "give the file of calibrate-mount --pan-tilt as --mount");
  if (mount.axes && !of_head)
    throw Error(ErrorKind::kInput, "pose source '" + text + "'", options.mount + " is of a pan-tilt head",
                "give the source of its angles, e.g. --pose-source pan-tilt:udp:9000");
  if (of_head)
    return track::open_head_source(text.substr(angles.size()),
                                   {*mount.axes, mount.world_from_base.value_or(Pose())});
  std::unique_ptr<track::PoseSource> source = dds::open_pose_source(text);
  if (mount.world_from_base) source = track::moved_source(std::move(source), *mount.world_from_base);
  return source;
}

std::unique_ptr<track::PoseSource> open_markers(const MarkerInput& input, const Rig& rig) {
  if (input.marker.empty() && input.markers.empty())
    throw Error(ErrorKind::kInput, "marker camera", "no marker is named", "give a marker or a marker map");
  const MarkerMap map =
      input.marker.empty() ? io::load_marker_map(input.markers) : io::parse_marker(input.marker);
  const RigCamera& camera = rig.camera(input.name);
  device::CameraOptions options;
  options.size = camera.camera.size;
  const auto open = [name = input.camera, options] { return device::open_camera(name, options); };
  return std::make_unique<MarkerSource>(open(), camera, map, detect::marker_cells(map.dictionary), open);
}

/// run.log: watch.csv; another.log: another_watch.csv, so that recordings in one folder keep theirs.
std::string watch_log_beside(const std::string& record) {
  const fs::path log = fs::absolute(record);
  const std::string stem = log.stem().string();
  return (log.parent_path() / (stem == "run" ? "watch.csv" : stem + "_watch.csv")).string();
}

std::unique_ptr<LightWatch> watch_light(const ShowOptions& options, const Rig& rig, bool stands) {
  const WatchInput& input = *options.watch;
  LightWatchOptions watching;
  watching.camera = rig.camera(input.name);
  watching.projector = rig.projector(options.projector);
  watching.camera_delay = input.delay_s;
  watching.corrects = !input.only;
  watching.correction.surfaces = stands;
  watching.rig = rig;
  watching.save = input.save;
  if (input.pose_m > 0) {
    constexpr double kPosePeriod = 0.1;  // seconds; a robot moves on
    watching.watch.locates_rig = true;
    watching.period = kPosePeriod;
    if (!input.markers.empty()) watching.markers = io::load_marker_map(input.markers);
  }
  watching.watch.movement.projector_covariance =
      watch::projector_covariance(rig, watching.projector.name, watching.camera.name);
  if (!options.record.empty()) watching.log = watch_log_beside(options.record);
  device::CameraOptions opening;
  opening.size = watching.camera.camera.size;
  return std::make_unique<LightWatch>(
      [name = input.camera, opening] { return device::open_camera(name, opening); }, watching);
}

std::unique_ptr<SurfaceSource> open_sights(const ShowOptions& options, const Rig& rig,
                                           const MovingOptions& moving, const SolvedSurfaceSet& solved) {
  const TrackInput& input = *options.track;
  SurfaceSourceOptions sights;
  sights.camera = rig.camera(input.name);
  sights.readout_s = input.readout_s;
  for (const MovingSurface& what : moving.surfaces) {
    for (const std::string& name : what.surfaces) solved_surface(solved, name);
    MarkedSurface surface{what.surfaces.front(), what.markers};
    std::string key;
    for (const std::string& name : what.surfaces) key += (key.empty() ? "" : ",") + name;
    const auto edge = input.hinges.find(key);
    if (edge != input.hinges.end())
      surface.hinge = hinge_of(solved_surface(solved, surface.name), edge->second,
                               rig.projector(options.projector), !options.pose.empty());
    sights.surfaces.push_back(std::move(surface));
  }
  device::CameraOptions opening;
  opening.size = sights.camera.camera.size;
  const auto open = [name = input.camera, opening] { return device::open_camera(name, opening); };
  return std::make_unique<SurfaceSource>(open(), sights, open);
}

ControlOptions control_options(const ShowOptions& options) {
  ControlOptions control = parse_page_address(options.control);
  control.token = options.token;
  return control;
}

}  // namespace procam::show
