#include "procam/core/geometry/ray.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

TEST(Ray, CountsInLengthsOfItsDirection) {
  const Ray ray{Vec3(1, 2, 3), Vec3(0, 0.5, -2)};
  EXPECT_LT((ray.at(3) - Vec3(1, 3.5, -3)).norm(), 1e-15);
}

TEST(Ray, MovesWithItsPoints) {
  const Pose target_from_source = test::lopsided_pose();
  const Ray ray{Vec3(0.3, -0.8, 1.1), Vec3(0.2, 0.9, -1.7)};
  for (const double s : {0.0, 0.7, 12.0})
    EXPECT_LT(((target_from_source * ray).at(s) - target_from_source * ray.at(s)).norm(), 1e-13);
}

}  // namespace
}  // namespace procam
