/// A projector's light that the camera sees in a mirror only.
#include "procam/calibrate/mirror.hpp"

#include <gtest/gtest.h>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/core/geometry/mirror.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

/// The camera looks away from boards and projector into a mirror with a board of its own in one corner.
struct MirrorWorld {
  test::NumericWorld seen;  ///< poses are those of the mirrored camera, which the library is to undo
  Pose camera_from_mirror_board{so3_exp<double>(Vec3(0.21, -0.33, 0.12)), Vec3(-0.12, -0.10, 0.42)};
  Board mirror_board = Chessboard{6, 5, 0.021};
  Camera camera;

  explicit MirrorWorld(std::uint64_t seed, double corner_sigma = 0, double light_sigma = 0)
      : seen(test::NumericWorld::make(8, seed, corner_sigma, light_sigma)) {
    // What matters is seen in the mirror: any world before the mirrored camera, reflected.
    camera = turned_left_to_right(seen.camera);
  }

  Plane mirror() const { return Plane::of_xy(camera_from_mirror_board); }
  Vec3 from_mirrored(const Vec3& p) const { return reflect(mirror(), Vec3(-p.x(), p.y(), p.z())); }

  Rig truth() const {
    Rig rig;
    rig.cameras.push_back({"camera", camera, Pose()});
    const Pose mirrored_from_projector = seen.projector_from_camera.inverse();
    const Vec3 origin = from_mirrored(mirrored_from_projector.translation);
    Mat3 axes;
    for (int i = 0; i < 3; ++i)
      axes.col(i) = from_mirrored(mirrored_from_projector * Vec3(Vec3::Unit(i))) - origin;
    rig.projectors.push_back({"projector", seen.projector, Pose(axes, origin)});
    return rig;
  }

  /// By the physics: the real camera's pixel of a real point's image in the mirror, turned left to right.
  Correspondences session(std::uint64_t seed) const {
    Correspondences data = seen.correspondences(seed);
    const Correspondences exact = [&] {
      test::NumericWorld quiet = seen;
      quiet.camera_sigma_px = quiet.projector_sigma_px = 0;
      return quiet.correspondences(seed);
    }();
    const Points3 board = points_in_board(data.board);
    for (std::size_t v = 0; v < data.views.size(); ++v)
      for (std::size_t i = 0; i < data.views[v].observations[0].size(); ++i) {
        Observation& o = data.views[v].observations[0][i];
        const Vec3 point = from_mirrored(seen.camera_from_board[v] * board[std::size_t(o.point)]);
        const Vec2 pixel = *camera.project(reflect(mirror(), point));
        const Vec2 turned(camera.size.width - 1 - pixel.x(), pixel.y());
        o.pixel += turned - exact.views[v].observations[0][i].pixel;
      }
    return data;
  }

  MirrorView view(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    MirrorView view{mirror_board, {camera.size, {}, {}}, 0};
    const double sigma = seen.camera_sigma_px, believed = sigma > 0 ? sigma : 0.1;
    const Points3 points = points_in_board(mirror_board);
    for (std::size_t i = 0; i < points.size(); ++i)
      view.detections.observations.push_back({int(i),
                                              *camera.project(camera_from_mirror_board * points[i]) +
                                                  sigma * Vec2{normal(random), normal(random)},
                                              Mat2::Identity() * believed * believed});
    return view;
  }
};

TEST(Mirror, TurnsTheCameraIntoOneBehindIt) {
  const MirrorWorld world(1);
  const Vec3 point(0.3, -0.2, -0.7);  // behind the camera
  const Vec2 pixel = *world.camera.project(reflect(world.mirror(), point));
  const Pose camera_from_mirrored = camera_from_mirrored_camera(world.mirror());
  const Vec2 turned = *turned_left_to_right(world.camera).project(camera_from_mirrored.inverse() * point);
  EXPECT_LT((turned - Vec2(world.camera.size.width - 1 - pixel.x(), pixel.y())).norm(), 1e-9);
  EXPECT_LT((reflect(world.mirror(), reflect(world.mirror(), point)) - point).norm(), 1e-15);
}

TEST(ThroughMirror, FindsTheProjectorBeforeTheRealCamera) {
  const MirrorWorld world(2);
  const MirrorSolution solution = through_mirror(calibrate_rig(world.session(1)), world.view(1));
  const Rig truth = world.truth();
  EXPECT_TRUE(solution.result.rig.quality.passed());
  EXPECT_LT(
      (parameters_of(solution.result.rig.camera().camera) - parameters_of(truth.camera().camera)).norm(),
      1e-4);
  EXPECT_LT(analyze::true_light_error(solution.result.rig, truth, 2).worst_mm, 1e-4);
  EXPECT_LT((solution.mirror_in_camera.normal - world.mirror().normal).norm(), 1e-9);
}

/// 22 parameters, correlated, in each of six seeds: the standard deviation of the mean squared score is about
/// 0.25 for the projector's pose alone (6 x 6 scores).
TEST(ThroughMirror, SigmasOfTheProjectorsPlaceAreHonest) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const MirrorWorld world(seed, 0.08, 0.06);
    const Rig rig = through_mirror(calibrate_rig(world.session(seed + 20)), world.view(seed + 40)).result.rig;
    const Vec6 xi =
        se3_log(rig.projector().rig_from_projector * world.truth().projector().rig_from_projector.inverse());
    const Mat6 covariance = rig.covariance.block(pose_increment_names("rig_from_projector"));
    sum += xi.dot(covariance.ldlt().solve(xi)) / 6;
    EXPECT_LT(analyze::true_light_error(rig, world.truth(), 2).rms_mm,
              4 * analyze::predicted_light_error(rig, 2).rms_mm);
  }
  EXPECT_GT(sum / 6, 0.4);
  EXPECT_LT(sum / 6, 1.8);
}

TEST(ThroughMirror, RefusesAMirrorThatItCannotPlace) {
  const MirrorWorld world(3, 0.05, 0.05);
  const CalibrationResult mirrored = calibrate_rig(world.session(1));
  MirrorView few = world.view(1);
  few.detections.observations.resize(4);
  EXPECT_THROW(through_mirror(mirrored, few), Error);
  MirrorView row = world.view(1);  // one row of corners: the mirror may turn about it
  row.detections.observations.resize(6);
  EXPECT_THROW(through_mirror(mirrored, row), Error);
  // Moved away after the session: the boards would stand behind it.
  MirrorWorld moved = world;
  moved.camera_from_mirror_board.translation.z() += 4;
  const MirrorSolution solution = through_mirror(mirrored, moved.view(1));
  EXPECT_FALSE(solution.result.rig.quality.passed());
}

}  // namespace
}  // namespace procam::calibrate
