// Shoulder abduction with feedback on the floor, and a forbidden zone beside it that shows a stop sign.
//
//   exercise --people log:rehab.csv --side left --sink video:exercise.mp4     a recording (docs/people.md)
//   exercise --people udp:9100 --sink window:0                                as it happens
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

#include "procam/core/error.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/images.hpp"
#include "procam/track/skeleton_source.hpp"
#include "room.hpp"

namespace {

using namespace procam;

constexpr char kUsage[] =
    "exercise --people log:FILE|udp:PORT|... [--side left|right] [--target 80] [--seconds 0] [--fps 30]\n"
    "         [--sink video:FILE|frames:FOLDER|window:N|none]\n"
    "  --target   degrees that count as reached\n"
    "  --seconds  0: to the end of the recording, or until the window is closed\n";

using Options = std::map<std::string, std::string>;

double number(const Options& options, const std::string& name, double least, double most) {
  char* end = nullptr;
  const std::string& text = options.at(name);
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value >= least && value <= most))
    throw Error(ErrorKind::kInput, "--" + name + " " + text, "it is not a number that makes sense here",
                "give one from " + std::to_string(least) + " to " + std::to_string(most));
  return value;
}

int run(const Options& options) {
  exercise::RoomOptions room_options;
  const std::string& side = options.at("side");
  if (side != "left" && side != "right")
    throw Error(ErrorKind::kInput, "--side " + side, "there is no such side", "say left or right");
  room_options.side = side == "left" ? track::Side::kLeft : track::Side::kRight;
  room_options.exercise.target = number(options, "target", 45, 170) * kDegree;
  exercise::Room room(room_options);

  const std::string& people = options.at("people");
  const bool is_recorded = people.rfind("log:", 0) == 0;
  std::vector<track::SkeletonFrame> recorded;
  std::unique_ptr<track::SkeletonSource> source;
  if (is_recorded)
    recorded = track::read_skeleton_log(people.substr(4));
  else
    source = track::open_skeleton_source(people);

  device::SinkOptions sink_options;
  sink_options.size = room.frame_size();
  sink_options.fps = number(options, "fps", 1, 240);
  sink_options.write = [](const std::filesystem::path& file, ViewU8 picture) {
    io::save_image(file, picture);
  };
  const std::string& where = options.at("sink");
  const auto sink = where.rfind("window:", 0) == 0 ? device::open_window(std::atoi(where.c_str() + 7))
                                                   : device::open_sink(where, sink_options);
  if (sink->size() != room.frame_size())
    throw Error(ErrorKind::kDevice, where, "the screen has not the projector's size",
                "set the display to 1280x800");

  const double begin = is_recorded ? recorded.front().arrival : track::steady_now();
  double seconds = number(options, "seconds", 0, 1e6);
  if (is_recorded && seconds == 0) seconds = recorded.back().arrival - begin;
  ImageU8 frame(room.frame_size(), 3);
  std::size_t next = 0;
  std::vector<track::SkeletonFrame> arrived;
  int trespasses = 0;
  bool was_forbidden = false;
  for (long i = 0; sink->poll() != device::Wish::kClose; ++i) {
    const double time = is_recorded ? begin + double(i) / sink_options.fps : track::steady_now();
    if (seconds > 0 && time - begin > seconds) break;
    for (; next < recorded.size() && recorded[next].arrival <= time; ++next) room.add(recorded[next]);
    if (source) {
      source->poll(arrived);
      for (const track::SkeletonFrame& seen : arrived) room.add(seen);
    }
    room.advance(time);
    room.draw(frame.view());
    trespasses += room.is_forbidden() && !was_forbidden ? 1 : 0;
    was_forbidden = room.is_forbidden();
    sink->show_next(frame);
    if (!is_recorded && where.rfind("window:", 0) != 0)
      std::this_thread::sleep_for(std::chrono::duration<double>(1 / sink_options.fps));
  }
  sink->finish();
  std::printf("%d repetitions, the zone was entered %d times\n", room.feedback().count, trespasses);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Options options = {{"people", ""},   {"side", "left"}, {"target", "80"},
                       {"seconds", "0"}, {"fps", "30"},    {"sink", "video:exercise.mkv"}};
    for (int i = 1; i < argc; i += 2) {
      const std::string name = argv[i];
      if (name.rfind("--", 0) != 0 || options.count(name.substr(2)) == 0 || i + 1 == argc)
        throw Error(ErrorKind::kInput, "'" + name + "'",
                    i + 1 == argc ? "it has no value" : "there is no such option",
                    std::string("usage:\n") + kUsage);
      options[name.substr(2)] = argv[i + 1];
    }
    if (options.at("people").empty())
      throw Error(ErrorKind::kInput, "--people", "nobody is there to see", std::string("usage:\n") + kUsage);
    return run(options);
  } catch (const Error& error) {
    std::fprintf(stderr, "exercise: %s\n", error.what());
    return error.kind() == ErrorKind::kDevice ? 6 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "exercise: %s\n", error.what());
    return 1;
  }
}
