#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "fields.hpp"
#include "procam/report/room.hpp"

namespace procam::report {
namespace {

using depth::Planes;

constexpr int kRoomScale = 2;     ///< the picture's pixels a depth pixel
constexpr int kRoomLegend = 470;  ///< its width
constexpr int kRoomLine = 44;     ///< height of a legend's entry
/// Planes without room for content.
const cv::Scalar kRoomRest(120, 160, 200);
constexpr auto kRoomFont = cv::FONT_HERSHEY_DUPLEX;

/// Twelve colours that stay apart, also on grey (RGB).
cv::Scalar surface_colour(std::size_t i) {
  constexpr std::uint8_t kColours[][3] = {{66, 133, 244}, {244, 160, 0},  {15, 157, 88},  {219, 68, 55},
                                          {171, 71, 188}, {0, 172, 193},  {255, 112, 67}, {158, 157, 36},
                                          {92, 107, 192}, {240, 98, 146}, {0, 121, 107},  {141, 110, 99}};
  const auto& c = kColours[i % std::size(kColours)];
  return {double(c[0]), double(c[1]), double(c[2])};
}

class RoomPicture {
 public:
  RoomPicture(const Planes& planes, const depth::RoomSurfaces& room, const depth::DepthImage& image,
              const depth::RayTable& rays)
      : planes_(planes), room_(room), image_(image), rays_(rays) {
    width_ = rays.size().width * kRoomScale;
    const int entries = int(room.set.surfaces.size()) + 4;
    const int height = std::max(rays.size().height * kRoomScale, 40 + entries * kRoomLine);
    canvas_ = cv::Mat(height, width_ + kRoomLegend, CV_8UC3, cv::Scalar(248, 248, 248));
    surface_of_.assign(planes.planes.size() + planes.curves.size(), -1);
    for (std::size_t i = 0; i < room.areas.size(); ++i)
      surface_of_[std::size_t(room.areas[i].plane)] = int(i);
    for (std::size_t i = 0; i < planes.curves.size(); ++i)
      surface_of_[planes.planes.size() + i] = int(room.areas.size() + i);
  }

  ImageU8 draw() {
    shade();
    for (std::size_t i = 0; i < room_.areas.size(); ++i) outline(room_.areas[i], surface_colour(i));
    corners();
    for (std::size_t i = 0; i < room_.areas.size(); ++i) rectangle(room_.areas[i], surface_colour(i));
    legend();
    ImageU8 out(canvas_.cols, canvas_.rows, 3);
    for (int y = 0; y < canvas_.rows; ++y)
      std::copy_n(canvas_.ptr<std::uint8_t>(y), std::ptrdiff_t(canvas_.cols) * 3, out.row(y));
    return out;
  }

 private:
  /// Light from the upper left, by the slope over a few pixels: relief without the depth's own noise.
  void shade() {
    const int w = rays_.size().width, h = rays_.size().height;
    cv::Mat inverse(h, w, CV_32F), known(h, w, CV_32F);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const float z = image_.at(x, y);
        inverse.at<float>(y, x) = z > 0 ? 1 / z : 0;
        known.at<float>(y, x) = z > 0;
      }
    cv::Mat smooth, weight;
    cv::boxFilter(inverse, smooth, -1, cv::Size(7, 7));
    cv::boxFilter(known, weight, -1, cv::Size(7, 7));
    smooth /= cv::max(weight, 1e-3f);
    const double fx = rays_.camera().intrinsics.fx;
    for (int y = 0; y < h * kRoomScale; ++y)
      for (int x = 0; x < w * kRoomScale; ++x) {
        const int px = x / kRoomScale, py = y / kRoomScale;
        auto& out = canvas_.at<cv::Vec3b>(y, x);
        if (!(known.at<float>(py, px) > 0)) {  // nothing measured: hatched
          const bool stripe = (x + y) / 4 % 2;
          out = stripe ? cv::Vec3b(38, 38, 42) : cv::Vec3b(30, 30, 34);
          continue;
        }
        const int x0 = std::max(px - 3, 0), x1 = std::min(px + 3, w - 1);
        const int y0 = std::max(py - 3, 0), y1 = std::min(py + 3, h - 1);
        const double gu = fx * double(smooth.at<float>(py, x1) - smooth.at<float>(py, x0)) / (x1 - x0);
        const double gv = fx * double(smooth.at<float>(y1, px) - smooth.at<float>(y0, px)) / (y1 - y0);
        const double q = double(smooth.at<float>(py, px));
        Vec3 t(gu, gv, q - gu * double(rays_.u(px, py)) - gv * double(rays_.v(px, py)));
        const Vec3 n = t.allFinite() && t.norm() > 0 ? Vec3(-t.normalized()) : Vec3(0, 0, -1);
        const double light = 0.35 + 0.65 * std::max(0.0, n.dot(Vec3(-0.35, -0.55, -0.76)));
        const double fade = std::clamp(1.15 - 0.08 / std::max(q, 0.05), 0.55, 1.0);
        const double grey = 235 * light * fade;
        const int label = planes_.labels.at(px, py);
        const int surface = label >= 0 ? surface_of_[std::size_t(label)] : -1;
        for (int c = 0; c < 3; ++c) {
          const double tint = surface >= 0 ? surface_colour(std::size_t(surface))[c] : kRoomRest[c];
          const double mix = surface >= 0 ? 0.55 : label >= 0 ? 0.35 : 0.0;
          out[c] = cv::saturate_cast<std::uint8_t>(grey * (1 - mix) + mix * tint * (0.45 + 0.6 * light));
        }
      }
  }

  cv::Point at(const Vec3& point_in_camera) const {
    const double z = std::max(point_in_camera.z(), 0.05);
    const Vec2 pixel = rays_.pixel_of(point_in_camera.x() / z, point_in_camera.y() / z);
    // Far outside of the picture lines are cut anyway.
    const auto place = [](double v) {
      return int(std::lround(std::clamp((v + 0.5) * kRoomScale, -4e3, 8e3)));
    };
    return {place(pixel.x()), place(pixel.y())};
  }
  cv::Mat picture() { return canvas_(cv::Rect(0, 0, width_, rays_.size().height * kRoomScale)); }

  void outline(const depth::SurfaceArea& area, const cv::Scalar& colour) {
    cv::Mat into = picture();
    const auto loop = [&](const Points2& corners) {
      std::vector<cv::Point> points;
      for (const Vec2& p : corners) points.push_back(at(area.area.camera_from_plane * Vec3(p.x(), p.y(), 0)));
      cv::polylines(into, points, true, cv::Scalar(255, 255, 255), 3, cv::LINE_AA);
      cv::polylines(into, points, true, colour * 0.7, 2, cv::LINE_AA);
    };
    for (const depth::PlaneOutline& part : area.area.outlines) {
      loop(part.outer);
      for (const Points2& hole : part.holes) loop(hole);
    }
  }

  void corners() {
    cv::Mat into = picture();
    for (const depth::CornerLine& line : room_.corners) {
      if (surface_of_[std::size_t(line.first)] < 0 || surface_of_[std::size_t(line.second)] < 0) continue;
      cv::line(into, at(line.from), at(line.to), cv::Scalar(20, 20, 20), 4, cv::LINE_AA);
      cv::line(into, at(line.from), at(line.to), cv::Scalar(255, 235, 59), 2, cv::LINE_AA);
    }
  }

  void rectangle(const depth::SurfaceArea& area, const cv::Scalar& colour) {
    cv::Mat into = picture();
    const auto& [low, high] = *area.area.rectangle;
    const Pose& camera_from_plane = area.area.camera_from_plane;
    std::vector<cv::Point> points;
    for (const Vec2& p : Points2{low, {high.x(), low.y()}, high, {low.x(), high.y()}})
      points.push_back(at(camera_from_plane * Vec3(p.x(), p.y(), 0)));
    cv::polylines(into, points, true, cv::Scalar(0, 0, 0), 6, cv::LINE_AA);
    cv::polylines(into, points, true, cv::Scalar(255, 255, 255), 3, cv::LINE_AA);
    const Vec2 middle = 0.5 * (low + high);
    const std::string size = format("%.2f x %.2f m", high.x() - low.x(), high.y() - low.y());
    label(into, at(camera_from_plane * Vec3(middle.x(), middle.y(), 0)), area.name, size, colour);
  }

  static void label(cv::Mat& into, const cv::Point& middle, const std::string& name, const std::string& size,
                    const cv::Scalar& colour) {
    const cv::Size a = cv::getTextSize(name, kRoomFont, 0.6, 1, nullptr);
    const cv::Size b = cv::getTextSize(size, kRoomFont, 0.5, 1, nullptr);
    const int w = std::max(a.width, b.width) + 12;
    const int x = std::clamp(middle.x - w / 2, 0, std::max(0, into.cols - w));
    const int y = std::clamp(middle.y - 22, 0, std::max(0, into.rows - 44));
    cv::rectangle(into, cv::Rect(x, y, w, 44), cv::Scalar(255, 255, 255), cv::FILLED);
    cv::rectangle(into, cv::Rect(x, y, w, 44), colour * 0.7, 2);
    cv::putText(into, name, {x + 6, y + 18}, kRoomFont, 0.6, cv::Scalar(0, 0, 0), 1, cv::LINE_AA);
    cv::putText(into, size, {x + 6, y + 37}, kRoomFont, 0.5, cv::Scalar(60, 60, 60), 1, cv::LINE_AA);
  }

  void legend() {
    const int x = width_ + 16;
    int y = 30;
    const auto text = [&](const std::string& words, int left, int top, double size, const cv::Scalar& c) {
      cv::putText(canvas_, words, {left, top}, kRoomFont, size, c, 1, cv::LINE_AA);
    };
    const cv::Scalar black(0, 0, 0), grey(95, 95, 95);
    text("surfaces", x, y, 0.7, black);
    y += 14;
    for (std::size_t i = 0; i < room_.set.surfaces.size(); ++i, y += kRoomLine) {
      cv::rectangle(canvas_, cv::Rect(x, y + 6, 26, 26), surface_colour(i), cv::FILLED);
      std::string first = room_.set.surfaces[i].name, second;
      if (i < room_.areas.size()) {
        const depth::SurfaceArea& area = room_.areas[i];
        const depth::DetectedPlane& plane = planes_.planes[std::size_t(area.plane)];
        const Vec2 size = area.area.rectangle->size();
        first += format("   free %.2f x %.2f m", size.x(), size.y());
        const double sigma = std::sqrt(std::max(plane.estimate.covariance(3, 3), 0.0));
        second = format("%.2f m2, %.3f m off (+- %.1f mm), rms %.1f mm", area.area.area,
                        plane.estimate.plane.offset, 1e3 * sigma, 1e3 * plane.rms);
      } else {
        std::visit(
            [&](const auto& shape) {
              if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, CylinderSurface> ||
                            std::is_same_v<std::decay_t<decltype(shape)>, SphereSurface>)
                second = format("radius %.3f m, %.0f degrees of it seen", shape.radius,
                                (shape.right - shape.left) / kDegree);
            },
            room_.set.surfaces[i].geometry);
      }
      text(first, x + 38, y + 17, 0.5, black);
      text(second, x + 38, y + 34, 0.4, grey);
    }
    y += 16;
    cv::line(canvas_, {x, y}, {x + 26, y}, cv::Scalar(20, 20, 20), 4);
    cv::line(canvas_, {x, y}, {x + 26, y}, cv::Scalar(255, 235, 59), 2);
    text("where two planes meet", x + 38, y + 5, 0.42, grey);
    y += 26;
    cv::rectangle(canvas_, cv::Rect(x, y - 9, 26, 16), cv::Scalar(30, 30, 34), cv::FILLED);
    text("nothing measured", x + 38, y + 5, 0.42, grey);
    y += 26;
    cv::rectangle(canvas_, cv::Rect(x, y - 9, 26, 16), kRoomRest, cv::FILLED);
    text("plane without room for content; grey: no plane", x + 38, y + 5, 0.42, grey);
  }

  const Planes& planes_;
  const depth::RoomSurfaces& room_;
  const depth::DepthImage& image_;
  const depth::RayTable& rays_;
  int width_ = 0;
  cv::Mat canvas_;
  std::vector<int> surface_of_;  ///< place in the set of every plane and curve
};

}  // namespace

ImageU8 room_picture(const Planes& planes, const depth::RoomSurfaces& room, const depth::DepthImage& image,
                     const depth::RayTable& rays) {
  return RoomPicture(planes, room, image, rays).draw();
}

}  // namespace procam::report
