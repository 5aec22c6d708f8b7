#include "overlay.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace procam::show {

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
