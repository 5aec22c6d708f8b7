#pragma once
/// Light maps of a room -> points of its walls, each as every camera reads it: what a rig is calibrated from without
/// a board.
///
/// A light map says which projector pixel p lights each pixel x of a camera. About x it is linear,
///
///   p(x + d) = p + J d,
///
/// fitted by least squares to a few pixels around, where they lie on one smooth surface. A point of the walls begins
/// at a pixel of one camera position, its anchor; the other positions that see the same projector's pixel are found
/// by inverting their maps (Newton). Every light map that sees the point then has one reading of it:
///
///   residual = p + J (pi_camera(X) - x) - pi_projector(X),
///
/// the light at the camera's image of the point against the projector's pixel of the point. Its noise is that of
/// this light map alone, since the pixel where a map is read is exact.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::room {

/// A light map, and what took it: the camera `camera` at its place in `view`, by the light of `projector`.
struct PositionLight {
  std::string camera, view, projector;
  LightMap light;
};

/// A light map read at one point of the walls.
struct LightReading {
  int map = 0;                              ///< index into RoomPoints::maps
  Vec2 camera_pixel = Vec2::Zero();         ///< x
  Vec2 projector_pixel = Vec2::Zero();      ///< p
  Mat2 projector_by_camera = Mat2::Zero();  ///< J
  Vec2 sigma = Vec2::Ones();                ///< of p, projector pixels, up to a common factor
};

/// The first reading is the anchor: the point lies exactly on the ray of its camera pixel.
struct RoomPoint {
  std::vector<LightReading> readings;
};

/// A camera at one place. A camera that is moved between the views has several.
struct CameraPosition {
  int camera = 0;    ///< index into RoomPoints::cameras
  std::string view;  ///< for messages
};

/// One light map's devices.
struct MapDevices {
  int position = 0, projector = 0;
};

struct RoomPoints {
  std::vector<Device> cameras, projectors;
  std::vector<CameraPosition> positions;
  std::vector<MapDevices> maps;
  std::vector<RoomPoint> points;
  std::vector<int> marked;  ///< of each RoomPointsOptions::marked, the index into `points`
};

/// A pixel of a camera in a view whose point is wanted; empty names for the first ones.
struct MarkedPixel {
  std::string camera, view;
  Vec2 pixel = Vec2::Zero();
};

struct RoomPointsOptions {
  /// Points to begin in each light map, spread evenly over the image.
  int points_a_map = 4000;
  std::vector<MarkedPixel> marked;
  int threads = 0;  ///< 0: as many as the machine has. The result does not depend on it
};

/// Throws Error(kInput) for light maps of one camera that differ in size, or of one projector that do, and for a
/// marked pixel without light; Error(kNotEnoughData) when fewer than 100 points are found, naming the light map with
/// the least light.
PROCAM_EXPORT RoomPoints room_points(const std::vector<PositionLight>& lights,
                                     const RoomPointsOptions& options = {});

}  // namespace procam::room
