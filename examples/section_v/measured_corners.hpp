#pragma once
/// points.csv <-> where the corners of sheets landed, as somebody measured them with a ruler.
///
///   sheet, placement, distance_m, incidence_deg, corner, physical_x, physical_y, projected_x, projected_y
///   A4, 1, 1.2, 47, 1, 0, 0, 0.3, -0.8
///
/// A line a corner. sheet: its name; placement: a number; distance from the projector to the sheet's middle
/// and the angle of the light there; corner: 1 top left, 2 top right, 3 bottom right, 4 bottom left; the last
/// four in the unit that the reader is told, x to the right and y down, from any origin on the sheet. The
/// line of column names may be absent. Separators and comments as in io/session/point_pairs_file.hpp.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::section_v {

struct MeasuredCorner {
  std::string sheet;
  int placement = 0;
  double distance = 0;                                     ///< metres
  double incidence_deg = 0;                                ///< 0..90
  int corner = 0;                                          ///< 0..3
  Vec2 physical = Vec2::Zero(), projected = Vec2::Zero();  ///< metres
};

/// `unit` is a length in metres: 0.01 for centimetres. Throws Error(kIo) for a file that cannot be read,
/// Error(kInput) naming file, line and column: also for a corner measured twice, and for a sheet with two
/// angles.
std::vector<MeasuredCorner> load_measured_corners(const std::filesystem::path& path, double unit);
/// The same from a text; `name` stands in messages.
std::vector<MeasuredCorner> parse_measured_corners(const std::string& text, const std::string& name,
                                                   double unit);

/// The text that parse_measured_corners() reads.
std::string format_measured_corners(const std::vector<MeasuredCorner>& corners, double unit);

}  // namespace procam::section_v
