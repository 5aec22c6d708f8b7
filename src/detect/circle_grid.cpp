#include "circle_grid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <string>

#include "board_map.hpp"
#include "disc_fit.hpp"
#include "fit_verdict.hpp"
#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/homography_fit.hpp"

namespace procam::detect {
namespace {

/// Centres from blobs are good to about half a pixel, fitted ones to a fiftieth.
constexpr double kFittedWeight = 100;

/// The blob finder's thresholds are grey levels of a well exposed picture: the one it gets has its brightest
/// paper near white, however dim the light was.
cv::Mat brightened(const ViewU8& image) {
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                       std::size_t(image.stride));
  std::array<int, 256> counts{};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) ++counts[image.at(x, y)];
  int brightest = 255;
  for (int above = 0; brightest > 1; --brightest) {
    above += counts[std::size_t(brightest)];
    if (above > image.width * image.height / 100) break;
  }
  cv::Mat bright;
  pixels.convertTo(bright, CV_8U, 240.0 / brightest);
  return bright;
}

/// Centres row by row in some order of rows and columns, to about a pixel.
std::optional<Points2> find_centres(const ViewU8& image, const CircleGrid& board) {
  const cv::Mat pixels = brightened(image);
  cv::SimpleBlobDetector::Params blobs;
  blobs.minThreshold = 20;
  blobs.minArea = 20;
  blobs.maxArea = float(image.width) * float(image.height) / float(board.size());
  blobs.minDistBetweenBlobs = 4;
  blobs.minInertiaRatio = 0.05f;
  const auto detector = cv::SimpleBlobDetector::create(blobs);
  const int layout = board.asymmetric ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID;
  for (const int flags : {layout, layout | cv::CALIB_CB_CLUSTERING}) {
    std::vector<cv::Point2f> centres;
    if (!cv::findCirclesGrid(pixels, cv::Size(board.columns, board.rows), centres, flags, detector)) continue;
    Points2 found;
    for (const cv::Point2f& c : centres) found.emplace_back(c.x, c.y);
    return found;
  }
  return std::nullopt;
}

/// The finder's order turned or mirrored into the board's own: of the orders that are not mirrored and fit
/// about as well as the best, the one whose first point lies towards the top left.
std::optional<Points2> in_board_order(const CircleGrid& board, const Points2& in_board,
                                      const Points2& found) {
  struct Order {
    Points2 pixels;
    double rmse, first;
  };
  std::vector<Order> orders;
  for (int turn = 0; turn < (board.columns == board.rows ? 8 : 4); ++turn) {
    Order order;
    for (int row = 0; row < board.rows; ++row)
      for (int column = 0; column < board.columns; ++column) {
        int c = (turn & 1) != 0 ? board.columns - 1 - column : column;
        int r = (turn & 2) != 0 ? board.rows - 1 - row : row;
        if ((turn & 4) != 0) std::swap(c, r);
        order.pixels.push_back(found[std::size_t(r * board.columns + c)]);
      }
    try {
      const HomographyFit fit = fit_homography(in_board, order.pixels);
      if (fit.destination_from_source.mirrors()) continue;
      order.rmse = fit.rmse;
    } catch (const Error&) {
      continue;
    }
    order.first = order.pixels.front().sum();
    orders.push_back(order);
  }
  if (orders.empty()) return std::nullopt;
  double best = orders.front().rmse;
  for (const Order& order : orders) best = std::min(best, order.rmse);
  const Order* chosen = nullptr;
  for (const Order& order : orders)
    if (order.rmse <= 1.5 * best + 0.5 && (chosen == nullptr || order.first < chosen->first)) chosen = &order;
  return chosen->pixels;
}

/// The image of a disc under the map: the ellipse through its rim's points.
struct Ellipse {
  Vec2 centre;
  Mat2 shape;
};

std::optional<Ellipse> image_of_disc(const BoardMap& map, const Vec2& centre, double radius) {
  constexpr int kPoints = 32;
  const auto middle = map.at(centre);
  if (!middle) return std::nullopt;
  // x^T A x + g . x = 1 about the mapped centre; scaled, so that the equations are well conditioned.
  Eigen::Matrix<double, kPoints, 5> rows;
  double scale = 0;
  Points2 rim;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * EIGEN_PI * i / kPoints;
    const auto p = map.at(centre + radius * Vec2(std::cos(angle), std::sin(angle)));
    if (!p) return std::nullopt;
    rim.push_back(*p - *middle);
    scale = std::max(scale, rim.back().norm());
  }
  if (!(scale > 0)) return std::nullopt;
  for (int i = 0; i < kPoints; ++i) {
    const Vec2 p = rim[std::size_t(i)] / scale;
    rows.row(i) << p.x() * p.x(), 2 * p.x() * p.y(), p.y() * p.y(), p.x(), p.y();
  }
  const Eigen::Matrix<double, 5, 1> conic =
      Cholesky(Eigen::Matrix<double, 5, 5>(rows.transpose().lazyProduct(rows)))
          .solve(Eigen::Matrix<double, 5, 1>(rows.colwise().sum().transpose()));
  Mat2 a;
  a << conic[0], conic[1], conic[1], conic[2];
  const Vec2 shift = -0.5 * a.inverse() * conic.tail<2>();
  // About its own centre: (x - shift)^T A (x - shift) = 1 + shift^T A shift.
  const Mat2 shape = a / (1 + shift.dot(a * shift)) / (scale * scale);
  if (!(shape.determinant() > 0)) return std::nullopt;
  return Ellipse{*middle + scale * shift, shape};
}

/// `before`: the disc's fit in the round before, with which perspective and lens displace the ellipse's centre.
std::optional<DiscFit> fit_again(const ViewU8& image, const BoardMap& map, const Vec2& in_board,
                                 double radius, double half_gap, const std::optional<DiscFit>& before) {
  std::optional<DiscFit> fit;
  const auto mapped = map.at(in_board);
  const auto ellipse = image_of_disc(map, in_board, radius);
  if (mapped && ellipse) {
    const double pixels_per_metre = 1 / (radius * std::sqrt(ellipse->shape.trace()));
    DiscGuess guess;
    guess.centre = before ? before->centre + ellipse->centre - *mapped : ellipse->centre;
    guess.shape = ellipse->shape;
    const double reach = before ? std::max(3.5 * before->blur, 2.5) : 1e9;
    guess.inside = std::clamp(0.7 * radius * pixels_per_metre, 1.5, reach);
    guess.outside = std::clamp(0.9 * half_gap * pixels_per_metre, 1.5, reach);
    fit = fit_disc(image, guess);
    if (fit) fit->centre += *mapped - ellipse->centre;
  }
  return fit;
}

/// Fits of all discs, in the board's order.
std::vector<std::optional<DiscFit>> fit_discs(const ViewU8& image, const CircleGrid& board,
                                              const Points2& in_board, BoardMap map) {
  // A gap's half away the neighbour begins; staggered neighbours stand sqrt(2) rows apart.
  const double radius = 0.5 * board.diameter;
  const double half_gap = 0.5 * ((board.asymmetric ? std::sqrt(2.0) : 1) * board.spacing) - radius;
  std::vector<std::optional<DiscFit>> fits(in_board.size());
  // Each round knows the last one's centres, and with them how perspective and lens displace the ellipses'.
  for (int round = 0; round < 3; ++round) {
    Points2 seen, seen_in_board;
    for (std::size_t i = 0; i < in_board.size(); ++i) {
      fits[i] = fit_again(image, map, in_board[i], radius, half_gap, fits[i]);
      if (!fits[i]) continue;
      seen.push_back(fits[i]->centre);
      seen_in_board.push_back(in_board[i]);
    }
    if (const auto better =
            BoardMap::fit(seen_in_board, seen, image.size(), std::vector<double>(seen.size(), kFittedWeight)))
      map = *better;
  }
  return fits;
}

double usual_residual(const std::vector<std::optional<DiscFit>>& fits) {
  std::vector<double> residuals;
  for (const auto& fit : fits)
    if (fit) residuals.push_back(fit->residual);
  return residuals.empty() ? 0 : std::max(at_rank(residuals, residuals.size() / 2), 0.5);
}

}  // namespace

Detections detect_circle_grid(const ViewU8& image, const CircleGrid& board,
                              const CircleGridOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_circle_grid: needs an image with one channel");
  require(board.flaw().empty(), "detect_circle_grid: " + board.flaw());
  Detections result;
  result.image_size = image.size();
  Points2 in_board;
  for (const Vec3& p : points_in_board(board)) in_board.push_back(p.head<2>());
  const auto found = find_centres(image, board);
  const auto pixels = found ? in_board_order(board, in_board, *found) : std::nullopt;
  auto map = pixels ? BoardMap::fit(in_board, *pixels, image.size()) : std::nullopt;
  if (!map) {
    result.diagnostics.warn(
        "board_not_found",
        "no grid of " + std::to_string(board.columns) + "x" + std::to_string(board.rows) +
            (board.asymmetric ? " staggered" : "") +
            " dark circles was found; check the counts and the kind, and that every circle "
            "is in the picture, sharp, and on light paper");
    return result;
  }

  const std::vector<std::optional<DiscFit>> fits = fit_discs(image, board, in_board, *map);
  const double usual = usual_residual(fits);
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits[i] && fits[i]->residual < kWorstResidual * usual &&
        std::sqrt(fits[i]->covariance.trace() / 2) <= options.max_sigma_px)
      result.observations.push_back({int(i), fits[i]->centre, fits[i]->covariance});
  report_rejected(result.diagnostics, "circles_left_out", int(fits.size() - result.observations.size()),
                  int(fits.size()), "circles", "a cover or the image's rim beside them");
  return result;
}

}  // namespace procam::detect
