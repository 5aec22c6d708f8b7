#pragma once
/// The few large planes of a room as a person names them: a door and the wall around it are one, and a
/// folding screen is the plane through the middle of its folds.
///
///   Planes fine = find_planes(image, rays);               // a door 67 mm before its wall is another plane
///   MainPlanes room = main_planes(fine, image, rays);     // the wall, its door in it
///
/// Readings are of one main plane when they lie within a band of it that widens as the sensor's noise does,
///
///   |normal . p + offset| < floor + square z^2,   p = z (u, v, 1)
///
/// wherever in the image they are. From each fine plane and from each two of the largest together, a plane is
/// fitted to the readings in its band (least squares of perpendicular distances, each weighted by w = 1 /
/// band^2) until that changes nothing; the one with most readings is taken, its readings out, and again while
/// `min_share` of all is found: what sequential RANSAC looks for (M. A. Fischler, R. C. Bolles,
/// Communications of the ACM 24(6), 1981), without its chance. A fine plane that is nearly all of its main
/// plane stays as it is. A curve is taken whole or not at all, so that no band cuts a cylinder into slabs.
///
/// Such a plane is known only as well as it is one. Steps do not average: with r what a reading is off,
///
///   C = s^2 (sum w j j^T / sum w)^-1,   s^2 = sum w r^2 / sum w,   j = (turn_1 . p, turn_2 . p, 1)
///
/// bounds what any pattern of errors as large as the residuals can do to it (by Cauchy and Schwarz): none
/// moves it by more than one sigma.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/depth/planes.hpp"

namespace procam::depth {

struct MainPlaneOptions {
  double band_floor = 0.010;   ///< metres: half of the steps that one plane may have, near the camera
  double band_square = 0.004;  ///< per metre, times z^2
  double farthest = 6;         ///< metres: beyond, the band holds anything
  /// Of the readings: a main plane has at least so many. Where the parts are smaller, bands find planes in
  /// any clutter.
  double min_share = 0.1;
};

struct MainPlanes {
  /// As find_planes() returns them, main planes in the place of what they are made of. A fine plane stays
  /// where no main plane took more than half of its pixels.
  Planes planes;
  /// What each of `planes.planes` is made of: places in the fine result's planes, then its planes.size() +
  /// places in its curves, of which a quarter or more lies in the band. A plane that stayed: itself.
  std::vector<std::vector<int>> members;
};

/// `fine` is of the same image and camera. Takes ten milliseconds or more: it is no part of find_planes().
/// Throws std::invalid_argument where sizes differ or options are out of range.
PROCAM_EXPORT MainPlanes main_planes(const Planes& fine, const DepthImage& image, const RayTable& rays,
                                     const MainPlaneOptions& options = {});

}  // namespace procam::depth
