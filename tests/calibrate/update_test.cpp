/// A rig refreshed by one or two views after a bump, a zoom or a focus.
#include "procam/calibrate/update.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/expect_error.hpp"
#include "support/numeric_fleet.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericFleet;
using test::NumericWorld;

constexpr double kCameraSigma = 0.06, kLightSigma = 0.15;

Rig true_rig(const NumericWorld& world) {
  Rig rig;
  rig.cameras = {{"camera", world.camera, Pose()}};
  rig.projectors = {{"projector", world.projector, world.projector_from_camera.inverse()}};
  return rig;
}

/// Ten views of a rig, and the rig that they give.
struct Calibrated {
  NumericWorld world;
  Rig rig;

  explicit Calibrated(std::uint64_t seed, int views = 10)
      : world(NumericWorld::make_rig(views, seed, kCameraSigma, kLightSigma)),
        rig(calibrate_rig(world.with_light_read_at_corners(seed + 1)).rig) {}

  /// Views after a change of the world.
  Correspondences views(int count, std::uint64_t seed) const {
    NumericWorld now = world;
    now.camera_from_board.clear();
    now.place_boards(count, seed);
    return now.with_light_read_at_corners(seed + 1);
  }

  /// 0.25 degrees and 2.5 mm.
  void bump() {
    const Vec3 turn = Vec3(0.6, -0.7, 0.4).normalized() * 0.25 * kDegree;
    const Vec3 shift = Vec3(-0.5, 0.3, 0.8).normalized() * 0.0025;
    world.projector_from_camera = Pose(so3_exp<double>(turn), shift) * world.projector_from_camera;
  }
  void zoom(double factor) {
    Intrinsics& k = world.projector.inverse_camera.intrinsics;
    k.fx *= factor, k.fy *= factor;
    k.cy += 300 * (factor - 1);  // the lens is shifted: its principal point moves along
  }

  double true_rms_mm() const { return rms_mm(rig); }
  double rms_mm(const Rig& estimated) const {
    return analyze::true_light_errors(estimated, true_rig(world), 2)
        .of(analyze::SurfaceLocated::kByCamera)
        .rms_mm;
  }
};

UpdateOptions changed(std::vector<RigChange> changes) {
  UpdateOptions options;
  options.changed = std::move(changes);
  return options;
}
const RigChange kBump{"projector", RigChange::Kind::kPose}, kZoom{"projector", RigChange::Kind::kZoom},
    kFocus{"projector", RigChange::Kind::kFocus};

/// Of an estimate, the squared errors of all parameters in sigmas.
std::vector<double> scores(const Rig& estimated, const Rig& truth) {
  std::vector<double> out;
  const auto add = [&](const std::string& name, double error) {
    if (const double sigma = estimated.covariance.sigma(name); sigma > 0) out.push_back(error / sigma);
  };
  const auto add_lens = [&](const std::string& device, const Camera& lens, const Camera& true_lens) {
    const VecX difference = parameters_of(lens) - parameters_of(true_lens);
    const std::vector<std::string> names = parameter_names(lens);
    for (std::size_t i = 0; i < names.size(); ++i) add(device + "." + names[i], difference[Eigen::Index(i)]);
  };
  add_lens("camera", estimated.camera().camera, truth.camera().camera);
  add_lens("projector", estimated.projector().projector.inverse_camera,
           truth.projector().projector.inverse_camera);
  const Vec6 xi =
      se3_log(estimated.projector().rig_from_projector * truth.projector().rig_from_projector.inverse());
  const auto names = pose_increment_names("rig_from_projector");
  for (int i = 0; i < 6; ++i) add(names[std::size_t(i)], xi[i]);
  return out;
}

TEST(UpdateRig, OneViewFindsABump) {
  Calibrated old(41);
  old.bump();
  ASSERT_GT(old.true_rms_mm(), 5);
  const UpdateResult fresh = update_rig(old.rig, old.views(1, 900), changed({kBump}));
  EXPECT_LT(old.rms_mm(fresh.rig), 0.5);
  ASSERT_EQ(fresh.changes.size(), 1U);
  const DeviceChange& change = fresh.changes.front();
  EXPECT_NEAR(change.rotation / kDegree, 0.25, 3 * change.rotation_sigma / kDegree);
  EXPECT_NEAR(change.translation, 0.0025, 3 * change.translation_sigma);
  EXPECT_LT(change.rotation_sigma / kDegree, 0.06);
  EXPECT_TRUE(fresh.rig.quality.passed());
  EXPECT_EQ(fresh.rig.quality.views_used, 11);
}

/// Errors of one rig are correlated: over 24 rigs the share inside 2 sigma of right covariances has a standard
/// deviation of about 1.5 %; below 0.90 or above 0.99 chance comes in less than one of a thousand suites.
TEST(UpdateRig, CovarianceHoldsAfterBumpsAndZooms) {
  int inside = 0, count = 0;
  double squares = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Calibrated old(5000 + 10 * seed, 8);
    old.bump();
    const bool zooms = seed % 2 == 1;
    if (zooms) old.zoom(seed % 4 == 1 ? 1.06 : 0.93);
    const UpdateResult fresh = update_rig(old.rig, old.views(2, 7000 + seed),
                                          changed(zooms ? std::vector{kBump, kZoom} : std::vector{kBump}));
    for (const double score : scores(fresh.rig, true_rig(old.world)))
      inside += std::abs(score) < 2, squares += score * score, ++count;
  }
  const double share = double(inside) / count;
  EXPECT_GT(share, 0.90) << squares / count;
  EXPECT_LT(share, 0.99) << squares / count;
}

TEST(UpdateRig, AZoomNeedsOneTiltedView) {
  Calibrated old(43);
  old.zoom(1.05);
  const UpdateResult fresh = update_rig(old.rig, old.views(1, 901), changed({kZoom}));
  EXPECT_LT(old.rms_mm(fresh.rig), 0.5);
  EXPECT_NEAR(fresh.changes.front().focal_ratio, 1.05, 3 * fresh.changes.front().focal_ratio_sigma);
  EXPECT_LT(fresh.changes.front().focal_ratio_sigma, 0.003);
}

TEST(UpdateRig, NothingChangedRefinesTheRig) {
  const Calibrated old(44, 5);
  const UpdateResult fresh = update_rig(old.rig, old.views(2, 902), {});
  for (const std::string& name : fresh.rig.covariance.names)
    EXPECT_LE(fresh.rig.covariance.sigma(name), old.rig.covariance.sigma(name) * 1.001) << name;
  EXPECT_LT(fresh.rig.covariance.sigma("projector.fx"), 0.9 * old.rig.covariance.sigma("projector.fx"));
  EXPECT_TRUE(fresh.diagnostics.items.empty()) << fresh.diagnostics.items.front().message;
}

std::string refusal(const Calibrated& old, const Correspondences& views, const UpdateOptions& options) {
  try {
    update_rig(old.rig, views, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDegenerate);
    return error.what();
  }
  return "accepted";
}

TEST(UpdateRig, AChangeThatWasNotStatedIsNamed) {
  Calibrated bumped(45);
  bumped.bump();
  EXPECT_NE(refusal(bumped, bumped.views(2, 903), {}).find("state --changed projector:pose"),
            std::string::npos)
      << refusal(bumped, bumped.views(2, 903), {});
  Calibrated zoomed(46);
  zoomed.zoom(1.08);
  const std::string why = refusal(zoomed, zoomed.views(2, 904), changed({kBump}));
  EXPECT_NE(why.find("state --changed projector:zoom "), std::string::npos) << why;
  zoomed.bump();  // both
  const std::string both = refusal(zoomed, zoomed.views(3, 910), changed({kBump}));
  EXPECT_NE(both.find("state --changed projector:pose,projector:zoom "), std::string::npos) << both;
}

TEST(UpdateRig, AViewThatContradictsTheOthersIsRejected) {
  Calibrated old(47);
  old.bump();
  Correspondences views = old.views(3, 905);
  for (Observation& light : views.views[1].observations[1])
    light.pixel += Vec2(7, -4);  // moved before the patterns
  const UpdateResult fresh = update_rig(old.rig, views, changed({kBump}));
  EXPECT_TRUE(fresh.views[0].used);
  EXPECT_FALSE(fresh.views[1].used);
  EXPECT_NE(fresh.views[1].note.find("projector"), std::string::npos) << fresh.views[1].note;
  EXPECT_TRUE(fresh.views[2].used);
  EXPECT_LT(old.rms_mm(fresh.rig), 0.5);
}

TEST(UpdateRig, SingleBlundersAreRejected) {
  Calibrated old(48);
  old.bump();
  Correspondences views = old.views(1, 906);
  for (const std::size_t i : {3U, 17U, 40U}) views.views[0].observations[1][i].pixel += Vec2(-60, 25);
  const UpdateResult fresh = update_rig(old.rig, views, changed({kBump}));
  EXPECT_LT(old.rms_mm(fresh.rig), 1.2);
  EXPECT_LT(fresh.views[0].rms_px[1], 0.5);
}

/// A board that faces the projector moves like a zoom.
TEST(UpdateRig, AZoomThatHidesInABumpIsSaid) {
  Calibrated old(49);
  old.bump();
  NumericWorld facing = old.world;
  facing.camera_from_board = {Pose(so3_exp<double>(Vec3(-0.05, 0.09, 0.02)), Vec3(-0.17, -0.1, 1.3))};
  const auto said = [&](const Correspondences& views) {
    const UpdateResult fresh = update_rig(old.rig, views, changed({kBump}));
    return std::any_of(fresh.diagnostics.items.begin(), fresh.diagnostics.items.end(),
                       [](const Diagnostic& one) { return one.code == "zoom_not_tested"; });
  };
  EXPECT_TRUE(said(facing.with_light_read_at_corners(3)));
  EXPECT_FALSE(said(old.views(3, 907)));
}

/// The first camera carries the rig's frame; devices that no view shows follow it.
TEST(UpdateRig, ABumpOfTheFirstCameraMovesAllOthers) {
  const std::vector<test::Cast> all(9, {0, 1, 2, 3});
  NumericFleet fleet = NumericFleet::make(all, 51, kCameraSigma, kLightSigma);
  Options flat;
  flat.board_shape = BoardShape::kFlat;
  const Rig before = calibrate_rig(fleet.correspondences(52), flat).rig;
  const Pose motion(so3_exp<double>(Vec3(0.003, -0.002, 0.004)), Vec3(0.002, -0.001, 0.003));
  fleet.rig.cameras[1].rig_from_camera = motion * fleet.rig.cameras[1].rig_from_camera;
  for (RigProjector& p : fleet.rig.projectors) p.rig_from_projector = motion * p.rig_from_projector;
  NumericFleet now = NumericFleet::make({{0, 1, 2}}, 53, kCameraSigma, kLightSigma);
  now.rig = fleet.rig;
  const UpdateResult fresh =
      update_rig(before, now.correspondences(54), changed({{"left", RigChange::Kind::kPose}}));
  const auto error_mm = [&](const Rig& rig) {
    return 1e3 * (rig.projector("beamer").rig_from_projector.translation -
                  fleet.rig.projector("beamer").rig_from_projector.translation)
                     .norm();
  };
  EXPECT_GT(error_mm(before), 2.5);
  EXPECT_LT(error_mm(fresh.rig), 0.6 * error_mm(before));  // never shown by the new view
}

TEST(UpdateRig, RefusesUnusableInput) {
  const Calibrated old(55, 5);
  const Correspondences views = old.views(1, 908);
  Rig bare = old.rig;
  bare.covariance = {};
  EXPECT_THROW(update_rig(bare, views, {}), Error);
  EXPECT_THROW(update_rig(old.rig, views, changed({{"beamer", RigChange::Kind::kZoom}})), Error);
  Correspondences other = views;
  other.devices[1].size = {800, 600};
  EXPECT_THROW(update_rig(old.rig, other, {}), Error);
  Correspondences none = views;
  none.views.clear();
  EXPECT_THROW(update_rig(old.rig, none, {}), Error);
  Correspondences dark = views;
  dark.views[0].observations[1].clear();
  EXPECT_ERROR(update_rig(old.rig, dark, changed({kBump})), kNotEnoughData, "0 points of it");
  Correspondences few = views;
  few.views[0].observations[0].resize(3);
  EXPECT_THROW(update_rig(old.rig, few, {}), Error);
}

}  // namespace
}  // namespace procam::calibrate
