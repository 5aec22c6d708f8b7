#include "procam/people/eye_safe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "procam/core/base/error.hpp"

namespace procam::people {
namespace {

constexpr int kOutline = 48;  ///< corners; the circle is drawn around, so that none of it is cut

void blacken(ImageView<std::uint8_t> frame, int y, int x0, int x1) {
  if (x0 <= x1)
    std::fill(frame.row(y) + std::ptrdiff_t(x0) * frame.channels,
              frame.row(y) + std::ptrdiff_t(x1 + 1) * frame.channels, std::uint8_t(0));
}
void blacken(ImageView<std::uint8_t> frame) {
  for (int y = 0; y < frame.height; ++y) blacken(frame, y, 0, frame.width - 1);
}

/// A pixel is within when any of its square may be: outwards by half a pixel and one more.
void fill(ImageView<std::uint8_t> frame, const Points2& outline) {
  double top = std::numeric_limits<double>::infinity(), bottom = -top;
  for (const Vec2& p : outline) top = std::min(top, p.y()), bottom = std::max(bottom, p.y());
  const int first = int(std::clamp(std::floor(top) - 1, 0.0, double(frame.height)));
  const int last = int(std::clamp(std::ceil(bottom) + 1, -1.0, double(frame.height - 1)));
  for (int y = first; y <= last; ++y) {
    double left = std::numeric_limits<double>::infinity(), right = -left;
    const double above = y - 1.5, below = y + 1.5;
    for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const Vec2 &a = outline[j], &b = outline[i];
      if (std::max(a.y(), b.y()) < above || std::min(a.y(), b.y()) > below) continue;
      for (const double at : {above, below}) {
        const double s = a.y() == b.y() ? 0 : std::clamp((at - a.y()) / (b.y() - a.y()), 0.0, 1.0);
        const double x = a.x() + s * (b.x() - a.x());
        left = std::min({left, x, a.y() == b.y() ? b.x() : x});
        right = std::max({right, x, a.y() == b.y() ? b.x() : x});
      }
    }
    if (left > right) continue;
    blacken(frame, y, int(std::clamp(std::floor(left) - 1, 0.0, double(frame.width))),
            int(std::clamp(std::ceil(right) + 1, -1.0, double(frame.width - 1))));
  }
}

enum class Ball { kDrawn, kOutOfSight, kUnknown };

/// Lines from the lens touch the ball (centre c at distance d, radius r) in a circle about c (1 - r^2 / d^2)
/// with radius r sqrt(1 - r^2 / d^2), square to c.
Ball blacken_ball(ImageView<std::uint8_t> frame, const Camera& lens, const Vec3& centre, double r) {
  const double d = centre.norm();
  if (!(d > r)) return Ball::kUnknown;
  if (centre.z() < -r) return Ball::kOutOfSight;  // behind the lens, all of it
  const double shrink = 1 - r * r / (d * d);
  const Vec3 axis = centre / d;
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  // Corners outside of the circle by as much as the sides between them cut it.
  const double out = r * std::sqrt(shrink) / std::cos(kPi / kOutline);
  Points2 outline;
  int unseen = 0;
  for (int i = 0; i < kOutline; ++i) {
    const double a = 2 * kPi * i / kOutline;
    const std::optional<Vec2> pixel =
        lens.project(shrink * centre + out * (std::cos(a) * u + std::sin(a) * v));
    if (pixel)
      outline.push_back(*pixel);
    else
      ++unseen;
  }
  if (unseen == 0) {
    fill(frame, outline);
    return Ball::kDrawn;
  }
  // Some lines miss the lens model. Whether any light passes the ball is asked of the picture's own rays,
  // coarsely, with the ball larger by what lies between them.
  const double step = 1.0 / 32;
  for (int i = 0; i <= 32; ++i)
    for (int j = 0; j <= 32; ++j) {
      const Vec2 pixel(i * step * (frame.width - 1), j * step * (frame.height - 1));
      const std::optional<Vec3> bearing = lens.unproject(pixel);
      if (!bearing) return Ball::kUnknown;
      const double along = bearing->dot(centre);
      if (along > 0 && (centre - along * *bearing).norm() < r + 0.1 * d) return Ball::kUnknown;
    }
  return Ball::kOutOfSight;
}

}  // namespace

MaskResult darken_heads(ImageView<std::uint8_t> frame, const Projector& projector,
                        const Pose& projector_from_sensor, const std::vector<TrackedPerson>& people,
                        const std::optional<double>& newest, double light_time,
                        const EyeSafeOptions& options) {
  require(frame.size() == projector.size(), "darken_heads: the frame is not of the projector's size");
  MaskResult result;
  const auto darken_all = [&](const char* why) {
    blacken(frame);
    result.blanked = true;
    result.reason = why;
    return result;
  };
  if (options.dark_without_news && !(newest && light_time - *newest <= options.fresh))
    return darken_all("there is no news of people");
  if (!projector_from_sensor.is_finite()) return darken_all("where the sensor is, is not known");
  const auto cover = [&](const Vec3& point_in_sensor, double age, double sigma) {
    const double r = options.radius + options.margin + options.speed * std::max(0.0, age) + 3 * sigma;
    return blacken_ball(frame, projector.inverse_camera, projector_from_sensor * point_in_sensor, r);
  };
  for (const TrackedPerson& person : people) {
    const std::optional<Vec3> head = head_of(person.skeleton);
    bool is_drawn = false;
    // Without a head: any joint may be where it is.
    double sigma = 0;
    for (std::size_t j = 0; j < kJointCount; ++j)
      if (person.skeleton.joints[j])
        sigma = std::max(sigma, j <= std::size_t(Joint::kRightEar) || !head ? person.sigma[j] : 0);
    if (head) {
      const Ball ball = cover(*head, person.age, sigma);
      if (ball == Ball::kUnknown) return darken_all("a head is at the lens, or beyond its model");
      is_drawn = ball == Ball::kDrawn;
    } else {
      bool has_joint = false;
      for (const auto& seen : person.skeleton.joints) {
        if (!seen) continue;
        has_joint = true;
        // A head is within 0.35 m of a shoulder; more of what else was seen.
        const double around = 0.35;
        const double r =
            options.radius + options.margin + options.speed * std::max(0.0, person.age) + 3 * sigma;
        const Ball ball =
            blacken_ball(frame, projector.inverse_camera, projector_from_sensor * seen->position, r + around);
        if (ball == Ball::kUnknown)
          return darken_all("a person without a head is at the lens, or beyond its model");
        is_drawn |= ball == Ball::kDrawn;
      }
      if (!has_joint) return darken_all("a person is there, but not a joint of it");
    }
    result.masked += is_drawn ? 1 : 0;
  }
  return result;
}

MaskResult darken_heads(ImageView<std::uint8_t> frame, const Projector& projector,
                        const Pose& projector_from_sensor, const PeopleTrack& track, double light_time,
                        const EyeSafeOptions& options) {
  return darken_heads(frame, projector, projector_from_sensor, track.at(light_time), track.newest(),
                      light_time, options);
}

}  // namespace procam::people
