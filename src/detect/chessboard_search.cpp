#include "chessboard_search.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace procam::detect {
namespace {

using Grid = CornerGrid;

/// Of the quadrilateral between its four corners, twice.
double area(const Grid& grid) {
  const Vec2 a = grid.at(grid.columns - 1, grid.rows - 1) - grid.at(0, 0),
             b = grid.at(0, grid.rows - 1) - grid.at(grid.columns - 1, 0);
  return std::abs(a.x() * b.y() - a.y() * b.x());
}

/// A picture to search, and how its pixels map to the original's: original = scale * pixel + (scale - 1) / 2.
struct SearchPicture {
  cv::Mat pixels;
  int scale = 1;

  Vec2 in_original(const Vec2& pixel) const { return scale * pixel + 0.5 * (scale - 1) * Vec2::Ones(); }
};

SearchPicture reduced(const cv::Mat& image, int scale) {
  if (scale == 1) return {image, 1};
  SearchPicture small{{}, scale};
  cv::resize(image, small.pixels, cv::Size(image.cols / scale, image.rows / scale), 0, 0, cv::INTER_AREA);
  return small;
}

/// The smallest power of two that leaves an image of at most `pixels`.
int scale_for(const cv::Mat& image, double pixels) {
  int scale = 1;
  while (double(image.cols) * image.rows > pixels * scale * scale) scale *= 2;
  return scale;
}

Grid grid_from(const std::vector<cv::Point2f>& corners, int columns, int rows, const SearchPicture& picture) {
  Grid grid{columns, rows, {}};
  for (const cv::Point2f& c : corners) grid.points.push_back(picture.in_original(Vec2(c.x, c.y)));
  return grid;
}

/// Large enough for squares of a hundredth of the image's width.
constexpr double kQuickPixels = 1.4e6;
/// And of a twentieth of it.
constexpr double kGlancePixels = 1e5;

/// Half the size where that leaves squares large enough: four times as fast, and less noise. Never more than
/// kQuickPixels.
SearchPicture quick_look(const cv::Mat& image) {
  const int half = std::min(image.cols, image.rows) < 700 ? 1 : 2;
  return reduced(image, std::max(half, scale_for(image, kQuickPixels)));
}

/// No two steps in a row along a line differ by half of the shorter one: no lens and no view bends a print so. A
/// small picture, in which squares are a few pixels wide, shows crossings that are none.
bool is_regular(const Grid& grid) {
  constexpr double kMaxChange = 0.5;  // of the shorter step
  const auto even = [](const Vec2& before, const Vec2& here, const Vec2& after) {
    const Vec2 a = here - before, b = after - here;
    return (b - a).norm() < kMaxChange * std::min(a.norm(), b.norm());
  };
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      if (c > 0 && c + 1 < grid.columns && !even(grid.at(c - 1, r), grid.at(c, r), grid.at(c + 1, r)))
        return false;
      if (r > 0 && r + 1 < grid.rows && !even(grid.at(c, r - 1), grid.at(c, r), grid.at(c, r + 1)))
        return false;
    }
  return true;
}

/// Sizes at which to search: a board that fills the picture shows at a small one, at once.
std::vector<int> search_scales(const cv::Mat& image) {
  const int first = scale_for(image, kQuickPixels);
  std::vector<int> scales;
  for (int scale = scale_for(image, kGlancePixels); scale > first; scale /= 2) scales.push_back(scale);
  for (const int scale : {first, 2 * first})
    if (std::count(scales.begin(), scales.end(), scale) == 0) scales.push_back(scale);
  for (int scale = first / 2; scale >= 1; scale /= 2) scales.push_back(scale);
  return scales;
}

/// The print's reflectance, roughly: the picture divided by its grey-level closing, which fills what is
/// darker and narrower than the window. Other than a local mean or maximum, the closing keeps the border of
/// the projector's light where it is, so that a board half in projector light and half in room light looks
/// evenly lit.
SearchPicture reflectance(const SearchPicture& picture) {
  cv::Mat smooth, light, ratio;
  cv::GaussianBlur(picture.pixels, smooth, cv::Size(), picture.scale == 1 ? 1.5 : 0.8);
  const int window = std::max(15, std::min(smooth.cols, smooth.rows) / 12) | 1;
  cv::morphologyEx(smooth, light, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_RECT, cv::Size(window, window)));
  smooth.convertTo(smooth, CV_32F);
  light.convertTo(light, CV_32F, 1, 4);  // four grey levels: darkness is not blown up to noise
  cv::divide(smooth, light, ratio, 230);
  ratio.convertTo(ratio, CV_8U);
  return {ratio, picture.scale};
}

}  // namespace

void turn_quarter(Grid& grid) {
  Grid turned{grid.rows, grid.columns, grid.points};
  for (int r = 0; r < turned.rows; ++r)
    for (int c = 0; c < turned.columns; ++c) turned.at(c, r) = grid.at(r, grid.rows - 1 - c);
  grid = turned;
}

GridSearch search_grids(const cv::Mat& image, const Chessboard& board) {
  GridSearch search;
  for (const int scale : search_scales(image)) {
    const SearchPicture picture = reduced(image, scale);
    for (Grid& grid : find_corner_grids(picture.pixels)) {
      if (!is_regular(grid)) continue;
      for (Vec2& p : grid.points) p = picture.in_original(p);
      if (grid.columns != board.columns) turn_quarter(grid);
      const bool counts_fit = grid.columns == board.columns && grid.rows == board.rows;
      if (!counts_fit)
        search.others.push_back(std::move(grid));
      else if (!search.asked || area(*search.asked) < area(grid))
        search.asked = std::move(grid);
    }
    if (search.asked) break;
  }
  return search;
}

std::optional<Grid> find_by_sectors(const cv::Mat& image, const Chessboard& board) {
  constexpr double kFullPixels = 6e6;
  const auto search = [&](const SearchPicture& picture, int flags) -> std::optional<Grid> {
    std::vector<cv::Point2f> corners;
    if (!cv::findChessboardCornersSB(picture.pixels, cv::Size(board.columns, board.rows), corners, flags))
      return std::nullopt;
    return grid_from(corners, board.columns, board.rows, picture);
  };
  const SearchPicture quick = quick_look(image), full = reduced(image, scale_for(image, kFullPixels));
  if (auto grid = search(quick, cv::CALIB_CB_NORMALIZE_IMAGE)) return grid;
  const SearchPicture quick_reflectance = reflectance(quick);
  if (auto grid = search(quick_reflectance, 0)) return grid;
  if (quick.scale > full.scale) {
    if (auto grid = search(full, cv::CALIB_CB_NORMALIZE_IMAGE)) return grid;
    if (auto grid = search(reflectance(full), 0)) return grid;
  }
  if (auto grid = search(quick_reflectance, cv::CALIB_CB_EXHAUSTIVE)) return grid;
  return search(full, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE);
}

std::optional<Grid> find_any(const cv::Mat& image, const Chessboard& board) {
  const SearchPicture quick = quick_look(image);
  std::optional<Grid> best;
  for (const auto& [columns, rows] :
       {std::pair(board.columns - 1, board.rows - 1), std::pair(board.rows - 1, board.columns - 1),
        std::pair(board.columns - 2, board.rows - 2), std::pair(3, 3)}) {
    if (columns < 3 || rows < 3) continue;
    std::vector<cv::Point2f> corners;
    cv::Mat meta;
    const int flags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER;
    if (!cv::findChessboardCornersSB(quick.pixels, cv::Size(columns, rows), corners, flags, meta)) continue;
    if (!best || int(corners.size()) > int(best->points.size()))
      best = grid_from(corners, meta.cols, meta.rows, quick);
  }
  return best;
}

}  // namespace procam::detect
