#include <gtest/gtest.h>

#include "procam/analyze/light_error.hpp"
#include "uncertain_rig.hpp"

namespace procam::analyze {
namespace {

TEST(ParametersWithinTruth, CountsThoseInsideThreeSigmas) {
  const Rig truth = test::uncertain_rig();
  const int all = int(truth.covariance.names.size());
  EXPECT_EQ(parameters_within_truth(truth, truth).parameters, all);
  EXPECT_EQ(parameters_within_truth(truth, truth).inside_3_sigma, all);
  Rig moved = truth;
  const double sigma = truth.covariance.sigma("projector.fx");
  moved.projectors[0].projector.inverse_camera.intrinsics.fx += 2.9 * sigma;
  EXPECT_EQ(parameters_within_truth(moved, truth).inside_3_sigma, all);
  moved.projectors[0].projector.inverse_camera.intrinsics.fx += 0.2 * sigma;
  EXPECT_EQ(parameters_within_truth(moved, truth).inside_3_sigma, all - 1);
  moved.covariance = {};
  EXPECT_EQ(parameters_within_truth(moved, truth).parameters, 0);
}

}  // namespace
}  // namespace procam::analyze
