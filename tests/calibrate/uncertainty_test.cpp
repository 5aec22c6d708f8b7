/// Sigmas: from the normal equations, and from the views themselves.
#include "uncertainty.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

Options flat() {
  Options options;
  options.board_shape = BoardShape::kFlat;
  return options;
}

/// Without the terms that are averaged over: their estimates are no refit's.
Options without_averaging() {
  Options options = flat();
  options.camera.held = options.projector.held = {"skew", "k3"};
  return options;
}

/// Every view's projector pixels are off by a shift of its own, as if light and sheet had moved a little.
void shift_views(Correspondences& data, double sigma_px, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (View& view : data.views) {
    const Vec2 shift(sigma_px * normal(random), sigma_px * normal(random));
    for (Observation& o : view.observations[1]) o.pixel += shift;
  }
}

/// Every view's projector pixels are off by a smooth field of its own over the board, `sigma_px` RMS an axis:
/// what decoding of blurred stripes leaves.
void bend_light(Correspondences& data, double sigma_px, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Points3 points = points_in_board(data.board);
  const Vec3 middle = 0.5 * (points.front() + points.back()), half = points.back() - middle;
  for (View& view : data.views)
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Matrix<double, 6, 1> terms;
      for (double& term : terms) term = sigma_px * normal(random) / std::sqrt(2.0);
      for (Observation& o : view.observations[1]) {
        const Vec3 at = points[std::size_t(o.point)] - middle;
        const double x = at.x() / half.x(), y = at.y() / half.y();
        Eigen::Matrix<double, 6, 1> field;
        field << 1, x, y, x * y, x * x - 0.4, y * y - 0.4;
        o.pixel[axis] += terms.dot(field);
      }
    }
}

/// Estimated minus true, of every lens term in the covariance and of the projector's pose.
std::map<std::string, double> errors(const Rig& estimated, const Rig& truth) {
  std::map<std::string, double> all;
  const auto add_lens = [&](const std::string& device, const Camera& lens, const Camera& true_lens) {
    const VecX error = parameters_of(lens) - parameters_of(true_lens);
    const std::vector<std::string> names = parameter_names(lens);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (estimated.covariance.index_of(device + "." + names[i]))
        all[device + "." + names[i]] = error[Eigen::Index(i)];
  };
  add_lens("camera", estimated.camera().camera, truth.camera().camera);
  add_lens("projector", estimated.projector().projector.inverse_camera,
           truth.projector().projector.inverse_camera);
  const Vec6 xi =
      se3_log(estimated.projector().rig_from_projector * truth.projector().rig_from_projector.inverse());
  for (int i = 0; i < 6; ++i) all[pose_increment_names("rig_from_projector")[std::size_t(i)]] = xi[i];
  return all;
}

struct Solved {
  Correspondences data;
  BundleState state;
  BundleOptions options;
  UsedMask used;
};

Solved solve(const NumericWorld& world, const Correspondences& data) {
  Solved solved{data, {}, {}, use_all(data)};
  solved.state.lenses = {world.camera, world.projector.inverse_camera};
  solved.state.device_from_rig = {Pose(), world.projector_from_camera};
  solved.state.rig_from_board = world.camera_from_board;
  solved.state.points_in_board = points_in_board(data.board);
  solved.options.held.assign(2, {"skew", "k3"});
  solved.options.noise.resize(2);
  solved.options.hold_pose.assign(2, false);
  solved.state = bundle_adjust(data, solved.used, solved.state, solved.options).state;
  return solved;
}

/// One Newton step against the whole solve without the view, for every view: they agree to second order in
/// the step, which is a part of a sigma here.
TEST(LeaveOneViewOut, AgreesWithFullRefits) {
  const NumericWorld world = NumericWorld::make(7, 3, 0.08, 0.12);
  const Solved full = solve(world, world.correspondences(4));
  const auto closed = leave_one_view_out(full.data, full.used, full.state, full.options);
  ASSERT_EQ(closed.size(), 7u);
  for (std::size_t v = 0; v < closed.size(); ++v) {
    ASSERT_TRUE(closed[v].has_value());
    UsedMask without = full.used;
    for (auto& of_device : without[v]) std::fill(of_device.begin(), of_device.end(), char(0));
    const BundleState refit = bundle_adjust(full.data, without, full.state, full.options).state;
    for (std::size_t d = 0; d < 2; ++d) {
      const VecX whole = parameters_of(refit.lenses[d]) - parameters_of(full.state.lenses[d]);
      const VecX step = parameters_of(closed[v]->lenses[d]) - parameters_of(full.state.lenses[d]);
      EXPECT_LT((whole - step).head<4>().norm(), 0.1 * whole.head<4>().norm() + 0.02)
          << "view " << v << " device " << d;
    }
  }
}

/// The same where light is read at corners, for what is reported of it: the jackknife's sigmas in closed form
/// against those of whole refits, (n - 1) / n times the sum of squared differences. What whole refits change
/// beyond a Newton step is second order; a fifth of a sigma is the limit that the sigmas' own uncertainty
/// (n views tell them to 1 / sqrt(2 (n - 1)), 25 % here) makes sensible.
TEST(Jackknife, AgreesWithFullRefitsWhereLightIsReadAtCorners) {
  const NumericWorld world = NumericWorld::make(9, 3, 0.1, 0.02);
  Correspondences data = world.with_light_read_at_corners(4);
  shift_views(data, 0.2, 8);
  const Options options = without_averaging();
  const SolvedBundle full = calibrate_rig(data, options).solved;
  const Jackknife closed = bundle_uncertainty(full.data, full.used, full.state, full.options).jackknife;
  std::map<std::string, double> variance;
  for (std::size_t v = 0; v < 9; ++v) {
    UsedMask without = full.used;
    for (auto& of_device : without[v]) std::fill(of_device.begin(), of_device.end(), char(0));
    const BundleState refit = bundle_adjust(full.data, without, full.state, full.options).state;
    for (std::size_t d = 0; d < 2; ++d) {
      const VecX moved = parameters_of(refit.lenses[d]) - parameters_of(full.state.lenses[d]);
      const auto names = parameter_names(refit.lenses[d]);
      for (std::size_t i = 0; i < names.size(); ++i)
        variance[full.data.devices[d].name + "." + names[i]] +=
            8.0 / 9 * moved[Eigen::Index(i)] * moved[Eigen::Index(i)];
    }
  }
  for (const char* name : {"camera.fx", "camera.fy", "camera.cx", "camera.cy", "camera.k1", "projector.fx",
                           "projector.fy", "projector.cx", "projector.cy", "projector.k1"})
    EXPECT_NEAR(closed.plain.sigma(name) / std::sqrt(variance.at(name)), 1, 0.2) << name;
}

/// tr(formal^-1 jackknife) / p is 1 for independent noise; its mean over 30 seeds has a standard error of
/// sqrt(2 / (7 * 22 * 30)) = 2 %, times two or so for parameters that one view dominates. [0.85, 1.15] is
/// more than three of those. By its own rule 2.5 % are inflated: more than 5 of 30 come up in 0.1 % of runs.
TEST(RobustCovariance, KeepsTheFormalOneForIndependentNoise) {
  double sum = 0;
  int inflated = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const NumericWorld world = NumericWorld::make(8, 300 + seed, 0.08, 0.12);
    const CalibrationResult result = calibrate_rig(world.correspondences(seed), flat());
    sum += result.variance_ratio;
    inflated += result.diagnostics.find("sigmas_from_views") != nullptr;
  }
  EXPECT_GT(sum / 30, 0.85);
  EXPECT_LT(sum / 30, 1.15);
  EXPECT_LE(inflated, 5);
}

/// With view-wise shifts the formal sigmas are several times too small; the robust ones hold: of 25 seeds x 4
/// projector parameters, at least 85 % inside 2 sigma (expected 95 %; correlated within a seed, standard
/// error about 3 %: false alarm 0.1 %), while the formal ones keep fewer than 70 %.
TEST(RobustCovariance, HoldsWhenWholeViewsAreOff) {
  int honest_inside = 0, formal_inside = 0, total = 0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    const NumericWorld world = NumericWorld::make(9, 400 + seed, 0.05, 0.05);
    Correspondences data = world.correspondences(500 + seed);
    shift_views(data, 0.4, seed);
    const CalibrationResult result = calibrate_rig(data, flat());
    const Solved formal = solve(world, data);
    const NamedCovariance covariance =
        bundle_covariance(formal.data, formal.used, formal.state, formal.options).devices;
    const VecX truth = parameters_of(world.projector.inverse_camera);
    const VecX found = parameters_of(result.rig.projector().projector.inverse_camera);
    const VecX formally = parameters_of(formal.state.lenses[1]);
    const auto names = parameter_names(world.projector.inverse_camera);
    for (Eigen::Index i = 0; i < 4; ++i) {
      const std::string name = "projector." + names[std::size_t(i)];
      ++total;
      honest_inside += std::abs(found[i] - truth[i]) < 2 * result.rig.covariance.sigma(name);
      formal_inside += std::abs(formally[i] - truth[i]) < 2 * covariance.sigma(name);
    }
  }
  EXPECT_GT(honest_inside, 0.85 * total);
  EXPECT_LT(formal_inside, 0.70 * total);
}

/// Errors that the corners of a view share, and independent ones: the sigmas come from the views. They must
/// be neither too small nor too large, because the prediction in millimetres uses them. 40 sessions of 12
/// views, 22 parameters each: 97.7 % lie inside two sigmas, and the predicted light is 1.34 times the true
/// one (RMS over the sessions) for a surface located externally, 1.33 times by the camera. Of exact sigmas
/// 95.4 % do, with a standard error of 1.4 % (the parameters of one rig count as 6 independent ones); the
/// ratio has one of 10 %. The limits are passed by these seeds; exact sigmas would leave them in 2 % of
/// draws. (With the uncorrected jackknife: 99.4 %, 1.84 and 1.92.)
TEST(RobustCovariance, IsNeitherTooSmallNorTooLargeWhereCornersOfAViewErrTogether) {
  int inside = 0, total = 0, from_views = 0;
  Eigen::Array2d predicted(0, 0), actual(0, 0);
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(12, 900 + seed, 0.03, 0.015);
    Correspondences data = world.with_light_read_at_corners(1000 + seed);
    bend_light(data, 0.015, 1100 + seed);
    const CalibrationResult result = calibrate_rig(data, without_averaging());
    from_views += result.sigmas_from_views;
    const Rig truth = world.rig();
    for (const auto& [name, error] : errors(result.rig, truth)) {
      const double sigmas = std::abs(error) / result.rig.covariance.sigma(name);
      inside += sigmas <= 2;
      ++total;
    }
    const analyze::LightErrors told = analyze::predicted_light_errors(result.rig, 2),
                               is = analyze::true_light_errors(result.rig, truth, 2);
    ASSERT_TRUE(told.by_camera && is.by_camera) << seed;
    predicted += Eigen::Array2d(told.externally.rms_mm, told.by_camera->rms_mm).square();
    actual += Eigen::Array2d(is.externally.rms_mm, is.by_camera->rms_mm).square();
  }
  EXPECT_EQ(total, 40 * 22);
  EXPECT_GE(from_views, 36);
  const Eigen::Array2d ratio = (predicted / actual).sqrt();
  EXPECT_GE(inside, 0.88 * total);
  EXPECT_LE(inside, 0.985 * total);
  for (const double one : ratio) {
    EXPECT_GT(one, 1 / 1.5);
    EXPECT_LT(one, 1.5);
  }
}

/// One corner error in camera and projector alike. Over 30 seeds x 6 weak parameters the share inside 2 sigma
/// has a standard error of about 3 % (parameters of one rig are correlated): [0.87, 1] raises a false alarm
/// in fewer than 1 % of runs. Taken as independent, the same error counts twice and fewer are inside.
TEST(RobustCovariance, CountsACornersErrorOnce) {
  int inside = 0, inside_as_independent = 0, total = 0;
  double spread = 0, spread_as_independent = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const NumericWorld world = NumericWorld::make(8, 700 + seed, 0.1, 0.01);
    const Correspondences data = world.with_light_read_at_corners(800 + seed);
    Correspondences as_independent = data;
    for (View& view : as_independent.views)
      for (Observation& lit : view.observations[1]) lit.correlated_with_camera = false;
    const CalibrationResult result = calibrate_rig(data, without_averaging()),
                            independent = calibrate_rig(as_independent, without_averaging());
    EXPECT_LT(result.rms_px[1], 0.03) << "the light's own error is left";
    for (const int index : {0, 1}) {
      const std::string device = index == 0 ? "camera" : "projector";
      const Camera& truth = index == 0 ? world.camera : world.projector.inverse_camera;
      const auto error_of = [&](const CalibrationResult& r) {
        return VecX(
            parameters_of(index == 0 ? r.rig.camera().camera : r.rig.projector().projector.inverse_camera) -
            parameters_of(truth));
      };
      const VecX error = error_of(result), other = error_of(independent);
      const auto names = parameter_names(truth);
      for (const Eigen::Index i : {0, 2, 3}) {  // fx, cx, cy
        const std::string name = std::string(device) + "." + names[std::size_t(i)];
        ++total;
        inside += std::abs(error[i]) < 2 * result.rig.covariance.sigma(name);
        inside_as_independent += std::abs(other[i]) < 2 * independent.rig.covariance.sigma(name);
        spread += error[i] * error[i];
        spread_as_independent += other[i] * other[i];
      }
    }
  }
  EXPECT_GE(inside, 0.87 * total);
  EXPECT_LT(inside_as_independent, inside);
  EXPECT_LT(spread, spread_as_independent);
}

TEST(BundleCovariance, KnowsTheBoardPosesToo) {
  const NumericWorld world = NumericWorld::make(6, 9, 0.08, 0.12);
  int inside = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Solved solved = solve(world, world.correspondences(seed));
    const BundleCovariance covariance =
        bundle_covariance(solved.data, solved.used, solved.state, solved.options);
    ASSERT_EQ(covariance.rig_from_board.size(), 6u);
    for (std::size_t v = 0; v < 6; ++v) {
      const Vec6 error = se3_log(solved.state.rig_from_board[v] * world.camera_from_board[v].inverse());
      const double chi2 = error.dot(covariance.rig_from_board[v].llt().solve(error));
      inside += chi2 < 12.59;  // 95 % of chi^2 with 6 degrees of freedom
    }
  }
  // 60 draws, correlated in six: 95 % expected, below 48 in fewer than one run of a thousand.
  EXPECT_GE(inside, 48);
}

/// Every view of a session three times: copies say nothing new. Rig and sigmas are those of the single views,
/// and the repetition is reported. (Counted as views of their own, copies make sigmas sqrt(3) too small.)
TEST(RepeatedPoses, CountAsOneView) {
  const NumericWorld world = NumericWorld::make(6, 31, 0.08, 0.12);
  const Correspondences once = world.correspondences(32);
  Correspondences repeated = once;
  for (const std::string again : {"_b", "_c"})
    for (const View& view : once.views) {
      repeated.views.push_back(view);
      repeated.views.back().name += again;
    }
  const CalibrationResult single = calibrate_rig(once, flat()), copied = calibrate_rig(repeated, flat());
  ASSERT_EQ(copied.rig.covariance.names, single.rig.covariance.names);
  const VecX ratio = copied.rig.covariance.matrix.diagonal()
                         .cwiseQuotient(single.rig.covariance.matrix.diagonal())
                         .cwiseSqrt();
  EXPECT_GT(ratio.minCoeff(), 0.95);
  EXPECT_LT(ratio.maxCoeff(), 1.05);
  EXPECT_EQ(single.diagnostics.find("repeated_poses"), nullptr);
  const Diagnostic* remark = copied.diagnostics.find("repeated_poses");
  ASSERT_NE(remark, nullptr);
  EXPECT_NE(remark->message.find("18 views show 6 poses"), std::string::npos) << remark->message;
  EXPECT_NE(remark->message.find("view_0, view_0_b and view_0_c"), std::string::npos) << remark->message;
}

/// A whole group is held out: a copy that stays would predict the view that went.
TEST(RepeatedPoses, AreHeldOutTogether) {
  const NumericWorld world = NumericWorld::make(5, 33, 0.1, 0.15);
  const Correspondences once = world.correspondences(34);
  Correspondences twice = once;
  for (const View& view : once.views) twice.views.push_back(view);
  Options options = flat();
  options.holdout = true;
  const CalibrationResult single = calibrate_rig(once, options), copied = calibrate_rig(twice, options);
  EXPECT_NEAR(copied.holdout_px[1], single.holdout_px[1], 0.02 * single.holdout_px[1]);
}

/// Pixels of a frame of half the size, the frame given as it is shown: a lens that is shifted by a quarter fits them.
TEST(FirstPart, OfAFrameThatIsStatedTooLargeIsNamed) {
  const NumericWorld world = NumericWorld::make(6, 35, 0.08, 0.12);
  Correspondences data = world.correspondences(36);
  EXPECT_EQ(calibrate_rig(data, flat()).diagnostics.find("points_in_first_part"), nullptr);
  data.devices[1].size = {2 * data.devices[1].size.width, 2 * data.devices[1].size.height};
  const CalibrationResult result = calibrate_rig(data, flat());
  const Diagnostic* remark = result.diagnostics.find("points_in_first_part");
  ASSERT_NE(remark, nullptr);
  EXPECT_NE(remark->message.find("of 2048 x 1536 pixels"), std::string::npos) << remark->message;
}

}  // namespace
}  // namespace procam::calibrate
