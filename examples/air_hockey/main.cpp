// Air hockey on a wall that does not face the projector. Two people's hands move the paddles, or a recording,
// or bots.
//
//   air_hockey                                        20 s of bots into air_hockey.mkv
//   air_hockey --players people --sink video:a.mp4    bots whose hands go through a simulated skeleton
//   tracker air_hockey --players log:people.csv --sink window:0 --rig rig.json --surfaces wall.json
//
// Built in the project's tree, and by itself on the installed package (CMakeLists.txt beside this file).
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>

#include "draw.hpp"
#include "players.hpp"
#include "procam/core/se3.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/live/projection.hpp"
#include "procam/surface/solve.hpp"
#include "procam/track/eye_safe.hpp"

namespace {

using namespace procam;

constexpr char kUsage[] =
    "air_hockey [--players bots|people|log:FILE|udp:PORT] [--sink video:FILE|frames:FOLDER|window:N|none] "
    "[--seconds "
    "20]\n"
    "           [--fps 60] [--seed 1] [--rig FILE --surfaces FILE] [--filter area|bilinear] [--snapshot "
    "FILE.png]\n"
    "  --players   bots; people: bots seen by a simulated skeleton tracker; log: a recording "
    "(docs/people.md), whose\n"
    "              one person plays both sides, the left with the left hand\n"
    "  --surfaces  planar surfaces in the frames \"rig\" or \"projector\", or \"world\" where that is the "
    "rig's: \"table\",\n"
    "              perhaps \"scoreboard\"; what else lies on the table's plane is an obstacle\n"
    "  --snapshot  the last frame as a picture\n";

/// --name value pairs; a name that is not known is told.
std::map<std::string, std::string> parse(int argc, char** argv) {
  std::map<std::string, std::string> options = {{"players", "bots"}, {"sink", "video:air_hockey.mkv"},
                                                {"seconds", "20"},   {"fps", "60"},
                                                {"seed", "1"},       {"rig", ""},
                                                {"surfaces", ""},    {"filter", "area"},
                                                {"snapshot", ""}};
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (name.rfind("--", 0) != 0 || options.count(name.substr(2)) == 0 || i + 1 == argc)
      throw Error(ErrorKind::kInput, "'" + name + "'",
                  i + 1 == argc ? "it has no value" : "there is no such option",
                  std::string("usage:\n") + kUsage);
    options[name.substr(2)] = argv[i + 1];
  }
  return options;
}
double number(const std::map<std::string, std::string>& options, const std::string& name, double least,
              double most) {
  char* end = nullptr;
  const std::string& text = options.at(name);
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value >= least && value <= most))
    throw Error(ErrorKind::kInput, "--" + name + " " + text, "it is not a number that makes sense here",
                "give one from " + std::to_string(least) + " to " + std::to_string(most));
  return value;
}

/// An office projector with a bent lens and its lens shift.
Rig example_rig() {
  Rig rig;
  RigProjector lamp;
  lamp.name = "lamp";
  lamp.projector.inverse_camera = {
      {1920, 1080}, {1750, 1738, 975, 905, 0.8}, BrownConrady{{-0.04, 0.01, 0.0006, -0.0004, 0}}};
  rig.projectors.push_back(lamp);
  return rig;
}
Surface rectangle(const std::string& name, const Pose& world_from_wall, const Vec2& from, const Vec2& to) {
  PlanarSurface plane;
  plane.frame_from_surface = world_from_wall;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {from, {to.x(), from.y()}, to, {from.x(), to.y()}};
  Surface surface;
  surface.name = name;
  surface.geometry = plane;
  return surface;
}
/// A wall that is turned away by 24 degrees and leans a little, with a table and a scoreboard; a picture
/// frame and a switch hang where the puck comes by.
SurfaceSet example_wall() {
  const Pose world_from_wall(so3_exp(Vec3(0.06, 0.42, -0.03)), Vec3(-0.85, -0.8, 3.0));
  return {{rectangle("table", world_from_wall, {0, 0}, {1.8, 1}),
           rectangle("scoreboard", world_from_wall, {0.6, -0.26}, {1.2, -0.1}),
           rectangle("picture frame", world_from_wall, {0.84, 0.14}, {0.99, 0.24}),
           rectangle("switch", world_from_wall, {0.86, 0.8}, {0.94, 0.88})}};
}

struct Wall {
  Pose world_from_table;  ///< the table's own plane, its content's corner at the origin
  Vec2 size;              ///< metres
  std::vector<hockey::Segment> obstacles;
  SurfaceSet lit;  ///< the table, and the scoreboard if there is one
};

/// The table's frame: origin at its content's corner (0, 0), x along its upper edge.
Wall read_wall(const SurfaceSet& set) {
  Wall wall;
  const auto corners = [](const PlanarSurface& plane) {
    std::vector<Vec3> in_world;
    for (const Vec2& p : plane.points) in_world.push_back(plane.frame_from_surface * Vec3(p.x(), p.y(), 0));
    return in_world;
  };
  const auto planar = [](const Surface& surface) { return std::get_if<PlanarSurface>(&surface.geometry); };
  const PlanarSurface* table = nullptr;
  for (const Surface& surface : set.surfaces)
    if (surface.name == "table") table = planar(surface);
  if (table == nullptr || table->points.size() != 4 ||
      table->content != Points2{{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    throw Error(ErrorKind::kInput, "the surfaces", "none is a planar \"table\" of the content's four corners",
                "name one so, with content (0,0) (1,0) (1,1) (0,1)");
  const std::vector<Vec3> edge = corners(*table);
  const Vec3 along = (edge[1] - edge[0]).normalized();
  const Vec3 into = along.cross(edge[3] - edge[0]).normalized();
  Mat3 axes;
  axes << along, into.cross(along), into;
  wall.world_from_table = Pose(axes, edge[0]);
  wall.size = Vec2((edge[1] - edge[0]).norm(), (edge[3] - edge[0]).norm());
  for (const Surface& surface : set.surfaces) {
    if (surface.name == "table" || surface.name == "scoreboard") {
      wall.lit.surfaces.push_back(surface);
      continue;
    }
    const PlanarSurface* other = planar(surface);
    if (other == nullptr || other->points.size() < 3) continue;
    std::vector<Vec2> ring;
    for (const Vec3& corner : corners(*other)) {
      const Vec3 p = wall.world_from_table.inverse() * corner;
      if (std::abs(p.z()) < 0.05) ring.push_back(p.head<2>());
    }
    if (ring.size() != other->points.size()) continue;  // elsewhere in the room
    for (std::size_t i = 0; i < ring.size(); ++i)
      wall.obstacles.push_back({ring[i], ring[(i + 1) % ring.size()]});
  }
  return wall;
}

int play(const std::map<std::string, std::string>& options) {
  const bool has_files = !options.at("rig").empty();
  if (has_files != !options.at("surfaces").empty())
    throw Error(ErrorKind::kInput, "--rig and --surfaces", "one is missing", "give both, or neither");
  const Rig rig = has_files ? io::load_rig(options.at("rig")) : example_rig();
  const Wall wall = read_wall(has_files ? io::load_surfaces(options.at("surfaces")) : example_wall());
  const double fps = number(options, "fps", 1, 500), seconds = number(options, "seconds", 0, 1e6);
  const auto seed = std::uint64_t(number(options, "seed", 0, 1e15));

  hockey::Table table;
  table.length = wall.size.x();
  table.width = wall.size.y();
  table.obstacles = wall.obstacles;
  hockey::Match match(table, {}, seed);
  const std::unique_ptr<hockey::Players> players =
      hockey::open_players(options.at("players"), wall.world_from_table, seed);

  // The content of the surfaces: whoever asks for the table's picture gets the match at that time.
  const int width = 1280, height = int(std::lround(width * table.width / table.length));
  hockey::TableArtist artist(table, {width, height});
  live::Show show;
  show.surfaces = wall.lit;
  for (const Surface& surface : wall.lit.surfaces) {
    if (surface.name == "table")
      show.contents.push_back(device::drawn_content({width, height}, 3, [&](double, hockey::Picture picture) {
        artist.draw(match, picture);
        return true;
      }));
    else
      show.contents.push_back(
          device::drawn_content({600, 160}, 3, [&, shown = -1](double, hockey::Picture picture) mutable {
            const int now = int(match.time()) * 10000 + match.score(0) * 100 + match.score(1);
            if (now == shown) return false;
            shown = now;
            hockey::draw_scoreboard(match, picture);
            return true;
          }));
  }

  live::ProjectionOptions drawing;
  drawing.projector_from_world = rig.projector().rig_from_projector.inverse();
  render::RenderOptions rendering;
  rendering.filter = options.at("filter") == "bilinear" ? render::Filter::kBilinear : render::Filter::kArea;
  render::CpuRenderer renderer(rendering);
  double light_time = 0;
  drawing.draw = [&](const Scene& scene, const Projector& projector, hockey::Picture frame) {
    const render::RenderWork work = renderer.render(scene, projector, frame);
    // Over everything that is lit: nobody looks into the lamp.
    if (const track::PeopleTrack* people = players->people())
      track::darken_heads(frame, projector, *drawing.projector_from_world * players->world_from_sensor(),
                          *people, light_time);
    return work;
  };
  live::Projection projection(rig, drawing);
  projection.set_show(std::move(show));

  const std::string& where = options.at("sink");
  const bool is_window = where.rfind("window:", 0) == 0;
  device::SinkOptions sink_options;
  sink_options.size = projection.frame_size();
  sink_options.fps = fps;
  sink_options.write = [](const std::filesystem::path& file, ViewU8 picture) {
    io::save_image(file, picture);
  };
  const std::unique_ptr<device::FrameSink> sink =
      is_window ? device::open_window(std::atoi(where.c_str() + 7)) : device::open_sink(where, sink_options);
  if (sink->size() != projection.frame_size())
    throw Error(ErrorKind::kDevice, where, "the screen has not the projector's size",
                "set the display to the resolution that was calibrated");

  ImageU8 frame(projection.frame_size(), 3);
  // Files have their own time; screens, and people who are there, have the clock's.
  const bool is_real = is_window || players->is_live();
  const double begin = device::now_s();
  long frames = 0;
  for (double time = 0; time < seconds && match.phase() != hockey::Phase::kOver; ++frames) {
    if (is_real && !is_window)
      while (device::now_s() - begin < double(frames) / fps)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    time = is_real ? device::now_s() - begin : double(frames) / fps;
    light_time = time;
    const hockey::Match::Hands hands = players->hands(match, time);
    while (match.time() + hockey::Match::kStep <= time)
      match.step(players->is_bot() ? players->hands(match, time) : hands);
    projection.draw(time, time, frame.view());
    sink->show_next(frame);
    if (sink->poll() == device::Wish::kClose) break;
  }
  const double took = device::now_s() - begin;
  sink->finish();
  if (!options.at("snapshot").empty()) io::save_image(options.at("snapshot"), frame);
  std::printf("%d : %d after %.1f s; %ld frames in %.2f s, %.1f a second\n", match.score(0), match.score(1),
              match.time(), frames, took, double(frames) / took);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 2 && (std::string(argv[1]) == "--help" || std::string(argv[1]) == "-h")) {
      std::fputs(kUsage, stdout);
      return 0;
    }
    return play(parse(argc, argv));
  } catch (const Error& error) {
    std::fprintf(stderr, "air_hockey: %s\n", error.what());
    return error.kind() == ErrorKind::kDevice ? 6 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "air_hockey: %s\n", error.what());
    return 1;
  }
}
