#include "marker_grid.hpp"

#include <algorithm>

#include "edge_shift.hpp"
#include "fit_verdict.hpp"
#include "marker_board.hpp"

namespace procam::detect {
namespace {

/// How the map bends the edge between two board points: the second derivative of its distance from the chord,
/// towards the left of the way (edge_fit.hpp).
double bend_between(const BoardMap& map, const Vec2& from, const Vec2& to) {
  const auto a = map.at(from), b = map.at(to), m = map.at(0.5 * (from + to));
  if (!a || !b || !m) return 0;
  const Vec2 chord = *b - *a;
  const double length = chord.norm();
  const Vec2 normal = Vec2(chord.y(), -chord.x()) / length;
  return -8 * (*m - 0.5 * (*a + *b)).dot(normal) / (length * length);
}

/// Drops the markers whose edges fit worse than most: a cover reaches over them.
void drop_strangers(std::vector<RefinedMarker>& refined) {
  std::vector<double> residuals;
  for (const RefinedMarker& r : refined) residuals.push_back(r.residual);
  std::sort(residuals.begin(), residuals.end());
  if (residuals.empty()) return;
  const double usual = std::max(residuals[residuals.size() / 2], 0.5);
  const auto stranger = [&](const RefinedMarker& r) { return r.residual > kWorstResidual * usual; };
  refined.erase(std::remove_if(refined.begin(), refined.end(), stranger), refined.end());
}

}  // namespace

Detections detect_marker_grid(const ViewU8& image, const MarkerGrid& board, const MarkerOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_marker_grid: needs an image with one channel");
  require(board.flaw().empty(), "detect_marker_grid: " + board.flaw());
  Detections result;
  result.image_size = image.size();
  const MarkerLayout layout("marker grid", board);
  auto markers = find_board_markers(image, layout, result.diagnostics);
  if (!markers) return result;

  EdgeSurroundings around;
  around.modules = layout.codes.modules();
  around.inside = options.window_modules;
  // The neighbour's edge begins a gap away.
  around.outside = std::min(options.window_modules, 0.5 * board.gap / (board.marker_size / around.modules));
  std::vector<RefinedMarker> refined;
  // The first round's corners are good enough to say how the lens bends the edges of the second.
  for (int round = 0; round < 2; ++round) {
    refined.clear();
    for (const FoundMarker& found : markers->markers) {
      if (round > 0)
        for (int i = 0; i < 4; ++i)
          around.bends[std::size_t(i)] = bend_between(markers->map, layout.corner_in_board(found.id, i),
                                                      layout.corner_in_board(found.id, (i + 1) % 4));
      if (const auto marker = refine_marker(image, found, around, options.max_sigma_px))
        refined.push_back(*marker);
    }
    drop_strangers(refined);
    if (round > 0) break;
    Points2 in_board, pixels;
    for (const auto& [marker, residual] : refined)
      for (int c = 0; c < 4; ++c) {
        in_board.push_back(layout.corner_in_board(marker.id, c));
        pixels.push_back(marker.corners[std::size_t(c)]);
      }
    // What the edges leave is a fiftieth of what the finder leaves.
    if (const auto map =
            BoardMap::fit(in_board, pixels, image.size(), std::vector<double>(pixels.size(), 100)))
      markers->map = *map;
  }

  std::vector<FoundCorner> corners;
  for (const auto& [marker, residual] : refined)
    for (int c = 0; c < 4; ++c)
      corners.push_back({layout.corner_in_board(marker.id, c),
                         Vec2(c == 1 || c == 2 ? 1 : -1, c >= 2 ? 1 : -1), marker.corners[std::size_t(c)],
                         marker.covariance[std::size_t(c)]});
  remove_edge_shift(corners, image.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    result.observations.push_back(
        {4 * refined[i / 4].marker.id + int(i % 4), corners[i].pixel, corners[i].covariance});
  report_rejected(result.diagnostics, "markers_left_out", int(markers->markers.size() - refined.size()),
                  int(markers->markers.size()), "markers", "a cover or too little light paper round them");
  return result;
}

}  // namespace procam::detect
