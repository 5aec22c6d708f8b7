#pragma once
/// A rig without a board: cameras and projectors from the structured light that they see on a room.
///
/// Unknown are every projector's lens and pose, the poses of the camera positions, and lenses of cameras that are
/// not known. From the points of the walls (points.hpp): epipolar geometry of two camera positions, or of a camera
/// and a projector; the other devices one after the other by resection; bundle adjustment over everything
/// (src/room/adjust.hpp). Light tells no length: the scale is that of known distances, or of a marker or board whose
/// points are triangulated by the camera positions.
///
/// What the light determines. One camera position and a projector are two images of a scene: seven numbers, five of
/// which are the pose's. Two are left for the projector's focal length and principal point, three unknowns even with
/// square pixels and a known camera (Hartley & Zisserman, "Multiple View Geometry", 2nd edition, 19.3). So one
/// position needs a data sheet; a second camera position, or a second camera, determines the whole lens of the
/// projector. Projector and camera calibrated by their own light: S. Yamazaki, M. Mochimaru, T. Kanade,
/// "Simultaneous self-calibration of a projector and a camera using structured light", PROCAMS 2011 (lens shift,
/// radial terms by the epipolar geometry); R. Furukawa, H. Kawasaki, "Uncalibrated multiple image stereo system with
/// arbitrarily movable camera and projector for wide range scanning", 3DIM 2005; several devices by bundle
/// adjustment.
///
/// Every lens has weak priors: pixels square to 0.5 %, terms of distortion as small as those of real lenses, a
/// principal point within about half a picture. The covariance holds them, what the light determines, and the noise
/// as neighbouring points share it (by groups of points). A result is refused when this covariance says that the
/// walls are not known: the cause is named.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/point_cloud.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/room/points.hpp"

namespace procam::room {

/// A camera's lens that is known before. How well, by the first of:
/// - `covariance`, as a calibration gives it; a parameter without a row is exact;
/// - `sigma`, a share: of the focal length, of the principal point's offset over the focal length, and of the distortion
///   in the image's corner. 0: exact;
/// - neither: the lens may be exact or a data sheet's. It is kept while the light agrees, and what the light leaves open
///   within 10 % of the focal length, 3 % of the width and 10 % of distortion is part of the result's covariance.
///   A lens that the light contradicts is estimated from the light ("known_lens_disagrees").
struct CameraLens {
  Camera lens;
  NamedCovariance covariance = {};  ///< rows by parameter names ("fx", "k1")
  std::optional<double> sigma = {};
};

/// A number and its standard deviation.
struct Estimate {
  double value = 0, sigma = 0;
};

/// What is known of the focal length of a camera whose lens is estimated: EXIF, a data sheet.
struct CameraSheet {
  Estimate focal_px;
  std::string source;  ///< for messages: "28 mm equivalent by the images' EXIF"
};

/// A projector's data sheet, as far as it is known.
struct LensSheet {
  std::optional<Estimate> throw_ratio;  ///< distance over width of the picture
  std::optional<Estimate> shift_x,
      shift_y;  ///< Projector::lens_shift(): parts of the picture's width and height
};

/// What gives the scale: the distance of two points of the walls, or of two devices' centres of projection.
struct KnownDistance {
  std::vector<int> points;           ///< two indices into RoomPoints::points, or none
  std::vector<std::string> devices;  ///< two names of cameras or projectors, or none
  double length = 0, sigma = 0;      ///< metres
};

/// A marker or board of known size that stands still while several camera positions see it: it gives the scale as well.
struct KnownTarget {
  struct View {
    std::string camera, view;
    std::vector<int> points;  ///< indices into `places`
    Points2 pixels;           ///< where this position sees them
    double sigma = 0.1;       ///< of a pixel's coordinate
  };
  std::string name;       ///< for messages
  Points3 places;         ///< in the target's frame, metres
  double size_sigma = 0;  ///< of its size, a share
  std::vector<View> views;
};

struct RoomOptions {
  std::map<std::string, CameraLens> cameras;  ///< by name; of the others the lens is estimated
  /// By name: a prior for cameras whose lens is estimated. One that the light contradicts is not used
  /// ("camera_sheet_disagrees"). For a known camera it is compared with the known focal length alone.
  std::map<std::string, CameraSheet> camera_sheets;
  std::map<std::string, LensSheet> projectors;  ///< by name
  std::vector<KnownDistance> distances;         ///< at least one, or a target
  std::vector<KnownTarget> targets;
  double outlier_sigmas = 5;  ///< farther points are rejected
  /// Refused when the walls' standard deviation (95 % of the points) exceeds this share of their distance (half of it
  /// for one camera position, whose result rests on the priors) ...
  double max_wall_sigma = 0.03;
  /// ... or when the light misses the devices by more than this, projector pixels.
  double max_rms_px = 0.6;
  int threads = 0;  ///< 0: as many as the machine has. The result does not depend on it
};

/// Where a camera was in a view.
struct SolvedPosition {
  std::string camera, view;
  Pose rig_from_camera;
};

/// Points that took no part, by the part of a camera's image that they are in: 3 x 3.
struct RegionError {
  std::string camera, view, projector;
  int column = 0, row = 0;
  int points = 0;
  double rms_px = 0;  ///< of one coordinate of the light, projector pixels; 0 without points
};

struct RoomCalibration {
  Rig rig;  ///< each camera where it was first; the first camera's frame
  std::vector<SolvedPosition> positions;
  int points = 0, outliers = 0;
  double rms_px = 0;       ///< of one coordinate of the light, points in use
  double held_out_px = 0;  ///< of points that took no part
  double scatter = 1;      ///< of the readings over their stated standard deviations
  double parallax =
      0;  ///< angle between the rays of a point, the largest of each, median over the points, radians
  /// Standard deviation of the walls by the rig, median and 95 % of the points, metres; and as a share of their
  /// distance.
  double wall_sigma = 0, wall_sigma_95 = 0, wall_sigma_share = 0;
  double distance = 0;  ///< of the points from the first camera, median, metres
  bool planar = false;  ///< all points are on one plane
  PointCloud
      walls;  ///< the points in use, in the rig's frame; standard deviation along the anchor's ray by the rig
  std::vector<RegionError> regions;
  Diagnostics diagnostics;
};

/// Notes of assumptions travel in the result: "planar_room", "one_position", "lens_estimated", "lens_unchecked" (a lens
/// without a stated deviation that the light does not determine). "known_lens_disagrees": the light contradicts a known
/// lens; a failure for a lens with a stated deviation, else a warning, and the light's estimate is in use.
/// "camera_sheet": the prior of a camera's focal length and what became of it; "camera_sheet_disagrees", a warning: the light,
/// or a known lens, contradicts it by more than three standard deviations of the difference. Throws
/// Error(kDegenerate) for a room or devices whose light does not determine the rig (one plane, no parallax, one
/// position without a data sheet), Error(kNotEnoughData) for devices that share too few points with the others,
/// Error(kNotConverged) for light that no rig explains: a wrong lens or size, a device that moved; Error(kInput) for
/// a known lens of another image size and for names that the session does not have.
PROCAM_EXPORT RoomCalibration calibrate_room(const RoomPoints& points, const RoomOptions& options);

}  // namespace procam::room
