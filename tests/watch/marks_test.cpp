/// Marks where the content has no texture: where they are, when, and whether a plain colour can be watched with them.
#include "procam/watch/marks.hpp"

#include <gtest/gtest.h>

#include "procam/watch/correction.hpp"
#include "watched_world.hpp"

namespace procam::watch {
namespace {

using test::Content;
using test::WatchedWorld;
using test::WorldOptions;

/// One wall before the rig, with a picture; the left half may have another colour.
struct Lit {
  Rig rig = test::watched_rig();
  ImageU8 content = ImageU8(240, 160, 3, 128), mask;
  render::CpuRenderer renderer;
  Scene scene;
  ImageU8 plain, frame;

  /// The frame without marks and with those of a time.
  void draw(Marks& marks, double time) {
    const test::Wall wall = test::one_wall().front();
    PlacedPlane placed;
    placed.plane_from_content = Vec3(wall.size.x(), wall.size.y(), 1).asDiagonal();
    placed.projector_from_surface = rig.projector().rig_from_projector.inverse() * wall.rig_from_surface;
    scene.items.assign(1, {placed, content.view()});
    scene.items[0].content_revision = ++drawn_;
    scene.items[0].mask = mask.view();
    scene.items[0].mask_revision = drawn_;
    plain = ImageU8(rig.projector().projector.size(), 3);
    renderer.render(scene, rig.projector().projector, plain);
    frame = plain;
    marks.draw(time, scene, rig.projector().projector, frame);
  }
  void texture(int left, int right) {
    for (int y = 0; y < content.height(); ++y)
      for (int x = left; x < right; ++x)
        for (int c = 0; c < 3; ++c) content.at(x, y, c) = test::field(x / 4.0, y / 4.0, 7) > 0.5 ? 230 : 20;
  }
  /// Largest change of a pixel within the columns of the frame.
  int change(int left, int right) const {
    int largest = 0;
    for (int y = 0; y < frame.height(); ++y)
      for (int x = left; x < right; ++x)
        for (int c = 0; c < 3; ++c)
          largest = std::max(largest, std::abs(int(frame.at(x, y, c)) - int(plain.at(x, y, c))));
    return largest;
  }
  int change() const { return change(0, frame.width()); }
  int middle() const { return int(pixel_of(Vec2(0.5, 0.5)).x()); }
  Vec2 pixel_of(const Vec2& content_place) const {
    const test::Wall wall = test::one_wall().front();
    const Vec2 metres = content_place.cwiseProduct(wall.size);
    return *rig.projector().projector.project(rig.projector().rig_from_projector.inverse() *
                                              (wall.rig_from_surface * Vec3(metres.x(), metres.y(), 0)));
  }

 private:
  std::uint64_t drawn_ = 0;
};

TEST(Marks, TenSmallOnesAreOnAPlainColour) {
  Lit lit;
  Marks marks;
  lit.draw(marks, 5);
  int changed = 0, brighter = 0;
  for (int y = 0; y < lit.frame.height(); ++y)
    for (int x = 0; x < lit.frame.width(); ++x) {
      const int more = int(lit.frame.at(x, y, 1)) - int(lit.plain.at(x, y, 1));
      changed += more != 0;
      brighter += more > 0;
    }
  EXPECT_EQ(lit.change(), 96);
  const double disc = kPi * std::pow(0.5 * 0.03 * lit.frame.width(), 2);
  EXPECT_NEAR(changed / (10 * disc), 1, 0.12);
  EXPECT_NEAR(brighter, 0.5 * changed, 0.02 * changed);
  // A quarter of a disc below and to the right of its centre is brighter, the next one darker.
  for (const Vec2& place :
       {Vec2(1 / 11.0, 1 / 8.0), Vec2(7 / 11.0, 1 / 8.0), Vec2(10 / 11.0, 0.5), Vec2(4 / 11.0, 7 / 8.0)}) {
    const Vec2 centre = lit.pixel_of(place);
    EXPECT_EQ(lit.frame.at(int(centre.x() + 6), int(centre.y() + 6), 0), 224) << place.transpose();
    EXPECT_EQ(lit.frame.at(int(centre.x() - 5), int(centre.y() + 6), 0), 32) << place.transpose();
  }
}

TEST(Marks, ContentWithTextureHasNone) {
  Lit lit;
  lit.texture(0, 120);
  Marks marks;
  lit.draw(marks, 5);
  EXPECT_EQ(lit.change(0, lit.middle()), 0);
  EXPECT_EQ(lit.change(lit.middle(), lit.frame.width()), 96);
}

TEST(Marks, FadeInAndOut) {
  Lit lit;
  Marks marks;
  lit.draw(marks, 5);
  EXPECT_EQ(lit.change(), 96);
  lit.texture(0, 240);
  lit.draw(marks, 5.25);
  EXPECT_NEAR(lit.change(), 72, 2);
  lit.draw(marks, 6.2);
  EXPECT_EQ(lit.change(), 0);
  lit.content = ImageU8(240, 160, 3, 128);
  lit.draw(marks, 6.5);
  EXPECT_NEAR(lit.change(), 29, 2);
  lit.draw(marks, 6.0);  // a clock that is set back
  EXPECT_NEAR(lit.change(), 29, 2);
  lit.draw(marks, 60);
  EXPECT_EQ(lit.change(), 96);
}

TEST(Marks, AreOmittedWhereTheMaskIsDark) {
  Lit lit;
  lit.mask = ImageU8(100, 60, 1, 255);
  for (int y = 0; y < 60; ++y)
    for (int x = 50; x < 100; ++x) lit.mask.at(x, y) = 0;
  Marks marks;
  lit.draw(marks, 5);
  EXPECT_EQ(lit.change(0, lit.middle()), 96);
  EXPECT_EQ(lit.change(lit.middle(), lit.frame.width()), 0);
}

TEST(Marks, OptionsOutOfRangeAreRefused) {
  for (const MarkOptions& wrong :
       {MarkOptions{0, 96, 1}, MarkOptions{0.02, 300, 1}, MarkOptions{0.02, 96, 0}})
    EXPECT_THROW(Marks{wrong}, std::invalid_argument);
}

/// A show of one colour with marks, five images a second.
struct MarkedShow {
  WorldOptions options;
  WatchedWorld world;
  Watch watch;
  double time = 0.013;

  explicit MarkedShow(const std::array<int, 3>& colour)
      : options(marked(colour)), world(options), watch(world.rig().camera(), world.rig().projector()) {
    watch.place(world.surfaces());
  }
  static WorldOptions marked(const std::array<int, 3>& colour) {
    WorldOptions options;
    options.content = Content::kPlain;
    options.plain = colour;
    options.marks = true;
    options.seed = 3;
    return options;
  }
  WatchReport next() {
    const ImageU8 frame = world.frame(time);
    const WatchReport report = watch.add(time, {frame, frame, 0, 0}, world.image(frame, time));
    time += 0.2;
    return report;
  }
  WatchReport after(double seconds) {
    WatchReport report = next();
    for (const double end = time + seconds - 0.25; time < end;) report = next();
    return report;
  }
};

TEST(Marks, ABumpBeforeAPlainColourIsFoundAndCorrected) {
  for (const std::array<int, 3>& colour : {std::array<int, 3>{255, 255, 255}, {120, 124, 128}, {4, 3, 6}}) {
    MarkedShow show(colour);
    WatchReport report = show.after(4.5);
    EXPECT_EQ(report.state, WatchState::kOk) << colour[0] << ": " << report.sentence;
    show.world.projector_moved << 0.0015, 0.0030, 0.0012, 0, 0, 0;  // 0.2 degrees
    const double bumped = show.time;
    while (!report.is_alarm && show.time < bumped + 10) report = show.next();
    ASSERT_TRUE(report.is_alarm) << colour[0] << ": " << report.sentence;
    const Correction correction = correction_of(report, show.watch.projector());
    ASSERT_TRUE(correction.is_possible()) << colour[0] << ": " << correction.sentence;
    EXPECT_GT(true_error(show.watch, show.world, show.options), 5e-3);
    show.watch.correct(correction.projector, correction.covariance);
    EXPECT_LT(true_error(show.watch, show.world, show.options), 5e-4) << colour[0];
  }
}

TEST(Marks, ACoveredCameraALampAndAnAbsentProjectorAreReported) {
  MarkedShow show({200, 205, 210});
  EXPECT_EQ(show.after(2.5).state, WatchState::kOk);
  show.world.covered = true;
  EXPECT_EQ(show.after(1).state, WatchState::kNotSeen);
  show.world.covered = false;
  show.after(0.5);
  show.world.projector_off = true;
  EXPECT_EQ(show.after(1).state, WatchState::kProjectorOff);
  show.world.projector_off = false;
  show.after(0.5);
  show.world.ambient_factor = 3;
  EXPECT_EQ(show.next().state, WatchState::kLightSwitched);
  EXPECT_EQ(show.after(4.6).state, WatchState::kOk);
}

}  // namespace
}  // namespace procam::watch
