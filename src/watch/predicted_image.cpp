#include "predicted_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "procam/core/base/color.hpp"

namespace procam::watch {
namespace {

std::array<float, 256> srgb_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < 256; ++i) table[i] = light_from_srgb(float(i) / 255);
  return table;
}

float interpolated(const ImageF& image, float x, float y) {
  x = std::clamp(x, 0.f, float(image.width() - 1));
  y = std::clamp(y, 0.f, float(image.height() - 1));
  const int column = std::min(int(x), image.width() - 2), row = std::min(int(y), image.height() - 2);
  const float right = x - float(column), down = y - float(row);
  const float *top = image.row(row) + column, *bottom = image.row(row + 1) + column;
  return (1 - down) * ((1 - right) * top[0] + right * top[1]) +
         down * ((1 - right) * bottom[0] + right * bottom[1]);
}

}  // namespace

ImageF smoothed(const ImageF& image) {
  const int width = image.width(), height = image.height();
  ImageF across(width, height), result(width, height);
  for (int y = 0; y < height; ++y) {
    const float* in = image.row(y);
    float* out = across.row(y);
    const auto at = [&](int x) { return in[std::clamp(x, 0, width - 1)]; };
    for (int x = 0; x < width; ++x) {
      if (x < 2 || x >= width - 2)
        out[x] = (at(x - 2) + 4 * at(x - 1) + 6 * at(x) + 4 * at(x + 1) + at(x + 2)) / 16;
      else
        out[x] = (in[x - 2] + 4 * in[x - 1] + 6 * in[x] + 4 * in[x + 1] + in[x + 2]) / 16;
    }
  }
  for (int y = 0; y < height; ++y) {
    const float* rows[5];
    for (int k = 0; k < 5; ++k) rows[k] = across.row(std::clamp(y + k - 2, 0, height - 1));
    float* out = result.row(y);
    for (int x = 0; x < width; ++x)
      out[x] = (rows[0][x] + 4 * rows[1][x] + 6 * rows[2][x] + 4 * rows[3][x] + rows[4][x]) / 16;
  }
  return result;
}

ImageF averaged(ViewU8 image, int k) {
  ImageF result(image.width / k, image.height / k);
  const float share = 1.f / float(k * k);
  for (int y = 0; y < result.height(); ++y)
    for (int x = 0; x < result.width(); ++x) {
      int sum = 0;
      for (int j = 0; j < k; ++j) {
        const std::uint8_t* in = image.row(y * k + j) + x * k;
        for (int i = 0; i < k; ++i) sum += in[i];
      }
      result.at(x, y) = share * float(sum);
    }
  return result;
}

ImageF frame_light(ViewU8 frame, int k) {
  static const std::array<float, 256> light = srgb_table();
  ImageF result(frame.width / k, frame.height / k);
  const float share = 1.f / float(k * k * frame.channels);
  for (int y = 0; y < result.height(); ++y) {
    float* out = result.row(y);
    for (int j = 0; j < k; ++j) {
      const std::uint8_t* in = frame.row(y * k + j);
      for (int x = 0; x < result.width(); ++x)
        for (int i = 0; i < k * frame.channels; ++i) out[x] += light[*in++];
    }
    for (int x = 0; x < result.width(); ++x) out[x] *= share;
  }
  return result;
}

ImageF light_in_camera(const LightGeometry& geometry, const ImageF& light, int k) {
  constexpr int kSpacing = LightGeometry::kNodeSpacing;
  ImageF seen(geometry.working_size);
  const float scale = 1 / float(k), offset = -0.5f * float(k - 1) / float(k);
  const ImageF& nodes = geometry.node_pixel;
  for (int j = 0; j + 1 < nodes.height(); ++j)
    for (int i = 0; i + 1 < nodes.width(); ++i) {
      if (!geometry.is_lit(i * kSpacing, j * kSpacing)) continue;
      for (int y = 0; y < kSpacing && j * kSpacing + y < seen.height(); ++y) {
        const float down = float(y) / kSpacing;
        float pixel[2], step[2];
        for (int c = 0; c < 2; ++c) {
          const float left = (1 - down) * nodes.at(i, j, c) + down * nodes.at(i, j + 1, c),
                      right = (1 - down) * nodes.at(i + 1, j, c) + down * nodes.at(i + 1, j + 1, c);
          pixel[c] = scale * left + offset;
          step[c] = scale * (right - left) / kSpacing;
        }
        float* out = seen.row(j * kSpacing + y) + i * kSpacing;
        const int count = std::min(kSpacing, seen.width() - i * kSpacing);
        for (int x = 0; x < count; ++x)
          out[x] = interpolated(light, pixel[0] + float(x) * step[0], pixel[1] + float(x) * step[1]);
      }
    }
  return seen;
}

}  // namespace procam::watch
