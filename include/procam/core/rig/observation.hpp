#pragma once
/// What was seen: detections in one image, and correspondences over all views of a session.
#include <string>

#include "procam/core/base/error.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/board/board.hpp"

namespace procam {

/// One point of a board at one pixel of one device (for a projector: the pixel whose light falls on the
/// point).
struct Observation {
  int point = 0;  ///< index into points_in_board()
  Vec2 pixel = Vec2::Zero();
  Mat2 covariance = Mat2::Identity() * 0.01;  ///< pixel^2: what the detector believes
  /// Of a projector's pixel: the camera that read it off the light, as index into Correspondences::devices.
  /// Each camera that sees the light reads the point's pixel on its own, an observation each.
  int camera = 0;
  /// Of a projector's pixel: it was read off the light at the corner that `camera` found (Gray code, phase
  /// shift; pattern::project_board). The corner's error is then in both, and `covariance` includes it:
  /// covariance = C_light + J C_corner J^T, J the derivative of the projector's pixel by the camera's. False
  /// for pixels whose error is independent of the corner's.
  bool correlated_with_camera = false;
};

/// The board as one image shows it.
struct Detections {
  ImageSize image_size;
  std::vector<Observation> observations;
  Diagnostics diagnostics;
};

/// A point of the room, measured in the room's frame, and the pixel of a device that sees or lights it.
struct PointPair {
  std::string name;  ///< for messages: "door, top left"; may be empty
  Vec3 point_in_world = Vec3::Zero();
  Vec2 pixel = Vec2::Zero();
};

enum class DeviceKind { kCamera, kProjector };

/// A camera or projector that takes part in a session.
struct Device {
  std::string name;  ///< "camera", "projector"
  DeviceKind kind = DeviceKind::kCamera;
  ImageSize size;
};

/// A point of light on the board's sheet that is not one of the board's points: the corner of a projected
/// chessboard. The projector showed it at a pixel that is known exactly; where it falls on the sheet (board
/// frame, z = 0, x and y anywhere on the paper, also beside the print) is unknown. The camera measured it.
struct LightPoint {
  int projector = 0;  ///< index into Correspondences::devices
  Vec2 projector_pixel = Vec2::Zero();
  int camera = 0;  ///< index into Correspondences::devices
  Vec2 camera_pixel = Vec2::Zero();
  Mat2 camera_covariance = Mat2::Identity() * 0.01;  ///< pixel^2: what the detector believes
  int point = -1;  ///< its number in what was shown; -1 unless views can be compared by it
};

/// One placement of the board: what each device saw or lit of it.
struct View {
  std::string name;  ///< the folder's name
  std::vector<std::vector<Observation>>
      observations;                           ///< by device, in the order of Correspondences::devices
  std::vector<LightPoint> light_points = {};  ///< of patterns that light the sheet beside the board's points
};

/// All that a calibration needs: join(detections, decoded maps) -> Correspondences -> calibrate.
struct Correspondences {
  Board board;
  std::vector<Device> devices;  ///< at least one camera; the first one's frame is the rig's
  std::vector<View> views;
  Diagnostics diagnostics;
};

}  // namespace procam
