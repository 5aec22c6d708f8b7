/// Skew and k3 that may be zero: averaging keeps the accuracy of both cases.
#include <gtest/gtest.h>

#include <cmath>

#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

struct Term {
  const char* device;
  const char* name;
};

double value_of(const Rig& rig, const Term& term) {
  const bool camera = std::string(term.device) == "camera";
  const Camera& lens = camera ? rig.camera().camera : rig.projector().projector.inverse_camera;
  const auto names = parameter_names(lens);
  return parameters_of(lens)[std::find(names.begin(), names.end(), std::string(term.name)) - names.begin()];
}

/// What a user knows of a term is left as it is: so little knowledge leaves it free.
std::vector<LensPrior> know_next_to_nothing() {
  return {{{{"skew", 1}}, 0, 1e3}, {{{"k3", 1}}, 0, 1e2}};
}

/// RMS error of each term over 20 seeds, averaged and free, and how many lie inside 3 reported sigmas.
struct Errors {
  double averaged = 0, free = 0;
  double free_sigma = 0;  ///< reported, RMS
  double scores = 0;      ///< of the averaged term, mean square
  int inside = 0;
};

constexpr int kSeeds = 20;

Errors errors_of(const Term& term, double skew_px, double k3, double camera_sigma, double projector_sigma) {
  Errors errors;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    NumericWorld world = NumericWorld::make(8, 900 + seed, camera_sigma, projector_sigma);
    for (Camera* lens : {&world.camera, &world.projector.inverse_camera}) {
      lens->intrinsics.skew = skew_px;
      std::get<BrownConrady>(lens->distortion).coefficients[4] = k3;
    }
    const Correspondences data = world.correspondences(1000 + seed);
    Options options;
    options.board_shape = BoardShape::kFlat;
    const Rig averaged = calibrate_rig(data, options).rig;
    options.camera.priors = options.projector.priors = know_next_to_nothing();
    const Rig free = calibrate_rig(data, options).rig;
    const double truth = std::string(term.name) == "k3" ? k3 : skew_px;
    const double error = value_of(averaged, term) - truth;
    errors.averaged += error * error / kSeeds;
    errors.free += std::pow(value_of(free, term) - truth, 2) / kSeeds;
    const std::string name = std::string(term.device) + "." + term.name;
    const double score = error / averaged.covariance.sigma(name);
    errors.free_sigma += std::pow(free.covariance.sigma(name), 2) / kSeeds;
    errors.scores += score * score / kSeeds;
    errors.inside += std::abs(score) <= 3;
  }
  for (double* square : {&errors.averaged, &errors.free, &errors.free_sigma}) *square = std::sqrt(*square);
  return errors;
}

class TermsThatMayBeZero : public ::testing::TestWithParam<Term> {};

/// Zero terms: at most 0.75 of the free error (about 0.5 was measured; the RMS of 20 has a standard error of
/// 16 %).
TEST_P(TermsThatMayBeZero, ZeroTermsCostLittle) {
  const Errors errors = errors_of(GetParam(), 0, 0, 0.08, 0.12);
  EXPECT_LT(errors.averaged, 0.75 * errors.free);
  EXPECT_EQ(errors.inside, kSeeds);
}

/// Terms of many sigmas are what the views say; one of 20 beyond 3 sigma has a chance of 5 %, two of 0.2 %.
TEST_P(TermsThatMayBeZero, LargeTermsAreKept) {
  const Errors errors = errors_of(GetParam(), 6, 0.9, 0.002, 0.003);
  EXPECT_LT(errors.averaged, 1.15 * errors.free);
  EXPECT_GE(errors.inside, kSeeds - 1);
}

INSTANTIATE_TEST_SUITE_P(Terms, TermsThatMayBeZero,
                         ::testing::Values(Term{"camera", "skew"}, Term{"camera", "k3"},
                                           Term{"projector", "skew"}, Term{"projector", "k3"}),
                         [](const auto& term) {
                           return std::string(term.param.device) + "_" + term.param.name;
                         });

/// Terms of two sigmas shrink most, and the reported sigmas include that bias: mean squared scores of 1.0 to
/// 1.6, on average 1.2, were measured. Without the bias they were 1.7 to 2.8, on average 2.1. The fourth term,
/// the camera's k3, is not tested: in these views two of its sigmas are more than its prior expects.
TEST(TermAveraging, TermsOfTwoSigmasHaveTheReportedSigmas) {
  double scores = 0;
  int inside = 0;
  for (const Term& term : {Term{"camera", "skew"}, Term{"projector", "skew"}, Term{"projector", "k3"}}) {
    const bool is_skew = std::string(term.name) == "skew";
    const double two_sigmas = 2 * errors_of(term, 0, 0, 0.08, 0.12).free_sigma;
    const Errors errors = errors_of(term, is_skew ? two_sigmas : 0, is_skew ? 0 : two_sigmas, 0.08, 0.12);
    scores += errors.scores / 3;
    inside += errors.inside;
  }
  EXPECT_LT(scores, 1.6);
  EXPECT_GE(inside, 3 * kSeeds - 2);
}

}  // namespace
}  // namespace procam::calibrate
