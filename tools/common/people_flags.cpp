#include "common/people_flags.hpp"

#include <CLI/CLI.hpp>

#include "common/dark_words.hpp"
#include "common/pose_sender.hpp"
#include "common/room_frames.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/text.hpp"
#include "procam/people/skeleton_source.hpp"
#include "procam/show/room_people.hpp"

namespace procam::tools {
namespace {

show::PeopleSensor place_of_sensor(const std::string& file, const Rig& rig, const RigProjector& projector) {
  if (file.empty())
    throw Error(
        ErrorKind::kInput, "--people", "where their sensor stands is not known",
        "give --sensor: a pose file between 'sensor' and the rig, its projector, a camera or the world");
  FrameTree::Link link = io::load_pose(file);
  if ((link.target == "sensor") == (link.source == "sensor"))
    throw Error(ErrorKind::kInput, file, "it does not tell where anything is on 'sensor'",
                "give a pose between 'sensor' and the rig, its projector, a camera or the world");
  if (link.target == "world" || link.source == "world") {
    FrameTree frames;
    frames.set(link.target, link.source, link.target_from_source);
    return {show::PeopleSensor::Stands::kInWorld, frames.get("world", "sensor").pose};
  }
  // room_frames() hangs a device's surroundings on the rig under the name "world".
  (link.target == "sensor" ? link.target : link.source) = "world";
  return {show::PeopleSensor::Stands::kOnRig,
          room_frames(rig, projector, std::move(link)).get(projector.name, "world").pose};
}

}  // namespace

void declare(CLI::App& app, PeopleFlags& flags) {
  CLI::Option* people = app.add_option(
      "--people", flags.source,
      "skeletons of the people before the projector, whose heads are kept dark: udp:9100, tcp:HOST:PORT, "
      "tcp-listen:PORT, vmc:39539, log:FILE");
  app.add_option("--sensor", flags.sensor,
                 "pose.json between 'sensor', which sees the people, and the rig, its projector, a camera or "
                 "the world")
      ->needs(people);
  add_parsed(
      app, "--sensor-delay", [&](const std::string& text) { flags.delay = io::parse_duration(text); },
      "from the moment that a skeleton speaks of to its arrival at the fastest, e.g. 50ms");
  app.add_option("--people-to", flags.to,
                 "SURFACE=udp:HOST:PORT: the skeletons in metres of that surface, for what draws its content")
      ->needs(people);
}

struct ShowPeople::State {
  struct Destination {
    std::string surface;
    std::unique_ptr<PoseSender> sender;
  };
  std::unique_ptr<people::SkeletonSource> source;
  show::RoomPeople people;
  std::vector<Destination> destinations;
  DarkWords words;
  std::vector<people::SkeletonFrame> arrived;
  std::uint64_t frames = 0, told = 0;
};

ShowPeople::ShowPeople(const PeopleFlags& flags, const Rig& rig, const RigProjector& projector,
                       std::function<void(const std::string&)> say) {
  people::PeopleOptions options;
  options.delay = flags.delay;
  show::RoomPeople people(place_of_sensor(flags.sensor, rig, projector), options);
  std::vector<State::Destination> destinations;
  for (const std::string& item : flags.to) {
    const std::size_t equals = item.find("=udp:");
    if (equals == std::string::npos || equals == 0)
      throw Error(ErrorKind::kInput, "--people-to " + item, "it does not read SURFACE=udp:HOST:PORT",
                  "write e.g. --people-to table=udp:127.0.0.1:9101");
    destinations.push_back({item.substr(0, equals), open_pose_sender(item.substr(equals + 1), false)});
  }
  state_ = std::make_unique<State>(State{people::open_skeleton_source(flags.source),
                                         std::move(people),
                                         std::move(destinations),
                                         DarkWords(std::move(say)),
                                         {},
                                         0,
                                         0});
}
ShowPeople::~ShowPeople() = default;

void ShowPeople::take(const show::Projection& projection) {
  State& s = *state_;
  s.source->poll(s.arrived);
  for (const people::SkeletonFrame& frame : s.arrived) {
    if (!s.people.add(frame)) continue;
    ++s.frames;
    for (const State::Destination& to : s.destinations)
      if (const auto told = s.people.on_content(frame, projection, to.surface)) {
        to.sender->send(people::to_json_line(*told));
        ++s.told;
      }
  }
}

void ShowPeople::over(const show::Projection& projection, double light_time, ImageView<std::uint8_t> frame) {
  take(projection);
  state_->words.tell(state_->people.darken(frame, projection, light_time));
}

void ShowPeople::tell(Console& console) const {
  const people::PeopleFaults& faults = state_->people.track().faults();
  const std::uint64_t malformed = state_->source->status().malformed;
  console.say(
      format("people: %llu frames of skeletons taken, %llu malformed, %llu refused, %llu repeated or "
             "late, %llu joints that jumped; %llu sent to contents",
             (unsigned long long)state_->frames, (unsigned long long)malformed,
             (unsigned long long)faults.refused, (unsigned long long)(faults.repeated + faults.late),
             (unsigned long long)faults.teleports, (unsigned long long)state_->told));
  Summary& summary = console.summary();
  summary.set("/people/frames", double(state_->frames));
  summary.set("/people/malformed", double(malformed));
  summary.set("/people/refused", double(faults.refused));
  summary.set("/people/teleports", double(faults.teleports));
  summary.set("/people/told", double(state_->told));
}

}  // namespace procam::tools
