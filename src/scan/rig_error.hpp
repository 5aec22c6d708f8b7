#pragma once
/// The part of a depth's error that comes from the rig: common to all pixels, and smooth over each surface.
#include <vector>

#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

/// Sets `rig_sigma`, sqrt(g C g^T) for every measured pixel, `consistency_px_of_rig` and `rig_modes`: worked out for one pixel in each cell of 16 x 16,
/// and carried to the others by the depths' squares.
void set_rig_error(const LightMap& light, const Rig& rig, const RigProjector& projector, int threads,
                   Scan& scan);

/// The error of the point of pixel (x, y) at depth z for each element of c: 3 rows in the rig's frame, then the depth's. False
/// where the cells around have none.
bool rig_modes_at(const RigModes& modes, const Vec2& pixel, double z, MatX& errors);

/// A value that is known at some depth in each cell (depth, value; depth 0: none), for every measured pixel: it grows with the
/// depth's square. 0 where it is not known.
ImageF carried(const ImageF& depth, const std::vector<float>& cells, int threads);

/// Cells of an image: one value each, row by row.
inline int cell_columns(int width) {
  return (width + 15) / 16;
}
inline int cell_rows(int height) {
  return (height + 15) / 16;
}
/// The measured pixel nearest to the middle of a cell; x -1 where there is none.
Eigen::Vector2i pixel_of_cell(const ImageF& depth, int column, int row);

/// `camera` where the rig's error is root c: its lens and its pose without that error.
RigCamera without_error(const RigCamera& camera, const RigModes& modes, const VecX& c);

}  // namespace procam::scan
