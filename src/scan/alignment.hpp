#pragma once
/// Common points of two stations, and alignments of two stations without a known pose.
#include <vector>

#include "surface_view.hpp"

namespace procam::scan {

/// A point of one station and the point of the other at the pixel where it sees the first; each in its own rig's frame.
struct CommonPoint {
  SurfacePoint first, second;
  int first_view = 0, second_view = 0;
};

/// The samples that the second station sees within `gate` metres along the normals, on a surface that faces alike.
std::vector<CommonPoint> common_points(const std::vector<StationView::Sample>& samples,
                                       const StationView& second, const Pose& second_from_first, double gate);

/// One of the poses at which two stations fit.
struct Alignment {
  Pose second_from_first;
  double score =
      0;  ///< share of the samples that agree, minus the share that the second station sees through
};

/// All that differ by more than 30 mm or 1.5 degrees, the best first. Poses all over the range that the options allow are
/// compared by a few hundred points, and the best of these refined by point-to-plane ICP.
std::vector<Alignment> find_alignments(const StationView& first, const StationView& second,
                                       const RegistrationOptions& options);

/// The score of the alignment that point-to-plane ICP finds from a start; -1 where it is farther from there than metres and radians.
double alignment_near(const StationView& first, const StationView& second, const Pose& second_from_first,
                      double max_distance, double max_angle);

}  // namespace procam::scan
