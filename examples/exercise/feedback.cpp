#include "feedback.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

namespace exercise {
namespace {

using procam::kDegree;
using procam::kPi;
using procam::people::Side;

constexpr int kShift = 4;  // OpenCV draws to 1/16 px

/// A picture of a surface, drawn on in metres.
struct Canvas {
  cv::Mat image;
  double scale;  ///< pixels a metre

  Canvas(Picture picture, const Vec2& size)
      : image(picture.height, picture.width, CV_8UC3, picture.data, std::size_t(picture.stride)),
        scale(picture.width / size.x()) {}
  cv::Point at(const Vec2& p) const {
    return {int(std::lround((p.x() * scale - 0.5) * (1 << kShift))),
            int(std::lround((p.y() * scale - 0.5) * (1 << kShift)))};
  }
  int width(double metres) const { return std::max(1, int(std::lround(metres * scale))); }
  void line(const Vec2& a, const Vec2& b, const cv::Scalar& colour, double metres) const {
    cv::line(image, at(a), at(b), colour, width(metres), cv::LINE_AA, kShift);
  }
  void disc(const Vec2& centre, double r, const cv::Scalar& colour) const {
    cv::circle(image, at(centre), int(std::lround(r * scale * (1 << kShift))), colour, -1, cv::LINE_AA,
               kShift);
  }
  void ring(const Vec2& centre, double r, const cv::Scalar& colour, double metres) const {
    cv::circle(image, at(centre), int(std::lround(r * scale * (1 << kShift))), colour, width(metres),
               cv::LINE_AA, kShift);
  }
  void polygon(const Points2& ring, const cv::Scalar& colour) const {
    std::vector<cv::Point> corners;
    for (const Vec2& p : ring) corners.push_back(at(p));
    cv::fillConvexPoly(image, corners, colour, cv::LINE_AA, kShift);
  }
  void words(const std::string& text, const Vec2& middle, double height, const cv::Scalar& colour) const {
    const int font = cv::FONT_HERSHEY_DUPLEX;
    int below = 0;
    const double size = height * scale / cv::getTextSize("0", font, 1, 1, &below).height;
    const int stroke = std::max(1, int(std::lround(height * scale / 8)));
    const cv::Size box = cv::getTextSize(text, font, size, stroke, &below);
    cv::putText(
        image, text,
        cv::Point(int(middle.x() * scale - box.width / 2.0), int(middle.y() * scale + box.height / 2.0)),
        font, size, colour, stroke, cv::LINE_AA);
  }
};

const cv::Scalar kWhite(255, 255, 255), kDim(70, 80, 95), kGreen(60, 220, 110), kAmber(255, 190, 40),
    kRed(200, 16, 24);

}  // namespace

void draw_feedback(const Feedback& feedback, const Vec2& size, Picture picture) {
  Canvas canvas(picture, size);
  canvas.image.setTo(cv::Scalar(8, 12, 20));
  const double unit = size.y();
  // As in a mirror: the left arm on the left.
  const double sign = feedback.side == Side::kLeft ? -1 : 1;
  const Vec2 shoulder(size.x() / 2 - sign * 0.12 * unit, 0.38 * unit);
  const auto along = [&](double angle, double r) {
    return Vec2(shoulder + r * Vec2(sign * std::sin(angle), std::cos(angle)));
  };
  const auto arc = [&](double from, double to, double r, const cv::Scalar& colour, double metres) {
    constexpr int kParts = 40;
    for (int i = 0; i < kParts; ++i)
      canvas.line(along(from + (to - from) * i / kParts, r), along(from + (to - from) * (i + 1) / kParts, r),
                  colour, metres);
  };
  // Trunk and head.
  const Vec2 neck = shoulder - Vec2(sign * 0.1 * unit, 0.03 * unit);
  canvas.line(neck, neck + Vec2(0, 0.45 * unit), kDim, 0.09 * unit);
  canvas.line(neck, shoulder, kDim, 0.05 * unit);
  canvas.disc(neck - Vec2(0, 0.14 * unit), 0.075 * unit, kDim);

  const double r = 0.42 * unit, target = feedback.options.target, rest = feedback.options.rest;
  arc(0, kPi / 2 + 0.35, r, kDim, 0.012 * unit);
  arc(0, rest, r, cv::Scalar(60, 110, 190), 0.02 * unit);
  const bool is_there = feedback.angle && *feedback.angle >= target;
  canvas.line(along(target, 0.85 * r), along(target, 1.12 * r), is_there ? kGreen : kAmber, 0.02 * unit);
  canvas.words(std::to_string(int(std::lround(target / kDegree))), along(target, 1.26 * r), 0.045 * unit,
               is_there ? kGreen : kAmber);
  if (feedback.angle) {
    const double angle = std::clamp(*feedback.angle, -0.3, kPi);
    arc(0, std::max(0.0, angle), r, is_there ? kGreen : kWhite, 0.035 * unit);
    canvas.line(shoulder, along(angle, r), is_there ? kGreen : kWhite, 0.05 * unit);
    canvas.disc(along(angle, r), 0.045 * unit, is_there ? kGreen : kWhite);
    const double best = std::clamp(feedback.best, 0.0, kPi);
    canvas.line(along(best, 0.95 * r), along(best, 1.06 * r), kWhite, 0.01 * unit);
  }
  // The count, which swells when it has grown; beside the trunk, where no arm goes.
  const double swell = std::max(0.0, 1 - feedback.since_reached / 0.5);
  const Vec2 beside(size.x() / 2 - sign * (size.x() / 2 - 0.3 * unit), 0.36 * unit);
  canvas.words(std::to_string(feedback.count), beside, (0.22 + 0.08 * swell) * unit,
               swell > 0 ? kGreen : kWhite);
  canvas.words(
      feedback.angle ? std::to_string(int(std::lround(*feedback.angle / kDegree))) + " deg" : "arm not seen",
      beside + Vec2(0, 0.3 * unit), 0.06 * unit, feedback.angle ? kWhite : kAmber);
}

void draw_zone(const Points2& zone, const std::optional<Vec2>& trespasser, const Vec2& size, double time,
               Picture picture) {
  Canvas canvas(picture, size);
  canvas.image.setTo(cv::Scalar(0, 0, 0));
  if (trespasser) canvas.polygon(zone, cv::Scalar(70, 6, 10));
  const bool is_bright = !trespasser || std::fmod(time, 0.6) < 0.4;
  for (std::size_t i = 0; i < zone.size(); ++i) {
    const Vec2 &a = zone[i], &b = zone[(i + 1) % zone.size()];
    constexpr int kDashes = 9;  // odd, so that corners are drawn
    for (int d = 0; d < kDashes; d += trespasser ? 1 : 2)
      canvas.line(a + (b - a) * d / kDashes, a + (b - a) * (d + 1) / kDashes,
                  is_bright ? (trespasser ? cv::Scalar(255, 40, 40) : cv::Scalar(150, 90, 20)) : kRed, 0.02);
  }
  if (!trespasser) return;
  Vec2 middle = Vec2::Zero();
  for (const Vec2& p : zone) middle += p / double(zone.size());
  const double r = 0.34 * std::min(size.x(), size.y());
  const auto octagon = [&](double radius) {
    Points2 corners;
    for (int i = 0; i < 8; ++i)
      corners.push_back(middle +
                        radius * Vec2(std::cos(kPi / 8 + i * kPi / 4), std::sin(kPi / 8 + i * kPi / 4)));
    return corners;
  };
  canvas.polygon(octagon(r), kWhite);
  canvas.polygon(octagon(0.92 * r), kRed);
  canvas.words("STOP", middle, 0.42 * r, kWhite);
  canvas.ring(*trespasser, 0.06, kWhite, 0.012);
}

}  // namespace exercise
