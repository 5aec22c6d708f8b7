#include "room.hpp"

#include "procam/core/geometry/se3.hpp"
#include "procam/people/eye_safe.hpp"
#include "procam/people/interaction.hpp"

namespace exercise {
namespace {

using namespace procam;

const Vec2 kFeedbackSize(1.4, 0.8), kZoneSize(0.7, 1.0);
const Points2 kZone = {{0.03, 0.03}, {0.67, 0.03}, {0.67, 0.97}, {0.03, 0.97}};
constexpr double kFloor = 1.35;  ///< metres below the sensor
constexpr double kPixelsPerMetre = 500;

/// On the floor, read by somebody who faces the sensor: x to their right, y towards them, z into the floor.
Pose room_from_floor(double x, double z) {
  Mat3 axes;
  axes << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  return Pose(axes, Vec3(x, kFloor, z));
}
const Pose& room_from_zone(people::Side side) {
  static const Pose left = room_from_floor(1.1, 1.7), right = room_from_floor(-0.4, 1.7);
  return side == people::Side::kLeft ? left : right;
}

Surface on_floor(const std::string& name, const Pose& room_from_surface, const Vec2& size) {
  PlanarSurface plane;
  plane.frame_from_surface = room_from_surface;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {{0, 0}, {size.x(), 0}, size, {0, size.y()}};
  Surface surface;
  surface.name = name;
  surface.geometry = plane;
  return surface;
}

ImageSize picture_of(const Vec2& size) {
  return {int(size.x() * kPixelsPerMetre), int(size.y() * kPixelsPerMetre)};
}

/// Above the sensor, looking down.
Rig projector_above() {
  Rig rig;
  RigProjector lamp;
  lamp.name = "lamp";
  lamp.projector.inverse_camera = {{1280, 800}, {1080, 1072, 655, 372, 0.4}, {}};
  lamp.rig_from_projector = Pose(so3_exp(Vec3(-1.0, 0.03, 0.01)), Vec3(0.1, -1.2, 0.1));
  rig.projectors.push_back(lamp);
  return rig;
}

}  // namespace

Room::Room(const RoomOptions& options) : options_(options), counter_(options.exercise) {
  feedback_.side = options.side;
  feedback_.options = options.exercise;
  show::ProjectionOptions drawing;
  const Rig rig = projector_above();
  drawing.projector_from_world = rig.projector().rig_from_projector.inverse();
  drawing.over = [this](const show::Projection& projection, double time, Picture frame) {
    people::darken_heads(frame, projection.projector(), *projection.projector_from_world(time), people_,
                         time);
  };
  projection_ = std::make_unique<show::Projection>(rig, drawing);
  show::Show show;
  show.surfaces = {{on_floor("feedback", room_from_floor(0.7, 0.75), kFeedbackSize),
                    on_floor("zone", room_from_zone(options.side), kZoneSize)}};
  show.contents = {device::drawn_content(picture_of(kFeedbackSize), 3,
                                         [this](double, Picture picture) {
                                           draw_feedback(feedback_, kFeedbackSize, picture);
                                           return true;
                                         }),
                   device::drawn_content(picture_of(kZoneSize), 3, [this](double, Picture picture) {
                     draw_zone(kZone, trespasser_, kZoneSize, time_, picture);
                     return true;
                   })};
  projection_->set_show(std::move(show));
}

ImageSize Room::frame_size() const {
  return projection_->frame_size();
}

void Room::add(const people::SkeletonFrame& frame) {
  people_.add(frame);
}

void Room::advance(double time) {
  time_ = time;
  const std::vector<people::TrackedPerson> people = people_.at(time);
  feedback_.angle = people.empty() ? std::nullopt : abduction_angle(people[0].skeleton, options_.side);
  if (counter_.update(feedback_.angle) == ExerciseCounter::Event::kReached) reached_ = time;
  feedback_.count = counter_.count();
  feedback_.best = counter_.best();
  feedback_.since_reached = time - reached_;
  trespasser_ =
      people::trespass(people, room_from_zone(options_.side).inverse(), kZone, options_.zone_height);
}

void Room::draw(Picture frame) {
  projection_->draw(time_, time_, frame);
}

}  // namespace exercise
