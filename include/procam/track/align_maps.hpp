#pragma once
/// Two maps of one place, each in its own frame, joined by the walls, floors and markers in both.
///
///   const AlignMapsResult joined = align_maps(elements_of(surfaces_a, sigma), elements_of(surfaces_b, sigma));
///   joined.map_a_from_map_b;   // pose with covariance
///
/// An element is a plane (its position along the plane and its turn within the plane mean nothing) or a pose
/// (a marker). With E = (map_a_from_element)^-1 map_a_from_map_b map_b_from_element, which is the identity
/// where the maps agree, the residual is
///   of a pose:   se3_log(E)                              6 numbers
///   of a plane:  the angle of E e_z to e_z, in its x and y, and (E origin).z      3 numbers
/// and map_a_from_map_b minimises the sum of r^T V^-1 r over the pairs, where V is the covariance of both
/// elements carried to r: the tilt of one plane counts with the distance to the other's origin. Gauss-Newton over
/// SE(3), from starts by each pair of poses and by each three pairs of planes with independent normals; the
/// start that most pairs agree with wins (Fischler and Bolles, "Random Sample Consensus", CACM 24(6), 1981, with
/// all samples instead of random ones).
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::track {

enum class MapElementKind { kPlane, kPose };

/// Something that a map holds.
struct MapElement {
  std::string name;  ///< "floor", "marker 3"
  MapElementKind kind = MapElementKind::kPose;
  Pose map_from_element;  ///< of a plane: its origin lies on it, z is its normal
  /// Of the right increment [rotation, translation]: map_from_element * se3_exp(xi); rad^2, rad m, m^2. Of a
  /// plane, the rows of rx, ry and tz count: its tilts about its origin, and its distance there.
  Mat6 covariance = Mat6::Zero();
};

/// One standard deviation an axis.
struct PlacedSigma {
  double position = 0;  ///< metres
  double angle = 0;     ///< radians
};

/// The planar surfaces that are placed in the world, each with its origin at the mean of its points; others
/// are omitted.
PROCAM_EXPORT std::vector<MapElement> elements_of(const SurfaceSet& surfaces, const PlacedSigma& sigma);

/// The markers, by "marker ID", with the sigmas of the map, or with `otherwise` where the map states none.
PROCAM_EXPORT std::vector<MapElement> elements_of(const MarkerMap& map, const PlacedSigma& otherwise);

struct AlignMapsOptions {
  /// Planes are matched by where they are, whatever their names are. Poses are always matched by name.
  bool planes_by_geometry = false;
  /// An alignment that is known less well than this in any direction is refused: one standard deviation, metres
  /// (at the middle of the elements) and radians.
  PlacedSigma largest_sigma = {0.1, 0.035};
};

/// An element of map A and one of map B that were taken for the same.
struct AlignedPair {
  std::string name_in_a, name_in_b;
  bool used = true;     ///< false: rejected, because the others contradict it
  double distance = 0;  ///< metres, between the poses or from B's origin of the plane to the plane of A
  double angle = 0;     ///< radians, between the poses or the normals
  double chi2 = 0;      ///< r^T V^-1 r; about 3 for a plane and 6 for a pose
};

struct AlignMapsResult {
  /// The covariance is that of the left increment; scaled up when the maps disagree more than they state.
  PoseWithCovariance map_a_from_map_b;
  std::vector<AlignedPair> pairs;
  std::vector<std::string> only_in_a, only_in_b;
  double chi2 = 0;  ///< of the used pairs
  int degrees_of_freedom = 0;
  Diagnostics diagnostics;
};

/// Remarks: "pair_rejected" names pairs that the others contradict; "maps_disagree" says that the residuals are
/// larger than the stated sigmas allow (by chance in 1 of 1000 alignments) and that the covariance was scaled
/// up; "unchecked" says that there are no more measurements than unknowns; "second_alignment" says that another
/// alignment agrees with one element less.
///
/// Throws Error: kInput for an element whose covariance is not positive definite in the rows that count, kNotEnoughData
/// when no element is in both maps, kDegenerate when a direction is poorly constrained (it is named), when
/// two alignments agree with equally many elements, or when the pairs by name contradict each other
/// without a majority.
PROCAM_EXPORT AlignMapsResult align_maps(const std::vector<MapElement>& map_a,
                                         const std::vector<MapElement>& map_b,
                                         const AlignMapsOptions& options = {});

/// `surfaces` in the frame of map A, where they were placed in map B. Those in other frames are unchanged.
PROCAM_EXPORT SurfaceSet moved(SurfaceSet surfaces, const Pose& map_a_from_map_b);

/// The markers in the frame of map A. Their sigmas grow by those of the alignment, at the marker where it is
/// known least.
PROCAM_EXPORT MarkerMap moved(MarkerMap map, const PoseWithCovariance& map_a_from_map_b);

}  // namespace procam::track
