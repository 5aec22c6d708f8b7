#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "image/image_check.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/sheet/board_sheet.hpp"
#include "sheet/sheet_formats.hpp"

namespace procam::io {
namespace {

/// How much of [i, i + 1] lies in [low, high].
double overlap(int i, double low, double high) {
  return std::max(0.0, std::min(i + 1.0, high) - std::max(double(i), low));
}

/// Adds the share of each pixel that the rectangle covers; lengths in pixels.
void cover(ImageF& dark, const Vec2& low, const Vec2& high) {
  const int x0 = std::max(0, int(low.x())), x1 = std::min(dark.width() - 1, int(high.x()));
  const int y0 = std::max(0, int(low.y())), y1 = std::min(dark.height() - 1, int(high.y()));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x)
      dark.at(x, y) += float(overlap(x, low.x(), high.x()) * overlap(y, low.y(), high.y()));
}

void cover(ImageF& dark, const Vec2& centre, double radius) {
  constexpr int kFine = 16;
  const int x0 = std::max(0, int(centre.x() - radius)),
            x1 = std::min(dark.width() - 1, int(centre.x() + radius));
  const int y0 = std::max(0, int(centre.y() - radius)),
            y1 = std::min(dark.height() - 1, int(centre.y() + radius));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double distance = (Vec2(x + 0.5, y + 0.5) - centre).norm();
      if (std::abs(distance - radius) > 0.75) {  // no border in this pixel
        dark.at(x, y) += distance < radius ? 1 : 0;
        continue;
      }
      int inside = 0;
      for (int j = 0; j < kFine; ++j)
        for (int i = 0; i < kFine; ++i)
          inside += (Vec2(x + (i + 0.5) / kFine, y + (j + 0.5) / kFine) - centre).norm() < radius;
      dark.at(x, y) += float(inside) / (kFine * kFine);
    }
}

std::string big_endian(std::uint32_t value) {
  return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

}  // namespace

ImageU8 sheet_pixels(const BoardSheet& sheet, double dots_per_inch) {
  require(dots_per_inch > 0, "sheet_pixels: the resolution is not positive");
  const double scale = dots_per_inch / 0.0254;
  ImageF dark(int(std::ceil(sheet.size.x() * scale - 1e-6)), int(std::ceil(sheet.size.y() * scale - 1e-6)));
  for (const ArtworkRectangle& r : sheet.rectangles) cover(dark, scale * r.low, scale * r.high);
  for (const ArtworkDisc& d : sheet.discs) cover(dark, scale * d.centre, scale * d.radius);
  ImageU8 image(dark.size(), 1);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image.at(x, y) = std::uint8_t(std::lround(255 * (1 - std::min(1.0f, dark.at(x, y)))));
  cv::Mat pixels(image.height(), image.width(), CV_8U, image.data());
  for (const BoardSheet::Text& t : sheet.texts) {
    // Its capitals are 21 units high at scale one, and those of a usual font 0.72 of the font's size.
    const double font = 0.72 * t.height * scale / 21;
    cv::putText(pixels, t.text, cv::Point(int(t.at.x() * scale), int(t.at.y() * scale)),
                cv::FONT_HERSHEY_SIMPLEX, font, cv::Scalar(0), std::max(1, int(std::lround(1.5 * font))),
                cv::LINE_AA);
  }
  return image;
}

std::string sheet_png(const BoardSheet& sheet, double dots_per_inch) {
  const std::string png = encode_png(sheet_pixels(sheet, dots_per_inch).view());
  // pHYs: pixels a metre in both directions; it stands after the header, which ends at byte 33.
  const std::string pitch = big_endian(std::uint32_t(std::lround(dots_per_inch / 0.0254)));
  const std::string chunk = "pHYs" + pitch + pitch + '\x01';
  constexpr std::size_t kHeaderEnd = 33;
  return png.substr(0, kHeaderEnd) + big_endian(9) + chunk + big_endian(crc32(chunk)) +
         png.substr(kHeaderEnd);
}

}  // namespace procam::io
