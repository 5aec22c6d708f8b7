#include "procam/core/board/artwork_index.hpp"

#include <gtest/gtest.h>

#include <random>

namespace procam {
namespace {

/// Lopsided, with shapes that touch and one that reaches over many cells.
BoardArtwork some_artwork() {
  BoardArtwork art;
  art.rectangles = {{Vec2(-0.01, 0.02), Vec2(0.13, 0.05)},
                    {Vec2(0.13, 0.02), Vec2(0.17, 0.11)},
                    {Vec2(0.031, 0.0521), Vec2(0.0317, 0.0529)}};
  art.discs = {{Vec2(0.06, 0.093), 0.021}, {Vec2(0.2, 0.03), 0.0043}};
  art.sheet = {Vec2(-0.04, -0.02), Vec2(0.24, 0.13)};
  return art;
}

/// The reference: whether is_dark() says so, on a fine grid over the box.
double sampled_share(const BoardArtwork& art, const Vec2& low, const Vec2& high) {
  constexpr int kFine = 400;
  int dark = 0;
  for (int j = 0; j < kFine; ++j)
    for (int i = 0; i < kFine; ++i)
      dark += art.is_dark(low + Vec2((i + 0.5) / kFine, (j + 0.5) / kFine).cwiseProduct(high - low));
  return dark / double(kFine * kFine);
}

TEST(ArtworkIndex, AnswersAsTheArtworkItself) {
  const BoardArtwork art = some_artwork();
  const ArtworkIndex index(art);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-0.06, 0.26), y(-0.04, 0.15);
  int dark = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec2 p(x(random), y(random));
    ASSERT_EQ(index.is_dark(p), art.is_dark(p)) << p.transpose();
    dark += index.is_dark(p);
  }
  EXPECT_GT(dark, 1000);
}

/// A border through n x n samples leaves at most 4 / n of them in doubt.
TEST(ArtworkIndex, MeasuresTheDarkShareOfABox) {
  const BoardArtwork art = some_artwork();
  const ArtworkIndex index(art);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> x(-0.05, 0.24), y(-0.03, 0.13), size(-3, -0.8);
  int partly = 0;
  for (int i = 0; i < 60; ++i) {
    const Vec2 low(x(random), y(random)),
        high = low + Vec2(std::pow(10, size(random)), 0.7 * std::pow(10, size(random)));
    const double share = index.dark_share(low, high);
    EXPECT_NEAR(share, sampled_share(art, low, high), 0.01) << low.transpose() << " to " << high.transpose();
    partly += share > 0.01 && share < 0.99;
  }
  EXPECT_GT(partly, 10);
}

TEST(ArtworkIndex, KnowsTheWholeDiscAndItsQuarters) {
  const double r = 0.37;
  EXPECT_NEAR(area_of_disc_in_box(r, Vec2(-1, -2), Vec2(3, 1)), M_PI * r * r, 1e-12);
  EXPECT_NEAR(area_of_disc_in_box(r, Vec2(0, 0), Vec2(3, 1)), M_PI * r * r / 4, 1e-12);
  EXPECT_NEAR(area_of_disc_in_box(r, Vec2(-0.1, -0.2), Vec2(0.1, 0.05)), 0.05, 1e-12);
  EXPECT_EQ(area_of_disc_in_box(r, Vec2(0.3, 0.3), Vec2(3, 1)), 0);
  EXPECT_THROW(ArtworkIndex{BoardArtwork()}, std::invalid_argument);
}

}  // namespace
}  // namespace procam
