#pragma once
/// One blurred edge, fitted straight to the pixels round it:
///
///   I(p) = a + a_t t + (b + b_t t) erf(d / (sqrt2 s)),   d = (p - m) . n - offset - slope t - bend t^2 / 2,
///
/// with t = (p - m) . e along the edge from its middle m, n the normal towards the light side, s the blur.
/// Offset, slope, s and the light are fitted by damped Gauss-Newton; the bend is given. Pixels are used where
/// they lie: nothing is interpolated, so no pixel phase pulls the edge.
#include <optional>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::detect {

/// Where an edge is thought to be, in pixels.
struct EdgeGuess {
  Vec2 from, to;    ///< its ends; light lies to the left of the way in image axes (x right, y down: above)
  double bend = 0;  ///< second derivative of d along t, 1 / pixels; positive bows towards the light
  double trim = 0;  ///< ignored at both ends, where other edges blur in
  double inside = 2, outside = 2;  ///< pixels used on the dark and the light side
};

struct EdgeFit {
  Vec2 middle, along, normal;  ///< m, e, n
  double offset = 0, slope = 0, bend = 0;
  Mat2 covariance;  ///< of offset and slope
  double contrast = 0, blur = 0, residual = 0;

  /// Signed distance to the fitted edge; positive on the light side.
  double distance(const Vec2& p) const;
  /// d distance / d p.
  Vec2 gradient(const Vec2& p) const;
  /// Variance of the distance at p.
  double variance(const Vec2& p) const;
};

/// nullopt where the window leaves the picture, holds too few pixels, or shows no such edge.
std::optional<EdgeFit> fit_edge(const ViewU8& image, const EdgeGuess& guess);

/// Where two fitted edges cross, and its covariance; nullopt for edges that are nearly parallel.
struct Crossing {
  Vec2 point;
  Mat2 covariance;
};
std::optional<Crossing> crossing(const EdgeFit& a, const EdgeFit& b, const Vec2& start);

}  // namespace procam::detect
