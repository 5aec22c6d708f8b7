#include "room_people.hpp"

#include <algorithm>
#include <limits>

#include "procam/core/base/error.hpp"

namespace procam::show {

std::optional<ContentFrameInRoom> content_frame(const Projection& projection, const std::string& surface) {
  const SolvedSurfaceSet& solved = projection.solved();
  const auto found = std::find_if(solved.surfaces.begin(), solved.surfaces.end(),
                                  [&](const SolvedSurface& one) { return one.surface.name == surface; });
  if (found == solved.surfaces.end()) return std::nullopt;
  const auto* plane = std::get_if<PlacedPlane>(&found->placement);
  const InRoom* place = place_of(found->surface.geometry);
  if (plane == nullptr || place == nullptr) return std::nullopt;
  ContentFrameInRoom frame;
  frame.is_in_world = place->frame == "world";
  if (frame.is_in_world && !solved.projector_from_world) return std::nullopt;
  const auto corner = [&](double u, double v) {
    const Vec3 h = plane->plane_from_content * Vec3(u, v, 1);
    return Vec3(h.x() / h.z(), h.y() / h.z(), 0);
  };
  const Vec3 origin = corner(0, 0), top = corner(1, 0) - origin, side = corner(0, 1) - origin;
  if (!(top.norm() > 0) || !top.allFinite() || !side.allFinite()) return std::nullopt;
  Mat3 axes;
  axes.col(0) = top.normalized();
  // A content that is read from the wall's other side has its z towards the room.
  axes.col(2) = Vec3(0, 0, top.cross(side).z() < 0 ? -1 : 1);
  axes.col(1) = axes.col(2).cross(axes.col(0));
  frame.size = Vec2(top.norm(), side.norm());
  const Pose projector_from_content = plane->projector_from_surface * Pose(axes, origin);
  frame.place_from_content = frame.is_in_world
                                 ? solved.projector_from_world->inverse() * projector_from_content
                                 : projector_from_content;
  return frame;
}

RoomPeople::RoomPeople(PeopleSensor sensor, const people::PeopleOptions& people,
                       const people::EyeSafeOptions& eyes)
    : sensor_(std::move(sensor)), people_(people), eyes_(eyes) {
  require(sensor_.place_from_sensor.is_finite(), "RoomPeople: the sensor's place is not finite");
}

std::optional<Pose> RoomPeople::projector_from_sensor(const Projection& projection, double time) const {
  if (sensor_.stands == PeopleSensor::Stands::kOnRig) return sensor_.place_from_sensor;
  const std::optional<Pose> projector_from_world = projection.projector_from_world(time);
  if (!projector_from_world) return std::nullopt;
  return *projector_from_world * sensor_.place_from_sensor;
}

std::optional<people::SkeletonFrame> RoomPeople::on_content(const people::SkeletonFrame& taken,
                                                            const Projection& projection,
                                                            const std::string& surface) const {
  const std::optional<ContentFrameInRoom> content = content_frame(projection, surface);
  const std::optional<double> moment = people_.newest();
  if (!content || !moment) return std::nullopt;
  const std::optional<Pose> projector_from_sensor = this->projector_from_sensor(projection, *moment);
  if (!projector_from_sensor) return std::nullopt;
  Pose content_from_projector = content->place_from_content.inverse();
  if (content->is_in_world) {
    const std::optional<Pose> projector_from_world = projection.projector_from_world(*moment);
    if (!projector_from_world) return std::nullopt;
    content_from_projector = content_from_projector * projector_from_world->inverse();
  }
  const Pose content_from_sensor = content_from_projector * *projector_from_sensor;
  people::SkeletonFrame told = taken;
  told.stamp = *moment;
  told.frame = surface;
  for (people::Skeleton& person : told.people)
    for (auto& joint : person.joints)
      if (joint) joint->position = content_from_sensor * joint->position;
  if (people::why_refused(told) != nullptr) return std::nullopt;
  return told;
}

people::MaskResult RoomPeople::darken(ImageView<std::uint8_t> frame, const Projection& projection,
                                      double light_time) const {
  // A place that is not finite darkens all.
  const Pose unknown(Eigen::Quaterniond::Identity(),
                     Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  return people::darken_heads(frame, projection.projector(),
                              projector_from_sensor(projection, light_time).value_or(unknown), people_,
                              light_time, eyes_);
}

}  // namespace procam::show
