#include "coded_corners.hpp"

#include <algorithm>
#include <cmath>

#include "corner_fit.hpp"
#include "fit_verdict.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::detect {
namespace {

/// What the model leaves of a clean picture, as a share of the contrast.
constexpr double kModelResidual = 0.01;
/// Flat paper where a corner should be, as a share of the usual contrast.
constexpr double kMinCodedContrast = 0.35;
/// Corners weigh more in the map than markers, which are found to a pixel.
constexpr double kCornerWeight = 100;

/// `blur`: of the picture, pixels; the markers blur out that far.
std::optional<CornerNeighbourhood> neighbourhood(const BoardMap& map, const Vec2& p,
                                                 const CodedCorners& corners, double blur) {
  const double s = corners.square;
  const auto here = map.at(p), left = map.at(p - Vec2(s, 0)), right = map.at(p + Vec2(s, 0)),
             up = map.at(p - Vec2(0, s)), down = map.at(p + Vec2(0, s));
  if (!here || !left || !right || !up || !down) return std::nullopt;
  CornerNeighbourhood around;
  around.corner = *here;
  around.e_x = 0.5 * (*right - *left);
  around.e_y = 0.5 * (*down - *up);
  around.e_xx = *right - 2 * *here + *left;
  around.e_yy = *down - 2 * *here + *up;
  if (corners.margin >= 1) return around;
  const double square = std::max(1.0, std::min(around.e_x.norm(), around.e_y.norm()));
  around.clear = std::max(corners.margin - 2 * blur / square, 0.4 * corners.margin);
  return around;
}

using Fits = std::vector<std::optional<CornerFit>>;

/// Fits that cannot be corners of this print are dropped: wrong colours, faint, or worse than most.
void drop_strangers(const CodedCorners& corners, Fits& fits) {
  std::vector<double> contrasts, residuals;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (!fits[i]) continue;
    // contrast is positive where the square at (+x, +y) is light; from here on where it is as printed.
    if (!corners.light_beyond[i]) fits[i]->contrast *= -1;
    contrasts.push_back(fits[i]->contrast);
    residuals.push_back(fits[i]->residual);
  }
  if (contrasts.empty()) return;
  // Covered corners may be the most, and are faint: the usual contrast is that of the better quarter.
  std::sort(contrasts.begin(), contrasts.end());
  const double contrast = contrasts[3 * contrasts.size() / 4];
  residuals.clear();
  for (auto& fit : fits) {
    if (fit && fit->contrast < kMinCodedContrast * std::max(contrast, 10.0)) fit.reset();
    if (fit) residuals.push_back(fit->residual);
  }
  if (residuals.empty()) return;
  const double residual = std::max(median(residuals), kModelResidual * contrast);
  for (auto& fit : fits)
    if (fit && fit->residual > kWorstResidual * residual) fit.reset();
}

}  // namespace

void find_coded_corners(const ViewU8& image, const BoardMarkers& markers, const CodedCorners& corners,
                        double window_share, double max_sigma_px, Detections& result) {
  BoardMap map = markers.map;
  Fits fits;
  int in_picture = 0;
  double blur = 0.7;
  // The second round knows from the first one's corners where the others are, and how the lens bends.
  for (int round = 0; round < 2; ++round) {
    fits.assign(corners.points.size(), std::nullopt);
    in_picture = 0;
    for (int i = 0; i < int(corners.points.size()); ++i) {
      const auto around = neighbourhood(map, corners.points[std::size_t(i)], corners, blur);
      if (!around) continue;
      const Vec2& p = around->corner;
      if (p.x() < 0 || p.y() < 0 || p.x() > image.width - 1 || p.y() > image.height - 1) continue;
      ++in_picture;
      auto fit = fit_corner(image, *around, window_share);
      if (fit &&
          (fit->corner - p).norm() < corners.out_of_place * std::min(around->e_x.norm(), around->e_y.norm()))
        fits[std::size_t(i)] = fit;
    }
    drop_strangers(corners, fits);
    if (round > 0) break;
    Points2 in_board = markers.in_board, pixels = markers.pixels;
    std::vector<double> weights(pixels.size(), 1), blurs;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (!fits[i]) continue;
      in_board.push_back(corners.points[i]);
      pixels.push_back(fits[i]->corner);
      weights.push_back(kCornerWeight);
      blurs.push_back(fits[i]->blur);
    }
    if (!blurs.empty()) blur = median(blurs);
    if (const auto better = BoardMap::fit(in_board, pixels, image.size(), weights)) map = *better;
  }

  for (int i = 0; i < int(corners.points.size()); ++i) {
    const auto& fit = fits[std::size_t(i)];
    if (fit && std::sqrt(fit->covariance.trace() / 2) <= max_sigma_px)
      result.observations.push_back({i, fit->corner, fit->covariance});
  }
  report_rejected(result.diagnostics, "corners_left_out", in_picture - int(result.observations.size()),
                  in_picture, "corners in the image", "a cover or the image's rim beside them");
}

}  // namespace procam::detect
