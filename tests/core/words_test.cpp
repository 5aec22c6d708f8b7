#include "procam/core/base/words.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace procam {
namespace {

TEST(Words, NumbersHaveTheDigitsAskedFor) {
  EXPECT_EQ(fixed(2.5, 2), "2.50");
  EXPECT_EQ(fixed(-12.345678, 3), "-12.346");
  EXPECT_EQ(fixed(1e20, 0), "100000000000000000000");
  EXPECT_EQ(shortest(0.50), "0.5");
  EXPECT_EQ(shortest(1234567), "1.23457e+06");
  EXPECT_EQ(shortest(0.0123456, 3), "0.0123");
  EXPECT_EQ(significant(0.5, 2), "0.50");
  EXPECT_EQ(significant(1234, 2), "1234");
  EXPECT_EQ(significant(1.234e-9, 2), "1.2e-09");
}

TEST(Words, ZeroHasNoMinusAndWhatIsNoNumberIsADash) {
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(shortest(-0.0), "0");
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(fixed(value, 2), "-");
    EXPECT_EQ(shortest(value), "-");
    EXPECT_EQ(significant(value, 2), "-");
  }
}

TEST(Words, QuantitiesCarryTheirUnit) {
  EXPECT_EQ(px(0.25), "0.25 px");
  EXPECT_EQ(mm(0.0125), "12.50 mm");
  EXPECT_EQ(mm(0.0125, 0), "12 mm");
  EXPECT_EQ(metres(1.2), "1.20 m");
  EXPECT_EQ(percent(0.0451), "4.5 %");
}

TEST(Words, CountsAndLists) {
  EXPECT_EQ(counts(7, 9), "7x9");
  EXPECT_EQ(counts(ImageSize{1024, 768}, " x "), "1024 x 768");
  EXPECT_EQ(counted(1, "view"), "1 view");
  EXPECT_EQ(counted(0, "view"), "0 views");
  EXPECT_EQ(comma_list({}), "");
  EXPECT_EQ(comma_list({"", "b"}), ", b");
  EXPECT_EQ(comma_list(std::vector<int>{3, 5}, [](int n) { return std::to_string(n); }), "3, 5");
  EXPECT_EQ(and_list({"a"}), "a");
  EXPECT_EQ(and_list({"a", "b"}), "a and b");
  EXPECT_EQ(and_list({"a", "b", "c"}), "a, b and c");
}

}  // namespace
}  // namespace procam
