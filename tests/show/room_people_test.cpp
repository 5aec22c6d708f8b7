/// People before a projector that drives: are they where they are on the surface, and out of the light?
#include "room_people.hpp"

#include <gtest/gtest.h>

#include "live_world.hpp"
#include "loop.hpp"

namespace procam::show {
namespace {

using people::Joint;

/// A rig that turns and drives before small_show()'s walls.
Pose world_from_rig(double t) {
  return Pose(so3_exp(Vec3(0.02, 0.15 * std::sin(t), -0.03)), Vec3(0.3 * std::sin(0.8 * t), 0.02, 0.1 * t));
}

struct Drive {
  Rig rig = small_rig();
  PeopleSensor sensor;
  Pose world_from_sensor;  ///< of one in the room
  std::optional<RoomPeople> people;
  std::optional<Projection> projection;
  ImageU8 frame;
  static constexpr double kDelay = 0.06;

  explicit Drive(PeopleSensor::Stands stands) {
    sensor.stands = stands;
    world_from_sensor = Pose(so3_exp(Vec3(0.1, -0.2, 0.05)), Vec3(0.3, -0.4, -0.2));
    sensor.place_from_sensor = stands == PeopleSensor::Stands::kOnRig
                                   ? Pose(so3_exp(Vec3(-0.1, 0.2, 0.04)), Vec3(-0.1, 0.15, 0.02))
                                   : world_from_sensor;
    people::PeopleOptions options;
    options.delay = kDelay;
    people.emplace(sensor, options);
    ProjectionOptions drawing;
    drawing.track.delay = 0;
    drawing.over = [this](const Projection& through, double light, ImageView<std::uint8_t> picture) {
      people->darken(picture, through, light);
    };
    projection.emplace(rig, drawing);
    projection->set_show(small_show());
    frame = ImageU8(projection->frame_size(), 3);
  }

  Pose sensor_from_world(double t) const {
    if (sensor.stands == PeopleSensor::Stands::kInWorld) return world_from_sensor.inverse();
    return sensor.place_from_sensor.inverse() *
           (world_from_rig(t) * rig.projector().rig_from_projector).inverse();
  }
  /// In the middle of the light, at first.
  Vec3 before_the_lamp() const {
    return world_from_rig(0) * (rig.projector().rig_from_projector * Vec3(-0.05, -0.1, 1.5));
  }
  /// Somebody whose hand rests at a place of the room, and whose head is at another.
  people::SkeletonFrame seen(double t, const Vec3& hand_in_world, const Vec3& head_in_world) const {
    people::SkeletonFrame result;
    result.stamp = t;
    result.arrival = t + kDelay;
    people::Skeleton person;
    person[Joint::kLeftHand] = people::SeenJoint<Vec3>{sensor_from_world(t) * hand_in_world, 1};
    person[Joint::kHead] = people::SeenJoint<Vec3>{sensor_from_world(t) * head_in_world, 1};
    result.people.push_back(person);
    return result;
  }
};

class RoomPeopleOn : public testing::TestWithParam<PeopleSensor::Stands> {};

TEST_P(RoomPeopleOn, AHandThatRestsRestsOnTheContentAndTheHeadIsDark) {
  Drive drive(GetParam());
  const PlanarSurface wall = std::get<PlanarSurface>(small_show().surfaces.surfaces[0].geometry);
  const Vec2 corner = wall.points[0], right = wall.points[1];
  // The content's own frame, by hand: its corner, along its top edge.
  const Vec2 along = (right - corner).normalized(), down(-along.y(), along.x());
  const Vec2 on_content(0.21, 0.13);
  const Vec2 on_plane = corner + on_content.x() * along + on_content.y() * down;
  const Vec3 hand = wall.frame_from_surface * Vec3(on_plane.x(), on_plane.y(), -0.04);
  const Vec3 head = drive.before_the_lamp();
  double next_frame = 0;
  int told = 0, dark = 0;
  for (int i = 0; i < 120; ++i) {
    const double now = i / 60.0;
    drive.projection->add(message(now, world_from_rig(now)));
    if (now >= next_frame + Drive::kDelay) {
      const people::SkeletonFrame frame = drive.seen(next_frame, hand, head);
      next_frame += 1 / 30.0;
      ASSERT_TRUE(drive.people->add(frame));
      const auto seen = drive.people->on_content(frame, *drive.projection, "left");
      if (i < 20) continue;
      ASSERT_TRUE(seen);
      ++told;
      EXPECT_EQ(seen->frame, "left");
      EXPECT_NEAR(*seen->stamp, next_frame - 1 / 30.0, 1e-3) << "by the local clock";
      const Vec3 at = seen->people[0][Joint::kLeftHand]->position;
      EXPECT_LT((at - Vec3(on_content.x(), on_content.y(), -0.04)).norm(), 0.002) << at.transpose();
    }
    drive.projection->draw(now, now, drive.frame.view());
    if (i < 40) continue;
    const Pose projector_from_world =
        (world_from_rig(now) * drive.rig.projector().rig_from_projector).inverse();
    const auto pixel = drive.projection->projector().inverse_camera.project(projector_from_world * head);
    ASSERT_TRUE(pixel);
    if (pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 319 || pixel->y() > 199) continue;
    ++dark;
    EXPECT_EQ(drive.frame.at(int(pixel->x()), int(pixel->y()), 2), 0) << i;
  }
  EXPECT_GT(told, 30);
  EXPECT_GT(dark, 30);
  const auto last = drive.seen(2, hand, head);
  EXPECT_FALSE(drive.people->on_content(last, *drive.projection, "sign"))
      << "pixels are no place in the room";
  EXPECT_FALSE(drive.people->on_content(last, *drive.projection, "nobody"));
  // No news of people for a while: dark.
  drive.projection->draw(2.9, 2.9, drive.frame.view());
  EXPECT_EQ(*std::max_element(drive.frame.data(), drive.frame.data() + 320 * 200 * 3), 0);
}
INSTANTIATE_TEST_SUITE_P(Sensors, RoomPeopleOn,
                         testing::Values(PeopleSensor::Stands::kOnRig, PeopleSensor::Stands::kInWorld));

/// A localiser that changes its mind moves the picture, and not the mask of a sensor that is on the rig.
TEST(RoomPeople, AMapJumpDoesNotLightAHead) {
  Drive drive(PeopleSensor::Stands::kOnRig);
  const Vec3 head = drive.before_the_lamp();
  const Pose jump(so3_exp(Vec3(0, 0.12, 0)), Vec3(0.3, 0, 0));
  for (int i = 0; i < 90; ++i) {
    const double now = i / 60.0;
    drive.projection->add(message(now, i < 60 ? world_from_rig(0) : jump * world_from_rig(0)));
    if (i % 2 == 0) {
      people::SkeletonFrame frame = drive.seen(0, head, head);
      frame.stamp = now - Drive::kDelay;
      frame.arrival = now;
      drive.people->add(frame);
    }
    drive.projection->draw(now, now, drive.frame.view());
    if (i < 30) continue;
    const Pose projector_from_world =
        (world_from_rig(0) * drive.rig.projector().rig_from_projector).inverse();
    const auto pixel = drive.projection->projector().inverse_camera.project(projector_from_world * head);
    EXPECT_EQ(drive.frame.at(int(pixel->x()), int(pixel->y()), 2), 0) << i;
  }
}

TEST(RoomPeople, AHeldPictureIsDarkWherePeopleAreNow) {
  ProjectionOptions options;
  options.projector_from_world = Pose();
  int row = 120;
  options.over = [&](const Projection&, double, ImageView<std::uint8_t> frame) {
    std::fill_n(frame.row(row), frame.width * 3, std::uint8_t(0));
  };
  Projection projection(small_rig(), options);
  projection.set_show(small_show());
  KeptFrames sink(projection.frame_size());
  const auto lit = [&](int y) {
    const ImageU8 frame = sink.last();
    return std::any_of(frame.row(y), frame.row(y) + frame.width() * 3, [](std::uint8_t v) { return v > 0; });
  };
  LoopParts parts{projection, sink};
  parts.tick = [&](const Metrics& metrics) {
    if (metrics.frames == 2) {
      EXPECT_TRUE(!lit(120) && lit(140));
      sink.wish(device::WindowEvent::kFreeze);
    }
    if (metrics.frames == 5) row = 140;
    if (metrics.frames == 8) {
      EXPECT_TRUE(!lit(120) && !lit(140) && lit(130));
      row = 130;
    }
    if (metrics.frames == 10) {
      EXPECT_TRUE(!lit(120) && lit(140) && !lit(130));
      sink.wish(device::WindowEvent::kClose);
    }
  };
  LoopOptions loop;
  loop.fps = 200;
  EXPECT_GE(run_loop(parts, loop).frames, 10u);
}

}  // namespace
}  // namespace procam::show
