#pragma once
/// A place to exercise: a sensor that sees the person, a floor that shows how it goes, and a zone beside it
/// that nobody may reach into.
#include <memory>

#include "feedback.hpp"
#include "procam/people/people.hpp"
#include "procam/show/projection.hpp"

namespace exercise {

struct RoomOptions {
  procam::people::Side side = procam::people::Side::kLeft;
  ExerciseOptions exercise;
  double zone_height = 2;  ///< metres above the floor up to which the zone is forbidden
};

/// The sensor's frame is the room's. Both surfaces are read by a person who faces the sensor.
class Room {
 public:
  explicit Room(const RoomOptions& options);

  void add(const procam::people::SkeletonFrame& frame);
  /// To a moment of the skeletons' clock.
  void advance(double time);
  /// The frame of the projector for that moment.
  void draw(Picture frame);

  procam::ImageSize frame_size() const;
  const Feedback& feedback() const { return feedback_; }
  bool is_forbidden() const { return trespasser_.has_value(); }
  const procam::people::PeopleTrack& people() const { return people_; }

 private:
  RoomOptions options_;
  procam::people::PeopleTrack people_;
  ExerciseCounter counter_;
  Feedback feedback_;
  std::optional<Vec2> trespasser_;
  double time_ = 0, reached_ = -10;
  std::unique_ptr<procam::show::Projection> projection_;
};

}  // namespace exercise
