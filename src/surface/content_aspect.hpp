#pragma once
/// The aspect ratio of placed content.
#include "procam/surface/lay_out.hpp"

namespace procam::surface {

/// Width over height of the content's area as it looks to somebody who stands before it; nullopt where no
/// such number exists (a horizon, no area).
///
/// Planes: metres along the two middle lines (u, 1/2) and (1/2, v). Pixel surfaces: the same in projector
/// pixels, which are taken as square. Meshes: the mean of |dX/du| over the mean of |dX/dv|, over the
/// content's area: of a cylinder its arc over its height.
std::optional<double> content_aspect(const Placement& placement);

}  // namespace procam::surface
