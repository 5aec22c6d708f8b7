#include "procam/core/base/stats.hpp"

#include <gtest/gtest.h>

namespace procam {
namespace {

TEST(Stats, RanksCountFromTheSmallest) {
  std::vector<int> values{5, 3, 9, 1};
  EXPECT_EQ(at_rank(values, 0), 1);
  EXPECT_EQ(at_rank(values, 2), 5);
  EXPECT_EQ(at_rank(values, 3), 9);
  EXPECT_EQ(at_rank(std::vector<double>{2.5, 0.5}, 1), 2.5);
}

TEST(Stats, MediansOfAnEvenCountDiffer) {
  const std::vector<double> even{4, 1, 3, 2}, odd{7, 5, 6};
  EXPECT_EQ(median(even), 3);
  EXPECT_EQ(lower_median(even), 2);
  EXPECT_EQ(median(odd), 6);
  EXPECT_EQ(lower_median(odd), 6);
  EXPECT_EQ(even.front(), 4) << "the argument keeps its order";
  EXPECT_EQ(median_or(std::vector<double>{}, 8.0), 8);
  EXPECT_EQ(median_or(odd, 8.0), 6);
}

TEST(Stats, QuantilesGoFromTheSmallestToTheLargest) {
  const std::vector<float> values{30, 10, 20, 50, 40};
  EXPECT_EQ(quantile(values, 0), 10);
  EXPECT_EQ(quantile(values, 0.5), 30);
  EXPECT_EQ(quantile(values, 0.74), 30);
  EXPECT_EQ(quantile(values, 0.75), 40);
  EXPECT_EQ(quantile(values, 1), 50);
}

}  // namespace
}  // namespace procam
