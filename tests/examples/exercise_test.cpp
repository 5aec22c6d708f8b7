// An exercise as it is drawn: counted, its arc as far as the arm is, and a stop sign while somebody reaches
// into the zone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "exercise/room.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "support/test_data.hpp"

namespace exercise {
namespace {

using namespace procam;
using people::Joint;
using people::Side;

/// Pixels of a colour, and how far they reach to the right.
int count(const ImageU8& picture, bool (*is_it)(const std::uint8_t*)) {
  int found = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) found += is_it(&picture.at(x, y, 0));
  return found;
}
bool is_stop_red(const std::uint8_t* p) {
  return p[0] > 150 && p[1] < 60 && p[2] < 60;
}
bool is_green(const std::uint8_t* p) {
  return p[1] > 180 && p[0] < 120 && p[2] < 160;
}

TEST(Feedback, TheArcGrowsWithTheArmAndTurnsGreenAtTheTarget) {
  const Vec2 size(1.4, 0.8);
  const auto draw = [&](double deg) {
    ImageU8 picture(700, 400, 3);
    Feedback feedback;
    feedback.angle = deg * kDegree;
    draw_feedback(feedback, size, picture.view());
    return picture;
  };
  const auto white = [](const std::uint8_t* p) { return p[0] > 240 && p[1] > 240 && p[2] > 240; };
  EXPECT_GT(count(draw(70), white), count(draw(20), white) + 500);
  EXPECT_EQ(count(draw(70), is_green), 0);
  EXPECT_GT(count(draw(85), is_green), 3000);
  ImageU8 unseen(700, 400, 3);
  draw_feedback({}, size, unseen.view());  // no arm: said, not drawn somewhere
  EXPECT_EQ(count(unseen, is_green), 0);
}

TEST(ForbiddenZone, ShowsAStopSignWhereSomebodyIs) {
  const Points2 zone = {{0.05, 0.05}, {0.65, 0.05}, {0.65, 0.95}, {0.05, 0.95}};
  ImageU8 picture(350, 500, 3);
  draw_zone(zone, std::nullopt, Vec2(0.7, 1), 0, picture.view());
  EXPECT_EQ(count(picture, is_stop_red), 0);
  draw_zone(zone, Vec2(0.2, 0.8), Vec2(0.7, 1), 0, picture.view());
  EXPECT_GT(count(picture, is_stop_red), 15000);
  // The ring is where they are: 6 cm around.
  EXPECT_GT(picture.at(int((0.2 + 0.06) * 500), 400, 1), 200);
}

/// An arm that is lifted three times; at the side it reaches over the zone.
TEST(Room, CountsAndStops) {
  RoomOptions options;
  Room room(options);
  ImageU8 frame(room.frame_size(), 3);
  int stops = 0, signs = 0;
  for (int i = 0; i < 300; ++i) {
    const double t = i / 25.0, angle = (55 - 45 * std::cos(2 * kPi * t / 4)) * kDegree;
    people::SkeletonFrame seen;
    seen.stamp = seen.arrival = t;
    people::Skeleton person;
    const auto put = [&](Joint joint, double x, double y) {
      person[joint] = people::SeenJoint<Vec3>{Vec3(x, y, 2.2), 1};
    };
    put(Joint::kHead, 0, 0.05);
    put(Joint::kNeck, 0, 0.2);
    put(Joint::kPelvis, 0, 0.7);
    put(Joint::kLeftShoulder, 0.17, 0.22);
    put(Joint::kRightShoulder, -0.17, 0.22);
    const double reach = 0.27;
    put(Joint::kLeftElbow, 0.17 + reach * std::sin(angle), 0.22 + reach * std::cos(angle));
    put(Joint::kLeftHand, 0.17 + 2 * reach * std::sin(angle), 0.22 + 2 * reach * std::cos(angle));
    seen.people.push_back(person);
    room.add(seen);
    room.advance(t);
    if (i % 5 != 0) continue;
    room.draw(frame.view());
    stops += room.is_forbidden();
    signs += count(frame, is_stop_red) > 2000;
  }
  EXPECT_EQ(room.feedback().count, 3);
  EXPECT_NEAR(room.feedback().best, 100 * kDegree, 3 * kDegree);
  EXPECT_GT(stops, 10);
  EXPECT_LT(stops, 50);
  EXPECT_EQ(signs, stops);
}

TEST(Room, PlaysTheRecordedTherapy) {
  const struct {
    const char* file;
    Side side;
    int repetitions;
  } logs[] = {{"rehab_abduction_left.csv", Side::kLeft, 10},
              {"rehab_abduction_right.csv", Side::kRight, 10},
              {"rehab_skeletonplayer.csv", Side::kRight, 1}};
  for (const auto& log : logs) {
    PROCAM_REQUIRE_TEST_DATA(std::filesystem::path("skeleton") / log.file);
    RoomOptions options;
    options.side = log.side;
    Room room(options);
    ImageU8 frame(room.frame_size(), 3);
    int n = 0, signs = 0;
    for (const people::SkeletonFrame& seen :
         people::read_skeleton_log(test::test_data() / "skeleton" / log.file)) {
      room.add(seen);
      room.advance(*seen.stamp);
      if (++n % 30 != 0) continue;
      room.draw(frame.view());
      signs += count(frame, is_stop_red) > 2000;
      EXPECT_EQ(count(frame, is_stop_red) > 2000, room.is_forbidden());
    }
    EXPECT_EQ(room.feedback().count, log.repetitions) << log.file;
    if (log.repetitions > 1) EXPECT_GT(signs, 0) << log.file;
  }
}

}  // namespace
}  // namespace exercise
