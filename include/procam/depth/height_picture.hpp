#pragma once
/// A picture of heights: a colour for every height, and contour lines.
///
/// The picture covers the area of the map, as its mesh's content coordinates do. Between the middles of cells heights are
/// bilinear. A pixel is on a contour where its height is within half a line's width of a multiple of `contours`:
///
///   |h - n contours| < line_width |g| / 2,   g: the slope there
///
/// so that lines are equally wide on all slopes. Level ground at a multiple's height gets no line.
#include <array>
#include <cstdint>

#include "procam/core/base/export.hpp"
#include "procam/depth/height_field.hpp"

namespace procam::depth {

struct HeightColours {
  double lowest = -0.1, highest = 0.1;  ///< metres; blue, green, yellow, brown and white lie between
  double contours = 0;                  ///< metres between two lines; 0: none
  double line_width = 0.004;            ///< metres, along the reference plane
};

/// RGB of a height, limited to the range.
PROCAM_EXPORT std::array<std::uint8_t, 3> colour_of(double height, const HeightColours& colours);

/// Black in holes. Throws std::invalid_argument for a picture that has not three channels, a range without width or a
/// negative distance of lines.
PROCAM_EXPORT void draw_heights(const HeightMap& map, const HeightColours& colours,
                                ImageView<std::uint8_t> picture);

}  // namespace procam::depth
