#pragma once
/// Square markers: where their edges lie on the print, what one image shows of them, and where they hang.
///
/// Marker frame: origin at the middle of the black square, x right and y down as the print is read, z into
/// the sheet, like an optical frame that looks at it. Positions on the print are in sides of the black square
/// ("unit" coordinates, -1/2 .. 1/2) until a size makes them metres. Corners run clockwise from the print's
/// top left.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/board/marker_dictionary.hpp"
#include "procam/core/geometry/pose.hpp"

namespace procam {

/// The black and white cells of every marker of a dictionary, by id.
struct MarkerCells {
  int per_side = 0;          ///< without the black border
  int correctable_bits = 0;  ///< wrong cells up to which an id is still certain
  /// One marker: 1 white, 0 black, row by row from the top left, per_side^2 of them.
  std::vector<std::vector<std::uint8_t>> white;

  /// Is the cell in row r, column c of marker `id` white? The black border is row -1 and row `per_side`;
  /// beyond it all is white.
  bool is_white(int id, int r, int c) const {
    if (r < -1 || c < -1 || r > per_side || c > per_side) return true;
    if (r < 0 || c < 0 || r >= per_side || c >= per_side) return false;
    return white[std::size_t(id)][std::size_t(r * per_side + c)] != 0;
  }
};

/// Middle of a short piece of a straight edge between black and white: somewhere along a line on the print
/// (a row or column of the cell grid), at a pixel.
struct MarkerEdge {
  Vec2 on_marker;       ///< a point of the line, unit coordinates; only the line counts, not where on it
  Vec2 towards_white;   ///< unit vector across the line on the print: (+-1, 0) or (0, +-1)
  Vec2 pixel;           ///< where the image shows the line
  double variance = 0;  ///< of the pixel's distance from the line's image, pixel^2
};

/// One marker in one image.
struct SeenMarker {
  int id = 0;
  std::array<Vec2, 4> corners;  ///< pixels, clockwise from the print's own top left
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();  ///< x0 y0 x1 ... y3, pixel^2
  /// What the corners were computed from; empty when the marker is too small or blurred for edges of its own:
  /// then the corners are those of a fit to all its pixels.
  std::vector<MarkerEdge> edges;
  /// That failed as well: the corners are the detector's, with a covariance to match.
  bool coarse = false;
};

struct MarkerDetections {
  ImageSize image_size;
  std::vector<SeenMarker> markers;  ///< by id
  Diagnostics diagnostics;
};

/// A marker that hangs somewhere.
struct PlacedMarker {
  int id = 0;
  double size = 0;  ///< metres, side of the black square
  Pose world_from_marker;
};

/// Markers whose place in the world was measured.
struct MarkerMap {
  MarkerDictionary dictionary = MarkerDictionary::k4x4_50;
  std::vector<PlacedMarker> markers;
  /// How well the places are known, one standard deviation an axis, in each marker's own frame: metres,
  /// radians. 0: exactly.
  double position_sigma = 0, angle_sigma = 0;

  const PlacedMarker* find(int id) const {
    for (const PlacedMarker& marker : markers)
      if (marker.id == id) return &marker;
    return nullptr;
  }
};

/// Unit coordinates of the corners, in their order.
inline const std::array<Vec2, 4>& marker_corners() {
  static const std::array<Vec2, 4> corners{Vec2(-0.5, -0.5), Vec2(0.5, -0.5), Vec2(0.5, 0.5),
                                           Vec2(-0.5, 0.5)};
  return corners;
}

/// Where the image of an edge's line passes closest to the pixel at which the edge was seen.
struct EdgeFoot {
  Vec2 on_marker;       ///< the point of the line, unit coordinates
  Vec2 normal;          ///< in the image, unit, towards white
  double distance = 0;  ///< of the edge's pixel from the image of the line, positive towards white; pixels
};

/// Foot of the edge's pixel on the projected line. `pixel_of` maps marker coordinates (units of the side) to
/// image coordinates, std::optional<Vec2>; nullopt where it has none.
template <typename PixelOf>
std::optional<EdgeFoot> foot_of(const MarkerEdge& edge, const PixelOf& pixel_of) {
  const Vec2 along(-edge.towards_white.y(), edge.towards_white.x());
  constexpr double kStep = 1e-4;
  EdgeFoot foot;
  foot.on_marker = edge.on_marker;
  // The image of the line is nearly straight: the second step lands within 1e-6 px of the foot.
  for (int i = 0; i < 3; ++i) {
    const std::optional<Vec2> at = pixel_of(foot.on_marker), ahead = pixel_of(foot.on_marker + kStep * along),
                              behind = pixel_of(foot.on_marker - kStep * along),
                              white = pixel_of(foot.on_marker + kStep * edge.towards_white);
    if (!at || !ahead || !behind || !white) return std::nullopt;
    const Vec2 tangent = (*ahead - *behind) / (2 * kStep);
    const double length2 = tangent.squaredNorm();
    if (!(length2 > 0)) return std::nullopt;
    foot.normal = Vec2(-tangent.y(), tangent.x()) / std::sqrt(length2);
    if (foot.normal.dot(*white - *at) < 0) foot.normal = -foot.normal;
    foot.distance = foot.normal.dot(edge.pixel - *at);
    foot.on_marker += tangent.dot(edge.pixel - *at) / length2 * along;
  }
  return foot;
}

}  // namespace procam
