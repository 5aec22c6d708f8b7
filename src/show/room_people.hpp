#pragma once
/// People before a projector that may drive: kept out of its light, and told to whoever draws a content in
/// the metres of that content's surface.
///
///   RoomPeople people({PeopleSensor::Stands::kOnRig, projector_from_sensor});
///   options.over = [&](const Projection& projection, double light_time, ImageView<std::uint8_t> frame) {
///     people.darken(frame, projection, light_time);
///   };
///   ...
///   for (const people::SkeletonFrame& frame : arrived)
///     if (people.add(frame))
///       if (const auto on_table = people.on_content(frame, projection, "table"))
///       send(to_json_line(*on_table));
///
/// Heads are followed in the sensor's own frame: with a sensor on the rig neither a localiser that jumps nor
/// one that falls silent moves the mask. What contents are told goes through the room,
///
///   content_from_sensor = content_from_world * world_from_projector(moment) * projector_from_sensor,
///
/// at the moment that the frame speaks of, so that a hand that rests on the wall rests in the content too
/// while the robot drives.
#include <optional>
#include <string>

#include "procam/people/eye_safe.hpp"
#include "procam/show/projection.hpp"

namespace procam::show {

struct PeopleSensor {
  enum class Stands { kOnRig, kInWorld };
  Stands stands = Stands::kOnRig;
  Pose place_from_sensor;  ///< projector_from_sensor of one on the rig, world_from_sensor of one in the room
};

/// A plane surface's content frame: origin at the content's (0, 0), x along its top edge, z into the wall,
/// metres, and how large the content is there. What stands in the world is in the world's frame, all else in
/// the projector's. nullopt for what is no plane in the room.
struct ContentFrameInRoom {
  bool is_in_world = false;
  Pose place_from_content;
  Vec2 size = Vec2::Zero();  ///< metres: along the top edge, and of the corner below its beginning
};
std::optional<ContentFrameInRoom> content_frame(const Projection& projection, const std::string& surface);

class RoomPeople {
 public:
  explicit RoomPeople(PeopleSensor sensor, const people::PeopleOptions& people = {},
                      const people::EyeSafeOptions& eyes = {});

  /// Returns whether the frame was taken (PeopleTrack::add).
  bool add(const people::SkeletonFrame& frame) { return people_.add(frame); }

  /// The last frame that was taken, in the content's frame; its stamp is the moment that it speaks of, by the
  /// local clock, its frame the surface's name. nullopt while where the projector stands is not known, for a
  /// surface that is none or no plane, and where somebody is too far from it for a frame to hold (20 m).
  std::optional<people::SkeletonFrame> on_content(const people::SkeletonFrame& taken,
                                                  const Projection& projection,
                                                  const std::string& surface) const;

  /// Blackens heads for the light of that time; all of the frame when where the sensor stands is not known.
  people::MaskResult darken(ImageView<std::uint8_t> frame, const Projection& projection,
                            double light_time) const;

  const people::PeopleTrack& track() const { return people_; }

 private:
  std::optional<Pose> projector_from_sensor(const Projection& projection, double time) const;

  PeopleSensor sensor_;
  people::PeopleTrack people_;
  people::EyeSafeOptions eyes_;
};

}  // namespace procam::show
