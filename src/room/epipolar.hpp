#pragma once
/// The epipolar geometry of two devices from pairs of image points, and the relative poses that agree with it.
///
///   (y, 1) F (x, 1)^T = 0,   F = K_2^-T [t]x R K_1^-1,   second_from_first = (R, t)
///
/// Eight points: R. Hartley, "In defense of the eight-point algorithm", PAMI 19(6), 1997. Random samples with local
/// optimisation: O. Chum, J. Matas, J. Kittler, "Locally optimized RANSAC", DAGM 2003, scored by Sampson's distance.
/// Poses from E and from the homography of a plane: Hartley & Zisserman, "Multiple View Geometry", 2nd edition, 9.6;
/// Y. Ma, S. Soatto, J. Kosecka, S. Sastry, "An Invitation to 3-D Vision", 5.3.
#include <cstdint>
#include <optional>
#include <vector>

#include "procam/core/geometry/pose.hpp"

namespace procam::room {

struct ImagePair {
  Vec2 first, second;
};

struct EpipolarGeometry {
  Mat3 fundamental = Mat3::Zero();  ///< of rank two, unit norm
  std::vector<char> inliers;
  double rms = 0;  ///< Sampson's distance of the inliers, in the pairs' unit
};

/// Pairs farther than `threshold` (Sampson's distance) are outliers. nullopt: no geometry that half of the pairs
/// agree with.
std::optional<EpipolarGeometry> find_epipolar(const std::vector<ImagePair>& pairs, double threshold,
                                              std::uint64_t seed = 1);

/// Signed Sampson's distance of a pair.
double sampson(const Mat3& fundamental, const ImagePair& pair);

/// The four poses second_from_first of an essential matrix, translations of length one.
std::vector<Pose> poses_of_essential(const Mat3& essential);

/// The poses second_from_first of a plane's homography between normalised images: two or four.
std::vector<Pose> poses_of_homography(const Mat3& homography);

/// How far the rays (a, b, 1) are from a rotation of each other, the 90 % quantile, radians: two devices in one
/// place (Kabsch 1976).
double rotation_error(const std::vector<ImagePair>& rays);

/// The share of the pairs (rays (a, b, 1)) whose point is in front of both devices.
double share_in_front(const Pose& second_from_first, const std::vector<ImagePair>& rays);

}  // namespace procam::room
