#include "procam/core/base/color.hpp"

#include <gtest/gtest.h>

namespace procam {
namespace {

// IEC 61966-2-1; the published table of 8-bit values: 10 -> 0.0030353, 128 -> 0.2158605, 188 -> 0.5028865.
TEST(Color, SrgbHasThePublishedValues) {
  EXPECT_NEAR(light_from_srgb(10 / 255.0), 0.0030353, 5e-8);
  EXPECT_NEAR(light_from_srgb(128 / 255.0), 0.2158605, 5e-8);
  EXPECT_NEAR(light_from_srgb(188 / 255.0), 0.5028865, 5e-8);
  EXPECT_EQ(light_from_srgb(0.0), 0);
  EXPECT_EQ(light_from_srgb(1.0), 1);
}

TEST(Color, CurvesAreInverse) {
  for (int i = 0; i <= 1000; ++i) {
    const double value = i / 1000.0;
    EXPECT_NEAR(srgb_from_light(light_from_srgb(value)), value, 1e-7) << value;
    EXPECT_NEAR(double(srgb_from_light(light_from_srgb(float(value)))), value, 1e-6) << value;
  }
}

}  // namespace
}  // namespace procam
