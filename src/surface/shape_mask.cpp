#include "shape_mask.hpp"

#include <cmath>

namespace procam::surface {

namespace {

/// Adds up what the sides of rings do to the area to the right of them, pixel by pixel: after all sides are
/// in, the running sum along a row is the share of each pixel inside (each side adds its signed height in a
/// row of pixels, split between the pixel it goes through and the next by the area to its right).
class Coverage {
 public:
  explicit Coverage(ImageSize size)
      : size_(size), cells_(std::size_t(size.width + 2) * std::size_t(size.height)) {}

  /// Corners in pixels from the corner of the picture; `sign` 1 adds the ring, -1 takes it away.
  void add(const Points2& ring, double sign) {
    if (twice_area(ring) < 0) sign = -sign;
    for (std::size_t i = 0; i < ring.size(); ++i) side(ring[i], ring[(i + 1) % ring.size()], sign);
  }
  /// Where no ring was added, nothing is inside.
  void write(ImageU8& picture, double everywhere) const {
    for (int y = 0; y < size_.height; ++y) {
      const double* cell = cells_.data() + std::ptrdiff_t(y) * (size_.width + 2);
      double sum = everywhere;
      for (int x = 0; x < size_.width; ++x) {
        sum += cell[x];
        picture.at(x, y) = std::uint8_t(std::lround(255 * std::min(1.0, std::max(0.0, sum))));
      }
    }
  }

 private:
  void side(Vec2 a, Vec2 b, double sign) {
    if (a.y() == b.y()) return;
    // Clockwise as seen (v down), a ring has its inside on the right of sides that go up.
    if (a.y() > b.y())
      std::swap(a, b);
    else
      sign = -sign;
    const double slope = (b.x() - a.x()) / (b.y() - a.y());
    const double top = std::max(a.y(), 0.0), bottom = std::min(b.y(), double(size_.height));
    for (int y = int(top); y < bottom; ++y) {
      const double y0 = std::max(top, double(y)), y1 = std::min(bottom, y + 1.0);
      if (!(y1 > y0)) continue;
      row(y, a.x() + (y0 - a.y()) * slope, a.x() + (y1 - a.y()) * slope, sign * (y1 - y0));
    }
  }
  /// A side within one row of pixels, from x0 to x1, of a signed height.
  void row(int y, double x0, double x1, double height) {
    if (x0 > x1) std::swap(x0, x1);
    double* const cell = cells_.data() + std::ptrdiff_t(y) * (size_.width + 2);
    const double width = size_.width;
    const auto at = [&](double from, double to, double part) {  // within one pixel
      const double middle = std::min(std::max(0.5 * (from + to), 0.0), width);
      const int x = std::min(int(middle), size_.width);
      const double right = x + 1 - middle;
      cell[x] += part * right;
      cell[x + 1] += part * (1 - right);
    };
    if (x1 - x0 < 1e-12 || x1 <= 0 || x0 >= width) return at(x0, x1, height);
    for (double from = x0; from < x1;) {
      const double next = from < 0 ? 0.0 : from >= width ? x1 : std::floor(from) + 1;
      const double to = std::min(x1, next);
      at(from, to, height * (to - from) / (x1 - x0));
      from = to;
    }
  }

  ImageSize size_;
  std::vector<double> cells_;
};

/// Bilinear, clamped.
double sample(const ImageU8& mask, const Vec2& uv) {
  const double x = std::min(std::max(uv.x() * mask.width() - 0.5, 0.0), mask.width() - 1.0),
               y = std::min(std::max(uv.y() * mask.height() - 0.5, 0.0), mask.height() - 1.0);
  const int x0 = int(x), y0 = int(y), x1 = std::min(x0 + 1, mask.width() - 1),
            y1 = std::min(y0 + 1, mask.height() - 1);
  const double s = x - x0, t = y - y0;
  return (1 - t) * ((1 - s) * mask.at(x0, y0) + s * mask.at(x1, y0)) +
         t * ((1 - s) * mask.at(x0, y1) + s * mask.at(x1, y1));
}

}  // namespace

ImageU8 shape_mask(const ContentShape& shape, const Vec2& from, const Vec2& to, ImageSize size) {
  const Vec2 scale = Vec2(size.width, size.height).cwiseQuotient(to - from);
  const auto in_pixels = [&](Points2 ring) {
    for (Vec2& corner : ring) corner = (corner - from).cwiseProduct(scale);
    return ring;
  };
  ImageU8 alpha(size);
  Coverage coverage(size);
  if (!shape.outline.empty()) coverage.add(in_pixels(shape.outline), 1);
  for (const Points2& hole : shape.holes) coverage.add(in_pixels(hole), -1);
  coverage.write(alpha, shape.outline.empty() ? 1 : 0);
  if (!shape.mask) return alpha;
  // The mean over a pixel of the new mask, by as many looks as it holds pixels of the old one.
  const ImageU8& mask = *shape.mask;
  const auto looks = [](double old_pixels) { return std::min(16, std::max(1, int(std::ceil(old_pixels)))); };
  const int across = looks(mask.width() / scale.x()), down = looks(mask.height() / scale.y());
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      std::uint8_t& value = alpha.at(x, y);
      if (value == 0) continue;
      double sum = 0;
      for (int j = 0; j < down; ++j)
        for (int i = 0; i < across; ++i)
          sum += sample(mask, from + Vec2(x + (i + 0.5) / across, y + (j + 0.5) / down).cwiseQuotient(scale));
      value = std::uint8_t(std::lround(value * sum / (255.0 * across * down)));
    }
  return alpha;
}

}  // namespace procam::surface
