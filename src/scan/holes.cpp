#include "holes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace procam::scan {
namespace {

/// The slope of a side is that between its last pixel and one this far behind it.
constexpr int kNearest = 2, kFarthest = 6;

/// Holes are bridged from their borders: each pass finds the pixels of the one before as measured.
constexpr int kPasses = 3;

/// One row or column of the images.
class Line {
 public:
  Line(const ImageF& depth, const ImageF& sigma, bool along_x, int number)
      : depth_(depth), sigma_(sigma), along_x_(along_x), number_(number) {}

  int length() const { return along_x_ ? depth_.width() : depth_.height(); }
  double depth(int at) const {
    if (at < 0 || at >= length()) return 0;
    return double(along_x_ ? depth_.at(at, number_) : depth_.at(number_, at));
  }
  double sigma(int at) const { return double(along_x_ ? sigma_.at(at, number_) : sigma_.at(number_, at)); }

 private:
  const ImageF &depth_, &sigma_;
  bool along_x_;
  int number_;
};

/// The inverse depth that the side which ends at `end`, and goes on in steps of `back`, has at `there`; and its standard
/// deviation.
struct Continued {
  double inverse, sigma;
};
std::optional<Continued> continued(const Line& line, int end, int back, int there) {
  for (int apart = kFarthest; apart >= kNearest; --apart) {
    const int behind = end + back * apart;
    if (!(line.depth(behind) > 0)) continue;
    const double w = 1 / line.depth(end), w_behind = 1 / line.depth(behind);
    const double share = double(std::abs(there - end)) / apart;
    const double sigma_w = line.sigma(end) * w * w, sigma_behind = line.sigma(behind) * w_behind * w_behind;
    return Continued{w + share * (w - w_behind), std::hypot((1 + share) * sigma_w, share * sigma_behind)};
  }
  return std::nullopt;
}

bool goes_on(const Line& line, int end, int back, int there, double max_deviation) {
  const std::optional<Continued> expected = continued(line, end, back, there);
  if (!expected || !(expected->inverse > 0)) return false;
  const double z = line.depth(there);
  const double sigma = std::hypot(expected->sigma * z * z, line.sigma(there));
  return std::abs(1 / expected->inverse - z) <=
         3 * sigma + max_deviation + 0.1 * std::abs(z - line.depth(end));
}

/// Of one pixel, by its row and its column.
struct Filled {
  double inverse = 0, sigma = 0, weight = 0;
  void add(double inverse_depth, double its_sigma, double its_weight) {
    inverse += its_weight * inverse_depth;
    sigma = std::max(sigma, its_sigma);
    weight += its_weight;
  }
};

/// Adds what the line says of its holes.
template <typename Add>
void bridge(const Line& line, int max_hole, double max_deviation, const Add& add) {
  int before = -1;
  for (int at = 0; at < line.length(); ++at) {
    if (!(line.depth(at) > 0)) continue;
    const int gap = at - before;
    if (before >= 0 && gap > 1 && gap <= max_hole + 1 && goes_on(line, before, -1, at, max_deviation) &&
        goes_on(line, at, 1, before, max_deviation))
      for (int i = before + 1; i < at; ++i) {
        const double t = double(i - before) / gap;
        add(i, (1 - t) / line.depth(before) + t / line.depth(at),
            std::max(line.sigma(before), line.sigma(at)), 1.0 / (gap * gap));
      }
    before = at;
  }
}

}  // namespace

void bridge_holes(ImageF& depth, ImageF& sigma, int max_hole, double max_deviation) {
  const int width = depth.width(), height = depth.height();
  for (int pass = 0; pass < kPasses; ++pass) {
    std::map<std::pair<int, int>, Filled> holes;  // by row and column; few
    for (int y = 0; y < height; ++y)
      bridge(Line(depth, sigma, true, y), max_hole, max_deviation,
             [&](int x, double inverse, double its_sigma, double weight) {
               holes[{y, x}].add(inverse, its_sigma, weight);
             });
    for (int x = 0; x < width; ++x)
      bridge(Line(depth, sigma, false, x), max_hole, max_deviation,
             [&](int y, double inverse, double its_sigma, double weight) {
               holes[{y, x}].add(inverse, its_sigma, weight);
             });
    if (holes.empty()) return;
    for (const auto& [at, hole] : holes) {
      depth.at(at.second, at.first) = float(hole.weight / hole.inverse);
      sigma.at(at.second, at.first) = float(hole.sigma);
    }
  }
}

}  // namespace procam::scan
