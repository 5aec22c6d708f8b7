#include "texture.hpp"

#include "parallel.hpp"

namespace procam::render {

namespace {

/// What one coarse texel takes from the fine row: texel j of n covers fine positions [j, j + 1) * fine / n,
/// at most three texels (3/2 < fine / n <= 2).
struct Share {
  int first;
  float weight[3];
};

std::vector<Share> shares(int fine, int coarse) {
  std::vector<Share> result;
  const double ratio = double(fine) / coarse;
  for (int j = 0; j < coarse; ++j) {
    const double begin = j * ratio, end = (j + 1) * ratio;
    Share share{std::min(int(begin), fine - 1), {0, 0, 0}};
    for (int k = 0; k < 3; ++k) {
      const double low = std::max(begin, double(share.first + k)),
                   high = std::min(end, double(share.first + k + 1));
      if (share.first + k < fine && high > low) share.weight[k] = float((high - low) / ratio);
    }
    result.push_back(share);
  }
  return result;
}

constexpr int kRowsPerTurn = 32;
int turns(int rows) {
  return (rows + kRowsPerTurn - 1) / kRowsPerTurn;
}

}  // namespace

Texture::Texture(ViewU8 image, const LightCurve& curve, int threads) {
  Level base;
  base.width = image.width;
  base.height = image.height;
  base.texels.resize(std::size_t(image.width) * std::size_t(image.height));
  parallel_for(turns(image.height), threads, [&](int turn) {
    const int last = std::min(image.height, (turn + 1) * kRowsPerTurn);
    for (int y = turn * kRowsPerTurn; y < last; ++y) {
      const std::uint8_t* from = image.row(y);
      Rgba* to = base.texels.data() + std::ptrdiff_t(y) * image.width;
      for (int x = 0; x < image.width; ++x, from += image.channels) {
        const bool grey = image.channels == 1;
        const float alpha = image.channels == 4 ? float(from[3]) / 255.0f : 1.0f;
        to[x] =
            Rgba(curve.light(from[0]), curve.light(from[grey ? 0 : 1]), curve.light(from[grey ? 0 : 2]), 1) *
            alpha;
      }
    }
  });
  levels_.push_back(std::move(base));
  while (std::max(levels_.back().width, levels_.back().height) > 1)
    levels_.push_back(half(levels_.back(), threads));
}

Texture::Level Texture::half(const Level& fine, int threads) {
  Level coarse;
  coarse.width = (fine.width + 1) / 2;
  coarse.height = (fine.height + 1) / 2;
  coarse.texels.resize(std::size_t(coarse.width) * std::size_t(coarse.height));
  const std::vector<Share> columns = shares(fine.width, coarse.width),
                           rows = shares(fine.height, coarse.height);
  parallel_for(turns(coarse.height), threads, [&](int turn) {
    const int last = std::min(coarse.height, (turn + 1) * kRowsPerTurn);
    for (int y = turn * kRowsPerTurn; y < last; ++y) {
      Rgba* to = coarse.texels.data() + std::ptrdiff_t(y) * coarse.width;
      std::fill(to, to + coarse.width, Rgba(Rgba::Zero()));
      for (int j = 0; j < 3; ++j) {
        const float down = rows[std::size_t(y)].weight[j];
        if (down == 0) continue;
        const Rgba* from = fine.texels.data() + std::ptrdiff_t(rows[std::size_t(y)].first + j) * fine.width;
        for (int x = 0; x < coarse.width; ++x) {
          const Share& across = columns[std::size_t(x)];
          for (int i = 0; i < 3; ++i)
            if (across.weight[i] != 0) to[x] += down * across.weight[i] * from[across.first + i];
        }
      }
    }
  });
  return coarse;
}

}  // namespace procam::render
