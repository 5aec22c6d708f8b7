#include "procam/session/coverage.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace procam::session {
namespace {

constexpr double kLongerSide = 160;

double cross(const Vec2& o, const Vec2& a, const Vec2& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

/// Andrew's monotone chain, counter-clockwise for y up.
Points2 convex_hull(Points2 points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  Points2 hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const Vec2& point : points) {
      while (hull.size() >= first + 2 && cross(hull[hull.size() - 2], hull.back(), point) <= 0)
        hull.pop_back();
      hull.push_back(point);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

bool inside(const Points2& hull, const Vec2& point) {
  for (std::size_t i = 0; i < hull.size(); ++i)
    if (cross(hull[i], hull[(i + 1) % hull.size()], point) < 0) return false;
  return true;
}

ImageSize raster_of(ImageSize device) {
  require(device.width > 0 && device.height > 0, "Coverage: a device without pixels");
  const double scale = kLongerSide / std::max(device.width, device.height);
  return {std::max(3, int(std::lround(device.width * scale))),
          std::max(3, int(std::lround(device.height * scale)))};
}

}  // namespace

Coverage::Coverage(ImageSize device)
    : scale_(kLongerSide / std::max(device.width, device.height)), views_(raster_of(device)) {}

// A pixel's left border is half a pixel left of its centre; so is a cell's.
Vec2 Coverage::cell_of(const Vec2& pixel) const {
  return (pixel + Vec2(0.5, 0.5)) * scale_ - Vec2(0.5, 0.5);
}

void Coverage::add(const Points2& points) {
  Points2 cells;
  for (const Vec2& point : points) cells.push_back(cell_of(point));
  points_.insert(points_.end(), cells.begin(), cells.end());
  const Points2 hull = convex_hull(cells);
  if (hull.size() < 3) return;
  for (int y = 0; y < views_.height(); ++y)
    for (int x = 0; x < views_.width(); ++x)
      if (views_.at(x, y) < 255 && inside(hull, Vec2(x, y))) ++views_.at(x, y);
}

void Coverage::add_dense(const Points2& points) {
  ImageU8 covered(views_.width(), views_.height(), 1, 0);
  for (const Vec2& point : points) {
    const Vec2 cell = cell_of(point).array().round();
    if (cell.minCoeff() >= 0 && cell.x() < views_.width() && cell.y() < views_.height())
      covered.at(int(cell.x()), int(cell.y())) = 1;
  }
  for (int y = 0; y < views_.height(); ++y)
    for (int x = 0; x < views_.width(); ++x)
      if (views_.at(x, y) < 255) views_.at(x, y) = std::uint8_t(views_.at(x, y) + covered.at(x, y));
}

double Coverage::share() const {
  const std::size_t all = std::size_t(views_.width()) * std::size_t(views_.height());
  return double(all - std::size_t(std::count(views_.data(), views_.data() + all, 0))) / double(all);
}

std::string Coverage::emptiest_part() const {
  static constexpr std::array<const char*, 9> kNames{
      "top left", "top", "top right", "left", "middle", "right", "bottom left", "bottom", "bottom right"};
  std::array<double, 9> covered{}, all{};
  for (int y = 0; y < views_.height(); ++y)
    for (int x = 0; x < views_.width(); ++x) {
      const std::size_t part = std::size_t(3 * (3 * y / views_.height()) + 3 * x / views_.width());
      covered[part] += views_.at(x, y) > 0;
      ++all[part];
    }
  std::size_t least = 0;
  for (std::size_t i = 1; i < 9; ++i)
    if (covered[i] / all[i] < covered[least] / all[least]) least = i;
  return covered[least] / all[least] < 0.5 ? kNames[least] : "";
}

ImageU8 draw(const std::vector<const Coverage*>& devices) {
  constexpr int kZoom = 3, kGap = 12;
  int width = 0, height = 0;
  for (const Coverage* device : devices) {
    width += device->views().width() * kZoom + (width > 0 ? kGap : 0);
    height = std::max(height, device->views().height() * kZoom);
  }
  ImageU8 picture(width, height, 3, 255);
  int left = 0;
  for (const Coverage* device : devices) {
    const ImageU8& views = device->views();
    for (int y = 0; y < views.height() * kZoom; ++y)
      for (int x = 0; x < views.width() * kZoom; ++x) {
        const int count = std::min<int>(views.at(x / kZoom, y / kZoom), 4);
        const std::array<int, 3> color = count == 0
                                             ? std::array<int, 3>{48, 48, 52}
                                             : std::array<int, 3>{30, 80 + 35 * count, 60 + 10 * count};
        for (int c = 0; c < 3; ++c) picture.at(left + x, y, c) = std::uint8_t(color[std::size_t(c)]);
      }
    for (const Vec2& point : device->points()) {
      const int x = int(std::lround((point.x() + 0.5) * kZoom)),
                y = int(std::lround((point.y() + 0.5) * kZoom));
      if (x < 0 || y < 0 || x >= views.width() * kZoom || y >= views.height() * kZoom) continue;
      for (int c = 0; c < 3; ++c) picture.at(left + x, y, c) = 255;
    }
    left += views.width() * kZoom + kGap;
  }
  return picture;
}

}  // namespace procam::session
