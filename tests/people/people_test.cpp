// People over time: identity, prediction, what content asks of them, and what keeps them out of the light.
#include "procam/people/people.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "depth_inside.hpp"
#include "procam/people/eye_safe.hpp"
#include "procam/people/interaction.hpp"
#include "procam/people/silhouette.hpp"
#include "support/lopsided.hpp"

namespace procam::people {
namespace {

/// Pelvis, neck, head and hands about a place on the floor, as the sensor sees them.
Skeleton person_at(const Vec3& pelvis) {
  Skeleton person;
  const auto put = [&](Joint joint, double x, double y, double z) {
    person[joint] = SeenJoint<Vec3>{pelvis + Vec3(x, y, z), 0.9};
  };
  put(Joint::kPelvis, 0, 0, 0);
  put(Joint::kNeck, 0.02, -0.52, 0.03);
  put(Joint::kHead, 0.03, -0.74, -0.02);
  put(Joint::kLeftHand, 0.31, 0.05, -0.12);
  put(Joint::kRightHand, -0.28, 0.02, -0.15);
  return person;
}
SkeletonFrame frame_at(double time, std::vector<Skeleton> people) {
  SkeletonFrame frame;
  frame.stamp = frame.arrival = time;
  frame.people = std::move(people);
  return frame;
}

TEST(PeopleTrack, KeepsTwoPeopleApartWhoPassEachOther) {
  PeopleTrack track;
  for (int i = 0; i <= 60; ++i) {
    const double t = i / 20.0, s = t / 3;
    std::vector<Skeleton> seen = {person_at(Vec3(-1 + 2 * s, 0.2, 2.2)),
                                  person_at(Vec3(1.1 - 2 * s, 0.2, 2.6))};
    // The tracker's order and ids mean nothing.
    if (i % 3 == 0) std::swap(seen[0], seen[1]);
    if (i == 31) seen.resize(1);  // one hides the other
    track.add(frame_at(t, seen));
    const auto people = track.at(t);
    ASSERT_EQ(people.size(), 2u);
    // Number 1 was handed out first: to whoever came first in the first frame, which was swapped.
    const TrackedPerson* first = find_person(people, 1);
    ASSERT_NE(first, nullptr);
    EXPECT_NEAR(body_of(first->skeleton)->z(), 2.6, 0.15) << i;
  }
}

/// Two in a row step sideways together: the second is nearest to where the first is now.
TEST(PeopleTrack, NearestFirstIsNotEnough) {
  PeopleTrack track;
  track.add(frame_at(0.0, {person_at(Vec3(0, 0.2, 2.2)), person_at(Vec3(0.4, 0.2, 2.2))}));
  track.add(frame_at(0.1, {person_at(Vec3(0.3, 0.2, 2.2)), person_at(Vec3(0.75, 0.2, 2.2))}));
  const auto people = track.at(0.1);
  ASSERT_EQ(people.size(), 2u);
  EXPECT_NEAR(body_of(people[0].skeleton)->x(), 0.3, 0.02);
  EXPECT_NEAR(body_of(people[1].skeleton)->x(), 0.75, 0.02);
}

TEST(PeopleTrack, RefusesTeleportsUntilTheyAreBelieved) {
  PeopleTrack track;
  double t = 0;
  for (int i = 0; i < 30; ++i, t += 1 / 30.0) track.add(frame_at(t, {person_at(Vec3(0.3, 0.1, 2))}));
  const auto hand_error = [&](const Vec3& where) {
    return (*hand_of(track.at(t).at(0).skeleton, Side::kLeft) - where).norm();
  };
  const Vec3 hand = *person_at(Vec3(0.3, 0.1, 2)).position(Joint::kLeftHand);
  Skeleton glitch = person_at(Vec3(0.3, 0.1, 2));
  const Vec3 elsewhere(-1.5, -0.8, 3.1);
  glitch[Joint::kLeftHand]->position = elsewhere;
  track.add(frame_at(t, {glitch}));
  EXPECT_LT(hand_error(hand), 0.02);
  EXPECT_EQ(track.faults().teleports, 1u);
  // Here and there: no two agree.
  for (int i = 0; i < 4; ++i) {
    t += 1 / 30.0;
    glitch[Joint::kLeftHand]->position = i % 2 == 0 ? elsewhere : Vec3(2, 1, 4);
    track.add(frame_at(t, {glitch}));
  }
  EXPECT_EQ(track.faults().teleports, 5u);
  // It stays: the fourth in a row is believed.
  for (int i = 0; i < 4; ++i) {
    t += 1 / 30.0;
    glitch[Joint::kLeftHand]->position = elsewhere;
    track.add(frame_at(t, {glitch}));
  }
  EXPECT_LT(hand_error(elsewhere), 0.02);
  EXPECT_EQ(track.at(t).size(), 1u) << "one joint does not make somebody else";
}

TEST(PeopleTrack, CountsWhatItRefuses) {
  PeopleTrack track;
  const Skeleton person = person_at(Vec3(0, 0, 2));
  EXPECT_TRUE(track.add(frame_at(1.0, {person})));
  EXPECT_FALSE(track.add(frame_at(1.0, {person})));
  SkeletonFrame late = frame_at(0.9, {person});
  late.arrival = 1.01;
  EXPECT_FALSE(track.add(late));
  EXPECT_FALSE(track.add(frame_at(1.1, std::vector<Skeleton>(500, person))));
  for (const double nonsense :
       {std::numeric_limits<double>::quiet_NaN(), 1e30, -1e30, std::numeric_limits<double>::infinity()}) {
    Skeleton broken = person;
    broken[Joint::kHead]->position.y() = nonsense;
    EXPECT_FALSE(track.add(frame_at(1.2, {broken})));
  }
  EXPECT_EQ(track.faults().repeated, 1u);
  EXPECT_EQ(track.faults().late, 1u);
  EXPECT_EQ(track.faults().refused, 5u);
  EXPECT_NE(track.faults().why, "");
  ASSERT_EQ(track.at(1.0).size(), 1u);
  EXPECT_NEAR(track.at(1.5).at(0).age, 0.5, 1e-9);
  EXPECT_TRUE(track.at(2.5).empty());
}

TEST(Players, KeepTheirSide) {
  // The sensor stands beside the surface and looks at the people: its x runs the other way.
  const Pose surface_from_sensor(Eigen::Quaterniond(Eigen::AngleAxisd(kPi, Vec3::UnitY())), Vec3(1, 0.4, 0));
  PeopleTrack track;
  Players players;
  const SeatOptions seats{1.0, 0.2, 3};
  const auto play = [&](double time, std::vector<Skeleton> seen) {
    track.add(frame_at(time, std::move(seen)));
    players = seat_players(track.at(time), surface_from_sensor, players, seats);
  };
  const Skeleton left = person_at(Vec3(0.6, 0, 2)), right = person_at(Vec3(-0.5, 0, 2.1));
  play(0.0, {left, right});
  EXPECT_FALSE(players.left || players.right) << "one sighting may be a phantom";
  play(0.1, {left, right});
  play(0.2, {right, left});
  EXPECT_EQ(players.left, 1);
  EXPECT_EQ(players.right, 2);
  play(0.3, {left, person_at(Vec3(0.1, 0, 2.1))});  // leans over the middle by less than 0.2 m
  EXPECT_EQ(players.right, 2);
  for (int i = 0; i < 12; ++i) play(0.4 + 0.1 * i, {left});
  EXPECT_EQ(players.left, 1);
  EXPECT_FALSE(players.right);
}

/// A hand circles before a wall that is not aligned with the sensor, at up to 1 m/s; 30 skeletons a second
/// with 5 mm of noise an axis, 1 % teleports; they speak of a moment 50 ms before they arrive, and are asked
/// for at their arrival and between. Bounds are three times the spread between seeds away.
TEST(Hand, IsWhereItIsAfterFiftyMilliseconds) {
  const Pose surface_from_sensor = test::lopsided_pose();
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.005);
    std::uniform_real_distribution<double> chance(0, 1);
    PeopleOptions options;
    options.noise = 0.005;
    options.delay = 0.05;
    PeopleTrack track(options);
    const auto hand_on_wall = [](double t) {
      return Vec3(0.8 + 0.35 * std::sin(2.2 * t), 0.5 + 0.25 * std::sin(3.1 * t + 0.4), -0.05);
    };
    double squares = 0, squares_unpredicted = 0;
    std::vector<double> errors;
    for (int i = 0; i < 900; ++i) {
      const double moment = i / 30.0, arrival = moment + 0.05;
      const Vec3 truth = surface_from_sensor.inverse() * hand_on_wall(moment);
      Skeleton seen;
      seen[Joint::kPelvis] = SeenJoint<Vec3>{truth + Vec3(0.1, 0.6, 0.3), 1};
      Vec3 measured = truth + Vec3(noise(random), noise(random), noise(random));
      const Vec3 newest = measured;
      if (chance(random) < 0.01) measured += Vec3(0.9, -0.7, 0.8);
      seen[Joint::kRightHand] = SeenJoint<Vec3>{measured, 1};
      SkeletonFrame frame = frame_at(moment + 1000, {seen});
      frame.arrival = arrival;
      track.add(frame);
      if (i < 30) continue;
      for (const double later : {0.0, 1 / 60.0}) {
        const auto people = track.at(arrival + later);
        ASSERT_EQ(people.size(), 1u);
        const Vec2 paddle = on_surface(*hand_of(people[0].skeleton, Side::kRight), surface_from_sensor).point;
        const Vec2 there = hand_on_wall(arrival + later).head<2>();
        errors.push_back((paddle - there).norm());
        squares += (paddle - there).squaredNorm();
        squares_unpredicted += (on_surface(newest, surface_from_sensor).point - there).squaredNorm();
      }
    }
    std::sort(errors.begin(), errors.end());
    const double rms = std::sqrt(squares / double(errors.size()));
    const double p95 = errors[errors.size() * 95 / 100];
    const double rms_unpredicted = std::sqrt(squares_unpredicted / double(errors.size()));
    RecordProperty("seed " + std::to_string(seed), std::to_string(1e3 * rms) + " mm rms, p95 " +
                                                       std::to_string(1e3 * p95) + ", unpredicted " +
                                                       std::to_string(1e3 * rms_unpredicted));
    EXPECT_LT(rms, 0.015);
    EXPECT_GT(rms_unpredicted, 2 * rms) << "without prediction it must look worse";
    EXPECT_GT(track.faults().teleports, 0u);
  }
}

TEST(Zone, EntersDwellsAndLeavesWithHysteresis) {
  using Event = Zone::Event;
  Zone zone({{0, 0}, {1, 0}, {1, 0.6}, {0, 0.6}}, {0.03, 1.0, 0.25});
  EXPECT_EQ(zone.update(Vec2(0.5, -0.1), 0), Event::kNone);
  EXPECT_EQ(zone.update(Vec2(0.5, 0.02), 0.1), Event::kNone) << "not yet far inside";
  EXPECT_EQ(zone.update(Vec2(0.5, 0.04), 0.2), Event::kEntered);
  EXPECT_EQ(zone.update(Vec2(0.5, -0.02), 0.3), Event::kNone) << "trembles at the edge";
  EXPECT_EQ(zone.update(std::nullopt, 0.4), Event::kNone);
  EXPECT_NEAR(zone.progress(0.7), 0.5, 1e-9);
  EXPECT_EQ(zone.update(Vec2(0.6, 0.3), 1.2), Event::kDwelled);
  EXPECT_EQ(zone.update(Vec2(0.6, 0.3), 1.3), Event::kNone) << "told once";
  EXPECT_EQ(zone.update(Vec2(0.6, 0.7), 1.4), Event::kLeft);
  EXPECT_EQ(zone.update(Vec2(0.6, 0.3), 1.5), Event::kEntered);
  EXPECT_EQ(zone.update(std::nullopt, 1.8), Event::kLeft) << "out of sight";
  EXPECT_NEAR(depth_inside({{0, 0}, {4, 0}, {0, 3}}, Vec2(2, 1.25)), 0.2, 1e-12);  // 3-4-5, its hypotenuse
  EXPECT_NEAR(depth_inside({{0, 0}, {4, 0}, {0, 3}}, Vec2(-3, -4)), -5, 1e-12);
}

TEST(Pointing, HitsWhatHeadAndHandPointAt) {
  const Pose surface_from_sensor = test::lopsided_pose();
  const Vec3 target(0.7, 0.3, 0);
  const Vec3 head(0.2, -0.1, -2.4), hand = head + 0.25 * (target - head);
  Skeleton person;
  person[Joint::kLeftEar] =
      SeenJoint<Vec3>{surface_from_sensor.inverse() * Vec3(head + Vec3(0.07, 0, 0.01)), 1};
  person[Joint::kRightEar] =
      SeenJoint<Vec3>{surface_from_sensor.inverse() * Vec3(head - Vec3(0.07, 0, 0.01)), 1};
  person[Joint::kLeftWrist] = SeenJoint<Vec3>{surface_from_sensor.inverse() * hand, 1};
  const auto ray = pointing_ray(person, Side::kLeft);
  ASSERT_TRUE(ray);
  EXPECT_LT((*hit_on_surface(*ray, surface_from_sensor) - target.head<2>()).norm(), 1e-9);
  EXPECT_FALSE(pointing_ray(person, Side::kRight));
  EXPECT_FALSE(hit_on_surface(Ray{ray->origin, -ray->direction}, surface_from_sensor));
  EXPECT_NEAR(on_surface(surface_from_sensor.inverse() * hand, surface_from_sensor).distance, -hand.z(),
              1e-9);

  Touch touch;
  EXPECT_FALSE(touch.update(SurfacePoint{Vec2(0, 0), 0.08}));
  EXPECT_TRUE(touch.update(SurfacePoint{Vec2(0, 0), 0.05}));
  EXPECT_TRUE(touch.update(SurfacePoint{Vec2(0, 0), 0.08}));
  EXPECT_FALSE(touch.update(SurfacePoint{Vec2(0, 0), 0.13}));
  EXPECT_FALSE(touch.update(std::nullopt));
}

TEST(ForbiddenZone, SeesAnyJoint) {
  TrackedPerson person;
  person.skeleton[Joint::kRightFoot] = SeenJoint<Vec3>{Vec3(0.4, 0.2, -0.3), 1};
  const Points2 zone = {{0, 0}, {1, 0}, {1, 0.5}, {0, 0.5}};
  ASSERT_TRUE(trespass({person}, Pose(), zone, 0.5));
  EXPECT_FALSE(trespass({person}, Pose(), zone, 0.2));
  EXPECT_FALSE(trespass({person}, Pose(Eigen::Quaterniond::Identity(), Vec3(0, 1, 0)), zone, 0.5));
}

// --- the light ---

Projector lopsided_projector() {
  Projector projector;
  projector.inverse_camera = {
      {1024, 768}, test::lopsided_intrinsics(), BrownConrady{{-0.09, 0.02, 0.001, -0.0007, 0.01}}};
  return projector;
}

/// No pixel whose light passes within the radius of the head's truth stays lit; and most of the picture does.
TEST(EyeSafe, NoLightPassesThroughAHead) {
  const Projector projector = lopsided_projector();
  std::mt19937_64 random(5);
  const EyeSafeOptions options;
  for (int round = 0; round < 20; ++round) {
    const Pose projector_from_sensor(so3_exp(test::random_vec3(random, 0.3)), test::random_vec3(random, 0.4));
    TrackedPerson person;
    person.age = test::uniform(random, 0, 0.1);
    const Vec3 head(test::uniform(random, -0.6, 0.6), test::uniform(random, -0.5, 0.5),
                    test::uniform(random, 1.5, 3));
    person.skeleton[Joint::kHead] = SeenJoint<Vec3>{projector_from_sensor.inverse() * head, 1};
    person.sigma[std::size_t(Joint::kHead)] = 0.01;
    ImageU8 frame(1024, 768, 3, 255);
    const MaskResult done =
        darken_heads(frame, projector, projector_from_sensor, {person}, 10.0, 10.05, options);
    ASSERT_FALSE(done.blanked) << done.reason;
    const double r = options.radius + options.margin + options.speed * person.age + 0.03;
    std::size_t dark = 0, within = 0;
    for (int y = 0; y < 768; y += 3)
      for (int x = 0; x < 1024; x += 3) {
        const Vec3 bearing = projector.emit(Vec2(x, y))->direction;
        const bool hits = (head - bearing.dot(head) * bearing).norm() <= r;
        within += hits;
        dark += frame.at(x, y, 1) == 0;
        if (hits) {
          ASSERT_EQ(frame.at(x, y, 1), 0) << x << " " << y << " round " << round;
        }
      }
    EXPECT_LE(dark, within * 1.1 + 400) << "more is dark than must be, round " << round;
  }
}

TEST(EyeSafe, FailsDark) {
  const Projector projector = lopsided_projector();
  const auto darken = [&](std::vector<TrackedPerson> people, std::optional<double> newest,
                          EyeSafeOptions options = {}) {
    ImageU8 frame(1024, 768, 3, 200);
    const MaskResult done = darken_heads(frame, projector, Pose(), people, newest, 10, options);
    const bool is_dark =
        std::all_of(frame.data(), frame.data() + 1024 * 768 * 3, [](auto v) { return v == 0; });
    EXPECT_EQ(is_dark, done.blanked);
    EXPECT_EQ(done.blanked, *done.reason != '\0');
    return is_dark;
  };
  EXPECT_FALSE(darken({}, 9.9)) << "news of nobody is news";
  EXPECT_TRUE(darken({}, 9.5));
  EXPECT_TRUE(darken({}, std::nullopt));
  EyeSafeOptions lit;
  lit.dark_without_news = false;
  EXPECT_FALSE(darken({}, std::nullopt, lit));

  TrackedPerson person;
  EXPECT_TRUE(darken({person}, 9.9)) << "somebody without a joint";
  person.skeleton[Joint::kHead] = SeenJoint<Vec3>{Vec3(0.02, 0.05, 0.1), 1};
  EXPECT_TRUE(darken({person}, 9.9)) << "a head at the lens";
  person.skeleton[Joint::kHead]->position = Vec3(0.2, 0.3, -3);
  EXPECT_FALSE(darken({person}, 9.9)) << "behind the projector";
  person.skeleton[Joint::kHead]->position = Vec3(0, 0, 2);
  person.age = 2;  // it may be anywhere by now
  EXPECT_TRUE(darken({person}, 9.9));
}

/// A wall 3 m away, a ball before it, seen by a depth camera beside the projector.
struct DepthScene {
  Camera camera{{160, 120}, {140, 137, 77.3, 61.9, 0.3}, {}};
  Pose projector_from_camera{so3_exp(Vec3(0.03, -0.08, 0.02)), Vec3(0.22, -0.06, 0.03)};
  Vec3 ball{0.2, -0.1, 2.0};  ///< in the projector's frame
  double radius = 0.15;
  ImageF background{160, 120}, depth{160, 120};

  DepthScene() {
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        const Vec3 way = *camera.unproject(Vec2(x, y));
        const double wall = 3.0;
        background.at(x, y) = float(wall);
        const Vec3 centre = projector_from_camera.inverse() * ball;
        const double along = way.dot(centre), off = centre.squaredNorm() - along * along;
        depth.at(x, y) =
            off < radius * radius ? float((along - std::sqrt(radius * radius - off)) * way.z()) : float(wall);
      }
  }
  ImageU8 darkened(double age, MaskResult* told = nullptr) const {
    ImageU8 frame(1024, 768, 3, 255);
    const Silhouettes seen = find_silhouettes({camera, depth.view(), background.view()});
    const MaskResult done = darken_silhouettes(frame, lopsided_projector(), projector_from_camera, seen, age);
    if (told != nullptr) *told = done;
    return frame;
  }
  /// Shares of lit pixels whose light meets the ball, or passes it by more than `far` metres.
  std::pair<double, double> lit(const ImageU8& frame, double far) const {
    const Projector projector = lopsided_projector();
    double on_ball = 0, lit_on_ball = 0, beside = 0, lit_beside = 0;
    for (int y = 0; y < 768; y += 4)
      for (int x = 0; x < 1024; x += 4) {
        const Vec3 way = projector.emit(Vec2(x, y))->direction;
        const double off = (ball - way.dot(ball) * way).norm();
        if (off < radius) ++on_ball, lit_on_ball += frame.at(x, y, 0) > 0;
        if (off > radius + far) ++beside, lit_beside += frame.at(x, y, 0) > 0;
      }
    return {lit_on_ball / on_ball, lit_beside / beside};
  }
};

TEST(Silhouette, WhateverIsBeforeTheWallIsDark) {
  const DepthScene scene;
  MaskResult told;
  const auto [on_ball, beside] = scene.lit(scene.darkened(0.05, &told), 0.4);
  EXPECT_FALSE(told.blanked);
  EXPECT_GT(told.masked, 5);
  EXPECT_EQ(on_ball, 0);
  EXPECT_EQ(beside, 1) << "the rest has light";
  // What moves on is given room.
  const auto count = [](const ImageU8& frame) {
    return std::count(frame.data(), frame.data() + 1024 * 768 * 3, 0);
  };
  EXPECT_GT(count(scene.darkened(0.2)), count(scene.darkened(0.0)) * 3 / 2);
}

TEST(Silhouette, FailsDark) {
  DepthScene scene;
  MaskResult told;
  scene.darkened(0.4, &told);
  EXPECT_TRUE(told.blanked) << "old";
  scene.darkened(std::numeric_limits<double>::quiet_NaN(), &told);
  EXPECT_TRUE(told.blanked);
  // A black coat returns nothing: where the ball was there are no readings.
  DepthScene coat = scene;
  for (int i = 0; i < 160 * 120; ++i)
    if (coat.depth.data()[i] < 2.9f) coat.depth.data()[i] = i % 2 == 0 ? 0.0f : -1.0f;
  EXPECT_EQ(coat.lit(coat.darkened(0.05), 0.4).first, 0);
  // No reading at all: every ray that the camera sees is dark.
  DepthScene blind = scene;
  std::fill_n(blind.depth.data(), 160 * 120, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(blind.lit(blind.darkened(0.05), 0.0).first, 0);
  // Single missing readings, as every depth camera has them, cost nothing.
  DepthScene speckled = scene;
  for (int i = 0; i < 160 * 120; i += 7) speckled.depth.data()[i] = 0;
  EXPECT_EQ(speckled.lit(speckled.darkened(0.05), 0.4).second, 1);
  EXPECT_EQ(speckled.lit(speckled.darkened(0.05), 0.4).first, 0);
  DepthScene near = scene;
  for (int i = 0; i < 3; ++i) near.depth.at(80 + i, 60) = 0.05f;
  near.darkened(0.2, &told);
  EXPECT_TRUE(told.blanked) << "at the lens";
  scene.depth = ImageF(16, 12);
  EXPECT_THROW(scene.darkened(0.05), std::invalid_argument);
}

TEST(Silhouette, GapsCountWhereAHeadFitsIn) {
  const Camera camera{{640, 480}, {585, 581, 317.2, 241.7, 0.4}, {}};
  const ImageF wall(640, 480, 1, 3.0f);
  const SilhouetteOptions options;
  const auto with_gap = [&](int x0, int width, int y0, int height) {
    ImageF depth = wall;
    for (int y = y0; y < y0 + height; ++y)
      for (int x = x0; x < x0 + width; ++x) depth.at(x, y) = 0;
    return find_silhouettes({camera, depth.view(), wall.view()}, options);
  };
  // An emitter's shadow beside somebody: no head of 0.12 m is so narrow before a wall at 3 m (23 pixels).
  EXPECT_TRUE(with_gap(200, 12, 0, 480).unseen.empty());
  // A coat: anywhere from where a head fills the gap's narrower side, 80 pixels, on.
  const Silhouettes coat = with_gap(200, 80, 120, 200);
  ASSERT_FALSE(coat.unseen.empty());
  EXPECT_TRUE(coat.seen.empty());
  for (const Silhouettes::Unseen& unseen : coat.unseen) {
    EXPECT_NEAR(unseen.from, 581 * 0.12 / 80, 0.12);
    EXPECT_EQ(unseen.to, 3.0);
  }
  // A narrow end of a wide gap stays narrow.
  ImageF keyhole = wall;
  for (int y = 100; y < 400; ++y)
    for (int x = 300; x < (y < 200 ? 400 : 308); ++x) keyhole.at(x, y) = 0;
  const Silhouettes seen = find_silhouettes({camera, keyhole.view(), wall.view()}, options);
  EXPECT_FALSE(seen.unseen.empty());
  for (const Silhouettes::Unseen& unseen : seen.unseen)
    EXPECT_LT(unseen.way.y(), (204 - 241.7) / 581) << "below the wide part";
}

}  // namespace
}  // namespace procam::people
