#include "procam/session/simulated.hpp"

#include <algorithm>

#include "condition_settings.hpp"
#include "new_folder.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/session/files.hpp"
#include "procam/session/patterns.hpp"
#include "procam/simulate/fleet.hpp"
#include "procam/simulate/marker_view.hpp"
#include "procam/simulate/scan_view.hpp"

namespace procam::session {
namespace fs = std::filesystem;
namespace {

std::size_t views_of(const SimulationOptions& options, std::size_t all) {
  return options.views > 0 ? std::min(std::size_t(options.views), all) : all;
}

simulate::Conditions conditions_of(const SimulationOptions& options) {
  return with_settings(simulate::level_conditions(options.level), options.settings);
}

void write_view(const simulate::SimulatedSession& session, std::size_t view,
                const std::vector<ImageU8>& frames, const fs::path& folder) {
  fs::create_directory(folder);
  const std::vector<ImageU8> captures = simulate::capture_view(session, view, frames);
  for (std::size_t frame = 0; frame < captures.size(); ++frame)
    io::save_image(folder / numbered("frame", frame, ".png"), captures[frame]);
  io::save_pose(folder / "truth_pose.json",
                {"rig", "board", PoseWithCovariance{session.views[view].rig_from_board}});
}

/// The rig before markers on its wall, blurred and noisy as the session's captures.
void write_marker_view(const simulate::SimulatedSession& session, const fs::path& folder) {
  const simulate::World& world = session.views.front();
  const simulate::HungMarkers hung = simulate::hang_markers(world);
  simulate::MarkerViewOptions view;
  view.blur_px = session.capture.camera_blur_px;
  view.noise = session.capture.noise;
  view.seed = session.capture.seed;
  const RigCamera& camera = session.rig().camera();
  io::save_image(folder / "marker_view.png",
                 simulate::marker_view(camera.camera, camera.rig_from_camera.inverse() * hung.rig_from_world,
                                       hung.map.markers, detect::marker_cells(hung.map.dictionary), view));
  io::save_marker_map(folder / "markers.json", hung.map);
  const RigProjector& projector = session.rig().projector();
  io::save_pose(folder / "truth_projector_from_world.json",
                {projector.name, "world",
                 PoseWithCovariance{projector.rig_from_projector.inverse() * hung.rig_from_world}});
}

void save_truth(Rig truth, const SimulationOptions& options, const std::string& pattern,
                const fs::path& folder) {
  truth.provenance.tool = "simulate-captures";
  truth.provenance.options["seed"] = std::to_string(options.seed);
  truth.provenance.options["level"] = simulate::to_string(options.level);
  truth.provenance.options["pattern"] = pattern;
  for (const std::string& setting : options.settings) {
    std::string& all = truth.provenance.options["set"];
    all += (all.empty() ? "" : ",") + setting;
  }
  io::save_rig(folder / "truth.json", truth);
}

/// What is wrong with each view, beside the seed and the level in truth.json.
Rig with_defects(Rig truth, const simulate::SimulatedSession& session, std::size_t first, std::size_t views,
                 int frames) {
  for (std::size_t view = 0; view < views && first + view < session.defects.size(); ++view)
    if (const std::string text = simulate::description(session.defects[first + view], frames); !text.empty())
      truth.provenance.options[numbered("view", view)] = text;
  return truth;
}

/// The wall as a surface of the room, placed in the rig; what is shown there spans a quarter of its distance.
SurfaceSet wall_of(const simulate::World& world) {
  PlanarSurface plane;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.frame = "rig";
  plane.frame_from_surface = simulate::rig_from_wall(world);
  const double half =
      0.25 * (plane.frame_from_surface.translation - world.rig.camera().rig_from_camera.translation).norm();
  plane.points = {{-half, -0.75 * half}, {half, -0.75 * half}, {half, 0.75 * half}, {-half, 0.75 * half}};
  return {{{"wall", plane, {}, ""}}};
}

bool changes_rig(const SimulationOptions& options) {
  return options.bump != 0 || options.zoom != 1;
}

/// Rotated about its centre; the principal point of a zoomed lens moves, too.
void change_projector(RigProjector& projector, const SimulationOptions& options) {
  Pose& place = projector.rig_from_projector;
  place = place * Pose(so3_exp(Vec3(options.bump * Vec3(0.7, -0.6, 0.38).normalized())), Vec3::Zero());
  Camera& lens = projector.projector.inverse_camera;
  lens.intrinsics.fx *= options.zoom;
  lens.intrinsics.fy *= options.zoom;
  constexpr double kWander = 0.15;  // shares of the picture, for a zoom by two
  lens.intrinsics.cx -= 0.4 * kWander * (options.zoom - 1) * lens.size.width;
  lens.intrinsics.cy += kWander * (options.zoom - 1) * lens.size.height;
}

/// The first of `count` views, and the noise of captures that were made at another time where the rig was changed.
std::size_t first_view(const SimulationOptions& options, std::size_t of_level, std::size_t count,
                       simulate::CaptureOptions& capture) {
  if (!changes_rig(options) || !options.check.empty()) return 0;
  constexpr std::uint64_t kLater = 7919;
  capture.seed += kLater;
  return of_level - count;
}

/// A projected board on the bare wall, after somebody has bumped the projector.
void write_check(const simulate::SimulatedSession& session, const SimulationOptions& options,
                 const fs::path& folder) {
  simulate::World world = simulate::with_bare_wall(session.views.front());
  const auto pattern = make_pattern(options.check, world.rig.projector().projector.size());
  change_projector(world.rig.projectors.front(), options);
  fs::create_directory(folder);
  const std::vector<ImageU8> captures = simulate::capture(world, pattern->frames(), session.capture);
  for (std::size_t frame = 0; frame < captures.size(); ++frame)
    io::save_image(folder / numbered("frame", frame, ".png"), captures[frame]);
  io::save_session(folder, {pattern->text(), world.rig.projector().projector.size(), {}, {}});
  io::save_surfaces(folder / "surfaces.json", wall_of(world));
  save_truth(world.rig, options, pattern->text(), folder);
}

void require_no_change_by_view(const simulate::Conditions& conditions) {
  if (conditions.flex > 0 || conditions.refocus > 0 || conditions.stabiliser_px > 0)
    throw Error(ErrorKind::kUnsupported, "--set flex, refocus or stabiliser",
                "changes from view to view are simulated for a board, one camera and one projector",
                "leave it out, or simulate such a session");
}

/// view_NN/<projector>/<camera>/frame_NN.png, without a folder for the only one of a kind.
void write_fleet_view(const simulate::Fleet& fleet, std::size_t view, const std::vector<ImageU8>& frames,
                      const fs::path& folder) {
  for (const std::size_t p : fleet.views[view].projectors)
    for (const std::size_t c : fleet.views[view].cameras) {
      fs::path stack = folder;
      if (fleet.rig.projectors.size() > 1) stack /= fleet.rig.projectors[p].name;
      if (fleet.rig.cameras.size() > 1) stack /= fleet.rig.cameras[c].name;
      make_folder(stack);
      const std::vector<ImageU8> captures = simulate::capture_pair(fleet, view, c, p, frames);
      for (std::size_t frame = 0; frame < captures.size(); ++frame)
        io::save_image(stack / numbered("frame", frame, ".png"), captures[frame]);
    }
  io::save_pose(folder / "truth_pose.json",
                {"rig", "board", PoseWithCovariance{fleet.views[view].rig_from_board}});
}

/// A session of several devices.
SimulatedFolder write_fleet(const fs::path& place, const SimulationOptions& options,
                            const SessionPattern& pattern, const ReadingProgress& progress) {
  if (pattern.on_blank_paper() || options.markers || options.board || !options.check.empty())
    throw Error(ErrorKind::kUnsupported,
                pattern.on_blank_paper() ? "pattern '" + options.pattern + "'"
                : options.markers        ? "--marker-view"
                : options.board          ? "--board"
                                         : "--check-board",
                "it is simulated for one camera and one projector", "leave out --cameras and --projectors");
  require_no_change_by_view(conditions_of(options));
  simulate::Fleet fleet = simulate::make_fleet(options.level, options.seed, options.cameras,
                                               options.projectors, conditions_of(options));
  change_projector(fleet.rig.projectors.front(), options);
  const std::vector<ImageU8> frames = pattern.frames();
  const std::size_t views = views_of(options, fleet.views.size());
  const std::size_t first = first_view(options, fleet.views.size(), views, fleet.capture);
  NewFolder folder(place, options.replace);
  for (std::size_t view = 0; view < views; ++view) {
    if (progress) progress(numbered("view", view), int(view), int(views));
    write_fleet_view(fleet, first + view, frames, folder.path() / numbered("view", view));
  }
  pattern.save_files(folder.path());
  const ImageSize size = simulate::projector_size(options.level);
  io::SessionInfo session{pattern.text(), {}, fleet.world.board.layout, {}};
  if (options.projectors == 1)
    session.projector_size = size;
  else
    for (const RigProjector& projector : fleet.rig.projectors)
      session.projectors[projector.name] = projector.projector.size();
  io::save_session(folder.path(), session);
  save_truth(fleet.rig, options, pattern.text(), folder.path());
  folder.finish();
  return {int(views), pattern.frame_count(), pattern.text(), fleet.world.board.layout, size};
}

/// A session of one camera and one projector.
SimulatedFolder write_pair(const fs::path& place, const SimulationOptions& options,
                           const SessionPattern& pattern, const ReadingProgress& progress) {
  std::optional<simulate::BoardPrint> print;
  if (options.board) print = simulate::BoardPrint{*options.board, detect::board_artwork(*options.board)};
  simulate::SimulatedSession session = simulate::make_session(
      options.level, options.seed, pattern.on_blank_paper(), print, conditions_of(options));
  if (options.check.empty())
    for (simulate::World& world : session.views) change_projector(world.rig.projectors.front(), options);
  const std::vector<ImageU8> frames = pattern.frames();
  const std::size_t views = views_of(options, session.views.size());
  const std::size_t first = first_view(options, session.views.size(), views, session.capture);
  NewFolder folder(place, options.replace);
  for (std::size_t view = 0; view < views; ++view) {
    if (progress) progress(numbered("view", view), int(view), int(views));
    write_view(session, first + view, frames, folder.path() / numbered("view", view));
  }
  if (options.markers) write_marker_view(session, folder.path());
  if (!options.check.empty()) write_check(session, options, folder.path() / "check");
  pattern.save_files(folder.path());
  const ImageSize size = simulate::projector_size(options.level);
  io::save_session(folder.path(), {pattern.text(), size, session.stated_board, {}});
  save_truth(with_defects(session.rig(), session, first, views, pattern.frame_count()), options,
             pattern.text(), folder.path());
  folder.finish();
  return {int(views), pattern.frame_count(), pattern.text(), session.board().layout, size};
}

/// The rig of the level and seed, and how it captures.
std::pair<Rig, simulate::CaptureOptions> room_rig(const SimulationOptions& options) {
  if (options.cameras > 1 || options.projectors > 1) {
    const simulate::Fleet fleet = simulate::make_fleet(options.level, options.seed, options.cameras,
                                                       options.projectors, conditions_of(options));
    return {fleet.rig, fleet.capture};
  }
  const simulate::SimulatedSession session =
      simulate::make_session(options.level, options.seed, std::nullopt, std::nullopt, conditions_of(options));
  return {session.rig(), session.capture};
}

/// The files of one camera and one projector in a view of a room.
struct RoomPairFiles {
  fs::path stack;  ///< the folder of the camera images
  fs::path truth_depth, truth_pose;
};

/// What one camera records of one projector in a room, and the truth beside the view's folders.
void write_room_pair(const simulate::CaptureOptions& capture, const simulate::Room& room,
                     const RigCamera& camera, const RigProjector& projector,
                     const std::vector<ImageU8>& frames, const RoomPairFiles& files,
                     const Pose& room_from_rig) {
  RigCamera camera_in_room = camera;
  RigProjector projector_in_room = projector;
  camera_in_room.rig_from_camera = room_from_rig * camera.rig_from_camera;
  projector_in_room.rig_from_projector = room_from_rig * projector.rig_from_projector;
  const simulate::RoomView seen =
      simulate::scan_view(capture, room, camera_in_room, projector_in_room, frames);
  make_folder(files.stack);
  for (std::size_t frame = 0; frame < seen.captures.size(); ++frame)
    io::save_image(files.stack / numbered("frame", frame, ".png"), seen.captures[frame]);
  io::save_pfm(files.truth_depth, seen.truth.depth);
  io::save_pose(files.truth_pose, {"rig", camera.name, PoseWithCovariance{camera.rig_from_camera}});
}

/// Views of a room. Between them the cameras are moved.
SimulatedFolder write_room(const fs::path& place, const SimulationOptions& options,
                           const SessionPattern& pattern, const ReadingProgress& progress) {
  require(options.station >= 0, "write_simulated_session: a negative station");
  if (options.markers || options.board || !options.check.empty() || changes_rig(options))
    throw Error(ErrorKind::kUnsupported, "--room", "a room is simulated without boards and changes",
                "leave out --board, --marker-view, --check-board, --bump and --zoom");
  const simulate::Conditions conditions = conditions_of(options);
  if (conditions.camera_deviation_px > 0 || conditions.projector_deviation_px > 0)
    throw Error(ErrorKind::kUnsupported, "--set lens-deviation", "lenses of a room are simulated without it",
                "leave it out, or simulate boards");
  require_no_change_by_view(conditions);
  if (conditions.bend.high > 0)
    throw Error(ErrorKind::kUnsupported, "--set bend", "a room has no board that bends",
                "leave it out, or simulate boards");
  const auto [rig, fixed_capture] = room_rig(options);
  simulate::CaptureOptions capture = fixed_capture;
  const simulate::Room room = simulate::scan_scene(options.room);
  const std::vector<ImageU8> frames = pattern.frames();
  const int views = std::max(1, options.views);
  const Pose room_from_rig = simulate::room_from_rig(options.station);
  constexpr std::uint64_t kOtherStation = 104729;  // noise of its own
  capture.seed += kOtherStation * std::uint64_t(options.station);
  NewFolder folder(place, options.replace);
  for (int view = 0; view < views; ++view) {
    const std::string name = numbered("view", std::size_t(view));
    if (progress) progress(name, view, views);
    fs::create_directory(folder.path() / name);
    for (const RigProjector& projector : rig.projectors)
      for (RigCamera camera : rig.cameras) {
        camera.rig_from_camera = simulate::moved_camera(camera.rig_from_camera, view);
        const fs::path view_folder = folder.path() / name;
        fs::path stack = view_folder;
        if (rig.projectors.size() > 1) stack /= projector.name;
        if (rig.cameras.size() > 1) stack /= camera.name;
        const std::string of_camera = rig.cameras.size() == 1 ? "" : "_" + camera.name;
        write_room_pair(capture, room, camera, projector, frames,
                        {stack, view_folder / ("truth_depth" + of_camera + ".pfm"),
                         view_folder / ("truth_" + camera.name + ".json")},
                        room_from_rig);
        ++capture.seed;  // noise of its own
      }
  }
  pattern.save_files(folder.path());
  const ImageSize size = simulate::projector_size(options.level);
  io::SessionInfo session{pattern.text(), {}, {}, {}};
  if (rig.projectors.size() == 1)
    session.projector_size = size;
  else
    for (const RigProjector& projector : rig.projectors)
      session.projectors[projector.name] = projector.projector.size();
  io::save_session(folder.path(), session);
  io::save_pose(folder.path() / "truth_station.json", {"world", "rig", PoseWithCovariance{room_from_rig}});
  Rig truth = rig;
  truth.provenance.options["room"] = options.room;
  if (options.station > 0) truth.provenance.options["station"] = std::to_string(options.station);
  save_truth(truth, options, pattern.text(), folder.path());
  folder.finish();
  return {views, pattern.frame_count(), pattern.text(), {}, size};
}

}  // namespace

SimulatedFolder write_simulated_session(const fs::path& folder, const SimulationOptions& options,
                                        const ReadingProgress& progress) {
  const auto pattern = make_pattern(options.pattern, simulate::projector_size(options.level));
  const bool fleet = options.cameras > 1 || options.projectors > 1;
  const auto write = !options.room.empty() ? write_room : fleet ? write_fleet : write_pair;
  const SimulatedFolder written = write(folder, options, *pattern, progress);
  if (progress) progress("", written.views, written.views);
  return written;
}

}  // namespace procam::session
