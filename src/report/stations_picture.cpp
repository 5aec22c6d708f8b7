#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/report/stations.hpp"

namespace procam::report {
namespace {

constexpr int kStationsWidth = 720, kStationsHeight = 600, kStationsLegend = 52;
const cv::Vec3b kStationsBackground(30, 34, 44);

/// An eye behind the first station's camera that sees all points, looking the same way from a little above.
struct Eye {
  Pose eye_from_world;
  double focal = 0;
  Vec2 middle = Vec2::Zero();
};

Eye eye_for(const scan::MergedStations& merged) {
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : merged.cloud.points) centre += p / double(merged.cloud.points.size());
  const Pose camera = merged.scans.front().scan.camera.rig_from_camera;
  const Vec3 back =
      camera.translation - 0.6 * (centre - camera.translation) + camera.rotate(Vec3(-0.35, -0.45, 0.0));
  const Vec3 forward = (centre - back).normalized();
  const Vec3 right = camera.rotate(Vec3::UnitY()).cross(forward).normalized();
  Mat3 world_from_eye;
  world_from_eye << right, forward.cross(right), forward;
  Eye eye;
  eye.eye_from_world = Pose(world_from_eye, back).inverse();
  std::vector<double> u, v;
  for (const Vec3& p : merged.cloud.points) {
    const Vec3 q = eye.eye_from_world * p;
    if (!(q.z() > 0.05)) continue;
    u.push_back(q.x() / q.z());
    v.push_back(q.y() / q.z());
  }
  if (u.empty()) return eye;
  const double u0 = quantile(u, 0.002), u1 = quantile(u, 0.998), v0 = quantile(v, 0.002),
               v1 = quantile(v, 0.998);
  eye.focal =
      0.92 * std::min(kStationsWidth / std::max(1e-6, u1 - u0), kStationsHeight / std::max(1e-6, v1 - v0));
  eye.middle = Vec2(0.5 * kStationsWidth - eye.focal * 0.5 * (u0 + u1),
                    0.5 * kStationsHeight - eye.focal * 0.5 * (v0 + v1));
  return eye;
}

cv::Vec3b tinted(std::size_t station, double light) {
  const Vec3 tints[] = {Vec3(0.95, 0.95, 1.0), Vec3(1.0, 0.78, 0.5), Vec3(0.6, 0.9, 0.65),
                        Vec3(0.75, 0.75, 1.0), Vec3(1.0, 0.7, 0.85)};
  const Vec3 colour = (40 + 205 * light) * tints[station % 5];
  return {std::uint8_t(colour.x()), std::uint8_t(colour.y()), std::uint8_t(colour.z())};
}

/// Draws each point as 2 x 2 pixels, the nearest in front.
template <typename Colour>
cv::Mat splatted(const scan::MergedStations& merged, const Eye& eye, const Colour& colour) {
  cv::Mat picture(kStationsHeight, kStationsWidth, CV_8UC3, cv::Scalar(kStationsBackground));
  cv::Mat depth(kStationsHeight, kStationsWidth, CV_64F, cv::Scalar(std::numeric_limits<double>::infinity()));
  for (std::size_t i = 0; i < merged.cloud.points.size(); ++i) {
    const Vec3 q = eye.eye_from_world * merged.cloud.points[i];
    if (!(q.z() > 0.05)) continue;
    const int x = int(std::floor(eye.middle.x() + eye.focal * q.x() / q.z())),
              y = int(std::floor(eye.middle.y() + eye.focal * q.y() / q.z()));
    for (int j = std::max(0, y); j <= std::min(kStationsHeight - 1, y + 1); ++j)
      for (int k = std::max(0, x); k <= std::min(kStationsWidth - 1, x + 1); ++k)
        if (q.z() < depth.at<double>(j, k)) {
          depth.at<double>(j, k) = q.z();
          picture.at<cv::Vec3b>(j, k) = colour(i);
        }
  }
  return picture;
}

cv::Vec3b viridis(double level) {
  static const cv::Mat table = [] {
    cv::Mat ramp(1, 256, CV_8U), colours, rgb;
    for (int i = 0; i < 256; ++i) ramp.at<std::uint8_t>(0, i) = std::uint8_t(i);
    cv::applyColorMap(ramp, colours, cv::COLORMAP_VIRIDIS);
    cv::cvtColor(colours, rgb, cv::COLOR_BGR2RGB);
    return rgb;
  }();
  return table.at<cv::Vec3b>(0, int(std::clamp(255 * level, 0.0, 255.0)));
}

void draw_stations_legend(cv::Mat& canvas, double largest) {
  const cv::Scalar ink(40, 40, 40);
  const auto write = [&](const std::string& text, int x) {
    cv::putText(canvas, text, {x, kStationsHeight + 33}, cv::FONT_HERSHEY_DUPLEX, 0.7, ink, 1, cv::LINE_AA);
  };
  write("merged surface, a colour for each station", 12);
  write("standard deviation   0", kStationsWidth + 12);
  for (int x = 0; x < 160; ++x)
    for (int y = 0; y < 16; ++y)
      canvas.at<cv::Vec3b>(kStationsHeight + 18 + y, kStationsWidth + 300 + x) = viridis(x / 160.0);
  write(format("%.2g mm", 1e3 * largest), kStationsWidth + 474);
}

}  // namespace

ImageU8 stations_picture(const scan::MergedStations& merged) {
  require(!merged.scans.empty() && !merged.cloud.points.empty(), "stations_picture: no points");
  const Eye eye = eye_for(merged);
  const double largest = std::max(1e-6, quantile(merged.cloud.sigma, 0.95));
  const Vec3 lamp = eye.eye_from_world.inverse().rotate(Vec3(-0.45, -0.5, -0.74)).normalized();
  const cv::Mat surface = splatted(merged, eye, [&](std::size_t i) {
    return tinted(std::size_t(merged.cloud_station[i]), std::max(0.0, merged.cloud.normals[i].dot(lamp)));
  });
  const cv::Mat sigma =
      splatted(merged, eye, [&](std::size_t i) { return viridis(merged.cloud.sigma[i] / largest); });
  cv::Mat canvas(kStationsHeight + kStationsLegend, 2 * kStationsWidth, CV_8UC3, cv::Scalar(248, 248, 248));
  surface.copyTo(canvas(cv::Rect(0, 0, kStationsWidth, kStationsHeight)));
  sigma.copyTo(canvas(cv::Rect(kStationsWidth, 0, kStationsWidth, kStationsHeight)));
  draw_stations_legend(canvas, largest);
  ImageU8 out(canvas.cols, canvas.rows, 3);
  for (int y = 0; y < canvas.rows; ++y)
    std::copy_n(canvas.ptr<std::uint8_t>(y), std::ptrdiff_t(canvas.cols) * 3, out.row(y));
  return out;
}

}  // namespace procam::report
