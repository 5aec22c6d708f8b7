// From a hand to the light of its paddle on the simulated wall, through a real socket.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "air_hockey/stage.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "support/udp.hpp"

namespace hockey {
namespace {

using namespace procam;
using people::Joint;
using people::SkeletonFrame;

constexpr double kSensorDelay = 0.05;

/// What a socket received, with arrivals in the simulation's time.
class SimulatedArrivals : public people::SkeletonSource {
 public:
  explicit SimulatedArrivals(const test::UdpSender& sender)
      : sender_(sender), socket_(people::open_skeleton_source("udp:127.0.0.1:" + sender.port())) {}
  void poll(std::vector<SkeletonFrame>& arrived) override {
    arrived.clear();
    std::vector<SkeletonFrame> some;
    for (int i = 0; i < 2000; ++i) {
      socket_->poll(some);
      arrived.insert(arrived.end(), some.begin(), some.end());
      taken_ += some.size();
      if (taken_ + socket_->status().malformed >= sender_.sent()) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    for (SkeletonFrame& frame : arrived) frame.arrival = frame.stamp.value_or(0) + kSensorDelay;
  }
  track::SourceStatus status() const override { return socket_->status(); }

 private:
  const test::UdpSender& sender_;
  std::unique_ptr<people::SkeletonSource> socket_;
  std::uint64_t taken_ = 0;
};

/// The example's rig at a third of its resolution: a pixel is 5 mm on the wall, the disc's middle far less.
Rig small_rig() {
  Rig rig = example_rig();
  Camera& lens = rig.projectors[0].projector.inverse_camera;
  lens.size = {lens.size.width / 3, lens.size.height / 3};
  Intrinsics& k = lens.intrinsics;
  k.fx /= 3, k.fy /= 3, k.skew /= 3;
  k.cx = (k.cx + 0.5) / 3 - 0.5, k.cy = (k.cy + 0.5) / 3 - 0.5;
  return rig;
}

/// Where the light of the left paddle falls: lit pixels are cast onto the wall, weighted by the share of the
/// wall that each lights. Lines of the table have its colour: only what is near is meant.
std::optional<Vec2> lit_paddle(const ImageU8& frame, const Projector& projector,
                               const Pose& table_from_projector, const Vec2& about) {
  Vec2 sum = Vec2::Zero();
  double weights = 0;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      // The disc and what it shades: green and blue high, red low.
      if (frame.at(x, y, 0) > 90 || frame.at(x, y, 1) < 170 || frame.at(x, y, 2) < 210) continue;
      const auto ray = projector.emit(Vec2(x, y));
      if (!ray) continue;
      const Vec3 from = table_from_projector.translation, way = table_from_projector.rotate(ray->direction);
      const double s = -from.z() / way.z();
      const Vec2 hit = (from + s * way).head<2>();
      if ((hit - about).norm() > 0.2) continue;  // the other lines of its colour
      const double area = s * s / std::abs(way.z());
      sum += area * hit;
      weights += area;
    }
  if (weights == 0) return std::nullopt;
  return Vec2(sum / weights);
}

struct Measured {
  double rms = 0, p95 = 0, unseen = 0;
};

/// A hand circles over the wall at up to 1 m/s; skeletons come `rate` times a second with so much noise an
/// axis, 50 ms after the moment that they speak of; frames are lit 60 times a second.
Measured play(unsigned seed, double noise, bool predicts) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  const Rig rig = small_rig();
  const Wall wall = read_wall(example_wall());
  const Pose world_from_sensor = example_world_from_sensor(wall.world_from_table);
  const Pose sensor_from_table = world_from_sensor.inverse() * wall.world_from_table;
  const Pose table_from_projector = wall.world_from_table.inverse() * rig.projector().rig_from_projector;
  const auto hand = [](double t) {
    return Vec3(0.44 + 0.22 * std::sin(2.2 * t), 0.5 + 0.25 * std::sin(3.1 * t + 0.4), -0.05);
  };
  test::UdpSender sender(test::free_udp_port());
  Seat seat{wall.world_from_table, world_from_sensor, {}};
  seat.people.delay = predicts ? kSensorDelay : 0;
  seat.people.noise = noise;
  GameOptions options;
  options.bots_stand_in = true;
  Game game(wall.table, live_people(std::make_unique<SimulatedArrivals>(sender), seat, 0), options);
  device::SinkOptions sink;
  sink.size = rig.projector().projector.size();
  const auto stage = projected_stage(wall, rig, render::Filter::kArea, device::open_sink("none", sink));
  std::vector<double> errors;
  double squares = 0;
  int unseen = 0;
  double moment = 0;
  constexpr double kBegin = 1.2, kEnd = 6;
  for (int i = 0; i < int(kEnd * 60); ++i) {
    const double now = i / 60.0;
    for (; moment + kSensorDelay <= now; moment += 1 / 30.0) {
      SkeletonFrame frame;
      frame.stamp = moment;
      people::Skeleton person;
      const auto put = [&](Joint joint, const Vec3& p) {
        person[joint] = people::SeenJoint<Vec3>{
            sensor_from_table * p + Vec3(normal(random), normal(random), normal(random)), 1};
      };
      put(Joint::kPelvis, Vec3(-0.3, 0.95, -0.7));
      put(Joint::kHead, Vec3(-0.35, 0.1, -0.65));
      put(Joint::kLeftHand, hand(moment));
      frame.people.push_back(person);
      sender.send(people::to_json_line(frame));
    }
    game.advance(now, now);
    if (now < kBegin) continue;
    stage->show(game, now);
    const Vec2 truth = hand(now).head<2>();
    const auto lit = lit_paddle(stage->picture(), rig.projector().projector, table_from_projector, truth);
    if (!lit) {
      ++unseen;
      continue;
    }
    errors.push_back((*lit - truth).norm());
    squares += errors.back() * errors.back();
  }
  std::sort(errors.begin(), errors.end());
  const double count = double(errors.size());
  return {std::sqrt(squares / count), errors[errors.size() * 95 / 100], unseen / (unseen + count)};
}

TEST(HandToPaddle, LightLandsWhereTheHandIs) {
  const auto tell = [](const char* what, const Measured& m) {
    testing::Test::RecordProperty(what, std::to_string(1e3 * m.rms) + " mm rms, p95 " +
                                            std::to_string(1e3 * m.p95) + ", unseen " +
                                            std::to_string(m.unseen));
  };
  const Measured exact = play(1, 1e-4, true), quiet = play(2, 0.0025, true), noisy = play(3, 0.005, true),
                 late = play(3, 0.005, false);
  tell("without noise", exact);
  tell("2.5 mm of noise an axis", quiet);
  tell("5 mm of noise an axis", noisy);
  tell("5 mm, not predicted", late);
  // What drawing, lens and casting cost; the filter's lag on a hand that circles.
  EXPECT_LT(exact.p95, 0.005);
  EXPECT_LT(quiet.p95, 0.015);
  EXPECT_LT(noisy.rms, 0.015) << "95 % of the time it is within 20 mm then";
  EXPECT_EQ(exact.unseen + quiet.unseen + noisy.unseen, 0);
  EXPECT_GT(late.rms, 0.03) << "without prediction it must look worse";
}

}  // namespace
}  // namespace hockey
