#include "draw.hpp"

#include <opencv2/imgproc.hpp>
#include <string>

namespace hockey {
namespace {

const cv::Scalar kLeft(40, 210, 255), kRight(255, 120, 40), kWhite(255, 255, 255), kLine(60, 110, 190);
constexpr int kShift = 4;  // OpenCV draws to 1/16 px

cv::Mat as_mat(Picture picture) {
  return {picture.height, picture.width, CV_8UC3, picture.data, std::size_t(picture.stride)};
}

/// Metres to pixels of a picture whose whole area is the table's.
struct Scale {
  double x, y;
  cv::Point at(const Vec2& p) const {
    return {int(std::lround((p.x() * x - 0.5) * (1 << kShift))),
            int(std::lround((p.y() * y - 0.5) * (1 << kShift)))};
  }
  int length(double metres) const { return std::max(1, int(std::lround(metres * x * (1 << kShift)))); }
  int thickness(double metres) const { return std::max(1, int(std::lround(metres * x))); }
};
Scale scale_of(const Table& table, int width, int height) {
  return {width / table.length, height / table.width};
}

void disc(cv::Mat& image, const Scale& scale, const Vec2& centre, double r, const cv::Scalar& colour,
          int thickness = -1) {
  cv::circle(image, scale.at(centre), scale.length(r), colour, thickness, cv::LINE_AA, kShift);
}

void paddle(cv::Mat& image, const Scale& scale, const Vec2& centre, double r, const cv::Scalar& colour) {
  disc(image, scale, centre, r * 1.12, 0.25 * colour);
  disc(image, scale, centre, r, colour);
  disc(image, scale, centre, r * 0.8, 0.55 * colour);
  disc(image, scale, centre, r * 0.42, colour);
  disc(image, scale, centre, r * 0.3, 0.35 * colour + 0.65 * kWhite);
}

void centred(cv::Mat& image, const std::string& text, cv::Point2d middle, double height,
             const cv::Scalar& colour) {
  const int font = cv::FONT_HERSHEY_DUPLEX;
  int below = 0;
  const double size = height / cv::getTextSize("0", font, 1, 1, &below).height;
  const int thickness = std::max(1, int(std::lround(height / 9)));
  const cv::Size box = cv::getTextSize(text, font, size, thickness, &below);
  cv::putText(image, text, cv::Point(int(middle.x - box.width / 2.0), int(middle.y + box.height / 2.0)), font,
              size, colour, thickness, cv::LINE_AA);
}

}  // namespace

procam::ImageSize table_size(const Table& table, double pixels_per_metre) {
  return {int(std::lround(table.length * pixels_per_metre)),
          int(std::lround(table.width * pixels_per_metre))};
}

TableArtist::TableArtist(const Table& table, procam::ImageSize size) : bare_(size, 3), felt_(size, 3) {
  const Scale scale = scale_of(table, size.width, size.height);
  cv::Mat felt = as_mat(bare_.view());
  for (int y = 0; y < felt.rows; ++y)
    for (int x = 0; x < felt.cols; ++x) {
      const double u = 2.0 * x / felt.cols - 1, v = 2.0 * y / felt.rows - 1;
      const double light = 1 - 0.45 * (u * u + v * v) / 2;
      felt.at<cv::Vec3b>(y, x) =
          cv::Vec3b(std::uint8_t(10 * light), std::uint8_t(22 * light), std::uint8_t(52 * light));
    }
  cv::Mat lines(felt.size(), CV_8UC3, cv::Scalar(0, 0, 0));
  const double l = table.length, w = table.width, low = (w - table.goal) / 2, high = (w + table.goal) / 2;
  const auto line = [&](const Vec2& a, const Vec2& b, const cv::Scalar& colour, double width) {
    cv::line(lines, scale.at(a), scale.at(b), colour, scale.thickness(width), cv::LINE_AA, kShift);
  };
  line({l / 2, 0}, {l / 2, w}, kLine, 0.006);
  disc(lines, scale, {l / 2, w / 2}, 0.16, kLine, scale.thickness(0.006));
  disc(lines, scale, {l / 2, w / 2}, 0.015, kLine);
  disc(lines, scale, {0, w / 2}, table.goal * 0.72, 0.5 * kLeft, scale.thickness(0.006));
  disc(lines, scale, {l, w / 2}, table.goal * 0.72, 0.5 * kRight, scale.thickness(0.006));
  const double edge = 0.004;  // half of it would lie off the picture
  for (const double y : {edge, w - edge}) {
    line({0, y}, {l / 2, y}, kLeft, 0.012);
    line({l / 2, y}, {l, y}, kRight, 0.012);
  }
  for (const auto& [from, to] : {std::pair(0.0, low), std::pair(high, w)}) {
    line({edge, from}, {edge, to}, kLeft, 0.012);
    line({l - edge, from}, {l - edge, to}, kRight, 0.012);
  }
  for (const Segment& obstacle : table.obstacles)
    line(obstacle.a, obstacle.b, cv::Scalar(230, 220, 120), 0.01);
  cv::Mat glow;
  cv::GaussianBlur(lines, glow, cv::Size(), 0.016 * scale.x);
  felt += 0.9 * glow;
  felt += lines;
  // A goal is a hole.
  cv::line(felt, scale.at({0, low}), scale.at({0, high}), cv::Scalar(0, 0, 0), scale.thickness(0.03),
           cv::LINE_8, kShift);
  cv::line(felt, scale.at({l, low}), scale.at({l, high}), cv::Scalar(0, 0, 0), scale.thickness(0.03),
           cv::LINE_8, kShift);
}

void TableArtist::draw_felt(const Match& match) {
  cv::Mat felt = as_mat(felt_.view());
  as_mat(bare_.view()).copyTo(felt);
  for (int side = 0; side < 2; ++side)
    centred(felt, std::to_string(match.score(side)), {(0.25 + 0.5 * side) * felt.cols, 0.5 * felt.rows},
            0.3 * felt.rows, 0.22 * (side == 0 ? kLeft : kRight));
  score_ = {match.score(0), match.score(1)};
}

void TableArtist::draw(const Match& match, Picture picture) {
  const Table& table = match.table();
  const Scale scale = scale_of(table, picture.width, picture.height);
  cv::Mat image = as_mat(picture);
  const cv::Mat felt = as_mat(felt_.view());
  if (score_[0] != match.score(0) || score_[1] != match.score(1) || picture_ != picture.data) {
    draw_felt(match);
    touched_ = {{0, 0, image.cols, image.rows}};
    picture_ = picture.data;
  }
  for (const auto& [x, y, width, height] : touched_) {
    const cv::Rect part(x, y, width, height);
    felt(part).copyTo(image(part));
  }
  touched_.clear();
  const auto touch = [&](const Vec2& centre, double r) {
    const int x = int((centre.x() - r) * scale.x) - 3, y = int((centre.y() - r) * scale.y) - 3;
    const cv::Rect part = cv::Rect(x, y, int(2 * r * scale.x) + 8, int(2 * r * scale.y) + 8) &
                          cv::Rect(0, 0, image.cols, image.rows);
    if (!part.empty()) touched_.push_back({part.x, part.y, part.width, part.height});
  };

  // A time that has gone back, or a serve, begins a new trail.
  const bool is_new = drawn_ < 0 || (trail_[0] - match.puck()).norm() > 0.3;
  if (is_new) trail_.fill(match.puck());
  std::rotate(trail_.rbegin(), trail_.rbegin() + 1, trail_.rend());
  trail_[0] = match.puck();
  drawn_ = match.time();

  for (std::size_t i = trail_.size(); i-- > 1;) {
    const double fresh = 1 - double(i) / double(trail_.size());
    cv::line(image, scale.at(trail_[i]), scale.at(trail_[i - 1]),
             cv::Scalar(40, 70, 120) * (0.25 + 0.75 * fresh),
             scale.thickness(2 * table.puck * (0.2 + 0.7 * fresh)), cv::LINE_AA, kShift);
    touch((trail_[i] + trail_[i - 1]) / 2, (trail_[i] - trail_[i - 1]).norm() / 2 + table.puck);
  }
  const Touch& blow = match.last_touch();
  const double since = match.time() - blow.time;
  if (blow.time >= 0 && since < 0.25) {
    disc(image, scale, blow.point, 0.02 + 0.35 * since, (1 - 4 * since) * cv::Scalar(255, 240, 170),
         scale.thickness(0.006));
    touch(blow.point, 0.03 + 0.35 * since);
  }
  disc(image, scale, match.puck(), table.puck * 1.1, cv::Scalar(60, 80, 110));
  disc(image, scale, match.puck(), table.puck, kWhite);
  disc(image, scale, match.puck(), table.puck * 0.72, cv::Scalar(205, 215, 230));
  disc(image, scale, match.puck(), table.puck * 0.6, kWhite);
  touch(match.puck(), table.puck * 1.2);
  for (int side = 0; side < 2; ++side) {
    paddle(image, scale, match.paddle(side), table.paddle, side == 0 ? kLeft : kRight);
    touch(match.paddle(side), table.paddle * 1.2);
  }

  if (match.phase() == Phase::kPlaying) return;
  image *= 0.45;
  touched_ = {{0, 0, image.cols, image.rows}};
  const bool is_over = match.phase() == Phase::kOver, left_won = match.score(0) > match.score(1);
  const std::string text = is_over ? (left_won ? "LEFT WINS" : "RIGHT WINS")
                           : match.countdown() > 0
                               ? std::to_string(int(std::ceil(3 * match.countdown() / match.rules().ready)))
                               : "WAITING FOR BOTH HANDS";
  centred(image, text, {0.5 * image.cols, 0.5 * image.rows}, (text.size() > 12 ? 0.06 : 0.16) * image.rows,
          is_over ? (left_won ? kLeft : kRight) : kWhite);
}

bool ScoreboardArtist::draw(const Match& match, Picture picture) {
  const long now = (long(match.time()) * 100 + match.score(0)) * 100 + match.score(1);
  if (now == shown_) return false;
  shown_ = now;
  cv::Mat image = as_mat(picture);
  image.setTo(cv::Scalar(6, 10, 20));
  const double h = image.rows, w = image.cols;
  cv::rectangle(image, cv::Rect(0, 0, image.cols, image.rows), kLine, std::max(2, int(0.03 * h)));
  centred(image, std::to_string(match.score(0)), {0.2 * w, 0.5 * h}, 0.55 * h, kLeft);
  centred(image, std::to_string(match.score(1)), {0.8 * w, 0.5 * h}, 0.55 * h, kRight);
  const int seconds = int(match.time());
  const std::string time =
      std::to_string(seconds / 60) + (seconds % 60 < 10 ? ":0" : ":") + std::to_string(seconds % 60);
  centred(image, time, {0.5 * w, 0.5 * h}, 0.3 * h, cv::Scalar(190, 205, 225));
  return true;
}

}  // namespace hockey
