#pragma once
/// The table where it hangs: from surfaces to what the puck meets.
#include "match.hpp"
#include "procam/core/pose.hpp"
#include "procam/core/rig.hpp"
#include "procam/core/surface.hpp"

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

/// An office projector with a bent lens and its lens shift.
procam::Rig example_rig();
/// A wall that is turned away by 24 degrees and leans a little, with a table and a scoreboard; a picture
/// frame and a switch hang where the puck comes by.
procam::SurfaceSet example_wall();

}  // namespace hockey
