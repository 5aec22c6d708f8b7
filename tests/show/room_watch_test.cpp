/// From depth pictures to light: a drive through a simulated room, and where the light of the frames lands.
#include "room_watch.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "../simulate/rooms.hpp"
#include "live_world.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/simulate/depth_view.hpp"
#include "procam/simulate/drive.hpp"
#include "support/room_stage.hpp"

namespace procam::show {
namespace {

using test::middle_of;
using test::quarters;
using test::Walker;

/// A wall 3.2 m ahead of where the robot begins, a floor and a table; z up.
struct SmallRoom {
  simulate::Room room;
  Rig rig;
  simulate::DepthSensor sensor;

  SmallRoom() {
    using simulate::test::hung;
    room.bodies.push_back(hung("far", Vec3(0, 3.2, 1.3), Vec3(0, -1, 0), Vec2(4.4, 2.6), 0.6));
    room.bodies.push_back(hung("left", Vec3(-2.2, 1, 1.3), Vec3(1, 0, 0), Vec2(5, 2.6), 0.6));
    room.bodies.push_back(hung("floor", Vec3(0, 1, 0), Vec3(0, 0, 1), Vec2(4.4, 5), 0.6));
    room.bodies.push_back(hung("table", Vec3(0.9, 2.5, 0.74), Vec3(0, 0, 1), Vec2(1.2, 0.7), 0.6, 0.1));
    sensor.camera = {
        {320, 240}, {292, 289, 158.6, 121.5, 0.2}, BrownConrady{{0.04, -0.08, 0.001, -0.0006, 0}}};
    rig = small_rig();
    RigCamera eye;
    eye.name = "depth";
    eye.camera = sensor.camera;
    eye.rig_from_camera = Pose(so3_exp(Vec3(0.02, 0.05, -0.03)), Vec3(-0.06, 0.04, 0.02));
    rig.cameras.push_back(eye);
  }
  RoomOptions options() const {
    RoomOptions options;
    options.camera = rig.camera("depth");
    options.track.prediction = track::Prediction::kConstantTwist;
    return options;
  }
  device::SeenDepth seen(const Pose& world_from_rig, double time, const std::vector<simulate::Body>& more,
                         std::uint64_t seed) const {
    simulate::Room now = room;
    for (const simulate::Body& body : more) now.bodies.push_back(body);
    const Pose world_from_camera = world_from_rig * rig.camera("depth").rig_from_camera;
    return {simulate::depth_view(now, sensor, world_from_camera, seed, 2).mm, time};
  }
};

std::vector<simulate::Body> somebody_at(double x) {
  return simulate::box("somebody", Pose(Eigen::Quaterniond::Identity(), Vec3(x, 2.0, 0)),
                       Vec3(0.45, 0.3, 1.75), 0.5);
}

TEST(DepthSurfaceTracker, LightStaysWhereItIsOnTheWallWhileTheRobotDrivesAndSomebodyPasses) {
  const SmallRoom world;
  const auto at = [](const Vec3& eye, const Vec3& target) { return simulate::test::looking_at(eye, target); };
  const simulate::Drive drive =
      simulate::drive_through({{at(Vec3(-0.3, 0.9, 1.2), Vec3(0, 3.2, 1.1)), 0},
                               {at(Vec3(0.2, 1.3, 1.2), Vec3(0.1, 3.2, 1.1)), 3},
                               {at(Vec3(-0.1, 1.1, 1.2), Vec3(-0.1, 3.2, 1.1)), 5}});
  constexpr double kDelay = 0.02;  // from the exposure of a depth picture to its arrival
  RoomOptions options = world.options();
  options.delay = kDelay;
  DepthSurfaceTracker view(options);
  ProjectionOptions drawing;
  drawing.track.prediction = track::Prediction::kConstantTwist;
  Projection projection(world.rig, drawing);
  const std::shared_ptr<device::ContentSource> picture = device::still_content(quarters());
  const Projector& lamp = projection.projector();
  ImageU8 frame(projection.frame_size(), 3);
  std::map<std::string, Points3> last;
  std::optional<Vec3> landed;
  Vec3 said = Vec3::Zero();
  int lit = 0, told = 0;
  for (int i = 0; i <= 50; ++i) {
    const double time = 0.1 * i;
    for (int k = 0; k < 3; ++k) {  // poses come at 30 Hz, without noise
      const double stamp = time - 0.1 + (k + 1) / 30.0;
      if (stamp < 0) continue;
      const track::StampedPose pose = message(stamp + 1, drive.world_from_rig(stamp));
      view.add(pose);
      projection.add(pose);
    }
    const double t = time + 1;
    const auto passer =
        time > 2 && time < 4.5 ? somebody_at(-2 + 1.6 * (time - 2)) : std::vector<simulate::Body>();
    device::SeenDepth seen = world.seen(drive.world_from_rig(time), t + kDelay, passer, std::uint64_t(i) + 1);
    if (auto surfaces = view.look(seen)) {
      ++told;
      Show show;
      for (Surface& surface : surfaces->surfaces) {
        EXPECT_TRUE(surface.name == "wall_1" || surface.name == "wall_2" || surface.name == "floor" ||
                    surface.name == "table_1")
            << surface.name;
        const auto& plane = std::get<PlanarSurface>(surface.geometry);
        Points3 corners;
        for (const Vec2& p : plane.points)
          corners.push_back(plane.frame_from_surface * Vec3(p.x(), p.y(), 0));
        if (const auto before = last.find(surface.name); before != last.end())
          for (std::size_t k = 0; k < 4; ++k)
            EXPECT_LT((corners[k] - before->second[k]).norm(), 0.003) << surface.name << " at " << time;
        last[surface.name] = corners;
        const bool far_wall = std::abs(corners[0].y() - 3.2) < 0.1;
        if (far_wall) said = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
        if (far_wall) surface.content = "quarters";
        show.contents.push_back(far_wall ? picture : nullptr);
      }
      show.surfaces = std::move(*surfaces);
      projection.set_show(std::move(show));
    }
    // Where the light truly lands: through the true projector, from the true pose, on the true wall.
    projection.draw(t, time, frame.view());
    const auto pixel = middle_of(frame);
    if (!pixel) continue;
    ++lit;
    const Pose world_from_lamp = drive.world_from_rig(time) * world.rig.projectors[0].rig_from_projector;
    const auto ray = lamp.inverse_camera.unproject(*pixel);
    ASSERT_TRUE(ray);
    const Vec3 origin = world_from_lamp.translation, along = world_from_lamp.rotate(*ray);
    const Vec3 hit = origin + along * ((3.2 - origin.y()) / along.y());
    if (!landed) landed = hit;
    EXPECT_LT((hit - *landed).norm(), 0.003) << "at " << time;
    // And where the content is said to be.
    EXPECT_LT((hit - said).norm(), 0.006) << "at " << time;
  }
  EXPECT_EQ(view.looked(), 51);
  EXPECT_GT(lit, 35);
  EXPECT_GT(told, 0);
  EXPECT_EQ(last.count("table_1"), 1u);
}

TEST(DepthSurfaceTracker, WhoeverWalksThroughIsKeptOutOfTheLightWhileTheRobotTurns) {
  const SmallRoom world;
  constexpr double kDelay = 0.03, kLightAfter = 0.09;  // seconds: of depth, and from exposure to light
  RoomOptions options = world.options();
  options.delay = kDelay;
  options.silhouettes.emplace();
  DepthSurfaceTracker view(options);
  ProjectionOptions drawing;
  drawing.track.prediction = track::Prediction::kConstantTwist;
  Projection projection(world.rig, drawing);
  const std::shared_ptr<device::ContentSource> white = device::still_content(ImageU8(8, 8, 3, 255));
  const auto robot = [](double time) {  // turns by up to 14 degrees/s
    return simulate::test::looking_at(Vec3(0.1 * std::sin(time), 0.6, 1.3),
                                      Vec3(0.55 * std::sin(1.1 * time), 3.2, 1.35));
  };
  const auto walker = [](double time) { return Walker{Vec3(-1.6 + 1.1 * (time - 4), 2.4, 0)}; };
  ImageU8 frame(projection.frame_size(), 3);
  long on_walker = 0, lit_on_walker = 0, beside = 0, lit_beside = 0, empty = 0, lit_empty = 0;
  for (int i = 0; i <= 68; ++i) {
    const double time = 0.1 * i;
    for (int k = 0; k < 3; ++k) {
      const double stamp = time - 0.1 + (k + 1) / 30.0;
      if (stamp < 0) continue;
      view.add(message(stamp + 1, robot(stamp)));
      projection.add(message(stamp + 1, robot(stamp)));
    }
    const bool is_there = time > 4;
    const auto bodies = is_there ? walker(time).bodies() : std::vector<simulate::Body>();
    if (auto surfaces = view.look(world.seen(robot(time), time + 1 + kDelay, bodies, std::uint64_t(i) + 1))) {
      Show show;
      for (Surface& surface : surfaces->surfaces) {
        surface.content = "white";
        show.contents.push_back(white);
      }
      show.surfaces = std::move(*surfaces);
      projection.set_show(std::move(show));
    }
    if (time < 3.5) continue;  // the room is known by then
    const double light = time + 1 + kLightAfter;
    projection.draw(light, time, frame.view());
    const ImageU8 all = frame;
    const people::MaskResult done = darken_before_room(frame, projection, light, view.silhouettes().get());
    ASSERT_FALSE(done.blanked) << done.reason;
    const Pose world_from_lamp = robot(time + kLightAfter) * world.rig.projectors[0].rig_from_projector;
    const Walker then = walker(time + kLightAfter);
    for (int y = 0; y < frame.height(); y += 3)
      for (int x = 0; x < frame.width(); x += 3) {
        if (all.at(x, y, 0) == 0) continue;
        const bool lit = frame.at(x, y, 0) > 0;
        const auto ray = projection.projector().inverse_camera.unproject(Vec2(x, y));
        const double off = then.clearance(world_from_lamp.translation, world_from_lamp.rotate(*ray));
        if (!is_there) ++empty, lit_empty += lit;
        if (is_there && off < 0) ++on_walker, lit_on_walker += lit;
        if (is_there && off > 0.5) ++beside, lit_beside += lit;
      }
  }
  EXPECT_GT(on_walker, 2000);
  EXPECT_EQ(lit_on_walker, 0);
  EXPECT_GT(beside, 20000);
  EXPECT_GT(double(lit_beside) / double(beside), 0.97);
  EXPECT_GT(double(lit_empty) / double(empty), 0.97);
  // Without news of depth, and without a pose, all is dark.
  EXPECT_TRUE(darken_before_room(frame, projection, 9, view.silhouettes().get()).blanked);
  EXPECT_TRUE(darken_before_room(frame, projection, 7.9, nullptr).blanked);
  Projection nowhere(world.rig, drawing);
  EXPECT_TRUE(darken_before_room(frame, nowhere, 7.9, view.silhouettes().get()).blanked);
}

TEST(DepthSurfaceTracker, PassesPicturesOverWithoutAPoseAndRefusesOtherSizes) {
  const SmallRoom world;
  DepthSurfaceTracker view(world.options());
  const Pose stands = simulate::test::looking_at(Vec3(0, 0.9, 1.2), Vec3(0, 3.2, 1.1));
  EXPECT_FALSE(view.look(world.seen(stands, 1, {}, 1)));
  EXPECT_EQ(view.frames_without_pose(), 1);
  EXPECT_THROW(view.look({Image<std::uint16_t>(16, 12), 2}), Error);
  RoomOptions still = world.options();
  still.world_from_rig = stands;
  DepthSurfaceTracker of_still(still);
  for (int i = 0; i < 8; ++i) of_still.look(world.seen(stands, 1 + 0.1 * i, {}, std::uint64_t(i)));
  EXPECT_EQ(of_still.looked(), 8);
  EXPECT_FALSE(of_still.look(world.seen(stands, 1, {}, 1)));  // older than the last: passed over
  EXPECT_EQ(of_still.looked(), 8);
}

/// Pictures that state their lens are seen through it, whatever the rig file says.
TEST(DepthSurfaceTracker, TheLensOfThePicturesCountsMoreThanTheRigs) {
  const SmallRoom world;
  const Pose stands = simulate::test::looking_at(Vec3(0, 0.9, 1.2), Vec3(0, 3.2, 1.1));
  const auto look = [&](const RoomOptions& options, bool states_lens) {
    RoomOptions still = options;
    still.world_from_rig = stands;
    DepthSurfaceTracker view(still);
    for (int i = 0; i < 10; ++i) {
      device::SeenDepth seen = world.seen(stands, 1 + 0.1 * i, {}, std::uint64_t(i));
      if (states_lens) seen.camera = world.options().camera.camera;
      view.look(seen);
    }
    return view.map().surfaces();
  };
  const SurfaceSet truth = look(world.options(), false);
  ASSERT_FALSE(truth.surfaces.empty());
  RoomOptions wrong = world.options();
  wrong.camera.camera.intrinsics.fx *= 1.2;
  wrong.camera.camera.size.width += 16;
  EXPECT_THROW(look(wrong, false), Error) << "of another size";
  const SurfaceSet by_lens = look(wrong, true);
  ASSERT_EQ(by_lens.surfaces.size(), truth.surfaces.size());
  for (std::size_t i = 0; i < truth.surfaces.size(); ++i) {
    const auto &a = std::get<PlanarSurface>(truth.surfaces[i].geometry),
               &b = std::get<PlanarSurface>(by_lens.surfaces[i].geometry);
    EXPECT_EQ(a.frame_from_surface.matrix(), b.frame_from_surface.matrix());
  }
}

/// Hands out what the test puts in; can break.
class Fed : public device::DepthSource {
 public:
  struct Shared {
    std::mutex mutex;
    std::deque<device::SeenDepth> pictures;
    bool broken = false;
    int opened = 0;
  };
  explicit Fed(Shared& shared) : shared_(shared) { ++shared.opened; }
  std::optional<device::SeenDepth> next(double, double timeout) override {
    {
      const std::lock_guard<std::mutex> lock(shared_.mutex);
      if (shared_.broken) throw Error(ErrorKind::kDevice, "depth camera", "unplugged", "plug it in");
      if (!shared_.pictures.empty()) {
        auto seen = std::move(shared_.pictures.front());
        shared_.pictures.pop_front();
        return seen;
      }
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(timeout, 0.01)));
    return std::nullopt;
  }

 private:
  Shared& shared_;
};

TEST(DepthSurfaceSource, ACameraThatIsLostIsToldAndComesBack) {
  const SmallRoom world;
  const Pose stands = simulate::test::looking_at(Vec3(0, 0.9, 1.2), Vec3(0, 3.2, 1.1));
  DepthSurfaceSourceOptions options;
  options.room = world.options();
  options.room.world_from_rig = stands;
  options.room.map.free_space_tau = 0.05;
  options.lost_after = 0.3;
  options.blank_on_loss = true;
  Fed::Shared shared;
  // Made before: on a slow machine that takes longer than the camera may be silent.
  const device::SeenDepth picture = world.seen(stands, 0, {}, 1);
  DepthSurfaceSource watch([&] { return std::make_unique<Fed>(shared); }, options);
  std::vector<std::string> words;
  std::uint64_t faults = 0;
  std::optional<SurfaceSet> now;
  const auto feed_until = [&](const auto& done, bool feeds) {
    for (int i = 0; i < 600 && !done(); ++i) {
      if (feeds) {
        const std::lock_guard<std::mutex> lock(shared.mutex);
        if (shared.pictures.empty()) shared.pictures.push_back({picture.pixels, device::now_s()});
      }
      if (auto news = watch.take()) {
        words.insert(words.end(), news->words.begin(), news->words.end());
        faults += news->faults;
        if (news->surfaces) now = std::move(news->surfaces);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_TRUE(done());
  };
  const auto is_told = [&](const char* part) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& text) { return text.find(part) != std::string::npos; });
  };
  feed_until([&] { return now && !now->surfaces.empty(); }, true);
  EXPECT_EQ(faults, 0u);
  {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    shared.broken = true;
  }
  feed_until([&] { return is_told("unplugged") && is_told("silent") && now->surfaces.empty(); }, false);
  {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    shared.broken = false;
  }
  feed_until([&] { return is_told("sees again") && !now->surfaces.empty(); }, true);
  EXPECT_EQ(shared.opened, 2);
  EXPECT_EQ(faults, 2u) << "the camera that broke, and its loss";
}

}  // namespace
}  // namespace procam::show
