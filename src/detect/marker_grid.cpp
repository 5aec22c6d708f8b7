#include "marker_grid.hpp"

#include <algorithm>

#include "edge_shift.hpp"
#include "fit_verdict.hpp"
#include "marker_board.hpp"
#include "marker_model.hpp"
#include "procam/core/base/stats.hpp"

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

/// Half a cell from an edge, the next edge has a five-thousandth of its step where cells are this many blurs
/// wide.
constexpr double kClearCells = 7;

MarkerCells cells_of(const MarkerCodes& codes) {
  MarkerCells cells{codes.bits, codes.correctable_bits, {}};
  for (const std::string& code : codes.codes) {
    std::vector<std::uint8_t>& white = cells.white.emplace_back();
    for (const char bit : code) white.push_back(bit == '1');
  }
  return cells;
}

std::vector<FoundCorner> corners_of(const MarkerLayout& layout, const std::vector<RefinedMarker>& refined) {
  std::vector<FoundCorner> corners;
  for (const auto& [marker, residual, blur] : refined)
    for (int c = 0; c < 4; ++c)
      corners.push_back({layout.corner_in_board(marker.id, c),
                         Vec2(c == 1 || c == 2 ? 1 : -1, c >= 2 ? 1 : -1), marker.corners[std::size_t(c)],
                         marker.covariance[std::size_t(c)]});
  return corners;
}

/// Cells by blurs; of most markers.
double clear_cells(const MarkerLayout& layout, const std::vector<RefinedMarker>& refined) {
  std::vector<double> widths;
  for (const auto& [marker, residual, blur] : refined) {
    double side = 1e9;
    for (std::size_t c = 0; c < 4; ++c)
      side = std::min(side, (marker.corners[(c + 1) % 4] - marker.corners[c]).norm());
    widths.push_back(side / layout.codes.modules() / std::max(blur, 0.1));
  }
  return median_or(std::move(widths), 1e9);
}

/// The markers that can be fitted as a whole, with the corners of that fit.
std::vector<RefinedMarker> fitted_whole(const ViewU8& image, const MarkerLayout& layout,
                                        const Straighten& straighten,
                                        const std::vector<RefinedMarker>& refined) {
  const MarkerCells cells = cells_of(layout.codes);
  std::vector<RefinedMarker> whole;
  for (const RefinedMarker& by_edges : refined) {
    const auto fit = fit_model(image, cells, by_edges.marker.id, by_edges.marker.corners, straighten);
    if (!fit) continue;
    Marker& marker = whole.emplace_back(by_edges).marker;
    marker.corners = fit->corners;
    for (int c = 0; c < 4; ++c) marker.covariance[std::size_t(c)] = fit->covariance.block<2, 2>(2 * c, 2 * c);
  }
  return whole;
}

/// Where cells are narrow, the next edges blur into the border's: every marker errs by its own cells, the same
/// in all views. Those markers are fitted as a whole, and keep their edges' corners where that fails. Gamma
/// displaces the two kinds by different amounts.
std::vector<FoundCorner> corners_without_shift(const ViewU8& image, const MarkerLayout& layout,
                                               const BoardMap& map, const std::vector<RefinedMarker>& refined,
                                               bool fit_cells) {
  constexpr std::size_t kFewest = 3;  // markers that determine their displacement
  std::vector<FoundCorner> corners = corners_of(layout, refined);
  remove_edge_shift(corners, image.size());
  if (!fit_cells || clear_cells(layout, refined) > kClearCells) return corners;
  const Straighten straighten = [&](const Vec2& pixel) { return map.straightened(pixel); };
  const std::vector<RefinedMarker> whole = fitted_whole(image, layout, straighten, refined);
  if (whole.size() < kFewest) return corners;
  std::vector<FoundCorner> better = corners_of(layout, whole);
  remove_edge_shift(better, image.size());
  for (std::size_t i = 0, w = 0; i < refined.size() && w < whole.size(); ++i)
    if (refined[i].marker.id == whole[w].marker.id)
      std::copy_n(better.begin() + std::ptrdiff_t(4 * w++), 4, corners.begin() + std::ptrdiff_t(4 * i));
  return corners;
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
    Points2 in_board, pixels;
    for (const auto& [marker, residual, blur] : refined)
      for (int c = 0; c < 4; ++c) {
        in_board.push_back(layout.corner_in_board(marker.id, c));
        pixels.push_back(marker.corners[std::size_t(c)]);
      }
    // What the edges leave is a fiftieth of what the finder leaves.
    if (const auto map =
            BoardMap::fit(in_board, pixels, image.size(), std::vector<double>(pixels.size(), 100)))
      markers->map = *map;
  }

  const std::vector<FoundCorner> corners =
      corners_without_shift(image, layout, markers->map, refined, options.fit_cells);
  for (std::size_t i = 0; i < corners.size(); ++i)
    result.observations.push_back(
        {4 * refined[i / 4].marker.id + int(i % 4), corners[i].pixel, corners[i].covariance});
  if (const std::size_t rejected = markers->markers.size() - refined.size(); rejected > 0)
    result.diagnostics.warn("markers_left_out", std::to_string(rejected) + " of " +
                                                    std::to_string(markers->markers.size()) +
                                                    " markers could not be refined and are rejected: blur, "
                                                    "glare, a cover, or too little light paper round them");
  return result;
}

}  // namespace procam::detect
