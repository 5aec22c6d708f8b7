#pragma once
/// A recording for the calibration of a mount: poses of a robot's base by its localiser, of an arm's flange by its
/// controller, or the angles of a pan-tilt head; and sightings of markers or planes by the rig on it, each in its own clock.
#include <string>
#include <vector>

#include "procam/core/geometry/covariance.hpp"

namespace procam {

/// A pose of the localiser, or of an arm's controller: then of the flange in the arm's base.
struct BasePose {
  double time = 0;  ///< localiser's clock, seconds
  Pose world_from_base;
};

/// The angles that a pan-tilt head reports.
struct HeadAngles {
  double time = 0;           ///< head's clock, seconds
  double pan = 0, tilt = 0;  ///< radians
};

/// A marker, or a map of markers, in one image; or a plane (wall, floor) as a depth sensor measures it, or a camera by the light
/// of its own projector.
struct MarkerSighting {
  double time = 0;  ///< camera's clock, seconds
  std::string
      marker;  ///< equal names are one marker (one map of markers, one plane); of a plane it may be empty
  /// With the covariance of the left increment, in the marker's frame.
  PoseWithCovariance marker_from_rig;
  /// A plane's frame has z along the normal, towards the rig. Three numbers count, with their part of the covariance: the
  /// tilt about x and y, and z. The rotation about z and the position along x and y are arbitrary.
  bool is_plane = false;
};

struct MountData {
  std::vector<BasePose> base;             ///< times grow
  std::vector<HeadAngles> angles;         ///< of a pan-tilt head, instead of `base`; times grow
  std::vector<MarkerSighting> sightings;  ///< in any order
};

}  // namespace procam
