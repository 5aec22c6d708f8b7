// The game around the physics: the wall that it is played on, keys, recordings, pictures, and bad skeletons.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "air_hockey/draw.hpp"
#include "air_hockey/stage.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/se3.hpp"

namespace hockey {
namespace {

using namespace procam;
using device::Key;

/// Whether the puck, sent along a line, comes back from what it meets before it has gone `far`.
bool is_reflected(const Table& table, const Vec2& from, const Vec2& speed, double far) {
  Match match(table);
  match.start();
  match.place_puck(from, speed);
  const Match::Hands away = {Vec2(0.06, 0.06), Vec2(table.length - 0.06, table.width - 0.06)};
  for (int i = 0; i < 240; ++i) {
    match.step(away);
    if ((match.puck() - from).dot(speed.normalized()) > far) return false;
    if (match.puck_speed().dot(speed) < 0) return true;
  }
  return false;
}

TEST(Wall, HolesOutlineAndMeetingWallsReflect) {
  SurfaceSet set = example_wall();
  set.surfaces.resize(1);
  Surface& table = set.surfaces[0];
  EXPECT_TRUE(read_wall(set).table.obstacles.empty());
  // A hole at 0.9..1.08 m, and an outline without the right end beyond 1.62 m.
  table.shape.holes = {{{0.5, 0.3}, {0.6, 0.3}, {0.6, 0.5}, {0.5, 0.5}}};
  table.shape.outline = {{0, 0}, {0.9, 0}, {0.9, 1}, {0, 1}};
  const Wall wall = read_wall(set);
  EXPECT_EQ(wall.table.obstacles.size(), 5u) << "the border is no obstacle: goals are there";
  EXPECT_TRUE(is_reflected(wall.table, Vec2(0.6, 0.4), Vec2(1, 0), 0.3));
  EXPECT_TRUE(is_reflected(wall.table, Vec2(1.3, 0.7), Vec2(1.5, 0), 0.33));
  EXPECT_FALSE(is_reflected(wall.table, Vec2(1.3, 0.7), Vec2(1.5, 0), 0.2));
  // Another wall comes out of this one at a corner: it ends on the table's plane at x = 1.2, with a
  // centimetre of measurement.
  table.shape = {};
  const auto* plane = std::get_if<PlanarSurface>(&table.geometry);
  PlanarSurface other = *plane;
  const Pose table_frame = plane->frame_from_surface;
  Mat3 across;
  across << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  other.frame_from_surface = table_frame * Pose(across, Vec3(1.2, 0, 0.01));
  other.points = {{0, -0.2}, {1, -0.2}, {1, 1.2}, {0, 1.2}};
  Surface second;
  second.name = "the other wall";
  second.geometry = other;
  set.surfaces.push_back(second);
  const Wall corner = read_wall(set);
  ASSERT_EQ(corner.table.obstacles.size(), 1u);
  EXPECT_TRUE(is_reflected(corner.table, Vec2(0.7, 0.7), Vec2(1.5, 0), 0.5));
  // And one that goes through the plane.
  std::get_if<PlanarSurface>(&set.surfaces[1].geometry)->points = {
      {-0.5, -0.2}, {1, -0.2}, {1, 1.2}, {-0.5, 1.2}};
  EXPECT_EQ(read_wall(set).table.obstacles.size(), 1u);
  set.surfaces[0].name = "desk";
  EXPECT_THROW(read_wall(set), Error);
}

/// A depth camera that looks at the table at an angle, 6 mm of noise; a box hangs there, and somebody stands
/// far before it.
TEST(Wall, WhatProtrudesInDepthReflects) {
  const Wall wall = read_wall([] {
    SurfaceSet set = example_wall();
    set.surfaces.resize(1);
    return set;
  }());
  const Camera camera{{320, 240}, {285, 281, 161.3, 117.8, 0.2}, {}};
  const Pose table_from_camera(so3_exp(Vec3(0.05, 0.2, 0.03)), Vec3(0.5, 0.55, -2.3));
  const Vec3 low(1.0, 0.3, -0.1), high(1.25, 0.6, 0);  // 10 cm thick
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.006);
  Image<std::uint16_t> depth(320, 240);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const Vec3 bearing = *camera.unproject(Vec2(x, y));
      const Vec3 o = table_from_camera.translation, d = table_from_camera.rotate(bearing);
      double s = -o.z() / d.z();
      // The box's front, then its sides.
      for (int axis = 0; axis < 3; ++axis)
        for (const double at : {low[axis], high[axis]}) {
          const double t = (at - o[axis]) / d[axis];
          const Vec3 p = o + t * d;
          bool is_on = t > 0;
          for (int k = 0; k < 3; ++k) is_on &= k == axis || (p[k] >= low[k] && p[k] <= high[k]);
          if (is_on) s = std::min(s, t);
        }
      if (x > 60 && x < 90 && y > 40) s = 1.2;  // a person
      depth.at(x, y) = random() % 50 == 0 ? 0 : std::uint16_t(1000 * (s * bearing.z() + noise(random)));
    }
  Table table = wall.table;
  table.obstacles =
      obstacles_in(depth::DepthImage(depth.view(), 0.001), camera, table_from_camera.inverse(), table);
  ASSERT_GE(table.obstacles.size(), 4u);
  EXPECT_LT(table.obstacles.size(), 20u);
  Vec2 least = table.obstacles[0].a, most = least;
  for (const Segment& s : table.obstacles) least = least.cwiseMin(s.a), most = most.cwiseMax(s.a);
  EXPECT_LT((least - low.head<2>()).cwiseAbs().maxCoeff(), 0.03) << least.transpose();
  EXPECT_LT((most - high.head<2>()).cwiseAbs().maxCoeff(), 0.03) << most.transpose();
  EXPECT_TRUE(is_reflected(table, Vec2(0.6, 0.45), Vec2(1.5, 0), 0.4));
  EXPECT_FALSE(is_reflected(table, Vec2(0.6, 0.8), Vec2(1.5, 0), 0.5));
  // Nothing seen is nothing known, and no crash.
  const Image<std::uint16_t> blind(320, 240);
  EXPECT_TRUE(obstacles_in(depth::DepthImage(blind.view(), 0.001), camera, table_from_camera.inverse(), table)
                  .empty());
}

/// Left goes with W A S D, right with the arrows, while they are held; a bot plays for who has not begun.
TEST(Keyboard, MovesThePaddles) {
  std::vector<Key> held;
  GameOptions options;
  options.bots_stand_in = true;
  Game game(Table{}, keyboard([&](Key key) { return std::count(held.begin(), held.end(), key) > 0; }),
            options);
  double time = 0;
  const auto play = [&](std::vector<Key> keys, double seconds) {
    held = std::move(keys);
    for (const double end = time + seconds; time < end; time += 1 / 60.0) game.advance(time, time);
  };
  play({}, 2);
  EXPECT_EQ(game.match().phase(), Phase::kPlaying) << "two bots";
  play({Key::kW}, 1.5);
  EXPECT_NEAR(game.match().paddle(0).y(), Table().paddle, 1e-9) << "up, to the wall";
  const double x = game.match().paddle(0).x();
  play({Key::kD, Key::kS}, 0.2);
  EXPECT_NEAR(game.match().paddle(0).x() - x, 1.4 * 0.2 / std::sqrt(2), 0.03);
  play({Key::kLeft, Key::kUp}, 1.5);
  EXPECT_NEAR(game.match().paddle(1).x(), Table().length / 2 + Table().paddle, 1e-9) << "not over the middle";
  const Vec2 rest = game.match().paddle(1);
  play({}, 0.3);
  EXPECT_EQ(game.match().paddle(1), rest) << "what is let go of stays";
}

/// Keys, bots and a player who comes and goes: the recording gives the same match, after a way through its
/// file.
TEST(Recording, PlaysTheMatchAgainBitForBit) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("procam_match_" + std::to_string(std::random_device()()) + ".rec");
  std::vector<Key> held;
  GameOptions options;
  options.seed = 77;
  options.records = true;
  options.bots_stand_in = true;
  const Table table = read_wall(example_wall()).table;
  Game game(table, keyboard([&](Key key) { return std::count(held.begin(), held.end(), key) > 0; }), options);
  std::mt19937 random(4);
  for (double time = 0; time < 12; time += 0.013 + 0.01 * double(random() % 3)) {
    held = {Key(random() % 8), Key(random() % 8)};
    if (random() % 3 == 0) held.clear();
    game.advance(time, time);
  }
  save_recording(file, game.recording());
  Recording recording = load_recording(file);
  EXPECT_TRUE(recording.table == table);
  EXPECT_EQ(recording.seed, 77u);
  EXPECT_EQ(recording.fingerprint, game.recording().fingerprint);
  GameOptions again;
  again.seed = recording.seed;
  const auto replay = [&](std::vector<Match::Hands> steps) {
    Game second(table, recorded_hands(std::move(steps)), again);
    second.advance(100, 100);
    EXPECT_TRUE(second.is_over());
    return std::pair(second.recording().fingerprint, second.match().puck());
  };
  EXPECT_EQ(replay(recording.steps), std::pair(recording.fingerprint, game.match().puck()));
  std::vector<Match::Hands> other = recording.steps;
  other[600] = {Vec2(0.3, 0.3), std::nullopt};
  EXPECT_NE(replay(other).first, recording.fingerprint);
  // Damaged files are refused with their line.
  std::ifstream in(file);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  for (const std::string& bad :
       {std::string(), std::string("procam-air-hockey 1\n"), text.substr(0, text.size() / 2),
        std::string("procam-air-hockey 1\nstep nan 0 0 0\n"),
        std::string("procam-air-hockey 1\nstep 1 2 3\n"), text + "step - - - -\n"}) {
    std::ofstream(file) << bad;
    EXPECT_THROW(load_recording(file), Error) << bad.substr(0, 60);
  }
  std::filesystem::remove(file);
}

/// A frame restores what the one before drew: the same picture as one drawn from nothing.
TEST(TableArtist, RestoresWhatItDrewOver) {
  const Table table = read_wall(example_wall()).table;
  const ImageSize size = table_size(table, 300);
  Match match(table, {}, 5);
  Bot left(0, 5), right(1, 5);
  TableArtist artist(table, size);
  ImageU8 kept(size, 3);
  int waited = 0, differing = 0;
  for (int i = 0; i < 1500; ++i) {
    match.step({left.hand(match), i % 700 < 60 ? std::optional<Vec2>() : right.hand(match)});
    waited += match.phase() == Phase::kPaused;
    if (i % 2 == 0) artist.draw(match, kept.view());
    if (i % 100 != 98) continue;
    // A copy drawn anew has the artist's trail and no memory of the picture.
    TableArtist copy = artist;
    ImageU8 fresh(size, 3);
    match.step({left.hand(match), right.hand(match)});
    copy.draw(match, fresh.view());
    artist.draw(match, kept.view());
    differing += !std::equal(kept.data(), kept.data() + size.width * size.height * 3, fresh.data());
  }
  EXPECT_GT(waited, 0);
  EXPECT_EQ(differing, 0);
}

/// What strangers send: the game goes on, paddles and pictures stay sound, and light stays off heads.
TEST(BadSkeletons, LeaveTheGameSound) {
  class Garbage : public people::SkeletonSource {
   public:
    void poll(std::vector<people::SkeletonFrame>& arrived) override {
      arrived.clear();
      time_ += 1 / 60.0;
      people::SkeletonFrame frame;
      frame.arrival = time_;
      const double nonsense[] = {std::numeric_limits<double>::quiet_NaN(), 1e30,   -1e30,
                                 std::numeric_limits<double>::infinity(),  1e-320, 19.9};
      const std::size_t people = random_() % 4 == 0 ? 500 : random_() % 17;
      for (std::size_t i = 0; i < people; ++i) {
        people::Skeleton person;
        for (auto& joint : person.joints) {
          const auto value = [&] {
            return random_() % 40 == 0 ? nonsense[random_() % 6] : 6.0 * double(random_() % 1000) / 1000 - 3;
          };
          if (random_() % 3 != 0) joint = people::SeenJoint<Vec3>{Vec3(value(), value(), value()), 1};
        }
        frame.people.push_back(person);
      }
      if (random_() % 5 == 0) frame.stamp = nonsense[random_() % 6];
      arrived.push_back(frame);
    }
    track::SourceStatus status() const override { return {}; }

   private:
    std::mt19937 random_{9};
    double time_ = 0;
  };
  const Wall wall = read_wall(example_wall());
  Rig rig = example_rig();
  Camera& lens = rig.projectors[0].projector.inverse_camera;
  lens.size = {320, 180};
  lens.intrinsics = {1750 / 6.0, 1738 / 6.0, 162, 150.4, 0.1};
  const Seat seat{wall.world_from_table, example_world_from_sensor(wall.world_from_table), {}};
  Game game(wall.table, live_people(std::make_unique<Garbage>(), seat, 0), {});
  device::SinkOptions sink;
  sink.size = lens.size;
  const auto stage = projected_stage(wall, rig, render::Filter::kBilinear, device::open_sink("none", sink));
  int lit = 0, checked = 0;
  for (int i = 1; i < 900; ++i) {
    const double now = i / 60.0;
    game.advance(now, now);
    ASSERT_TRUE(game.match().puck().allFinite());
    for (int side = 0; side < 2; ++side) {
      const Vec2& paddle = game.match().paddle(side);
      ASSERT_TRUE(paddle.x() > 0 && paddle.x() < wall.table.length && paddle.y() > 0 &&
                  paddle.y() < wall.table.width);
    }
    if (i % 5 != 0) continue;
    stage->show(game, now);
    // Every head that is believed is dark in its middle.
    const people::PeopleTrack& people = *game.players().people();
    for (const people::TrackedPerson& person : people.at(now))
      if (const auto head = people::head_of(person.skeleton)) {
        const Vec3 at = rig.projector().rig_from_projector.inverse() * (*seat.world_from_sensor * *head);
        const auto pixel = at.z() > 0.3 ? lens.project(at) : std::nullopt;
        if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 319 || pixel->y() > 179) continue;
        EXPECT_EQ(stage->picture().at(int(pixel->x()), int(pixel->y()), 2), 0);
        ++checked;
      }
    lit += *std::max_element(stage->picture().data(), stage->picture().data() + 320 * 180 * 3) > 0;
  }
  const people::PeopleFaults& faults = game.players().people()->faults();
  EXPECT_GT(faults.refused, 200u);
  EXPECT_NE(faults.why, "");
  EXPECT_GT(checked, 20);
  testing::Test::RecordProperty("frames with light", lit);
}

}  // namespace
}  // namespace hockey
