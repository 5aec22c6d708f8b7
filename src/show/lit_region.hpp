#pragma once
/// The part of a plane surface that a robot's light reaches, as it announces it to its fleet (dds/fleet.hpp).
///
/// A robot that drives announces the whole surface: each other region begins a turn with a dark time. One that stands announces
/// what its light reaches, enlarged, and keeps that region while its light stays inside. Two robots whose regions are apart then
/// light one surface together.
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/planar.hpp"

namespace procam::show {

/// The content's outline within the frame: convex, metres of the surface, corners as in core/geometry/convex.hpp. Each side of
/// the frame is a straight line outside of its curve, so that the region contains all light. Empty: no light reaches it, or
/// the plane is not wholly before the projector.
Points2 reached_region(const Projector& projector, const PlacedPlane& plane);

class AnnouncedRegion {
 public:
  static constexpr double kStandsFor = 2;   ///< seconds, before a region is announced
  static constexpr double kEnlarged = 1.2;  ///< about its middle
  static constexpr double kKept = 1.1;  ///< `reached`, enlarged by this, leaves the region: it is given up

  /// `reached` at a time, seconds. The region to be announced; empty: all of the surface.
  const Points2& follow(const Points2& reached, double time);

 private:
  Points2 tried_, announced_;
  double since_ = 0;
};

}  // namespace procam::show
