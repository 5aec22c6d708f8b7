#include "print.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/homography_fit.hpp"

namespace procam::pattern {
namespace {

constexpr int kRounds = 10;
constexpr int kBlock = 16;  ///< camera pixels that are looked at together
/// From where an edge begins to where it is (camera pixels).
constexpr int kEdgeLength = 4;
/// What corners err by and what lenses bend, in pitches: with few corners the second has no say.
constexpr double kPlaceSigma = 0.005, kBendSigma = 0.05;

/// Cauchy weights for residuals, by their median.
std::vector<double> weights_of(const Points2& residuals) {
  std::vector<double> sizes;
  for (const Vec2& r : residuals) sizes.push_back(r.norm());
  const double scale = std::max(median(sizes), 1e-6);
  for (double& size : sizes) size = 1 / (1 + (size / scale) * (size / scale));
  return sizes;
}

enum Tone : std::uint8_t { kOff, kLight, kDark };

}  // namespace

BoardPlace::Terms BoardPlace::terms(const Vec2& p) const {
  const double x = (p.x() - middle_.x()) / half_, y = (p.y() - middle_.y()) / half_;
  Terms t;
  t << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return t;
}

std::optional<BoardPlace> BoardPlace::fit(const Detections& in_camera, const Board& board) {
  const Points3 points = points_in_board(board);
  const double pitch = pitch_of(board);
  Points2 pixels, places;
  for (const Observation& o : in_camera.observations) {
    pixels.push_back(o.pixel);
    places.push_back(points[std::size_t(o.point)].head<2>() / pitch);
  }
  if (pixels.size() < 4) return std::nullopt;
  BoardPlace place;
  std::vector<double> weights;
  try {
    HomographyOptions options;
    HomographyFit fit = fit_homography(pixels, places, options);
    for (int round = 0; round < kRounds; ++round) {
      options.weights = weights_of(fit.residuals);
      fit = fit_homography(pixels, places, options);
    }
    place.homography_ = fit.destination_from_source;
    weights = options.weights;
  } catch (const Error&) {
    return std::nullopt;
  }

  Vec2 low = places.front(), high = places.front();
  for (const Vec2& p : places) low = low.cwiseMin(p), high = high.cwiseMax(p);
  place.middle_ = 0.5 * (low + high);
  place.half_ = std::max(0.5 * (high - low).maxCoeff(), 1e-9);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 10, 10> normal =
        Eigen::Matrix<double, 10, 10>::Identity() * (kPlaceSigma * kPlaceSigma / (kBendSigma * kBendSigma));
    Eigen::Matrix<double, 10, 2> right = Eigen::Matrix<double, 10, 2>::Zero();
    Points2 residuals(places.size(), Vec2::Zero());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto mapped = place.homography_.apply(pixels[i]);
      if (!mapped) continue;
      const Terms t = place.terms(*mapped);
      normal += weights[i] * t * t.transpose();
      right += weights[i] * t * (places[i] - *mapped).transpose();
      residuals[i] = places[i] - *mapped;
    }
    place.bend_ = normal.ldlt().solve(right);
    for (std::size_t i = 0; i < places.size(); ++i)
      if (const auto mapped = place.homography_.apply(pixels[i]))
        residuals[i] -= place.bend_.transpose() * place.terms(*mapped);
    weights = weights_of(residuals);
  }
  return place;
}

std::optional<Vec2> BoardPlace::at(const Vec2& pixel) const {
  const auto mapped = homography_.apply(pixel);
  if (!mapped) return std::nullopt;
  return Vec2(*mapped + bend_.transpose() * terms(*mapped));
}

Mat2 BoardPlace::jacobian(const Vec2& pixel) const {
  constexpr double kStep = 0.25;
  Mat2 j = Mat2::Zero();
  for (int d = 0; d < 2; ++d) {
    const auto ahead = at(pixel + kStep * Vec2::Unit(d)), behind = at(pixel - kStep * Vec2::Unit(d));
    if (!ahead || !behind) return Mat2::Zero();
    j.col(d) = (*ahead - *behind) / (2 * kStep);
  }
  return j;
}

Print::Print(const BoardPlace& place, const Detections& in_camera, const Board& board,
             const BoardArtwork& artwork, double border_px)
    : place_(place), clear_(in_camera.image_size) {
  const double pitch = pitch_of(board);
  const Points3 points = points_in_board(board);
  low_ = high_ = points[std::size_t(in_camera.observations.front().point)].head<2>() / pitch;
  for (const Observation& o : in_camera.observations) {
    const Vec2 p = points[std::size_t(o.point)].head<2>() / pitch;
    low_ = low_.cwiseMin(p), high_ = high_.cwiseMax(p);
  }
  // Squares surround the corners of a chessboard; round markers and circles the sheet must.
  const bool squares =
      std::holds_alternative<Chessboard>(board) || std::holds_alternative<CharucoBoard>(board);
  const ArtworkRectangle area = squares ? print_of(board) : artwork.sheet;
  low_ = (low_ - Vec2::Ones()).cwiseMax(area.low / pitch);
  high_ = (high_ + Vec2::Ones()).cwiseMin(area.high / pitch);

  const ArtworkIndex index(artwork);
  const ImageSize size = in_camera.image_size;
  ImageU8 tone(size, 1, kOff);
  for (int y0 = 0; y0 < size.height; y0 += kBlock)
    for (int x0 = 0; x0 < size.width; x0 += kBlock) {
      const int x1 = std::min(x0 + kBlock, size.width), y1 = std::min(y0 + kBlock, size.height);
      if (!may_hold_print(x0, y0)) continue;
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
          if (const auto at = place_at(Vec2(x, y)))
            tone.at(x, y) = index.is_dark(*at * pitch) ? kDark : kLight;
    }
  // Between a marker's modules little paper is farther from a border than that. On the light side half the
  // distance will do: dark print sends ten times less across.
  const bool fine = is_coded(board);
  // To how many pixels of a row to either side of a pixel the tone is the same, as far as it matters.
  const int reach = int(std::floor(border_px));
  ImageU8 alike(size);
  for (int y = 0; y < size.height; ++y) {
    const std::uint8_t* row = tone.row(y);
    std::uint8_t* out = alike.row(y);
    for (int x = 0, run = 0; x < size.width; ++x) {
      run = x > 0 && row[x] == row[x - 1] ? std::min(run + 1, reach) : 0;
      out[x] = std::uint8_t(run);
    }
    for (int x = size.width - 1, run = 0; x >= 0; --x) {
      run = x + 1 < size.width && row[x] == row[x + 1] ? std::min(run + 1, reach) : 0;
      out[x] = std::min(out[x], std::uint8_t(run));
    }
  }
  const auto half_widths = [](double clear_px) {
    std::vector<int> widths;
    for (int j = 0; j <= int(std::floor(clear_px)); ++j)
      widths.push_back(int(std::floor(std::sqrt(clear_px * clear_px - j * j))));
    return widths;
  };
  const std::vector<int> of_dark = half_widths(border_px),
                         of_light = half_widths(fine ? 0.5 * border_px : border_px);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const std::uint8_t here = tone.at(x, y);
      if (here == kOff) continue;
      const std::vector<int>& widths = here == kLight ? of_light : of_dark;
      const int rows = int(widths.size()) - 1;
      bool clear = x >= rows && y >= rows && x + rows < size.width && y + rows < size.height;
      for (int j = -rows; clear && j <= rows; ++j)
        clear = tone.at(x, y + j) == here && alike.at(x, y + j) >= widths[std::size_t(std::abs(j))];
      clear_.at(x, y) = clear ? 1 : 0;
    }
}

bool Print::may_hold_print(int x0, int y0) const {
  Vec2 low, high;
  for (int i = 0; i < 4; ++i) {
    const auto at = place_.at(Vec2(x0 + (i & 1) * kBlock, y0 + (i >> 1) * kBlock));
    if (!at) return true;
    low = i == 0 ? *at : Vec2(low.cwiseMin(*at)), high = i == 0 ? *at : Vec2(high.cwiseMax(*at));
  }
  const Vec2 margin = high - low;
  return ((low - margin).array() < high_.array()).all() && ((high + margin).array() > low_.array()).all();
}

ImageU8 Print::area() const {
  const ImageSize size = clear_.size();
  ImageU8 area(size, 1, 0);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (clear_.at(x, y) == 0) continue;
      for (int i = 0; i <= std::min(kEdgeLength, x); ++i) area.at(x - i, y) = 1;
      for (int j = 1; j <= std::min(kEdgeLength, y); ++j) area.at(x, y - j) = 1;
    }
  return area;
}

std::optional<Vec2> Print::place_at(const Vec2& pixel) const {
  const auto at = place_.at(pixel);
  if (!at || at->x() <= low_.x() || at->y() <= low_.y() || at->x() >= high_.x() || at->y() >= high_.y())
    return std::nullopt;
  return at;
}

bool Print::clear(const Vec2& pixel) const {
  const int x = int(std::lround(pixel.x())), y = int(std::lround(pixel.y()));
  return x >= 0 && y >= 0 && x < clear_.width() && y < clear_.height() && clear_.at(x, y) != 0;
}

}  // namespace procam::pattern
