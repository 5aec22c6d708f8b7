/// Images of rendered content on simulated walls: is a bump found, its cause, its size; what is reported where nothing can
/// be measured. Sub-pixel limits are those of the systematic errors that WatchOptions state.
#include "procam/watch/watch.hpp"

#include <gtest/gtest.h>

#include "watched_world.hpp"

namespace procam::watch {
namespace {

using test::Content;
using test::WatchedWorld;
using test::WorldOptions;

/// Images of a show from `time` on, five a second.
struct Session {
  WatchedWorld world;
  Watch watch;
  double time = 0.013, period = 0.2;

  explicit Session(const WorldOptions& options, const WatchOptions& watching = {})
      : world(options), watch(world.rig().camera(), world.rig().projector(), watching) {
    watch.place(world.surfaces());
  }
  WatchReport next() {
    const ImageU8 frame = world.frame(time);
    const WatchReport report = watch.add(time, {frame, frame, 0, 0}, world.image(frame, time));
    time += period;
    return report;
  }
  /// After so many seconds.
  WatchReport after(double seconds) {
    WatchReport report = next();
    for (const double end = time + seconds - 1.25 * period; time < end;) report = next();
    return report;
  }
};

/// A person half a metre before the wall hides most of the content and shows it herself, displaced by 31 pixels. The few
/// cells beside her stay.
TEST(Watch, LightOnAPersonIsNoMovement) {
  WorldOptions options;
  options.content = Content::kDarkGame;
  options.person = true;
  options.seed = 2;
  Session session(options);
  session.time = 15.013;
  int usable = 0;
  while (session.time < 21.1) {
    const WatchReport report = session.next();
    EXPECT_LT(report.median_shift.norm(), 3) << session.time;
    EXPECT_LT(report.error, 1e-3) << session.time << ", " << report.sentence;
    EXPECT_NE(report.state, WatchState::kLightSwitched) << session.time;
    usable += report.state == WatchState::kOk;
  }
  EXPECT_GT(usable, 10);
}

TEST(Watch, ABumpBehindAWalkingPersonIsFoundAndCorrected) {
  WorldOptions options;
  options.person = true;
  options.seed = 4;
  Session session(options);
  WatchReport report = session.after(4.5);
  EXPECT_EQ(report.state, WatchState::kOk) << report.sentence;
  EXPECT_LT(report.error, 4e-4);
  session.world.projector_moved << 0.0015, 0.0030, 0.0012, 0, 0, 0;  // 0.2 degrees
  const double bumped = session.time;
  const double error = true_error(session.watch, session.world, options);
  while (!report.is_alarm && session.time < bumped + 10) report = session.next();
  ASSERT_TRUE(report.is_alarm) << report.sentence;
  const auto causes = report.estimate->plausible();
  ASSERT_FALSE(causes.empty());
  EXPECT_EQ(causes.front()->thing, MovedThing::kProjector);
  EXPECT_EQ(report.state, WatchState::kMoved) << report.sentence;
  EXPECT_NEAR(report.error, error, 4e-4);

  RigProjector corrected = session.watch.projector();
  corrected.rig_from_projector = (se3_exp(causes.front()->moved) * corrected.rig_from_projector).normalized();
  session.watch.correct(corrected);
  session.world.believed_rig_from_projector = corrected.rig_from_projector;
  EXPECT_LT(true_error(session.watch, session.world, options), 5e-4);
  report = session.after(2.5);
  EXPECT_EQ(report.state, WatchState::kOk) << report.sentence;
}

/// Another robot lights the second wall of a corner with a film, and its light falls beyond the edge of this one's picture.
TEST(Watch, LightOfAnotherRobotIsNoMovementAndHidesNone) {
  WorldOptions options;
  options.walls = test::corner();
  options.of_another = 1;
  options.seed = 3;
  Session session(options);
  WatchReport report;
  for (const double end = session.time + 8; session.time < end;) {
    report = session.next();
    EXPECT_FALSE(report.is_alarm) << session.time << ", " << report.sentence;
    EXPECT_LT(report.error, 6e-4) << session.time << ", " << report.sentence;
    EXPECT_NE(report.state, WatchState::kLightSwitched) << session.time;
  }
  EXPECT_EQ(report.state, WatchState::kOk) << report.sentence;
  session.world.projector_moved << 0.0015, 0.0030, 0.0012, 0, 0, 0;  // 0.2 degrees
  const double bumped = session.time, error = true_error(session.watch, session.world, options);
  while (!report.is_alarm && session.time < bumped + 10) report = session.next();
  EXPECT_TRUE(report.is_alarm) << report.sentence;
  EXPECT_NEAR(report.error, error, 6e-4) << report.sentence;
}

TEST(Watch, ALargeBumpIsFoundByTheCoarseSearch) {
  WorldOptions options;
  options.seed = 2;
  Session session(options);
  session.world.projector_moved << 0.012, 0.022, 0, 0, 0, 0;  // 17 pixels
  const double error = true_error(session.watch, session.world, options);
  const WatchReport report = session.after(4.6);
  EXPECT_EQ(report.state, WatchState::kMoved) << report.sentence;
  EXPECT_NEAR(report.error / error, 1, 0.05);
}

/// A window of 2 s has fewer than three of these images.
TEST(Watch, AnImageEverySecondOrTwoSuffices) {
  WorldOptions options;
  options.seed = 7;
  Session session(options);
  session.period = 1.2;
  WatchReport report = session.after(8);
  EXPECT_EQ(report.state, WatchState::kOk) << report.sentence;
  session.world.projector_moved << 0.0015, 0.0030, 0.0012, 0, 0, 0;  // 0.2 degrees
  report = session.after(13);
  EXPECT_EQ(report.state, WatchState::kMoved) << report.sentence;
}

/// Content runs by at more than 400 pixels a second, and the camera sees it four milliseconds earlier or later: its shifts jump by
/// more than those of people who come and go.
TEST(Watch, FastContentSeenAtAnImpreciseMomentIsMeasured) {
  WorldOptions options;
  options.content = Content::kScroll;
  options.seed = 5;
  WatchedWorld world(options);
  Watch watch(world.rig().camera(), world.rig().projector());
  watch.place(world.surfaces());
  constexpr double kFaster = 12, kApart = 1 / 60.0;
  double jump = 0;
  Vec2 last = Vec2::Zero();
  WatchReport report;
  for (int k = 0; k < 24; ++k) {
    const double time = 0.5 + 0.2 * k, content = kFaster * time;
    const ImageU8 frame = world.draw(content), next = world.draw(content + kFaster * kApart),
                  seen = world.draw(content + kFaster * (k % 2 == 0 ? 0.004 : -0.004));
    report = watch.add(time, {frame, next, 0, kApart}, world.image(seen, time));
    if (k > 0) jump = std::max(jump, (report.median_shift - last).norm());
    last = report.median_shift;
  }
  EXPECT_GT(jump, 2);
  EXPECT_GT(report.window_time, 0);
  EXPECT_FALSE(report.is_alarm) << report.sentence;
}

TEST(Watch, APlainColourHasNoTexture) {
  WorldOptions options;
  options.content = Content::kPlain;
  Session session(options);
  const WatchReport report = session.after(1);
  EXPECT_EQ(report.state, WatchState::kNoTexture) << report.sentence;
  EXPECT_FALSE(report.is_alarm);
}

TEST(Watch, SlidesOnAnOverexposedWallGiveNoAlarm) {
  WorldOptions options;
  options.content = Content::kSlides;
  options.seed = 3;
  Session session(options);
  const WatchReport report = session.after(4.6);
  EXPECT_EQ(report.state, WatchState::kOk) << report.sentence;
  EXPECT_LT(report.error, 5e-4);
}

TEST(Watch, ACoveredCameraALampAndAnAbsentProjectorAreReported) {
  WorldOptions options;
  options.seed = 5;
  Session session(options);
  EXPECT_EQ(session.after(2.5).state, WatchState::kOk);
  session.world.covered = true;
  WatchReport report = session.after(1);
  EXPECT_EQ(report.state, WatchState::kNotSeen) << report.sentence;
  EXPECT_FALSE(report.is_alarm);
  session.world.covered = false;
  session.after(0.5);
  session.world.projector_off = true;
  report = session.after(1);
  EXPECT_EQ(report.state, WatchState::kProjectorOff) << report.sentence;
  session.world.projector_off = false;
  session.after(0.5);
  session.world.ambient_factor = 3;
  report = session.next();
  EXPECT_EQ(report.state, WatchState::kLightSwitched) << report.sentence;
  report = session.after(4.6);
  EXPECT_EQ(report.state, WatchState::kOk) << report.sentence;
  EXPECT_FALSE(report.is_alarm);
}

/// Its gain is smaller than that of the others, and its shift may be biased.
TEST(Watch, ACellInAShadowIsNotMeasured) {
  Session session(WorldOptions{});
  const ImageU8 frame = session.world.frame(0.5);
  ImageU8 image = session.world.image(frame, 0.5);
  const LightGeometry& geometry = session.watch.geometry();
  const ImageComparison before = compare(geometry, {frame, frame, 0, 0}, image);
  std::size_t shaded = geometry.cells.size() / 2;
  while (before.cells[shaded].state != CellState::kMeasured) ++shaded;
  const Vec2 centre = geometry.cells[shaded].pixel;
  for (int y = int(centre.y()) - 18; y <= int(centre.y()) + 18; ++y)
    for (int x = int(centre.x()) - 18; x <= int(centre.x()) + 18; ++x)
      image.at(x, y) = std::uint8_t(0.55 * image.at(x, y));
  const ImageComparison after = compare(geometry, {frame, frame, 0, 0}, image);
  EXPECT_EQ(after.cells[shaded].state, CellState::kMismatch);
  EXPECT_GE(after.measured, before.measured - 9);
}

/// Windows of content that stands still have their errors in common: no credit for two in a row.
TEST(Watch, TheLimitOfAWindowIsTheRateOverTheWindowsOfAWeek) {
  WatchOptions options;
  EXPECT_NEAR(Session(WorldOptions{}, options).watch.window_limit(), 2.0 / 604800, 1e-9);
  options.false_alarms_a_week = 7;
  options.window = 5;
  EXPECT_NEAR(Session(WorldOptions{}, options).watch.window_limit(), 35.0 / 604800, 1e-9);
}

/// A cut of a film changes the whole image, and nothing in the room.
TEST(Watch, ACutIsNoLampAndNoMovement) {
  WorldOptions options;
  options.seed = 6;
  options.person = true;
  Session session(options);
  session.time = 5.813;  // the cut is at seven seconds
  for (int i = 0; i < 16; ++i) {
    const WatchReport report = session.next();
    EXPECT_NE(report.state, WatchState::kLightSwitched) << report.time;
    EXPECT_FALSE(report.is_alarm);
    EXPECT_GT(report.measured, 40) << report.time;
  }
}

TEST(Watch, ImagesAndFramesOfOtherSizesAreRefused) {
  Session session(WorldOptions{});
  const ImageU8 frame = session.world.frame(0);
  const ImageU8 small(64, 64);
  EXPECT_THROW(session.watch.add(0, {frame, frame, 0, 0}, small), std::invalid_argument);
  EXPECT_THROW(session.watch.add(0, {small, small, 0, 0}, session.world.image(frame, 0)),
               std::invalid_argument);
  WatchOptions none;
  none.window = 0;
  EXPECT_THROW(Watch(session.world.rig().camera(), session.world.rig().projector(), none),
               std::invalid_argument);
}

TEST(Watch, WithoutSurfacesThereIsNoTexture) {
  Session session(WorldOptions{});
  session.watch.place({});
  EXPECT_EQ(session.next().state, WatchState::kNoTexture);
}

}  // namespace
}  // namespace procam::watch
