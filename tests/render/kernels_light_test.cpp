// Light and masks in vectors against plain code, to the bit; rays are in kernels_rays_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "kernels.hpp"

namespace procam::render {
namespace {

class LightVectors : public testing::TestWithParam<int> {
 protected:
  const Kernels& kernels_ = kernels_for(GetParam());
  std::mt19937 random_{11};

  float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  /// Runs whose alpha is all or nothing, and pixels in between.
  template <typename Pixel>
  std::vector<Pixel> row_of(int full) {
    std::vector<Pixel> row(4 * kRowRoom);
    for (int i = 0; i < kRowRoom; ++i) {
      for (int k = 0; k < 4; ++k) row[std::size_t(4 * i + k)] = Pixel(whole(0, full));
      const int run = i / 12 % 3;
      if (run != 0) row[std::size_t(4 * i + 3)] = Pixel(run == 1 ? full : 0);
    }
    return row;
  }

  /// Both write the same over the same for every number of pixels, and nothing after the last.
  template <typename Pixel>
  void expect_same(int full, void (*Kernels::*kernel)(const Pixel*, int, Pixel*)) {
    for (int count = 0; count <= kTileWidth; ++count) {
      const std::vector<Pixel> from = row_of<Pixel>(full), there = row_of<Pixel>(full);
      std::vector<Pixel> plain = there, wide = there;
      (kPlainKernels.*kernel)(from.data(), count, plain.data());
      (kernels_.*kernel)(from.data(), count, wide.data());
      ASSERT_EQ(plain, wide) << count << " pixels";
    }
  }
};

TEST_P(LightVectors, LayLightOverOtherAsPlainCodeDoes) {
  expect_same(kFull, &Kernels::light_over);
}

TEST_P(LightVectors, MaskAsPlainCodeDoes) {
  expect_same(255, &Kernels::values_alpha);
  expect_same(kFull, &Kernels::light_alpha);
}

TEST_P(LightVectors, LocateAsPlainCodeDoes) {
  for (int n = 0; n < 500; ++n) {
    RowMap row{};
    row.s0 = number(-1, 0);
    row.ds = number(0.3f, 2) / kTileWidth;
    for (float* const map : {row.q, row.down})
      for (int i = 0; i < 9; ++i) map[i] = number(-1, 1) * (i < 3 ? 900.0f : i < 6 ? 300.0f : 40.0f);
    for (int power = 0; power < 3; ++power) row.q[3 * power + 2] = number(-0.3f, 1) / float(1 + power);
    const int begin = whole(0, kTileWidth - 1), end = whole(begin + 1, kTileWidth);
    Points plain, wide;
    kPlainKernels.locate(row, begin, end, n % 2 == 0, plain);
    kernels_.locate(row, begin, end, n % 2 == 0, wide);
    for (const auto& [a, b] :
         {std::pair(plain.u, wide.u), std::pair(plain.v, wide.v), std::pair(plain.u_x, wide.u_x),
          std::pair(plain.v_x, wide.v_x), std::pair(plain.u_y, wide.u_y), std::pair(plain.v_y, wide.v_y)})
      for (int i = begin; i < end; ++i) ASSERT_EQ(a[i], b[i]) << "row " << n << ", pixel " << i;
  }
}

// Up to the largest filter, also mirrored at the borders.
TEST_P(LightVectors, AverageLightAsPlainCodeDoes) {
  for (const auto& [width, height] : {std::pair(67, 41), std::pair(1, 1), std::pair(1, 5), std::pair(9, 2)}) {
    std::vector<Light> texels(std::size_t(4 * (width + 1) * (height + 1)));
    for (Light& light : texels) light = Light(whole(0, 5) == 0 ? kFull : whole(0, kFull));
    const TexelsView<Light> view{texels.data(), width, height, width + 1};
    for (int n = 0; n < 120; ++n) {
      Points points;
      for (int i = 0; i < kRowRoom; ++i) {
        points.u[i] = number(-0.2f, 1.2f) * float(width);
        points.v[i] = number(-0.2f, 1.2f) * float(height);
        for (float* const slope : {points.u_x, points.v_x, points.u_y, points.v_y}) slope[i] = number(-4, 4);
      }
      const int across = whole(1, 16), down = whole(1, kMaxTaps / across);
      const FilterGrid taps{0, across, down, number(0.2f, 1), number(0.2f, 1)};
      const int begin = whole(0, kTileWidth - 1), count = whole(1, kTileWidth - begin);
      std::vector<Light> plain(4 * kRowRoom, 77), wide(4 * kRowRoom, 77);
      kPlainKernels.sample_light(view, taps, points, begin, count, plain.data());
      kernels_.sample_light(view, taps, points, begin, count, wide.data());
      const int written = 4 * ((count + kLanes - 1) / kLanes * kLanes);
      ASSERT_TRUE(std::equal(plain.begin(), plain.begin() + 4 * count, wide.begin())) << "row " << n;
      ASSERT_EQ(std::count(wide.begin() + written, wide.end(), Light(77)), 4 * kRowRoom - written);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfEachWidth, LightVectors, testing::Values(256, 512),
                         [](const auto& info) { return std::to_string(info.param); });

}  // namespace
}  // namespace procam::render
