#pragma once
/// Markers found to about a pixel, and the step that refines one.
#include <optional>

#include "edge_fit.hpp"
#include "markers.hpp"

namespace procam::detect {

/// As the installed detector sees it; good to about a pixel.
struct FoundMarker {
  int id = 0;
  std::array<Vec2, 4> corners;
};

std::vector<FoundMarker> find_markers(const ViewU8& image, const MarkerCodes& codes);

/// What is known about a marker's edges besides where they are.
struct EdgeSurroundings {
  int modules = 6;                             ///< across the marker, with its border
  double inside = 0.5, outside = 0.5;          ///< modules
  std::array<double, 4> bends = {0, 0, 0, 0};  ///< of the edge from corner i to i + 1, as EdgeGuess has it
};

struct RefinedMarker {
  Marker marker;
  double residual = 0;  ///< RMS of the worst of its edges' fits, grey levels
};

/// nullopt where an edge is covered, unsharp beyond use, or out of the picture.
std::optional<RefinedMarker> refine_marker(const ViewU8& image, const FoundMarker& found,
                                           const EdgeSurroundings& around, double max_sigma_px);

}  // namespace procam::detect
