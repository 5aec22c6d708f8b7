#include "overlay.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace procam::show {
namespace {

cv::Mat canvas_of(ImageView<std::uint8_t> frame) {
  require(frame.channels == 3, "overlay: the frame has not 3 channels");
  return cv::Mat(frame.height, frame.width, CV_8UC3, frame.data, std::size_t(frame.stride));
}

/// Black below, white above. Lines that are far outside the frame are not drawn: OpenCV counts in 32 bits.
void draw_line(const cv::Mat& picture, const Vec2& from, const Vec2& to) {
  constexpr int kFractionBits = 4;
  constexpr double kFar = 1e6;
  if (!(from.cwiseAbs().maxCoeff() < kFar && to.cwiseAbs().maxCoeff() < kFar)) return;
  const auto point = [](const Vec2& p) {
    return cv::Point(int(std::lround(p.x() * (1 << kFractionBits))),
                     int(std::lround(p.y() * (1 << kFractionBits))));
  };
  const int thin = std::max(1, picture.rows / 180);  // seen from the other side of a room
  for (const auto& [level, width] : {std::pair(0, 3 * thin), std::pair(255, thin)})
    cv::line(picture, point(from), point(to), cv::Scalar::all(level), width, cv::LINE_AA, kFractionBits);
}

}  // namespace

void draw_cross(ImageView<std::uint8_t> frame, const Vec2& pixel) {
  const cv::Mat picture = canvas_of(frame);
  const double arm = frame.height / 20.0, gap = arm / 5;
  for (const Vec2& way : {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1)})
    draw_line(picture, pixel + gap * way, pixel + arm * way);
}

void draw_ring(ImageView<std::uint8_t> frame, const Points2& pixels) {
  const cv::Mat picture = canvas_of(frame);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    draw_line(picture, pixels[i], pixels[(i + 1) % pixels.size()]);
}

void draw_words(ImageView<std::uint8_t> frame, const std::vector<std::string>& lines) {
  require(frame.channels == 3, "draw_words: the frame has not 3 channels");
  if (frame.empty() || lines.empty()) return;
  cv::Mat picture(frame.height, frame.width, CV_8UC3, frame.data, std::size_t(frame.stride));
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  int widest = 1, below = 0;
  for (const std::string& line : lines)
    widest = std::max(widest, cv::getTextSize(line, kFont, 1, 2, &below).width);
  constexpr double kLine = 40;  // pixels of height that a line takes at scale 1
  const double scale =
      std::min(0.5 * frame.width / widest, 0.5 * frame.height / (kLine * double(lines.size())));
  const double width = widest * scale, height = kLine * scale * double(lines.size());
  const cv::Point2d corner(0.5 * (frame.width - width), 0.5 * (frame.height - height));
  const double margin = 0.5 * kLine * scale;
  cv::rectangle(picture, cv::Point2d(corner.x - margin, corner.y - margin),
                cv::Point2d(corner.x + width + margin, corner.y + height + margin), cv::Scalar(24, 24, 24),
                cv::FILLED);
  for (std::size_t i = 0; i < lines.size(); ++i)
    cv::putText(picture, lines[i], cv::Point2d(corner.x, corner.y + kLine * scale * (double(i) + 0.75)),
                kFont, scale, cv::Scalar(255, 255, 255), std::max(1, int(std::lround(2 * scale))),
                cv::LINE_AA);
}

}  // namespace procam::show
