#include "procam/detect/chessboard.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "chessboard_search.hpp"
#include "corner_fit.hpp"
#include "corner_grid.hpp"
#include "fit_verdict.hpp"
#include "grid_neighbourhood.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::detect {
namespace {

using Grid = CornerGrid;

std::string counts(int columns, int rows) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

/// Index order reversed: half a turn.
void turn_half(Grid& grid) {
  std::reverse(grid.points.begin(), grid.points.end());
}

/// Rows read from the other end: mirrors the order.
void mirror(Grid& grid) {
  for (int r = 0; r < grid.rows; ++r)
    std::reverse(grid.points.begin() + r * grid.columns, grid.points.begin() + (r + 1) * grid.columns);
}

Vec2 along_rows(const Grid& grid) {
  Vec2 sum = Vec2::Zero();
  for (int r = 0; r < grid.rows; ++r) sum += grid.at(grid.columns - 1, r) - grid.at(0, r);
  return sum / (grid.rows * (grid.columns - 1));
}

Vec2 along_columns(const Grid& grid) {
  Vec2 sum = Vec2::Zero();
  for (int c = 0; c < grid.columns; ++c) sum += grid.at(c, grid.rows - 1) - grid.at(c, 0);
  return sum / (grid.columns * (grid.rows - 1));
}

/// Right-handed, and the first corner towards the image's top left.
void order_by_image(Grid& grid) {
  const Vec2 x = along_rows(grid), y = along_columns(grid);
  if (x.x() * y.y() - x.y() * y.x() < 0) mirror(grid);
  const auto first_corner = [](const Grid& g) {
    return Vec2(-(g.columns - 1) * along_rows(g) - (g.rows - 1) * along_columns(g)).sum();
  };
  if (first_corner(grid) > 0) turn_half(grid);
  if (grid.columns == grid.rows) {
    Grid best = grid;
    for (int i = 0; i < 3; ++i) {
      turn_quarter(grid);
      if (first_corner(grid) < first_corner(best)) best = grid;
    }
    grid = best;
  }
}

using Fits = std::vector<std::optional<CornerFit>>;

void move_to(const Fits& fits, Grid& grid) {
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits[i]) grid.points[i] = fits[i]->corner;
}

/// Calls fit(i, neighbourhood) for each corner. `known`: earlier fits, for the neighbourhoods' precision.
template <typename Fit>
Fits fit_each(const Grid& grid, const Fits& known, const Fit& fit) {
  Fits fits;
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c)
      fits.push_back(fit(fits.size(), neighbourhood_in_grid(grid, known, c, r)));
  return fits;
}

Fits fit_quickly(const ViewU8& image, Grid& grid, double window_share) {
  Fits fits = fit_each(grid, {}, [&](std::size_t, const CornerNeighbourhood& around) {
    return fit_corner(image, around, window_share, FitEffort::kQuick);
  });
  move_to(fits, grid);
  return fits;
}

/// Fits every corner and the bends of its edges, from the quick fits on. Where one of both fails, a full fit has
/// the bends by the neighbours.
Fits fit_precisely(const ViewU8& image, Grid& grid, double window_share, const Fits& quick) {
  Fits fits = fit_each(grid, quick, [&](std::size_t i, const CornerNeighbourhood& around) {
    std::optional<CornerFit> fit;
    if (quick[i]) fit = fit_corner_and_bends(image, around, window_share, *quick[i]);
    return fit ? fit : fit_corner(image, around, window_share);
  });
  move_to(fits, grid);
  return fits;
}

/// Fits every corner again, with the halo of a camera's sharpening, where a sample of the corners shows one. Without
/// it the residual beside the edges pulls corners by their place among the pixels.
void fit_halos(const ViewU8& image, Grid& grid, double window_share, Fits& fits) {
  constexpr std::size_t kSample = 9;        // corners
  constexpr double kMaxResidualLeft = 0.8;  // of the residual without a halo
  const auto fit = [&](std::size_t i, const CornerNeighbourhood& around) {
    return fit_corner_with_halo(image, around, window_share, fits[i] ? &*fits[i] : nullptr);
  };
  const std::size_t stride = std::max<std::size_t>(1, fits.size() / kSample);
  // The median, as soon as it is known.
  int much_less = 0, no_less = 0, in_doubt = 0;
  for (std::size_t i = 0; i < fits.size(); i += stride) in_doubt += fits[i].has_value();
  for (std::size_t i = 0; i < fits.size() && no_less <= much_less + in_doubt; i += stride) {
    const int column = int(i) % grid.columns, row = int(i) / grid.columns;
    if (!fits[i]) continue;
    --in_doubt;
    if (const auto with_halo = fit(i, neighbourhood_in_grid(grid, fits, column, row)))
      ++(with_halo->residual < kMaxResidualLeft * fits[i]->residual ? much_less : no_less);
  }
  if (much_less <= no_less) return;
  const Fits with_halos = fit_each(grid, fits, fit);
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (with_halos[i]) fits[i] = with_halos[i];
  move_to(fits, grid);
}

/// Medians over the fitted corners. light_first is the contrast with the sign that a corner's place in the
/// pattern gives: positive where the outer square beside the first corner is light.
struct PrintQuality {
  double light_first = 0, contrast = 0, residual = 0;  ///< grey levels; contrast without its sign
};

PrintQuality print_quality(const Fits& fits, int columns) {
  std::vector<double> contrasts, sizes, residuals;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (!fits[i]) continue;
    contrasts.push_back(fits[i]->contrast * ((int(i) % columns + int(i) / columns) % 2 == 0 ? 1 : -1));
    sizes.push_back(std::abs(fits[i]->contrast));
    residuals.push_back(fits[i]->residual);
  }
  if (contrasts.empty()) return {};
  return {median(std::move(contrasts)), median(std::move(sizes)), median(std::move(residuals))};
}

/// Of a clean picture the model leaves more at some places among the pixels than at others.
double usual_residual(const PrintQuality& print) {
  constexpr double kLeftOfContrast = 0.01;
  return std::max({print.residual, kLeftOfContrast * print.contrast, 0.5});
}

/// Corners with more than the usual residual are fitted in a smaller window: if that leaves much less, something else is in
/// the window, most often the border of the projected light, which pulls the corner away.
void fit_clear_of_borders(const ViewU8& image, Grid& grid, double window_share, double usual, Fits& fits) {
  constexpr double kSuspect = 1.4, kSmaller = 0.6, kMuchLess = 0.8;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (!fits[i] || fits[i]->residual < kSuspect * usual) continue;
    const int column = int(i) % grid.columns, row = int(i) / grid.columns;
    const auto smaller = fit_corner_and_bends(image, neighbourhood_in_grid(grid, fits, column, row),
                                              kSmaller * window_share, *fits[i]);
    if (smaller && smaller->residual < kMuchLess * fits[i]->residual) fits[i] = smaller;
  }
  move_to(fits, grid);
}

/// Median over the fitted ones; 0 without any.
template <typename Value>
double median_of(const std::vector<const CornerFit*>& fits, Value value) {
  std::vector<double> values;
  for (const CornerFit* fit : fits) values.push_back(value(*fit));
  return median_or(std::move(values), 0.0);
}

/// Contrast in units of the light on the corner: the same in projector light and in room light.
double relative_contrast(const CornerFit& fit) {
  return std::abs(fit.contrast) / std::max(fit.mean, 1.0);
}

/// A rim of a grid: `index(i, k)` numbers its corners (k = 0) and those of the lines inside it, `count` each.
struct Rim {
  enum Side { kLeft, kRight, kTop, kBottom } side;
  int columns, rows;

  Rim(Side of, const Grid& grid) : side(of), columns(grid.columns), rows(grid.rows) {}
  int count() const { return is_column() ? rows : columns; }
  bool is_column() const { return side == kLeft || side == kRight; }
  std::size_t index(int i, int k) const {
    if (side == kLeft) return std::size_t(i * columns + k);
    if (side == kRight) return std::size_t((i + 1) * columns - 1 - k);
    return std::size_t((side == kTop ? k : rows - 1 - k) * columns + i);
  }
};
constexpr Rim::Side kSides[] = {Rim::kLeft, Rim::kRight, Rim::kTop, Rim::kBottom};

/// The line of crossings beyond a rim, one for each of the rim's corners.
struct LineBeyond {
  Points2 points;            ///< fitted, or predicted where there is no crossing
  int alike = 0, clean = 0;  ///< as contrasted as the nearest corners; and fitted as well as these
};

/// On the line beyond the rim of a whole board each crossing has three light quarters. Fitted by the model
/// of a corner it has half a corner's contrast or less, unless light ends there as well; then the residual is
/// a tenth of the contrast or more. Both are compared with the nearest corners, which are lit alike: the
/// border of a projected frame may cross the board.
LineBeyond line_beyond(const ViewU8& image, const Grid& grid, const Fits& fits, const Rim& rim,
                       double window_share) {
  constexpr double kMinContrast = 0.7, kMaxResidual = 2.5;
  // Before the fit, at the predicted place. A light quarter too many halves it, and leaves less by the mean.
  constexpr double kMinContrastBefore = 0.55;
  LineBeyond line;
  for (int i = 0; i < rim.count(); ++i) {
    const auto at = [&](int along, int inwards) { return grid.points[rim.index(along, inwards)]; };
    CornerNeighbourhood around;
    around.corner = 3 * at(i, 0) - 3 * at(i, 1) + at(i, 2);
    around.e_x = around.corner - at(i, 0);
    const int lo = std::max(i - 1, 0), hi = std::min(i + 1, rim.count() - 1);
    around.e_y = (at(hi, 0) - at(lo, 0)) / (hi - lo);
    line.points.push_back(around.corner);
    std::vector<const CornerFit*> nearest;
    for (int along = lo; along <= hi; ++along)
      for (int inwards = 0; inwards < 2; ++inwards)
        if (const auto& other = fits[rim.index(along, inwards)]) nearest.push_back(&*other);
    if (nearest.empty()) continue;
    const double contrast = median_of(nearest, relative_contrast);
    around.min_contrast = kMinContrastBefore * contrast;
    const auto fit = fit_corner(image, around, window_share, FitEffort::kQuick);
    if (!fit) continue;
    line.points.back() = fit->corner;
    if (relative_contrast(*fit) <= kMinContrast * contrast) continue;
    ++line.alike;
    line.clean += fit->residual < kMaxResidual * median_of(
                                                     nearest, [](const CornerFit& f) { return f.residual; });
  }
  return line;
}

/// Counts of the whole board where it is larger than the grid by a line or more on some side.
std::optional<std::string> larger_board(const ViewU8& image, const Grid& grid, const Fits& fits,
                                        double window_share) {
  constexpr double kMinShare = 0.8;
  int more_columns = 0, more_rows = 0;
  for (const Rim::Side side : kSides) {
    const Rim rim(side, grid);
    const bool continues = line_beyond(image, grid, fits, rim, window_share).clean > kMinShare * rim.count();
    (rim.is_column() ? more_columns : more_rows) += continues;
  }
  if (more_columns + more_rows == 0) return std::nullopt;
  return "at least " + counts(grid.columns + more_columns, grid.rows + more_rows);
}

Grid with_line(const Grid& grid, const Rim& rim, const Points2& line) {
  Grid larger{grid.columns + rim.is_column(), grid.rows + !rim.is_column(), {}};
  const int left = rim.side == Rim::kLeft, top = rim.side == Rim::kTop;
  for (int r = 0; r < larger.rows; ++r)
    for (int c = 0; c < larger.columns; ++c) {
      const bool inside = c >= left && c - left < grid.columns && r >= top && r - top < grid.rows;
      larger.points.push_back(inside ? grid.at(c - left, r - top)
                                     : line[std::size_t(rim.is_column() ? r : c)]);
    }
  return larger;
}

/// A part of the board, extended line by line where the print continues: in dim light noise hides corners
/// from the search that a fit over the whole window measures, and on the border of a projected frame it is
/// the light's edge that does. nullopt where it does not continue up to the board's counts.
std::optional<Grid> extended(const ViewU8& image, Grid grid, const Chessboard& board, double window_share) {
  constexpr double kMinShare = 0.6;
  while (grid.columns < board.columns || grid.rows < board.rows) {
    Grid refined = grid;
    fit_quickly(image, refined, window_share);
    const Fits fits = fit_quickly(image, refined, window_share);
    std::optional<Grid> best;
    double best_score = 0;
    for (const Rim::Side side : kSides) {
      const Rim rim(side, refined);
      if (rim.is_column() ? grid.columns >= board.columns : grid.rows >= board.rows) continue;
      const LineBeyond line = line_beyond(image, refined, fits, rim, window_share);
      const double score = double(line.alike + line.clean) / rim.count();
      if (line.alike < kMinShare * rim.count() || score <= best_score) continue;
      best = with_line(refined, rim, line.points);
      best_score = score;
    }
    if (!best) return std::nullopt;
    grid = std::move(*best);
  }
  return grid;
}

/// Of all grids that may be a part of the board, the first that extends to it, the largest first.
std::optional<Grid> extended(const ViewU8& image, std::vector<Grid> parts, const Chessboard& board,
                             double window_share) {
  std::sort(parts.begin(), parts.end(),
            [](const Grid& a, const Grid& b) { return a.points.size() > b.points.size(); });
  for (Grid& part : parts)
    for (int turns = 0; turns < 2; ++turns, turn_quarter(part))
      if (part.columns <= board.columns && part.rows <= board.rows)
        if (auto grid = extended(image, part, board, window_share)) return grid;
  return std::nullopt;
}

/// Does a board of these counts, or a part of it, explain the grid?
bool is_within(const Grid& grid, const Chessboard& board) {
  return std::min(grid.columns, grid.rows) <= std::min(board.columns, board.rows) &&
         std::max(grid.columns, grid.rows) <= std::max(board.columns, board.rows);
}

/// Something else than one of the boards that are known to be there. Of two boards a grid that both explain tells nothing.
std::optional<Grid> unexpected(const cv::Mat& image, const Chessboard& board, const std::vector<Grid>& found,
                               const std::vector<Chessboard>& known) {
  const auto is_known = [&](const Grid& grid) {
    return std::any_of(known.begin(), known.end(),
                       [&](const Chessboard& other) { return is_within(grid, other); });
  };
  std::optional<Grid> largest;
  for (const Grid& grid : found)
    if (!is_known(grid) && (!largest || grid.points.size() > largest->points.size())) largest = grid;
  if (!largest && found.empty()) {
    largest = find_any(image, board);
    if (largest && is_known(*largest)) return std::nullopt;
  }
  return largest;
}

void explain_missing(const cv::Mat& image, const Chessboard& board, const std::vector<Grid>& others,
                     const ChessboardOptions& options, Diagnostics& diagnostics) {
  const std::optional<Grid> other = unexpected(image, board, others, options.others);
  const std::string asked = counts(board.columns, board.rows);
  if (other && other->columns * other->rows > 9) {
    // Printed counts are named the way round that resembles the question.
    const bool swap = (board.columns < board.rows) != (other->columns < other->rows);
    const std::string found =
        swap ? counts(other->rows, other->columns) : counts(other->columns, other->rows);
    diagnostics.warn(
        "board_counts_differ",
        is_within(*other, board)
            ? "only " + found + " of its " + asked +
                  " inner corners show: light or uncover the rest of the board; if that is all of "
                  "it, " +
                  options.counts_advice + found
            : "a board with " + found + " inner corners was found where " + asked +
                  " was asked; if the whole board is in the picture, " + options.counts_advice + found +
                  " (inner corners, not squares), else uncover the rest");
    return;
  }
  if (!options.others.empty() && !others.empty()) {
    diagnostics.warn(
        "board_not_found",
        "of the two boards only the other one was found, and no chessboard with " + asked +
            " inner corners; all of it must lie in the image, on blank paper, sharp and neither dim nor "
            "saturated, with a light margin of half a square around it; check its counts too");
    return;
  }
  diagnostics.warn(
      "board_not_found",
      "no chessboard with " + asked +
          " inner corners was found; check the counts (inner corners, one less than squares a side), "
          "that all of the board and a white margin around it are in the image, sharp and not saturated");
}

}  // namespace

Detections detect_chessboard(const ViewU8& image, const Chessboard& board, const ChessboardOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_chessboard: needs an image with one channel");
  require(
      board.columns >= 3 && board.rows >= 3,
      "detect_chessboard: a board needs 3x3 inner corners or more, not " + counts(board.columns, board.rows));
  Detections result;
  result.image_size = image.size();
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                       std::size_t(image.stride));

  GridSearch search = search_grids(pixels, board);
  // Within a larger grid the sectors would find a part of it.
  const bool within_larger = std::any_of(search.others.begin(), search.others.end(), [&](const Grid& other) {
    return std::min(other.columns, other.rows) >= std::min(board.columns, board.rows) &&
           std::max(other.columns, other.rows) >= std::max(board.columns, board.rows);
  });
  std::optional<Grid> grid = std::move(search.asked);
  if (!grid) grid = extended(image, search.others, board, options.window_share);
  if (!grid && !within_larger) grid = find_by_sectors(pixels, board);
  if (!grid) {
    explain_missing(pixels, board, search.others, options, result.diagnostics);
    return result;
  }
  order_by_image(*grid);
  // The second round has the first one's neighbours for the bending of the edges.
  const Fits quick = fit_quickly(image, *grid, options.window_share);
  Fits fits = fit_precisely(image, *grid, options.window_share, quick);
  fit_halos(image, *grid, options.window_share, fits);
  const PrintQuality print = print_quality(fits, board.columns);
  const double usual = usual_residual(print);
  fit_clear_of_borders(image, *grid, options.window_share, usual, fits);
  if (const auto found = larger_board(image, *grid, fits, options.window_share)) {
    result.diagnostics.warn("board_counts_differ", "the pattern goes on beyond the " +
                                                       counts(board.columns, board.rows) +
                                                       " inner corners that were asked; there are " + *found +
                                                       ": give the counts of all of it");
    return result;
  }
  // With one count odd the two ends differ in colour: the outer square beside the first corner is dark.
  if ((board.columns + board.rows) % 2 == 1 && print.light_first > 0) std::reverse(fits.begin(), fits.end());

  int rejected = 0;
  for (int i = 0; i < board.size(); ++i) {
    const auto& fit = fits[std::size_t(i)];
    if (fit && std::sqrt(fit->covariance.trace() / 2) <= options.max_sigma_px &&
        fit->residual < kWorstResidual * usual)
      result.observations.push_back({i, fit->corner, fit->covariance});
    else
      ++rejected;
  }
  report_rejected(result.diagnostics, "corners_left_out", rejected, board.size(), "corners",
                  "a cover or the image's rim beside them");
  return result;
}

}  // namespace procam::detect
