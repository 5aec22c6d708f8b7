// Rays, what they hit and where that looks, in vectors against plain code, to the bit.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "kernels.hpp"

namespace procam::render {
namespace {

constexpr float kNoRay = std::numeric_limits<float>::quiet_NaN();

/// Two layers of rectangles, each of two triangles, with gaps between them; some rays are missing.
struct Stage {
  Rays rays, right, down;
  Hits hits;
  std::vector<Facet> facets;
  std::vector<FacetBox> boxes;

  explicit Stage(std::mt19937& random) {
    const auto number = [&](float low, float high) {
      return std::uniform_real_distribution<float>(low, high)(random);
    };
    for (float* const numbers : {rays.x, rays.y, rays.z, right.x, right.y, right.z, down.x, down.y, down.z})
      std::fill_n(numbers, kRayRoom, kNoRay);
    for (int y = -1; y <= kTileHeight; ++y)
      for (int x = -1; x <= kTileWidth; ++x) {
        if (random() % 40 == 0) continue;
        const int at = ray_place(x, y);
        rays.x[at] = float(x) + number(-0.1f, 0.1f);
        rays.y[at] = float(y) + number(-0.1f, 0.1f);
        rays.z[at] = number(0.99f, 1.01f);
      }
    for (int layer = 0; layer < 2; ++layer)
      for (float x = -3; x < kTileWidth + 1; x += 11)
        for (float y = -2; y < kTileHeight + 1; y += 5) {
          const float x1 = x + number(6, 13), y1 = y + number(3, 6), near = number(0.4f, 0.6f);
          const float a = y1 - y, b = -(x1 - x), c = -(a * x + b * y);  // the diagonal
          for (const float side : {1.0f, -1.0f}) {
            Facet facet{};
            const float borders[4][3] = {{side, 0, side > 0 ? -x : x1},
                                         {0, -side, side > 0 ? y1 : -y},
                                         {-side * a, -side * b, -side * c},
                                         {0, 1, -y - 1}};
            std::memcpy(facet.borders, borders, sizeof borders);
            facet.nearness[0] = number(-1e-4f, 1e-4f);
            facet.nearness[2] = near;
            for (int i = 0; i < 9; ++i) facet.content[i / 3][i % 3] = number(-0.01f, 0.01f);
            facet.content[2][2] = number(0.05f, 1.5f);
            boxes.push_back({std::int16_t(x - 1), std::int16_t(y - 1), std::int16_t(x1 + 2),
                             std::int16_t(y1 + 2), std::int32_t(facets.size())});
            facets.push_back(facet);
          }
        }
    clear(hits);
  }
  static void clear(Hits& hits) {
    std::fill_n(hits.nearness, kRayRoom, 0.0f);
    std::fill_n(hits.facet, kRayRoom, -1);
  }
  void cast(const Kernels& kernels, int borders, Hits& to) const {
    clear(to);
    kernels.cast(facets.data(), borders, boxes.data(), boxes.size(), 0, 0, rays, to);
  }
};

class RayVectors : public testing::TestWithParam<int> {
 protected:
  const Kernels& kernels_ = kernels_for(GetParam());
  std::mt19937 random_{5};

  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
};

/// NaN is the same as NaN.
void expect_same(const float* a, const float* b, int begin, int end, const char* what) {
  for (int i = begin; i < end; ++i)
    ASSERT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])))
        << what << ", " << i << ": " << a[i] << ", " << b[i];
}

TEST_P(RayVectors, FollowTheMapAsPlainCodeDoes) {
  for (int count = 1; count <= kRayAcross; ++count) {
    RowMap row{};
    row.s0 = -0.3f;
    row.ds = 0.007f;
    for (int i = 0; i < 9; ++i) row.q[i] = float(whole(-1000, 1000)) / 700;
    const Stage there(random_);
    Rays plain = there.rays, wide = there.rays;
    kPlainKernels.follow(row, 131, count, plain);
    kernels_.follow(row, 131, count, wide);
    expect_same(plain.x, wide.x, 0, kRayRoom, "x");  // nothing before and after them is touched
    expect_same(plain.y, wide.y, 0, kRayRoom, "y");
    expect_same(plain.z, wide.z, 0, kRayRoom, "z");
  }
}

TEST_P(RayVectors, CastAsPlainCodeDoes) {
  for (int n = 0; n < 40; ++n) {
    Stage stage(random_);
    for (const int borders : {3, 4}) {
      Hits plain, wide;
      stage.cast(kPlainKernels, borders, plain);
      stage.cast(kernels_, borders, wide);
      ASSERT_GT(std::count_if(plain.facet, plain.facet + kRayRoom, [](int f) { return f >= 0; }), 500);
      expect_same(plain.nearness, wide.nearness, 0, kRayRoom, "nearness");
      ASSERT_TRUE(std::equal(plain.facet, plain.facet + kRayRoom, wide.facet)) << borders << " borders";
    }
  }
}

TEST_P(RayVectors, FindSlopesAndStepsAsPlainCodeDoes) {
  for (int n = 0; n < 40; ++n) {
    Stage stage(random_);
    stage.cast(kPlainKernels, 3, stage.hits);
    for (int y = 0; y < kTileHeight; ++y) {
      const int left = whole(0, kTileWidth - 1), count = whole(1, kTileWidth - left),
                first = ray_place(left, y);
      for (const int step : {1, kRayAcross}) {
        kPlainKernels.find_slopes(stage.rays, step, first, count, stage.right);
        kernels_.find_slopes(stage.rays, step, first, count, stage.down);
        expect_same(stage.right.x, stage.down.x, first, first + count, "x");
        expect_same(stage.right.y, stage.down.y, first, first + count, "y");
        expect_same(stage.right.z, stage.down.z, first, first + count, "z");
      }
      for (const float step : {0.001f, 0.3f}) {
        RowBits met[2], edges[2];
        kPlainKernels.find_steps(stage.facets.data(), stage.rays, stage.hits, first, count, step, met[0],
                                 edges[0]);
        kernels_.find_steps(stage.facets.data(), stage.rays, stage.hits, first, count, step, met[1],
                            edges[1]);
        for (const int word : {0, 1}) {
          ASSERT_EQ(met[0].words[word], met[1].words[word]) << "row " << y;
          ASSERT_EQ(edges[0].words[word], edges[1].words[word]) << "row " << y << ", step " << step;
        }
      }
    }
  }
}

TEST_P(RayVectors, LookAsPlainCodeDoes) {
  for (int n = 0; n < 40; ++n) {
    Stage stage(random_);
    stage.cast(kPlainKernels, 3, stage.hits);
    for (int y = 0; y < kTileHeight; ++y) {
      const int left = whole(0, kTileWidth - 1), count = whole(1, kTileWidth - left),
                first = ray_place(left, y);
      kPlainKernels.find_slopes(stage.rays, 1, first, count, stage.right);
      kPlainKernels.find_slopes(stage.rays, kRayAcross, first, count, stage.down);
      TexCoords plain{}, wide{};
      for (const auto& [kernels, to] : {std::pair(&kPlainKernels, &plain), std::pair(&kernels_, &wide)})
        kernels->look(stage.facets.data(), stage.rays, stage.right, stage.down, stage.hits, first, count,
                      n % 4 != 0, *to);
      for (int k = 0; k < (n % 4 != 0 ? 6 : 2); ++k) expect_same(plain.of[k], wide.of[k], 0, count, "look");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfEachWidth, RayVectors, testing::Values(256, 512),
                         [](const auto& info) { return std::to_string(info.param); });

}  // namespace
}  // namespace procam::render
