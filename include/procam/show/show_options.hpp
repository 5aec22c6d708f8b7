#pragma once
/// Everything that a show needs besides the rig, in memory and as a file (docs/file-formats.md):
///
///   {"format": "procam-show", "version": 1,
///    "surfaces": "surfaces.json", "contents": {"wall": "clip.mp4"},
///    "poses": ["udp:9000"], "blank_on_stale_s": 0.5}
///
/// Each field has the name and the default of the member here; fields that have their default may be missing.
/// File names are relative to the show file.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::show {

/// Poses from what a camera of the rig sees of markers (marker_source.hpp).
struct MarkerInput {
  std::string camera;   ///< number, device, address, topic or folder, as device::open_camera() takes it
  std::string name;     ///< the camera's name in the rig; may be empty when the rig has one
  std::string marker;   ///< one marker, whose frame becomes the world: DICTIONARY:ID:SIZE (io::parse_marker)
  std::string markers;  ///< or a marker map file
};

/// The rig's depth camera, for surfaces that begin with "depth:" or "depth-shape:".
struct DepthInput {
  std::string camera;              ///< its name in the rig; may be empty when the rig has one camera
  double metres_per_unit = 0.001;  ///< of 16-bit depth images, where no sensor states it
  double delay_s = 0;              ///< from a depth image's exposure to its arrival
  std::optional<Vec3> up;          ///< in the world; default 0,0,1, without poses 0,-1,0 (the rig's)
  bool silhouettes = false;  ///< what comes before the room is kept out of the light; dark without depth
};

/// Skeletons of the people before the projector, whose heads are kept dark.
struct PeopleInput {
  std::string source;  ///< udp:9100, tcp:HOST:PORT, tcp-listen:PORT, vmc:39539, log:FILE
  std::string sensor;  ///< pose file between "sensor" and the rig, its projector, a camera or the world
  double delay_s = 0;  ///< from the exposure of a skeleton to its arrival, the fastest
  std::vector<std::string> destinations;  ///< SURFACE=udp:HOST:PORT: skeletons in metres of that surface
};

/// A camera of the rig that watches where the light of the show is (docs/watch.md).
struct WatchInput {
  std::string camera;  ///< number, device, address, topic or folder, as device::open_camera() takes it
  std::string name;    ///< the camera's name in the rig; may be empty when the rig has one
  double delay_s = 0;  ///< from the exposure of an image to its arrival
  bool only = false;   ///< report, and correct nothing
  bool marks = false;  ///< small marks are drawn where the content has no texture
  std::string save;    ///< file for the rig as corrected, written after each correction; empty: none
  /// The localiser's poses are corrected (track/pose_correction.hpp): standard deviation of its error, metres, and about the
  /// world's z axis, radians, and the time for which that lasts, seconds. 0 metres: they are not corrected.
  double pose_m = 0, pose_rad = 0.0175, pose_time_s = 3;
  std::string markers;  ///< with pose_m: marker map file of known markers in the world; empty: none
};

/// Surfaces that move on their own, found by the markers on them (docs/tracked-surfaces.md).
struct TrackInput {
  std::string camera;    ///< number, device, address, topic or folder, as device::open_camera() takes it
  std::string name;      ///< the camera's name in the rig; may be empty when the rig has one
  double delay_s = 0;    ///< from the exposure of an image's middle row to its arrival
  double readout_s = 0;  ///< from the exposure of the first row to that of the last
  /// By surface: one marker, whose frame is the surface's, DICTIONARY:ID:SIZE (io::parse_marker); or a marker map file with
  /// the markers in the surface's frame. Surfaces that move as one are joined by commas; the frame is that of the first.
  std::map<std::string, std::string> surfaces;
  /// By surface, of those that rotate about an edge of their content: left, right, top or bottom. The surface file has
  /// the place at the angle 0.
  std::map<std::string, std::string> hinges;
  int marker_light =
      -1;  ///< grey value of the light on the markers, 0..255; -1: search_light, or the content's
  int search_light = 0;  ///< grey value of the light around the surfaces while one of these is not seen
};

/// One of several projectors of the rig that this process drives, and where its frames go.
struct ScreenOutput {
  std::string projector;               ///< its name in the rig
  std::optional<std::string> display;  ///< as ShowOptions::display
  std::string output;                  ///< or as ShowOptions::output
};

/// The blend with other projectors of the rig, where they light the same surfaces (docs/live.md, surface/blend.hpp).
struct BlendSettings {
  /// Names in the rig, or "all". In a group none: the hosts announce their projectors; or "off".
  std::vector<std::string> projectors;
  std::map<std::string, double> black;       ///< of each projector over its white; 0 where it is missing
  std::map<std::string, double> brightness;  ///< light of its white, with `compensate`; 1 where it is missing
  double compensate = 0;   ///< brightness is evened out; bright places keep at least this share; 0: it is not
  bool one_level = false;  ///< with `compensate`: all surfaces come to one brightness
};

struct ShowOptions {
  std::string projector;  ///< its name in the rig; may be empty when the rig has one

  /// A surface file, read again when it changes; or depth:watch:FOLDER, depth:folder:FOLDER, depth:openni2:[URI],
  /// depth:ros2:/TOPIC; or one surface that moves and deforms, "shape": depth-shape:SOURCE[,region=X:Y:WIDTHxHEIGHT], the
  /// region in pixels of the depth camera.
  std::string surfaces;
  /// Contents by surface (device/content_source.hpp), instead of the surface file's own.
  std::map<std::string, std::string> contents;

  std::vector<std::string> poses;  ///< pose sources (dds/pose_source.hpp): "udp:9000", "ros2:map,base_link"
  std::optional<MarkerInput> marker;  ///< instead of `poses`
  std::string pose;                   ///< or a pose file, for a projector that stands still
  /// Pose file that places the rig, its projector or a camera on "base", the moving frame of the poses. Without
  /// it the poses are those of the rig.
  std::string mount;
  std::string frame, child;         ///< of the poses; empty: those of the first message
  std::string prediction = "auto";  ///< auto, twist, acceleration or none
  double source_delay_s = 0;        ///< from the time of a pose to its arrival, the fastest
  /// Without a new pose for so long the frame is black, or drawn for the last pose (the default, 0.5 s).
  std::optional<double> blank_on_stale_s, freeze_on_stale_s;

  /// The projector's display (device::find_display); without it, as device::choose_display() chooses.
  std::optional<std::string> display;
  std::string output;  ///< instead of a display, as device::open_sink() takes it
  /// Several projectors of the rig in this process (docs/live.md), instead of `projector`, `display` and `output`. All show the
  /// same surfaces, pictures and poses, and blend. The first one's display gives the frame rate.
  std::vector<ScreenOutput> screens;
  std::optional<ImageSize> size;  ///< of the frame, where neither a rig nor a display states it
  double fps = 0;                 ///< frames a second; 0: the display's, or 60
  double duration_s = 0;          ///< 0: until the window is closed or the listener ends it
  double delay_s = 0;             ///< from the begin of a frame to its light
  std::string delay_camera;       ///< a camera that measures delay_s before the show, instead
  double camera_delay_s = 0;      ///< the camera's own share of what it measures

  DepthInput depth;
  std::optional<PeopleInput> people;
  std::optional<WatchInput> watch;
  std::optional<TrackInput> track;
  /// Without it a show blends in a group, and with several screens, alone.
  std::optional<BlendSettings> blend;

  /// ros2:[NAMESPACE]: CameraInfo and frames in the ROS 2 graph (dds/projector_publisher.hpp).
  std::string publish;

  /// Folder of the certificates of DDS Security (dds/security.hpp), for all that the show opens in the graph. Empty: as the
  /// environment states.
  std::string dds_security;

  /// Hosts with one name show one show (docs/live.md). Of hosts that have the state, the one with the greatest strength
  /// follows a leader that is gone.
  std::string group;
  int group_strength = 0;

  /// Robots of one fleet light one room (docs/live.md): of those that can light a surface, the one with the greatest priority
  /// does, or all that blend. Empty: no fleet. `robot`: the name of this one in it.
  std::string fleet, robot;
  int fleet_priority = 0;
  bool fleet_blend = false;

  bool autosave = false;                   ///< edits at the control page are saved within a second
  std::string record;                      ///< log of the run, for replay()
  std::string control = "127.0.0.1:8737";  ///< [ADDRESS:]PORT of the control page, or "off"
  std::string token;                       ///< the control page's secret; empty: a random one

  std::string renderer = "cpu";  ///< cpu or gl
  int threads = 0;               ///< 0: as many as the machine has
  bool bilinear = false;         ///< one sample a pixel: faster, and aliases where content is minified
  bool average_numbers = false;  ///< average pixel values as they stand instead of the light
};

/// Does the text name a depth camera instead of a surface file?
PROCAM_EXPORT bool is_depth_source(const std::string& surfaces);
/// Is its surface a live shape ("depth-shape:")?
PROCAM_EXPORT bool is_shape_source(const std::string& surfaces);

/// Does a value of TrackInput::surfaces name a marker map file, instead of one marker?
PROCAM_EXPORT bool is_marker_file(const std::string& markers);

/// "left=1" or "left=frames:out": a projector, and its display or output. Throws Error(kInput).
PROCAM_EXPORT ScreenOutput parse_screen(const std::string& text);

/// Relative file names become relative to the working directory. Throws Error(kIo), and Error(kInput) with file,
/// line and field, also for an unknown field.
PROCAM_EXPORT ShowOptions load_options(const std::filesystem::path& path);

/// Writes what differs from the defaults; file names become relative to the file. Throws Error(kIo).
PROCAM_EXPORT void save_options(const std::filesystem::path& path, const ShowOptions& options);

}  // namespace procam::show
