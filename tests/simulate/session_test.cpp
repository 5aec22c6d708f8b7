#include "procam/simulate/session.hpp"

#include <gtest/gtest.h>
#include "sheet_points.hpp"

namespace procam::simulate {
namespace {

class SessionLaws : public testing::TestWithParam<Level> {};

TEST_P(SessionLaws, EveryViewShowsTheWholeBoardLit) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSession session = make_session(GetParam(), seed);
    ASSERT_GE(session.views.size(), 6u);
    int partly_lit = 0;
    for (const World& world : session.views) {
      const std::size_t all = points_in_board(world.board.layout).size();
      EXPECT_EQ(board_in_camera(world).size(), all);
      const std::size_t lit = board_in_projector(world).size();
      EXPECT_GE(2 * lit, all);
      partly_lit += lit < all;
    }
    EXPECT_EQ(partly_lit, GetParam() == Level::kHard ? 4 : 0);
  }
}

TEST_P(SessionLaws, RigIsLopsided) {
  const Rig rig = make_session(GetParam(), 3).rig();
  for (const Camera& device : {rig.camera().camera, rig.projector().projector.inverse_camera}) {
    EXPECT_NE(device.intrinsics.fx, device.intrinsics.fy);
    EXPECT_GT(std::abs(device.intrinsics.cx - 0.5 * (device.size.width - 1)), 1.0);
    EXPECT_GT(std::abs(device.intrinsics.cy - 0.5 * (device.size.height - 1)), 1.0);
  }
  // No camera ray meets a fold of the lens: every pixel of the border has a bearing.
  const Camera& camera = rig.camera().camera;
  for (int x = 0; x < camera.size.width; x += 16) {
    EXPECT_TRUE(camera.unproject(Vec2(x, 0)));
    EXPECT_TRUE(camera.unproject(Vec2(x, camera.size.height - 1)));
  }
}

TEST_P(SessionLaws, SeedDecidesEverything) {
  const SimulatedSession a = make_session(GetParam(), 7), b = make_session(GetParam(), 7),
                         c = make_session(GetParam(), 8);
  EXPECT_EQ(parameters_of(a.rig().camera().camera), parameters_of(b.rig().camera().camera));
  EXPECT_NE(parameters_of(a.rig().camera().camera), parameters_of(c.rig().camera().camera));
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].rig_from_board.matrix(), b.views[i].rig_from_board.matrix());
    EXPECT_NE(a.views[i].rig_from_board.matrix(), c.views[i].rig_from_board.matrix());
  }
}

TEST_P(SessionLaws, NameComesBack) {
  EXPECT_EQ(level_named(to_string(GetParam())), GetParam());
}

TEST_P(SessionLaws, BlankPaperTakesThePatternBesideThePrint) {
  const Eigen::AlignedBox2d box(Vec2(63.5, 31.5), Vec2(959.5, 735.5));
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSession session = make_session(GetParam(), seed, box);
    ASSERT_EQ(session.views.size(), 18u);
    for (const World& world : session.views) {
      EXPECT_EQ(board_in_camera(world).size(), points_in_board(world.board.layout).size());
      const double print_right = print_of(world.board.layout).high.x();
      for (double u = box.min().x(); u <= box.max().x(); u += 128)
        for (double v = box.min().y(); v <= box.max().y(); v += 176) {
          const auto place = light_on_sheet(world, Vec2(u, v));
          ASSERT_TRUE(place && camera_pixel_of_light(world, Vec2(u, v)));
          EXPECT_GT(place->x(), print_right);
          // The way back: the projector pixel that lights what the camera sees there.
          const auto back = projector_pixel_seen_at(world, *camera_pixel_of_light(world, Vec2(u, v)));
          ASSERT_TRUE(back);
          EXPECT_LT((*back - Vec2(u, v)).norm(), 1e-6);
        }
    }
  }
}

/// The drawing does not matter to where things are.
TEST_P(SessionLaws, BoardsWithMarkersLeaveTheImageInEveryThirdView) {
  const CharucoBoard charuco{8, 6, 0.04, 0.03, MarkerDictionary::k5x5_100};
  const SimulatedSession session = make_session(GetParam(), 2, std::nullopt, BoardPrint{charuco});
  for (std::size_t v = 0; v < session.views.size(); ++v) {
    const World& world = session.views[v];
    EXPECT_EQ(std::get<CharucoBoard>(world.board.layout), charuco);
    const std::size_t seen = board_in_camera(world).size();
    if (v % 3 != 1) {
      EXPECT_EQ(seen, 35u) << v;
    } else {
      EXPECT_TRUE(seen >= 14 && seen <= 29) << v << ": " << seen;
    }
  }
  EXPECT_THROW(make_session(GetParam(), 2, std::nullopt, BoardPrint{Chessboard{10, 7, 0.3}}), Error);
}

INSTANTIATE_TEST_SUITE_P(AllLevels, SessionLaws, testing::Values(Level::kEasy, Level::kPaper, Level::kHard),
                         [](const auto& level) { return to_string(level.param); });

double skew(const Camera& camera) {
  return camera.intrinsics.skew;
}
double k3(const Camera& camera) {
  return std::get<BrownConrady>(camera.distortion).coefficients[4];
}

TEST(Session, PaperAndHardDepartFromWhatCalibrationAssumes) {
  bool positive = false, negative = false;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const Level level : {Level::kPaper, Level::kHard}) {
      const SimulatedSession session = make_session(level, seed);
      for (const Camera& lens :
           {session.rig().camera().camera, session.rig().projector().projector.inverse_camera}) {
        EXPECT_GE(std::abs(skew(lens)), 1);
        EXPECT_LE(std::abs(skew(lens)), 5);
        EXPECT_GT(std::abs(k3(lens)), 0.004);
        (skew(lens) > 0 ? positive : negative) = true;
      }
      EXPECT_GE(session.capture.gamma, 1.8);
      EXPECT_LE(session.capture.gamma, 2.2);
      int moved = 0, stale = 0, dark = 0, bright = 0;
      for (const ViewDefects& defects : session.defects) {
        moved += defects.moved.has_value(), stale += defects.stale.has_value();
        dark += defects.white && *defects.white >= 0.22 && *defects.white <= 0.35;
        bright += defects.white && *defects.white > 1;
      }
      const bool hard = level == Level::kHard;
      EXPECT_EQ(moved, hard);
      EXPECT_EQ(stale, hard);
      EXPECT_EQ(bright, hard);
      EXPECT_EQ(dark, hard ? 4 : 0);
    }
  }
  EXPECT_TRUE(positive && negative);
  const SimulatedSession easy = make_session(Level::kEasy, 3);
  EXPECT_EQ(skew(easy.rig().camera().camera), 0);
  EXPECT_EQ(easy.capture.gamma, 1);
}

TEST(Session, ABentSheetIsLitAndSeenWhereItIs) {
  Conditions conditions = level_conditions(Level::kPaper);
  const Eigen::AlignedBox2d box(Vec2(63.5, 31.5), Vec2(959.5, 735.5));
  const SimulatedSession flat = make_session(Level::kPaper, 5, box, {}, conditions);
  conditions.bend = {0.006, 0.006};
  const SimulatedSession session = make_session(Level::kPaper, 5, box, {}, conditions);
  const World& world = session.views.front();
  const BentSheet& sheet = world.board.sheet;
  // A cylinder that is 6 mm high half a metre from its middle, across its axis.
  EXPECT_NEAR(sheet.curvature[0] + sheet.curvature[2], 8 * 0.006, 1e-12);
  EXPECT_NEAR(sheet.curvature[0] * sheet.curvature[2], sheet.curvature[1] * sheet.curvature[1], 1e-12);
  EXPECT_EQ(session.rig().camera().camera.intrinsics.fx, flat.rig().camera().camera.intrinsics.fx);
  const Vec2 shown(700.25, 400.5);
  const auto place = light_on_sheet(world, shown), seen = camera_pixel_of_light(world, shown);
  ASSERT_TRUE(place && seen);
  EXPECT_GT(std::abs(sheet.height(*place)), 0.001);
  const auto back = projector_pixel_seen_at(world, *seen);
  ASSERT_TRUE(back);
  EXPECT_LT((*back - shown).norm(), 1e-6);
  World as_flat = world;
  as_flat.board.sheet.curvature.setZero();
  EXPECT_GT((*camera_pixel_of_light(as_flat, shown) - *seen).norm(), 0.3);
}

/// Each view has a bend of its own beside the common one: cylinders whose rise half a metre from the middle has the RMS that was
/// asked for. Of 72 uniform draws it lies within 20 % of that, four standard errors.
TEST(Session, ASheetThatFlexesBendsAnewInEachView) {
  double squares = 0;
  int views = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Conditions conditions = level_conditions(Level::kPaper);
    conditions.bend = {0.004, 0.004};
    conditions.views = 18;
    const SimulatedSession still = make_session(Level::kPaper, seed, {}, {}, conditions);
    conditions.flex = 0.001;
    const SimulatedSession session = make_session(Level::kPaper, seed, {}, {}, conditions);
    const Vec3 common = still.views.front().board.sheet.curvature;
    for (const World& world : session.views) {
      const Vec3 flex = world.board.sheet.curvature - common;
      EXPECT_NEAR(flex[0] * flex[2], flex[1] * flex[1], 1e-12);
      const double rise = (flex[0] + flex[2]) / 8;
      EXPECT_LE(std::abs(rise), std::sqrt(3.0) * 0.001);
      squares += rise * rise, ++views;
    }
    for (const World& world : still.views) EXPECT_EQ(world.board.sheet.curvature, common);
    EXPECT_EQ(session.rig().camera().camera.intrinsics.fx, still.rig().camera().camera.intrinsics.fx);
  }
  EXPECT_NEAR(std::sqrt(squares / views), 0.001, 0.0002);
}

/// A camera that focuses and is stabilised anew in each view, by the RMS given (of 72 numbers: within four standard errors),
/// about a rig that stays as it is.
TEST(Session, CamerasFocusAnewInEachView) {
  Vec3 squares = Vec3::Zero();
  double views = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Conditions conditions = level_conditions(Level::kPaper);
    conditions.views = 18;
    const SimulatedSession still = make_session(Level::kPaper, seed, {}, {}, conditions);
    EXPECT_TRUE(still.lenses.empty());
    conditions.refocus = 0.004;
    conditions.stabiliser_px = 3;
    const SimulatedSession session = make_session(Level::kPaper, seed, {}, {}, conditions);
    const Intrinsics& k = still.rig().camera().camera.intrinsics;
    EXPECT_EQ(session.rig().camera().camera.intrinsics.fx, k.fx);
    EXPECT_EQ(session.rig().camera().camera.intrinsics.cx, k.cx);
    ASSERT_EQ(session.lenses.size(), session.views.size());
    for (std::size_t v = 0; v < session.views.size(); ++v) {
      const Intrinsics& of_view = session.lenses[v].intrinsics;
      EXPECT_NEAR(of_view.fy / k.fy, of_view.fx / k.fx, 1e-12);
      EXPECT_NEAR(of_view.skew, k.skew * of_view.fx / k.fx, 1e-9);
      squares += Vec3(of_view.fx / k.fx - 1, of_view.cx - k.cx, of_view.cy - k.cy).cwiseAbs2();
      ++views;
      EXPECT_EQ(session.views[v].rig_from_board.translation, still.views[v].rig_from_board.translation);
    }
  }
  EXPECT_NEAR(std::sqrt(squares[0] / views), 0.004, 0.0008);
  EXPECT_NEAR(std::sqrt(squares[1] / views), 3, 0.6);
  EXPECT_NEAR(std::sqrt(squares[2] / views), 3, 0.6);
}

/// Its captures are those of its own lens: of a principal point 3 px further right, they are shifted by 3 px.
TEST(Session, CapturesHaveTheLensOfTheirView) {
  Conditions conditions = plain_conditions();
  conditions.views = 2;
  SimulatedSession session = make_session(Level::kEasy, 3, {}, {}, conditions);
  session.capture.noise = {0, 0};
  const ImageSize size = session.rig().projector().projector.size();
  const auto second_view = [&] {
    return capture_view(session, 1, {ImageU8(size.width, size.height, 1, 255)}).front();
  };
  const ImageU8 still = second_view();
  session.lenses.assign(2, session.rig().camera().camera);
  session.lenses[0].intrinsics.cx += 40;
  const ImageU8 of_other = second_view();
  EXPECT_TRUE(std::equal(still.data(), still.data() + still.width() * still.height(), of_other.data()));
  session.lenses[1].intrinsics.cx += 3;
  const ImageU8 moved = second_view();
  int largest = 0, differ = 0;
  for (int y = 0; y < moved.height(); ++y)
    for (int x = 3; x < moved.width(); ++x) {
      largest = std::max(largest, std::abs(int(moved.at(x, y)) - int(still.at(x - 3, y))));
      differ += std::abs(int(moved.at(x, y)) - int(still.at(x, y))) > 20;
    }
  EXPECT_LE(largest, 5);
  EXPECT_GT(differ, 1000);
}

/// A study of one factor changes that factor alone.
TEST(Session, ConditionsDoNotMoveTheRest) {
  Conditions conditions = level_conditions(Level::kHard);
  const SimulatedSession level = make_session(Level::kHard, 5, {}, {}, conditions);
  conditions.glare = 0;
  conditions.gamma = {2.2, 2.2};
  conditions.camera_skew_px = Range{3, 3};
  conditions.print_scale = 0.98;
  const SimulatedSession changed = make_session(Level::kHard, 5, {}, {}, conditions);
  EXPECT_EQ(changed.capture.glare, 0);
  EXPECT_EQ(changed.capture.gamma, 2.2);
  EXPECT_EQ(skew(changed.rig().camera().camera), 3);
  EXPECT_EQ(k3(changed.rig().camera().camera), k3(level.rig().camera().camera));
  EXPECT_EQ(changed.rig().camera().camera.intrinsics.fx, level.rig().camera().camera.intrinsics.fx);
  EXPECT_EQ(changed.capture.projector_lens.focus, level.capture.projector_lens.focus);
  EXPECT_EQ(changed.capture.indirect, level.capture.indirect);
  EXPECT_EQ(std::get<Chessboard>(changed.stated_board), std::get<Chessboard>(level.board().layout));
  EXPECT_EQ(std::get<Chessboard>(changed.board().layout).square_size, 0.98 * 0.034);
  EXPECT_THROW(
      [&] {
        conditions.finest_contrast = 0;
        make_session(Level::kHard, 5, {}, {}, conditions);
      }(),
      std::invalid_argument);
}

/// The finest Gray-code stripes, two projector pixels wide, on a sheet where the projector is most out of
/// focus.
TEST(Session, DefocusLeavesTheFinestStripesTheirContrast) {
  Conditions conditions = plain_conditions();
  conditions.finest_contrast = 0.2;
  SimulatedSession session = make_session(Level::kPaper, 4, {}, {}, conditions);
  session.capture.noise = {0, 0};
  session.capture.camera_blur_px = 0;
  const ThinLens& lens = session.capture.projector_lens;
  World world = session.views.front();
  world.ambient = 0;
  world.board.black_albedo = world.board.white_albedo;
  const double depth =
      std::abs(1 / 1.08 - 1 / lens.focus) > std::abs(1 / 2.42 - 1 / lens.focus) ? 1.08 : 2.42;
  const Pose& rig_from_projector = world.rig.projector().rig_from_projector;
  const Vec2 middle = 0.5 * (print_of(world.board.layout).low + print_of(world.board.layout).high);
  const Vec3 on_sheet =
      depth * world.rig.projector().projector.inverse_camera.unproject(Vec2(512, 384))->normalized();
  const Vec3 offset(-middle.x(), -middle.y(), 0);
  world.rig_from_board =
      Pose(rig_from_projector.rotation, rig_from_projector * (on_sheet / on_sheet.z() * depth + offset));
  // The camera looks from the projector, and its pixels are small against a stripe.
  RigCamera& eye = world.rig.cameras.front();
  eye.rig_from_camera = rig_from_projector;
  Intrinsics& k = eye.camera.intrinsics;
  k = {8000, 8000, 640 - 8000 * on_sheet.x() / on_sheet.z(), 480 - 8000 * on_sheet.y() / on_sheet.z(), 0};
  eye.camera.distortion = NoDistortion{};
  ImageU8 stripes(world.rig.projector().projector.size());
  for (int y = 0; y < stripes.height(); ++y)
    for (int x = 0; x < stripes.width(); ++x) stripes.at(x, y) = x % 4 < 2 ? 255 : 0;
  const ImageU8 seen = capture(world, {stripes}, session.capture).front();
  int low = 255, high = 0;
  for (int i = -30; i <= 30; ++i) {
    const int value = seen.at(640 + i, 480);
    low = std::min(low, value), high = std::max(high, value);
  }
  EXPECT_NEAR(double(high - low) / (high + low), 0.2, 0.04);
}

TEST(Session, DefectsOfAViewAreInItsCaptures) {
  Conditions conditions = plain_conditions();
  conditions.stale_views = conditions.moved_views = 1;
  SimulatedSession session = make_session(Level::kEasy, 6, {}, {}, conditions);
  session.capture.noise = {0, 0};
  session.capture.samples_per_axis = 1;
  const ImageSize size = session.rig().projector().projector.size();
  std::vector<ImageU8> frames;
  for (int i = 0; i < 10; ++i) frames.emplace_back(size.width, size.height, 1, std::uint8_t(25 * i));
  for (std::size_t v = 0; v < session.views.size(); ++v) {
    const ViewDefects& defects = session.defects[v];
    if (defects.empty()) continue;
    const std::vector<ImageU8> with = capture_view(session, v, frames);
    SimulatedSession sound = session;
    sound.defects.clear();
    const std::vector<ImageU8> without = capture_view(sound, v, frames);
    for (int i = 0; i < 10; ++i) {
      const bool same = std::equal(with[std::size_t(i)].data(), with[std::size_t(i)].data() + 1280 * 1024,
                                   without[std::size_t(i)].data());
      if (defects.stale)
        EXPECT_EQ(same, i != frame_at(*defects.stale, 10)) << i;
      else
        EXPECT_EQ(same, i < frame_at(defects.moved->share, 10)) << i;
    }
    EXPECT_NE(description(defects, 10), "");
  }
}

TEST(Session, RefusesAnUnknownLevel) {
  EXPECT_THROW(level_named("medium"), Error);
}

}  // namespace
}  // namespace procam::simulate
