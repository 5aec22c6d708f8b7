#pragma once
/// The table where it hangs: from surfaces to what the puck meets.
#include "match.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/depth/depth_image.hpp"

namespace hockey {

struct Wall {
  procam::Pose world_from_table;  ///< the table's own plane, its content's corner at the origin
  Table table;
  procam::SurfaceSet lit;  ///< the table, and the scoreboard if there is one
};

/// "table", perhaps "scoreboard". The puck is reflected by
/// - holes in the table's shape, and its outline where it leaves the border;
/// - what else lies on the table's plane, within 5 cm;
/// - walls that meet it: edges of other planes within 5 cm of it, and the lines where they cross it.
/// Throws procam::Error for surfaces without a planar table.
Wall read_wall(const procam::SurfaceSet& set);

/// What protrudes from the table, by one look at it with a depth camera, nobody before it: outlines of
/// whatever stands 2.5 to 30 cm out, by the foot of the perpendicular, 1 cm fine. Smaller than 4 cm^2 is
/// noise. Nothing is known where the camera does not see the table. `camera_from_table` is exact to about a
/// centimetre.
std::vector<Segment> obstacles_in(const procam::depth::DepthImage& image, const procam::Camera& camera,
                                  const procam::Pose& camera_from_table, const Table& table);

/// An office projector with a bent lens and its lens shift.
procam::Rig example_rig();
/// A wall that is turned away by 24 degrees and leans a little, with a table and a scoreboard; a picture
/// frame and a switch hang where the puck comes by.
procam::SurfaceSet example_wall();

}  // namespace hockey
