#pragma once
/// The options of calibrate-room.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/board/board.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/io/image/exif.hpp"
#include "procam/io/text.hpp"
#include "procam/room/calibrate_room.hpp"
#include "procam/session/reader.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

/// --distance: two camera pixels of the first view, or two devices, and how far apart they are.
struct DistanceFlag {
  std::string text;
  std::vector<Vec2> pixels;
  std::vector<std::string> devices;
  double length = 0, sigma = 0;
};

struct RoomFlags {
  std::string captures, output, points, preview, truth;
  session::OpenOptions open;
  std::vector<std::string> known_cameras;              ///< FILE or NAME=FILE
  std::vector<std::string> throw_ratios, lens_shifts;  ///< VALUE or NAME=VALUE
  std::optional<double> lens_sigma;  ///< of known cameras whose file has no covariance, a share
  std::vector<DistanceFlag> distances;
  std::optional<MarkerMap> marker;  ///< one
  std::optional<Board> board;
  int points_a_map = 4000;
};

void declare_room(CLI::App& app, RoomFlags& flags);

/// "412,300:880,310:1.25m", "camera:projector:0.4m+-2mm". Without a deviation: 2 mm between points, 5 mm between
/// devices. Throws Error(kInput).
DistanceFlag parse_distance(const std::string& text);

/// Of the distances, two for each.
std::vector<room::MarkedPixel> marked_pixels(const RoomFlags& flags);

/// What is known of the session's devices. Throws Error(kInput) for files and names that do not fit them.
room::RoomOptions room_options(const RoomFlags& flags, const room::RoomPoints& points);

/// What the first image of a view's captures states of a camera's lens.
struct CameraExif {
  std::string camera, view;
  io::ExifFocal focal;
};

/// By camera, of those that all views agree on; of others a remark.
std::map<std::string, room::CameraSheet> camera_sheets(const std::vector<CameraExif>& exif,
                                                       Diagnostics& remarks);

/// As given, for the rig's provenance.
std::map<std::string, std::string> given_options(const RoomFlags& flags);

}  // namespace procam::tools
