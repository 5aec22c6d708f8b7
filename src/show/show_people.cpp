#include "show_people.hpp"

#include "procam/core/rig/room_frames.hpp"
#include "procam/io/pose_file.hpp"

namespace procam::show {
namespace {

PeopleSensor load_sensor(const std::string& file, const Rig& rig, const RigProjector& projector) {
  if (file.empty())
    throw Error(ErrorKind::kInput, "people", "the pose of their sensor is not known",
                "give the sensor: a pose file between 'sensor' and the rig, its projector, a camera or the "
                "world");
  FrameTree::Link link = io::load_pose(file);
  if ((link.target == "sensor") == (link.source == "sensor"))
    throw Error(ErrorKind::kInput, file, "it does not tell where anything is on 'sensor'",
                "give a pose between 'sensor' and the rig, its projector, a camera or the world");
  if (link.target == "world" || link.source == "world") {
    FrameTree frames;
    frames.set(link.target, link.source, link.target_from_source);
    return {PeopleSensor::Stands::kInWorld, frames.get("world", "sensor").pose};
  }
  // room_frames() attaches a device's surroundings to the rig under the name "world".
  (link.target == "sensor" ? link.target : link.source) = "world";
  return {PeopleSensor::Stands::kOnRig,
          room_frames(rig, projector, std::move(link)).get(projector.name, "world").pose};
}

people::PeopleOptions people_options(const PeopleInput& input) {
  people::PeopleOptions options;
  options.delay = input.delay_s;
  return options;
}

}  // namespace

ShowPeople::ShowPeople(const PeopleInput& input, const Rig& rig, const RigProjector& projector,
                       std::function<void(const std::string&)> say)
    : people_(load_sensor(input.sensor, rig, projector), people_options(input)), log_(std::move(say)) {
  for (const std::string& item : input.destinations) {
    const std::size_t equals = item.find("=udp:");
    if (equals == std::string::npos || equals == 0)
      throw Error(ErrorKind::kInput, "people to " + item, "it does not read SURFACE=udp:HOST:PORT",
                  "write e.g. table=udp:127.0.0.1:9101");
    destinations_.push_back(
        {item.substr(0, equals), track::open_pose_sender(item.substr(equals + 1), false)});
  }
  source_ = people::open_skeleton_source(input.source);
}

void ShowPeople::take(const Projection& projection) {
  source_->poll(arrived_);
  for (const people::SkeletonFrame& frame : arrived_) {
    if (!people_.add(frame)) continue;
    ++frames_;
    for (const Destination& to : destinations_)
      if (const auto on_surface = people_.on_content(frame, projection, to.surface)) {
        to.sender->send(people::to_json_line(*on_surface));
        ++sent_;
      }
  }
}

void ShowPeople::draw_over(const Projection& projection, double light_time, ImageView<std::uint8_t> frame) {
  take(projection);
  log_.add(people_.darken(frame, projection, light_time));
}

PeopleCounts ShowPeople::counts() const {
  const people::PeopleFaults& faults = people_.track().faults();
  PeopleCounts counts;
  counts.frames = frames_;
  counts.malformed = source_->status().malformed;
  counts.refused = faults.refused;
  counts.repeated = faults.repeated + faults.late;
  counts.teleports = faults.teleports;
  counts.sent = sent_;
  return counts;
}

}  // namespace procam::show
