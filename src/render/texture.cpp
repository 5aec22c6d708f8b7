#include "texture.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>

namespace procam::render {

namespace {

constexpr int kRowsPerTurn = 32;

/// Calls row(y) for every row, and copies the last texel and the last row where the kernels want a copy.
template <typename Pixel, typename Row>
void fill(Texels<Pixel>& texels, Workers& workers, const Row& row) {
  const int turns = (texels.height + kRowsPerTurn - 1) / kRowsPerTurn;
  workers.run(turns, [&](int turn) {
    const int last = std::min(texels.height, (turn + 1) * kRowsPerTurn);
    for (int y = turn * kRowsPerTurn; y < last; ++y) {
      Pixel* const to = texels.row(y);
      row(y, to);
      std::copy_n(to + 4 * (texels.width - 1), 4, to + 4 * texels.width);
    }
  });
  const Pixel* const last = texels.row(texels.height - 1);
  std::copy_n(last, 4 * (texels.width + 1), texels.row(texels.height));
}

/// Calls texel(r, g, b, alpha, to) along a row of the image.
template <typename Pixel, typename Texel>
void convert_row(ViewU8 image, int y, Pixel* to, const Texel& texel) {
  const std::uint8_t* from = image.row(y);
  switch (image.channels) {
    case 1:
      for (int x = 0; x < image.width; ++x, ++from, to += 4) texel(from[0], from[0], from[0], 255, to);
      break;
    case 3:
      for (int x = 0; x < image.width; ++x, from += 3, to += 4) texel(from[0], from[1], from[2], 255, to);
      break;
    default:
      for (int x = 0; x < image.width; ++x, from += 4, to += 4) texel(from[0], from[1], from[2], from[3], to);
  }
}

bool is_opaque(ViewU8 image, Workers& workers) {
  if (image.channels != 4) return true;
  std::atomic<bool> opaque{true};
  workers.run((image.height + kRowsPerTurn - 1) / kRowsPerTurn, [&](int turn) {
    for (int y = turn * kRowsPerTurn; y < std::min(image.height, (turn + 1) * kRowsPerTurn) && opaque; ++y) {
      std::uint8_t all = 255;
      for (int x = 0; x < image.width; ++x) all &= image.at(x, y, 3);
      if (all != 255) opaque = false;
    }
  });
  return opaque;
}

/// What one coarse texel takes from the fine row: texel j of n covers fine positions [j, j + 1) * fine / n,
/// at most three texels (3/2 <= fine / n <= 2, or 1 of 1).
struct Share {
  int first;
  float weight[3];
};

Share share(int j, int fine, int coarse) {
  const double ratio = double(fine) / coarse, begin = j * ratio, end = (j + 1) * ratio;
  Share result{std::max(0, std::min(int(begin), fine - 3)), {0, 0, 0}};
  for (int k = 0; k < 3; ++k) {
    const double low = std::max(begin, double(result.first + k)),
                 high = std::min({end, double(result.first + k + 1), double(fine)});
    if (high > low) result.weight[k] = float((high - low) / ratio);
  }
  return result;
}

void halve(const Texels<Light>& fine, Texels<Light>& coarse, Workers& workers) {
  coarse.resize((fine.width + 1) / 2, (fine.height + 1) / 2);
  const bool even = fine.width % 2 == 0 && fine.height % 2 == 0;
  fill(coarse, workers, [&](int y, Light* to) {
    if (even) {
      const Light *upper = fine.row(2 * y), *lower = fine.row(2 * y + 1);
      for (int x = 0; x < coarse.width; ++x, upper += 8, lower += 8)
        for (int k = 0; k < 4; ++k)
          *to++ = Light((upper[k] + upper[k + 4] + lower[k] + lower[k + 4] + 2) >> 2);
      return;
    }
    const Share down = share(y, fine.height, coarse.height);
    for (int x = 0; x < coarse.width; ++x, to += 4) {
      const Share across = share(x, fine.width, coarse.width);
      float sum[4] = {};
      for (int j = 0; j < 3; ++j) {
        if (down.weight[j] == 0) continue;
        const Light* from = fine.row(down.first + j) + 4 * across.first;
        for (int i = 0; i < 3; ++i) {
          if (across.weight[i] == 0) continue;
          for (int k = 0; k < 4; ++k) sum[k] += down.weight[j] * across.weight[i] * float(from[4 * i + k]);
        }
      }
      for (int k = 0; k < 4; ++k) to[k] = Light(std::lround(sum[k]));
    }
  });
}

}  // namespace

int levels_of(ImageSize size) {
  int levels = 1;
  for (int longest = std::max(size.width, size.height); longest > 1; longest = (longest + 1) / 2) ++levels;
  return levels;
}

void LightTexture::prepare(ViewU8 image, const LightCurve& curve, int levels, Workers& workers) {
  if (levels_.size() < std::size_t(levels)) levels_.resize(std::size_t(levels));
  levels_made_ = levels;
  opaque_ = is_opaque(image, workers);
  levels_[0].resize(image.width, image.height);
  fill(levels_[0], workers, [&](int y, Light* row) {
    convert_row(image, y, row, [&](Value r, Value g, Value b, int alpha, Light* to) {
      const auto premultiplied = [&](Value v) {
        return alpha == 255 ? curve.light(v) : Light((curve.light(v) * alpha + 127) / 255);
      };
      to[0] = premultiplied(r);
      to[1] = premultiplied(g);
      to[2] = premultiplied(b);
      to[3] = Light(alpha * 128);
    });
  });
  for (std::size_t l = 1; l < std::size_t(levels); ++l) halve(levels_[l - 1], levels_[l], workers);
}

void ValueTexture::prepare(ViewU8 image, const Kernels& kernels, Workers& workers) {
  opaque_ = is_opaque(image, workers);
  texels_.resize(image.width, image.height);
  fill(texels_, workers, [&](int y, Value* row) {
    if (image.channels == 3) return kernels.rgb_to_texels(image.row(y), image.width, row);
    convert_row(image, y, row, [&](Value r, Value g, Value b, int alpha, Value* to) {
      const auto premultiplied = [&](Value v) {
        return Value((alpha == 255 ? int(v) : (v * alpha + 127) / 255) ^ 0x80);
      };
      to[0] = premultiplied(r);
      to[1] = premultiplied(g);
      to[2] = premultiplied(b);
      to[3] = Value(alpha ^ 0x80);
    });
  });
}

}  // namespace procam::render
