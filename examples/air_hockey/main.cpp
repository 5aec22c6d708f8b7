// Air hockey on a wall that does not face the projector. Two people's hands move the paddles, or keys, a
// recording, or bots.
//
//   air_hockey                                        20 s of bots into air_hockey.mkv
//   air_hockey --players people --sink video:a.mp4    bots whose hands a simulated tracker of skeletons sees
//   air_hockey --players keys --missing bot --sink window:0 --seconds 0
//   air_hockey --help                                 the rest, and the game as content of project-live
//
// Built in the project's tree, and by itself on the installed package (CMakeLists.txt beside this file).
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "../common/command_line.hpp"
#include "game.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "stage.hpp"

namespace {

using namespace procam;
using examples::is_first;
using examples::number;
using examples::Options;

constexpr char kUsage[] =
    R"(air_hockey [--players bots|people|keys|log:FILE|replay:FILE|udp:PORT|...] [--missing pause|bot]
           [--sensor FILE|table] [--sensor-delay MS] [--delay MS] [--rig FILE] [--surfaces FILE]
           [--depth FILE.png --depth-camera NAME]
           [--sink video:FILE|frames:FOLDER|window:N|shm:NAME|none] [--content NAME]
           [--seconds 20] [--fps 60] [--seed 1] [--record FILE] [--filter area|bilinear] [--snapshot FILE.png]
  --players   bots; people: bots seen by a simulated skeleton tracker; keys: W A S D and the arrows, in a window;
              log: a recording of skeletons; replay: a match that --record wrote; or where skeletons come from
              (docs/people.md). One person alone plays both sides, the left with the left hand
  --missing   a hand that is not there: pause the match, or a bot plays for it
  --sensor    pose.json between 'sensor', which sees the people, and 'world'; table: skeletons are told in metres
              of the table, as project-live --people-to does
  --sensor-delay, --delay  from a moment to its skeleton's arrival; from a frame's begin to its light
  --surfaces  planar surfaces: "table", perhaps "scoreboard". What else lies on the table's plane or meets it, and
              holes in the table's shape, reflect the puck
  --depth     16-bit picture in millimetres of the table with nobody before it, by the rig's camera --depth-camera:
              what protrudes reflects the puck
  --content   not the projector's frame but the contents, for project-live: shared memory NAME_table and
              NAME_scoreboard
  --seconds   0: until somebody has won or the window is closed
  --record    the match, for replay, which says whether it came out the same bit for bit
  --snapshot  the last frame as a picture
)";

hockey::Seat read_seat(const Options& options, const Pose& world_from_table) {
  hockey::Seat seat{world_from_table, std::nullopt, {}};
  seat.people.delay = 1e-3 * number(options, "sensor-delay", 0, 2000);
  const std::string& sensor = options.at("sensor");
  if (sensor == "table") return seat;
  if (sensor.empty() && options.at("players").rfind("log:", 0) != 0)
    throw Error(ErrorKind::kInput, "--players " + options.at("players"),
                "where the sensor stands is not known", "give --sensor FILE, or --sensor table");
  if (sensor.empty()) {
    seat.world_from_sensor = hockey::example_world_from_sensor(world_from_table);
    return seat;
  }
  const FrameTree::Link link = io::load_pose(sensor);
  FrameTree frames;
  frames.set(link.target, link.source, link.target_from_source);
  seat.world_from_sensor = frames.get("world", "sensor").pose;
  return seat;
}

std::unique_ptr<hockey::Players> open_players(const Options& options, const hockey::Wall& wall,
                                              std::uint64_t seed, double begin, device::FrameSink* window) {
  const std::string& text = options.at("players");
  if (text == "bots") return hockey::bots(seed);
  if (text == "people") return hockey::simulated_people(wall.world_from_table, seed);
  if (text == "keys") {
    if (window == nullptr)
      throw Error(ErrorKind::kInput, "--players keys", "no window receives them", "add --sink window:0");
    return hockey::keyboard([window](device::Key key) { return window->is_down(key); });
  }
  const hockey::Seat seat = read_seat(options, wall.world_from_table);
  if (text.rfind("log:", 0) == 0) return hockey::recorded_people(text.substr(4), seat);
  return hockey::live_people(people::open_skeleton_source(text), seat, begin);
}

int play(const Options& options) {
  const Rig rig = options.at("rig").empty() ? hockey::example_rig() : io::load_rig(options.at("rig"));
  hockey::Wall wall = hockey::read_wall(
      options.at("surfaces").empty() ? hockey::example_wall() : io::load_surfaces(options.at("surfaces")));
  if (!options.at("depth").empty()) {
    const Image<std::uint16_t> seen = io::load_depth(options.at("depth"));
    const RigCamera& camera = rig.camera(options.at("depth-camera"));
    if (seen.size() != camera.camera.size)
      throw Error(ErrorKind::kInput, options.at("depth"), "it has not the size of the rig's camera",
                  "name the camera that took it with --depth-camera");
    const std::vector<hockey::Segment> found =
        hockey::obstacles_in(depth::DepthImage(seen.view(), 0.001), camera.camera,
                             camera.rig_from_camera.inverse() * wall.world_from_table, wall.table);
    wall.table.obstacles.insert(wall.table.obstacles.end(), found.begin(), found.end());
    std::printf("depth: %zu edges of obstacles\n", found.size());
  }
  const double fps = number(options, "fps", 1, 500), seconds = number(options, "seconds", 0, 1e6);
  const double delay = 1e-3 * number(options, "delay", 0, 1000);
  hockey::GameOptions game_options;
  game_options.seed = std::uint64_t(number(options, "seed", 0, 1e15));
  game_options.bots_stand_in = !is_first(options, "missing", "pause", "bot");
  game_options.records = !options.at("record").empty();

  const bool is_content = !options.at("content").empty();
  std::unique_ptr<hockey::Stage> stage;
  device::FrameSink* window = nullptr;
  if (is_content) {
    stage = hockey::content_stage(options.at("content"), wall);
  } else {
    std::unique_ptr<device::FrameSink> sink =
        examples::open_sink(options.at("sink"), rig.projector().projector.size(), fps);
    if (options.at("sink").rfind("window:", 0) == 0) window = sink.get();
    stage = hockey::projected_stage(
        wall, rig,
        is_first(options, "filter", "area", "bilinear") ? render::Filter::kArea : render::Filter::kBilinear,
        std::move(sink));
  }

  const double begin = device::now_s();
  std::unique_ptr<hockey::Players> players;
  std::optional<std::uint64_t> expected;
  if (options.at("players").rfind("replay:", 0) == 0) {
    hockey::Recording recording = hockey::load_recording(options.at("players").substr(7));
    if (!(recording.table == wall.table))
      throw Error(ErrorKind::kInput, options.at("players"), "it was played on another table",
                  "give the surfaces of that time");
    game_options.seed = recording.seed;
    expected = recording.fingerprint;
    players = hockey::recorded_hands(std::move(recording.steps));
  } else {
    players = open_players(options, wall, game_options.seed, begin, window);
  }
  // Files have their own time; screens, other programs, and people who are there, have the clock's.
  const bool is_real = window != nullptr || is_content || players->is_live();
  hockey::Game game(wall.table, std::move(players), game_options);

  long frames = 0;
  const auto goes_on = [&](double time) {
    return (seconds == 0 || time < seconds) && !game.is_over() && !stage->is_closed() &&
           !examples::is_told_to_end();
  };
  for (double time = 0; goes_on(time); ++frames) {
    if (is_real && window == nullptr)
      while (device::now_s() - begin < double(frames) / fps)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    time = is_real ? device::now_s() - begin : double(frames) / fps;
    game.advance(time, time + delay);
    stage->show(game, time + delay);
  }
  const double took = device::now_s() - begin;
  stage->finish();
  if (!options.at("snapshot").empty()) io::save_image(options.at("snapshot"), stage->picture());
  if (game_options.records) hockey::save_recording(options.at("record"), game.recording());
  const hockey::Match& match = game.match();
  std::printf("%d : %d after %.1f s; %ld frames in %.2f s, %.1f a second\n", match.score(0), match.score(1),
              match.time(), frames, took, double(frames) / took);
  if (const people::PeopleTrack* people = game.players().people())
    std::printf("skeletons: %llu refused, %llu told twice or late, %llu joints that jumped%s%s\n",
                (unsigned long long)people->faults().refused,
                (unsigned long long)(people->faults().repeated + people->faults().late),
                (unsigned long long)people->faults().teleports, people->faults().why.empty() ? "" : "; ",
                people->faults().why.c_str());
  if (!expected) return 0;
  const bool is_whole = game.players().are_gone();
  const bool is_same = is_whole && *expected == game.recording().fingerprint;
  std::printf("replay: %s\n", is_same    ? "the recorded match, bit for bit"
                              : is_whole ? "another match than the recorded one"
                                         : "ended before the recording");
  return is_same || !is_whole ? 0 : 5;
}

}  // namespace

int main(int argc, char** argv) {
  return examples::run_main(argc, argv, "air_hockey", kUsage,
                            {{"players", "bots"},
                             {"sink", "video:air_hockey.mkv"},
                             {"seconds", "20"},
                             {"fps", "60"},
                             {"seed", "1"},
                             {"rig", ""},
                             {"surfaces", ""},
                             {"filter", "area"},
                             {"snapshot", ""},
                             {"sensor", ""},
                             {"delay", "0"},
                             {"sensor-delay", "50"},
                             {"content", ""},
                             {"missing", "pause"},
                             {"record", ""},
                             {"depth", ""},
                             {"depth-camera", ""}},
                            play);
}
