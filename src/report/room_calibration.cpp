#include "procam/report/room_calibration.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "fields.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::report {

static void fields(Fields& f, const room::SolvedPosition& position) {
  f.field("camera", position.camera);
  f.field("view", position.view);
  const Vec3& t = position.rig_from_camera.translation;
  f.field("position", std::vector<double>{t.x(), t.y(), t.z()});
}

static void fields(Fields& f, const room::RegionError& region) {
  f.field("camera", region.camera);
  f.field("view", region.view);
  f.field("projector", region.projector);
  f.field("column", region.column);
  f.field("row", region.row);
  f.field("points", region.points);
  f.field("rms_px", region.rms_px);
}

static void fields(Fields& f, const room::ParameterDeviation& deviation) {
  f.field("name", deviation.name);
  f.field("off", deviation.off);
  f.field("sigma", deviation.sigma);
}

namespace {

int inside_three_sigmas(const std::vector<room::ParameterDeviation>& deviations) {
  return int(std::count_if(deviations.begin(), deviations.end(),
                           [](const room::ParameterDeviation& d) { return std::abs(d.sigmas()) <= 3; }));
}

std::string device_line(const char* kind, const std::string& name, const Camera& lens,
                        const Pose& rig_from_device, const NamedCovariance& covariance) {
  const Intrinsics& k = lens.intrinsics;
  const Vec3& t = rig_from_device.translation;
  return format(
      "%-10s %s: focal length %.1f (+-%.2g) px, principal point %.1f, %.1f (+-%.2g, %.2g) px, at %.3f %.3f %.3f m",
      kind, name.c_str(), k.fx, covariance.sigma(name + ".fx"), k.cx, k.cy, covariance.sigma(name + ".cx"),
      covariance.sigma(name + ".cy"), t.x(), t.y(), t.z());
}

// ---- the picture

const cv::Scalar kPaper(248, 248, 248), kInk(40, 40, 40), kCameraColour(66, 103, 212),
    kProjectorColour(200, 80, 30);
constexpr int kViewWidth = 700, kViewHeight = 620, kRoomMargin = 50, kFooter = 56;

/// x or y against z, metres to pixels.
struct RoomView2 {
  int axis = 0;
  double scale = 1;
  Vec2 low = Vec2::Zero();
  cv::Point at(const Vec3& p, int left) const {
    const double across = p[axis] - low.x(), ahead = p.z() - low.y();
    return axis == 0 ? cv::Point(left + kRoomMargin + int(scale * across),
                                 kViewHeight - kRoomMargin - int(scale * ahead))
                     : cv::Point(left + kRoomMargin + int(scale * ahead), kRoomMargin + int(scale * across));
  }
};

RoomView2 fitted(const Points3& points, int axis) {
  Vec2 low(1e9, 1e9), high(-1e9, -1e9);
  for (const Vec3& p : points) {
    low = low.cwiseMin(Vec2(p[axis], p.z()));
    high = high.cwiseMax(Vec2(p[axis], p.z()));
  }
  const Vec2 size = (high - low).cwiseMax(1e-3);
  const double across = (axis == 0 ? kViewWidth : kViewHeight) - 2.0 * kRoomMargin,
               ahead = (axis == 0 ? kViewHeight : kViewWidth) - 2.0 * kRoomMargin;
  return {axis, std::min(across / size.x(), ahead / size.y()), low};
}

/// A label beside a point; it moves down until it covers none of those before.
void draw_label(cv::Mat& canvas, const std::string& text, const cv::Point& beside, const cv::Scalar& colour,
                std::vector<cv::Rect>& labels) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_DUPLEX, 0.5, 1, &below);
  cv::Rect box(beside.x + 9, beside.y + 16 - size.height, size.width, size.height + below);
  box.x = std::clamp(box.x, 0, std::max(0, canvas.cols - box.width));
  const auto covers = [&](const cv::Rect& other) { return (other & box).area() > 0; };
  for (int attempt = 0; attempt < 20 && std::any_of(labels.begin(), labels.end(), covers); ++attempt)
    box.y += box.height + 2;
  labels.push_back(box);
  cv::putText(canvas, text, {box.x, box.y + size.height}, cv::FONT_HERSHEY_DUPLEX, 0.5, colour, 1,
              cv::LINE_AA);
}

struct DrawnDevice {
  const Camera& lens;
  const Pose& rig_from_device;
  std::string name;
  cv::Scalar colour;
};

/// `length`: of the rays at its picture's sides, metres.
void draw_device(cv::Mat& canvas, const RoomView2& view, int left, const DrawnDevice& device, double length,
                 std::vector<cv::Rect>& labels) {
  const cv::Point from = view.at(device.rig_from_device.translation, left);
  const double w = device.lens.size.width - 1, h = device.lens.size.height - 1;
  const Vec2 ends[] = {view.axis == 0 ? Vec2(0, h / 2) : Vec2(w / 2, 0),
                       view.axis == 0 ? Vec2(w, h / 2) : Vec2(w / 2, h)};
  for (const Vec2& pixel : ends)
    if (const std::optional<Vec3> bearing = device.lens.unproject(pixel))
      cv::line(canvas, from, view.at(device.rig_from_device * Vec3(length * *bearing), left), device.colour,
               1, cv::LINE_AA);
  cv::circle(canvas, from, 6, device.colour, cv::FILLED, cv::LINE_AA);
  if (view.axis == 0) draw_label(canvas, device.name, from, device.colour, labels);
}

}  // namespace

std::string to_json(const RoomReport& report) {
  const room::RoomCalibration& r = report.result;
  Json object;
  Fields f(object);
  f.object("room", [&](Fields& room) {
    room.field("points", r.points);
    room.field("outliers", r.outliers);
    room.field("rms_px", r.rms_px);
    room.field("held_out_px", r.held_out_px);
    room.field("scatter", r.scatter);
    room.field("parallax_deg", r.parallax / kDegree);
    room.field("distance", r.distance);
    room.field("wall_sigma", r.wall_sigma);
    room.field("wall_sigma_95", r.wall_sigma_95);
    room.field("wall_sigma_share", r.wall_sigma_share);
    room.field("planar", r.planar);
    room.field("seconds", report.seconds);
    room.field("positions", r.positions);
    room.field("held_out", r.regions);
  });
  if (!report.deviations.empty())
    f.object("truth", [&](Fields& truth) {
      truth.field("parameters", int(report.deviations.size()));
      truth.field("inside_3_sigma", inside_three_sigmas(report.deviations));
      truth.field("deviations", report.deviations);
    });
  return text(object);
}

std::vector<std::string> lines(const RoomReport& report) {
  const room::RoomCalibration& r = report.result;
  std::vector<std::string> out;
  for (const RigCamera& c : r.rig.cameras)
    out.push_back(device_line("camera", c.name, c.camera, c.rig_from_camera, r.rig.covariance));
  for (const RigProjector& p : r.rig.projectors)
    out.push_back(
        device_line("projector", p.name, p.projector.inverse_camera, p.rig_from_projector, r.rig.covariance));
  out.push_back(format(
      "points     %d in use, %d rejected; the light is off by %.3f projector pixels (RMS of a coordinate), on points "
      "held out %.3f; rays meet at %.1f degrees",
      r.points, r.outliers, r.rms_px, r.held_out_px, r.parallax / kDegree));
  const auto worst = std::max_element(r.regions.begin(), r.regions.end(), [](const auto& a, const auto& b) {
    return (a.points >= 10 ? a.rms_px : 0) < (b.points >= 10 ? b.rms_px : 0);
  });
  if (worst != r.regions.end())
    out.push_back(format(
        "           of the parts of the images, column %d row %d of 3 x 3 in view '%s' is worst: %.3f px on %d points "
        "held out",
        worst->column + 1, worst->row + 1, worst->view.c_str(), worst->rms_px, worst->points));
  out.push_back(format(
      "walls      at %.2f m (median); the rig leaves them uncertain by %.2g mm (median), %.2g mm (95 %% of the points)",
      r.distance, 1e3 * r.wall_sigma, 1e3 * r.wall_sigma_95));
  if (!report.deviations.empty()) {
    out.push_back(format("truth      %d of %zu parameters inside three standard deviations",
                         inside_three_sigmas(report.deviations), report.deviations.size()));
    for (const room::ParameterDeviation& d : report.deviations)
      if (std::abs(d.sigmas()) > 3)
        out.push_back(format("           %s is off by %.3g, %.1f standard deviations", d.name.c_str(), d.off,
                             d.sigmas()));
  }
  return out;
}

ImageU8 room_calibration_picture(const room::RoomCalibration& result) {
  Points3 all = result.walls.points;
  for (const room::SolvedPosition& p : result.positions) all.push_back(p.rig_from_camera.translation);
  for (const RigProjector& p : result.rig.projectors) all.push_back(p.rig_from_projector.translation);
  cv::Mat canvas(kViewHeight + kFooter, 2 * kViewWidth, CV_8UC3, kPaper);
  const double largest =
      result.walls.sigma.empty() ? 1e-3 : std::max(1e-6, quantile(result.walls.sigma, 0.95));
  cv::Mat ramp(1, 256, CV_8U), colours, rgb;
  for (int i = 0; i < 256; ++i) ramp.at<std::uint8_t>(0, i) = std::uint8_t(i);
  cv::applyColorMap(ramp, colours, cv::COLORMAP_VIRIDIS);
  cv::cvtColor(colours, rgb, cv::COLOR_BGR2RGB);
  for (int axis = 0; axis < 2; ++axis) {
    const RoomView2 view = fitted(all, axis);
    const int left = axis * kViewWidth;
    for (std::size_t i = 0; i < result.walls.points.size(); ++i) {
      const int level = int(std::clamp(255 * result.walls.sigma[i] / largest, 0.0, 255.0));
      const cv::Vec3b c = rgb.at<cv::Vec3b>(0, level);
      cv::circle(canvas, view.at(result.walls.points[i], left), 1, cv::Scalar(c[0], c[1], c[2]), cv::FILLED,
                 cv::LINE_AA);
    }
    const double length = 0.35 * result.distance;
    std::vector<cv::Rect> labels;
    for (const room::SolvedPosition& p : result.positions)
      draw_device(
          canvas, view, left,
          {result.rig.camera(p.camera).camera, p.rig_from_camera, p.camera + " " + p.view, kCameraColour},
          length, labels);
    for (const RigProjector& p : result.rig.projectors)
      draw_device(canvas, view, left,
                  {p.projector.inverse_camera, p.rig_from_projector, p.name, kProjectorColour}, length,
                  labels);
    cv::putText(canvas, axis == 0 ? "from above" : "from the side", {left + 12, 28}, cv::FONT_HERSHEY_DUPLEX,
                0.6, kInk, 1, cv::LINE_AA);
    const int bar = int(0.5 * view.scale), y = kViewHeight - 14;
    cv::line(canvas, {left + 14, y}, {left + 14 + bar, y}, kInk, 2);
    cv::putText(canvas, "0.5 m", {left + 22 + bar, y + 5}, cv::FONT_HERSHEY_DUPLEX, 0.5, kInk, 1,
                cv::LINE_AA);
  }
  cv::Mat wide;
  cv::resize(rgb, wide, cv::Size(180, 16));
  wide.copyTo(canvas(cv::Rect(360, kViewHeight + 20, 180, 16)));
  cv::putText(canvas, "standard deviation of the walls   0", {14, kViewHeight + 34}, cv::FONT_HERSHEY_DUPLEX,
              0.6, kInk, 1, cv::LINE_AA);
  cv::putText(canvas, format("%.2g mm", 1e3 * largest), {550, kViewHeight + 34}, cv::FONT_HERSHEY_DUPLEX, 0.6,
              kInk, 1, cv::LINE_AA);
  ImageU8 out(canvas.cols, canvas.rows, 3);
  for (int y = 0; y < canvas.rows; ++y)
    std::copy_n(canvas.ptr<std::uint8_t>(y), std::ptrdiff_t(canvas.cols) * 3, out.row(y));
  return out;
}

}  // namespace procam::report
