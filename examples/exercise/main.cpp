// Shoulder abduction with feedback on the floor, and a forbidden zone beside it that shows a stop sign.
//
//   exercise --people log:rehab.csv --side left --sink video:exercise.mp4     a recording (docs/people.md)
//   exercise --people udp:9100 --sink window:0                                as it happens
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "../common/command_line.hpp"
#include "procam/people/skeleton_source.hpp"
#include "room.hpp"

namespace {

using namespace procam;
using examples::number;

constexpr char kUsage[] =
    "exercise --people log:FILE|udp:PORT|... [--side left|right] [--target 80] [--seconds 0] [--fps 30]\n"
    "         [--sink video:FILE|frames:FOLDER|window:N|none]\n"
    "  --target   degrees that count as reached\n"
    "  --seconds  0: to the end of the recording, or until the window is closed\n";

int run(const examples::Options& options) {
  exercise::RoomOptions room_options;
  room_options.side =
      examples::is_first(options, "side", "left", "right") ? people::Side::kLeft : people::Side::kRight;
  room_options.exercise.target = number(options, "target", 45, 170) * kDegree;
  exercise::Room room(room_options);

  const std::string& people = options.at("people");
  if (people.empty())
    throw Error(ErrorKind::kInput, "--people", "nobody is there to see",
                "give it a source; --help names some");
  const bool is_recorded = people.rfind("log:", 0) == 0;
  std::vector<people::SkeletonFrame> recorded;
  std::unique_ptr<people::SkeletonSource> source;
  if (is_recorded)
    recorded = people::read_skeleton_log(people.substr(4));
  else
    source = people::open_skeleton_source(people);

  const double fps = number(options, "fps", 1, 240);
  const std::string& where = options.at("sink");
  const auto sink = examples::open_sink(where, room.frame_size(), fps);

  const double begin = is_recorded ? recorded.front().arrival : track::steady_now();
  double seconds = number(options, "seconds", 0, 1e6);
  if (is_recorded && seconds == 0) seconds = recorded.back().arrival - begin;
  ImageU8 frame(room.frame_size(), 3);
  std::size_t next = 0;
  std::vector<people::SkeletonFrame> arrived;
  int trespasses = 0;
  bool was_forbidden = false;
  for (long i = 0; sink->poll() != device::WindowEvent::kClose && !examples::is_told_to_end(); ++i) {
    const double time = is_recorded ? begin + double(i) / fps : track::steady_now();
    if (seconds > 0 && time - begin > seconds) break;
    for (; next < recorded.size() && recorded[next].arrival <= time; ++next) room.add(recorded[next]);
    if (source) {
      source->poll(arrived);
      for (const people::SkeletonFrame& seen : arrived) room.add(seen);
    }
    room.advance(time);
    room.draw(frame.view());
    trespasses += room.is_forbidden() && !was_forbidden ? 1 : 0;
    was_forbidden = room.is_forbidden();
    sink->show_next(frame);
    if (!is_recorded && where.rfind("window:", 0) != 0)
      std::this_thread::sleep_for(std::chrono::duration<double>(1 / fps));
  }
  sink->finish();
  std::printf("%d repetitions, the zone was entered %d times\n", room.feedback().count, trespasses);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return examples::run_main(argc, argv, "exercise", kUsage,
                            {{"people", ""},
                             {"side", "left"},
                             {"target", "80"},
                             {"seconds", "0"},
                             {"fps", "30"},
                             {"sink", "video:exercise.mkv"}},
                            run);
}
