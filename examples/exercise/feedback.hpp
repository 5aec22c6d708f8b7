#pragma once
/// What somebody who exercises sees on the floor, as pictures of surfaces whose size is known in metres.
#include <optional>

#include "gestures.hpp"
#include "procam/core/base/image.hpp"

namespace exercise {

using Picture = procam::ImageView<std::uint8_t>;
using procam::Points2;
using procam::Vec2;

struct Feedback {
  procam::people::Side side = procam::people::Side::kLeft;
  std::optional<double> angle;  ///< of the arm now; nullopt: it is not seen
  ExerciseOptions options;
  int count = 0;
  double best = 0;            ///< of this repetition
  double since_reached = 10;  ///< seconds
};
/// The trunk and the arm as in a mirror: the arc to the target, how far it has come, and how often it was
/// there.
void draw_feedback(const Feedback& feedback, const Vec2& size, Picture picture);

/// A forbidden zone: its outline; and while somebody is in it, a stop sign, and a ring where they are. All in
/// metres of the surface.
void draw_zone(const Points2& zone, const std::optional<Vec2>& trespasser, const Vec2& size, double time,
               Picture picture);

}  // namespace exercise
