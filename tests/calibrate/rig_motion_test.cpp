/// A projector that was moved, or a lens that was zoomed, while the session was captured, by too little for a view to be
/// rejected; and by so much that views are.
#include <gtest/gtest.h>

#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

Options flat_options() {
  Options options;
  options.board_shape = BoardShape::kFlat;
  return options;
}

/// The session of one world up to a view, and of another one from it on.
Correspondences exchanged_from(std::size_t view, const NumericWorld& before, const NumericWorld& after,
                               std::uint64_t seed) {
  Correspondences data = before.correspondences(seed);
  const Correspondences later = after.correspondences(seed + 1);
  for (std::size_t v = view; v < data.views.size(); ++v) data.views[v] = later.views[v];
  return data;
}

/// The projector stands elsewhere from a view on.
Correspondences moved_from(const NumericWorld& world, std::size_t view, const Pose& motion,
                           std::uint64_t seed) {
  NumericWorld after = world;
  after.projector_from_camera = motion * world.projector_from_camera;
  return exchanged_from(view, world, after, seed);
}

/// Nudged by 0.05 degrees and 2 mm, a pixel or two of light: no view is rejected.
TEST(RigMotion, IsReportedWithItsInstant) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(10, 40 + seed, 0.05, 0.08);
    const std::size_t from = 4 + seed % 3;
    const CalibrationResult result = calibrate_rig(
        moved_from(world, from, Pose(so3_exp<double>(Vec3(0.0004, -0.0008, 0.0002)), Vec3(0.002, 0, 0.001)),
                   50 + seed),
        flat_options());
    const Diagnostic* remark = result.diagnostics.find("device_moved");
    ASSERT_NE(remark, nullptr) << seed;
    EXPECT_NE(remark->message.find("projector stands elsewhere from view view_" + std::to_string(from)),
              std::string::npos)
        << remark->message;
  }
}

/// Moved by 5 mm half way, so that the views of one half are rejected: one motion of the projector explains
/// them all. Seen from each view alone these motions differ by millimetres and tenths of a degree.
TEST(RigMotion, IsReportedWhereItsViewsAreRejected) {
  const Pose motion(Eigen::Quaterniond::Identity(), Vec3(0.8, 0.5, 0.33).normalized() * 0.005);
  for (const std::uint64_t seed : {0, 5, 6, 8}) {
    const NumericWorld world = NumericWorld::make_rig(7, 7007 + 97 * seed, 0.05, 0.08);
    const CalibrationResult result = calibrate_rig(moved_from(world, 3, motion, seed + 1), flat_options());
    EXPECT_NE(result.diagnostics.find("view_left_out"), nullptr) << seed;
    const Diagnostic* remark = result.diagnostics.find("device_moved");
    ASSERT_NE(remark, nullptr) << seed;
    EXPECT_NE(remark->message.find("projector stands elsewhere in views"), std::string::npos)
        << remark->message;
  }
}

/// A device's lens is zoomed from a view on, about a point that is no principal point.
Correspondences zoomed_from(const NumericWorld& world, std::size_t view, DeviceKind kind, double share,
                            std::uint64_t seed) {
  NumericWorld after = world;
  Intrinsics& k =
      kind == DeviceKind::kCamera ? after.camera.intrinsics : after.projector.inverse_camera.intrinsics;
  k.fx *= 1 + share, k.fy *= 1 + share, k.cx += 60 * share, k.cy -= 40 * share;
  return exchanged_from(view, world, after, seed);
}

/// Zoomed by 0.3 % either way, a pixel or two at the border. The rig has the mean of the two lenses, and its covariance holds
/// both: each is half a step away, or less where up to three causes share the step.
TEST(RigMotion, AZoomIsNoMotion) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(10, 340 + seed, 0.05, 0.08);
    const bool of_camera = seed % 2 == 1;
    const std::string device = of_camera ? "camera" : "projector";
    const double share = seed % 4 < 2 ? 0.003 : -0.003;
    const CalibrationResult result = calibrate_rig(
        zoomed_from(world, 5, of_camera ? DeviceKind::kCamera : DeviceKind::kProjector, share, 50 + seed),
        flat_options());
    // The views do not always separate a zoom from a motion of the projector: then both are named.
    const Diagnostic* remark = result.diagnostics.find("lens_changed");
    if (remark == nullptr) remark = result.diagnostics.find("device_moved");
    ASSERT_NE(remark, nullptr) << seed;
    EXPECT_NE(
        remark->message.find(device + "'s lens changed between view view_4 and view view_5 (focal length " +
                             (share > 0 ? "+0." : "-0.")),
        std::string::npos)
        << remark->message;
    const Intrinsics& k = of_camera ? world.camera.intrinsics : world.projector.inverse_camera.intrinsics;
    EXPECT_GT(result.rig.covariance.sigma(device + ".fx"), 0.15 * 0.003 * k.fx) << seed;
  }
}

/// Zoomed by 3 %: the views of one half are rejected.
TEST(RigMotion, AZoomThatRejectsViewsIsNamed) {
  for (const std::uint64_t seed : {0, 5, 6, 8}) {
    const NumericWorld world = NumericWorld::make_rig(7, 7007 + 97 * seed, 0.05, 0.08);
    const CalibrationResult result =
        calibrate_rig(zoomed_from(world, 3, DeviceKind::kProjector, 0.03, seed + 1), flat_options());
    EXPECT_NE(result.diagnostics.find("view_left_out"), nullptr) << seed;
    EXPECT_EQ(result.diagnostics.find("device_moved"), nullptr) << seed;
    const Diagnostic* remark = result.diagnostics.find("lens_changed");
    ASSERT_NE(remark, nullptr) << seed;
    EXPECT_NE(remark->message.find("projector has another lens in views"), std::string::npos)
        << remark->message;
  }
}

/// Nothing moved in forty sessions, half of which have views that are off by more than their noise, each by
/// an offset of its own. One false alarm is allowed: at a rate of 0.2 % two come up in 0.3 % of runs.
TEST(RigMotion, IsNotSeenWhereNothingMoved) {
  int alarms = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(6 + int(seed % 5), 100 + seed, 0.05, 0.08);
    Correspondences data = world.correspondences(seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (View& view : data.views) {
      const Vec2 offset(0.15 * normal(random), 0.15 * normal(random));
      if (seed % 2 == 1)
        for (Observation& o : view.observations[1]) o.pixel += offset;
    }
    const Diagnostics remarks = calibrate_rig(data, flat_options()).diagnostics;
    alarms += remarks.find("device_moved") != nullptr || remarks.find("lens_changed") != nullptr;
  }
  EXPECT_LE(alarms, 1);
}

}  // namespace
}  // namespace procam::calibrate
