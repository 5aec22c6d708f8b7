#include "procam/report/scan.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "fields.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::report {
namespace {

struct ScanSigmas {
  double noise = 0, rig = 0, misfit = 0, total = 0, depth = 0;  ///< medians over the measured pixels
};

ScanSigmas median_sigmas(const scan::Scan& scan) {
  std::vector<double> noise, rig, misfit, total, depth;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (!scan.measured(x, y)) continue;
      noise.push_back(scan.sigma.at(x, y));
      rig.push_back(scan.rig_sigma.at(x, y));
      misfit.push_back(scan.misfit_sigma.empty() ? 0 : scan.misfit_sigma.at(x, y));
      total.push_back(scan.total_sigma(x, y));
      depth.push_back(scan.depth.at(x, y));
    }
  return {median_or(noise, 0.0), median_or(rig, 0.0), median_or(misfit, 0.0), median_or(total, 0.0),
          median_or(depth, 0.0)};
}

}  // namespace

static void fields(Fields& f, const scan::ScanError& error) {
  f.field("compared", error.compared);
  f.field("rms", error.rms);
  f.field("median", error.median);
  f.field("expected_rms", error.expected_rms);
  f.field("noise_rms", error.noise_rms);
  f.field("inside_3_sigma", error.inside_3_sigma);
  f.field("outliers", error.outliers);
}

static void fields(Fields& f, const scan::ViewerAngle& angle) {
  f.field("median", angle.median);
  f.field("of_95", angle.of_95);
}

static void fields(Fields& f, const scan::ViewerError& error) {
  f.field("points", error.points);
  f.field("given", error.given);
  f.field("placed", error.placed);
}

static void fields(Fields& f, const ScannedSurface& surface) {
  const scan::ScanCounts& counts = surface.scan.counts;
  const ScanSigmas sigmas = median_sigmas(surface.scan);
  f.field("name", surface.name);
  f.field("camera", surface.scan.camera.name);
  f.field("projector", surface.scan.projector);
  f.field("lit", counts.lit);
  f.field("measured", counts.measured);
  f.field("inconsistent", counts.inconsistent);
  f.field("out_of_range", counts.out_of_range);
  f.field("isolated", counts.isolated);
  f.field("median_depth", sigmas.depth);
  f.field("median_sigma", sigmas.total);
  f.field("median_sigma_of_noise", sigmas.noise);
  f.field("median_sigma_of_rig", sigmas.rig);
  f.field("median_sigma_of_misfit", sigmas.misfit);
  f.field("consistency", surface.scan.consistency);
  f.field("consistency_px", surface.scan.consistency_px);
  f.field("consistency_px_of_rig", surface.scan.consistency_px_of_rig);
  f.field("vertices", int(surface.mesh.vertices.size()));
  f.field("triangles", int(surface.mesh.triangles.size()));
  f.optional("true_error", surface.error);
  f.optional("viewer_error", surface.viewer);
}

namespace {

cv::Mat depth_mat(const scan::Scan& scan) {
  cv::Mat depth(scan.depth.height(), scan.depth.width(), CV_32F);
  for (int y = 0; y < depth.rows; ++y) std::copy_n(scan.depth.row(y), depth.cols, depth.ptr<float>(y));
  return depth;
}

/// Light from the upper left, by the slopes over a few pixels.
cv::Mat shaded(const scan::Scan& scan) {
  const cv::Mat depth = depth_mat(scan);
  const cv::Mat known = depth > 0;
  cv::Mat weight, sum, smooth;
  known.convertTo(weight, CV_32F, 1.0 / 255);
  cv::GaussianBlur(depth, sum, cv::Size(), 1.5);
  cv::GaussianBlur(weight, weight, cv::Size(), 1.5);
  smooth = sum / (weight + 1e-6f);
  const double focal = scan.camera.camera.intrinsics.fx;
  cv::Mat picture(depth.rows, depth.cols, CV_8UC3, cv::Scalar(30, 34, 44));
  for (int y = 1; y + 1 < depth.rows; ++y)
    for (int x = 1; x + 1 < depth.cols; ++x) {
      if (!known.at<std::uint8_t>(y, x)) continue;
      const double z = smooth.at<float>(y, x);
      const double dx = (smooth.at<float>(y, x + 1) - smooth.at<float>(y, x - 1)) * focal / (2 * z),
                   dy = (smooth.at<float>(y + 1, x) - smooth.at<float>(y - 1, x)) * focal / (2 * z);
      const Vec3 normal = Vec3(dx, dy, -1).normalized();
      const double light = std::max(0.0, normal.dot(Vec3(-0.45, -0.5, -0.74)));
      const auto grey = std::uint8_t(std::clamp(40 + 205 * light, 0.0, 255.0));
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(grey, grey, std::uint8_t(std::min(255, grey + 6)));
    }
  return picture;
}

/// The standard deviations from black (small) to yellow (large), up to the 95 % quantile.
cv::Mat coloured(const scan::Scan& scan, double largest) {
  cv::Mat level(scan.depth.height(), scan.depth.width(), CV_8U, cv::Scalar(0)), colours, rgb;
  for (int y = 0; y < level.rows; ++y)
    for (int x = 0; x < level.cols; ++x)
      if (scan.measured(x, y))
        level.at<std::uint8_t>(y, x) =
            std::uint8_t(std::clamp(255 * scan.total_sigma(x, y) / largest, 0.0, 255.0));
  cv::applyColorMap(level, colours, cv::COLORMAP_VIRIDIS);
  cv::cvtColor(colours, rgb, cv::COLOR_BGR2RGB);
  for (int y = 0; y < level.rows; ++y)
    for (int x = 0; x < level.cols; ++x)
      if (!scan.measured(x, y)) rgb.at<cv::Vec3b>(y, x) = cv::Vec3b(30, 34, 44);
  return rgb;
}

/// Below the two pictures, the second of which begins at `second`.
void draw_scan_legend(cv::Mat& canvas, int top, int second, double largest) {
  const cv::Scalar ink(40, 40, 40);
  const auto write = [&](const std::string& text, int x) {
    cv::putText(canvas, text, {x, top + 33}, cv::FONT_HERSHEY_DUPLEX, 0.7, ink, 1, cv::LINE_AA);
  };
  cv::Mat ramp(16, 160, CV_8U), colours, rgb;
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x).setTo(255 * x / ramp.cols);
  cv::applyColorMap(ramp, colours, cv::COLORMAP_VIRIDIS);
  cv::cvtColor(colours, rgb, cv::COLOR_BGR2RGB);
  write("surface", 12);
  const int x = std::min(second + 12, canvas.cols - 560);
  write("standard deviation", x);
  write("0", x + 240);
  rgb.copyTo(canvas(cv::Rect(x + 262, top + 18, ramp.cols, ramp.rows)));
  write(format("%.2g mm", 1e3 * largest), x + 434);
}

}  // namespace

std::string to_json(const std::vector<ScannedSurface>& surfaces) {
  Json object;
  Fields(object).field("scans", surfaces);
  return text(object);
}

std::vector<std::string> lines(const std::vector<ScannedSurface>& surfaces) {
  std::vector<std::string> out;
  for (const ScannedSurface& surface : surfaces) {
    const scan::ScanCounts& counts = surface.scan.counts;
    const ScanSigmas sigmas = median_sigmas(surface.scan);
    out.push_back(format(
        "%-10s %d points at %.2f m (median) of %d lit pixels; standard deviation %.2g mm: %.2g mm by the "
        "light's noise, %.2g mm by the rig",
        surface.name.c_str(), counts.measured, sigmas.depth, counts.lit, 1e3 * sigmas.total,
        1e3 * sigmas.noise, 1e3 * sigmas.rig));
    if (sigmas.misfit > 0)
      out.back() += format(", %.2g mm because rig and light disagree", 1e3 * sigmas.misfit);
    out.push_back(format(
        "           columns and rows agree to %.2g projector pixels (RMS); rejected: %d inconsistent, %d out "
        "of range, %d isolated",
        surface.scan.consistency_px, counts.inconsistent, counts.out_of_range, counts.isolated));
    out.push_back(format("           mesh of %zu triangles", surface.mesh.triangles.size()));
    if (surface.error)
      out.push_back(format(
          "           true error %.2g mm RMS along the normal (%.2g mm expected), %.2g mm median, %.1f %% inside three sigma, "
          "%.2f %% outliers",
          1e3 * surface.error->rms, 1e3 * surface.error->expected_rms, 1e3 * surface.error->median,
          100 * surface.error->inside_3_sigma, 100 * surface.error->outliers));
    if (surface.viewer && surface.viewer->points > 0)
      out.push_back(format(
          "           content for the viewer is off by the rig's error, 95 %% of the points: %.2g mrad expected, %.2g mrad in "
          "95 %% of rigs; placed by this scan: %.2g, %.2g mrad",
          1e3 * surface.viewer->given.median, 1e3 * surface.viewer->given.of_95,
          1e3 * surface.viewer->placed.median, 1e3 * surface.viewer->placed.of_95));
  }
  return out;
}

ImageU8 scan_picture(const scan::Scan& scan) {
  std::vector<double> sigmas;
  cv::Rect part;  // of the image that is measured
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x)
      if (scan.measured(x, y)) {
        sigmas.push_back(scan.total_sigma(x, y));
        part |= cv::Rect(x, y, 1, 1);
      }
  const double largest = sigmas.empty() ? 1e-3 : std::max(1e-6, quantile(sigmas, 0.95));
  constexpr int kMargin = 12, kLegend = 52, kNarrowest = 1100;
  part = cv::Rect(part.x - kMargin, part.y - kMargin, part.width + 2 * kMargin, part.height + 2 * kMargin) &
         cv::Rect(0, 0, scan.depth.width(), scan.depth.height());
  cv::Mat both;
  cv::hconcat(shaded(scan)(part), coloured(scan, largest)(part), both);
  cv::Mat canvas(both.rows + kLegend, std::max(both.cols, kNarrowest), CV_8UC3, cv::Scalar(248, 248, 248));
  both.copyTo(canvas(cv::Rect(0, 0, both.cols, both.rows)));
  draw_scan_legend(canvas, both.rows, part.width, largest);
  ImageU8 out(canvas.cols, canvas.rows, 3);
  for (int y = 0; y < canvas.rows; ++y)
    std::copy_n(canvas.ptr<std::uint8_t>(y), std::ptrdiff_t(canvas.cols) * 3, out.row(y));
  return out;
}

}  // namespace procam::report
