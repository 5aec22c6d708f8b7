#include "kernels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace procam::render {
namespace {

constexpr int kRoom = 4 * kRowRoom;

/// Noise, with the copies of the last column and row that kernels want.
struct Picture {
  std::vector<Value> texels;
  TexelsView<Value> view;

  Picture(int width, int height, std::mt19937& random)
      : texels(std::size_t(width + 1) * std::size_t(height + 1) * 4) {
    for (Value& value : texels) value = Value(random() & 255);
    view = {texels.data(), width, height, width + 1};
    for (int y = 0; y <= height; ++y)
      for (int x = 0; x <= width; ++x)
        std::copy_n(at(std::min(x, width - 1), std::min(y, height - 1)), 4, at(x, y));
  }
  Value* at(int x, int y) { return texels.data() + (std::ptrdiff_t(y) * view.stride + x) * 4; }
};

/// Ordinary, of one texel, thin, of sides that 16 bits do not hold.
std::vector<Picture> pictures(std::mt19937& random) {
  std::vector<Picture> all;
  for (const auto& [width, height] : {std::pair(641, 333), std::pair(1, 1), std::pair(2, 1), std::pair(1, 3),
                                      std::pair(7, 5), std::pair(40000, 2), std::pair(2, 40000)})
    all.emplace_back(width, height, random);
  return all;
}

/// What each of the two writes for `count` pixels is the same, and as far as it may.
template <typename Draw>
void expect_same(const Kernels& kernels, int count, const std::string& what, const Draw& draw) {
  std::vector<Value> plain(kRoom, 77), wide(kRoom, 77);
  draw(kPlainKernels, plain.data());
  draw(kernels, wide.data());
  ASSERT_TRUE(std::equal(plain.begin(), plain.begin() + 4 * count, wide.begin())) << what;
  const int whole = 4 * ((count + kLanes - 1) / kLanes * kLanes);
  ASSERT_TRUE(std::all_of(wide.begin() + whole, wide.end(), [](Value v) { return v == 77; })) << what;
}

struct Instructions {
  int vector_bits;
  bool gathers;
};

class Vectors : public testing::TestWithParam<Instructions> {
 protected:
  const Kernels& kernels_ = kernels_for(GetParam().vector_bits, GetParam().gathers);
  std::mt19937 random_{7};

  float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
};

// Rows of homographies and of bent pieces, partly outside the content, some across the horizon.
TEST_P(Vectors, MapValuesAsPlainCodeDoes) {
  for (const Picture& picture : pictures(random_)) {
    const float w = kStepsAcross * float(picture.view.width), h = kStepsDown * float(picture.view.height);
    for (int n = 0; n < 600; ++n) {
      RowMap row{};
      row.s0 = number(-1, 0);
      row.ds = number(0.3f, 2) / kTileWidth;
      for (int power = 0; power < 3; ++power) {
        if (power == 2 && n % 3 != 0) continue;
        const float size = power == 0 ? 1.0f : power == 1 ? 0.4f : 0.1f;
        row.q[3 * power] = w * size * number(-0.2f, 1.2f);
        row.q[3 * power + 1] = h * size * number(-0.2f, 1.2f);
        row.q[3 * power + 2] = power == 0 ? number(n % 5 == 0 ? 0.0f : 0.8f, 1.2f) : size * number(-1, 1);
      }
      const int begin = whole(0, kTileWidth - 1),
                end = n % 4 == 0 ? kTileWidth : whole(begin + 1, kTileWidth), middle = whole(begin, end);
      expect_same(kernels_, end - begin,
                  "row " + std::to_string(n) + ", width " + std::to_string(picture.view.width),
                  [&](const Kernels& kernels, Value* to) {
                    RowCells cells;
                    // In two parts, as the pieces of a lens meet.
                    kernels.find_cells(picture.view, row, begin, middle, 0, cells);
                    kernels.find_cells(picture.view, row, middle, end, middle - begin, cells);
                    cells.clear(end - begin, (end - begin + 15) / 16 * 16);
                    kernels.sample_cells(picture.view, cells, 100, end - begin, to);
                  });
    }
  }
}

// Also halfway between the steps of the interpolation, at the borders, far outside, and nowhere.
TEST_P(Vectors, SampleValuesAsPlainCodeDoes) {
  constexpr float kFar = 1e30f, kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const Picture& picture : pictures(random_)) {
    const auto position = [&](int size) {
      switch (whole(0, 5)) {
        case 0:
          return float(whole(0, 256 * std::min(size, 500))) / 256;
        case 1:
          return float(size) - number(0, 2);
        case 2:
          return number(-2, 2);
        case 3:
          return std::array<float, 4>{kFar, -kFar, kNaN, float(size)}[std::size_t(whole(0, 3))];
        default:
          return number(0, float(size));
      }
    };
    for (int n = 0; n < 200; ++n) {
      Points points;
      for (int i = 0; i < kTileWidth; ++i) {
        points.u[i] = position(picture.view.width);
        points.v[i] = position(picture.view.height);
      }
      const int begin = whole(0, kTileWidth - 1), count = whole(1, kTileWidth - begin);
      expect_same(kernels_, count, "row " + std::to_string(n), [&](const Kernels& kernels, Value* to) {
        kernels.sample_values(picture.view, points, begin, count, to);
      });
    }
  }
}

TEST_P(Vectors, LayValuesOverOthersAsPlainCodeDoes) {
  for (int count = 0; count <= kTileWidth; ++count) {
    std::vector<Value> drawn(kRoom), below(kRoom);
    for (Value& value : below) value = Value(random_() & 255);
    for (int i = 0; i < kRowRoom; ++i) {
      // Runs that hide all or nothing, and pixels in between; a colour may exceed its alpha.
      const bool mixed = i / 16 % 2 == count % 2;
      for (int k = 0; k < 4; ++k) drawn[std::size_t(4 * i + k)] = Value(random_() & 255);
      if (!mixed || random_() % 4 == 0) drawn[std::size_t(4 * i + 3)] = 255;
    }
    std::vector<Value> plain = below, wide = below;
    kPlainKernels.values_over(drawn.data(), count, plain.data());
    kernels_.values_over(drawn.data(), count, wide.data());
    ASSERT_EQ(plain, wide) << count;  // what follows is left as it was
  }
}

TEST_P(Vectors, PackColoursAsPlainCodeDoes) {
  std::vector<Value> pixels(kRoom);
  for (Value& value : pixels) value = Value(random_() & 255);
  for (int count = 0; count <= kTileWidth; ++count) {
    std::vector<Value> plain(kRoom, 77), wide(kRoom, 77);
    kPlainKernels.values_to_rgb(pixels.data(), count, plain.data());
    kernels_.values_to_rgb(pixels.data(), count, wide.data());
    ASSERT_EQ(plain, wide) << count;
  }
}

// The sanitizers see a read beyond the picture's last byte.
TEST_P(Vectors, PrepareColoursAsPlainCodeDoes) {
  for (int count = 0; count <= kTileWidth; ++count) {
    std::vector<std::uint8_t> colours(std::size_t(3 * count));
    for (std::uint8_t& value : colours) value = std::uint8_t(random_() & 255);
    std::vector<Value> plain(kRoom, 77), wide(kRoom, 77);
    kPlainKernels.rgb_to_texels(colours.data(), count, plain.data());
    kernels_.rgb_to_texels(colours.data(), count, wide.data());
    ASSERT_EQ(plain, wide) << count;
  }
}

// A machine without the instructions runs what it has: the same code twice.
INSTANTIATE_TEST_SUITE_P(OfEachWidth, Vectors,
                         testing::Values(Instructions{256, false}, Instructions{512, false},
                                         Instructions{512, true}),
                         [](const auto& info) {
                           return std::to_string(info.param.vector_bits) +
                                  (info.param.gathers ? "Gathers" : "");
                         });

}  // namespace
}  // namespace procam::render
