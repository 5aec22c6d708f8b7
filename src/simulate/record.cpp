#include "record.hpp"

#include <algorithm>
#include <cmath>

#include "blur.hpp"
#include "noise.hpp"
#include "parallel.hpp"

namespace procam::simulate::internal {
namespace {

/// The linear levels of the frames first .. first + kFrames - 1 (as far as there are any): what falls on the
/// sensor of a perfect camera lens.
template <std::size_t kFrames>
std::vector<ImageF> gather_light(const SampledView& view, const std::vector<ShownFrames>& lights,
                                 std::size_t first, std::size_t count, int threads) {
  using Field = LightField<kFrames>;
  std::vector<Field> fields;
  for (const ShownFrames& light : lights) fields.emplace_back(light, first, threads);
  const ImageSize size = view.ambient_level.size();
  std::vector<ImageF> levels(std::min(count - first, kFrames), ImageF(size));
  parallel_for(size.height, threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y)
      for (int x = 0; x < size.width; ++x) {
        typename Field::Levels sum;
        sum.fill(view.ambient_level.at(x, y));
        for (std::size_t l = 0; l < fields.size(); ++l) {
          const LightSample* sample = view.of_row(l, y) + std::ptrdiff_t(x) * view.samples_per_pixel;
          for (int i = 0; i < view.samples_per_pixel; ++i, ++sample)
            if (sample->level > 0) fields[l].add(sample->u, sample->v, sample->level, sum);
        }
        for (std::size_t i = 0; i < levels.size(); ++i) levels[i].at(x, y) = sum[i];
      }
  });
  return levels;
}

}  // namespace

ImageU8 develop(const ImageF& levels, const Sensor& sensor, std::uint64_t frame) {
  const std::vector<float>& normal = normal_table();
  const bool noisy = sensor.noise.at_black > 0 || sensor.noise.per_level > 0;
  ImageU8 grey(levels.size());
  std::vector<float> row(std::size_t(levels.width()));
  for (int y = 0; y < levels.height(); ++y) {
    const float* in = levels.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) row[x] = float(sensor.exposure) * in[x];
    if (!sensor.falloff.empty())
      for (std::size_t x = 0; x < row.size(); ++x) row[x] *= sensor.falloff.row(y)[x];
    if (noisy) {
      const float at_black = float(sensor.noise.at_black), per_level = float(sensor.noise.per_level);
      Random random(sensor.seed, frame, std::uint64_t(y));
      std::uint64_t bits = 0;
      for (std::size_t x = 0; x < row.size(); ++x, bits >>= 16) {
        if (x % 4 == 0) bits = random.next();
        row[x] += std::sqrt(at_black + per_level * row[x]) * normal[bits & 0xffff];
      }
    }
    for (float& value : row) value = std::min(std::max(value, 0.f), 255.f);
    if (sensor.gamma != 1)
      for (float& value : row) value = 255 * std::pow(value / 255, float(1 / sensor.gamma));
    std::transform(row.begin(), row.end(), grey.row(y),
                   [](float value) { return std::uint8_t(value + 0.5f); });
  }
  return grey;
}

std::vector<ImageU8> record(const SampledView& view, const std::vector<ShownFrames>& lights,
                            std::size_t count, const Sensor& sensor, int threads) {
  constexpr std::size_t kMany = 16;
  const std::vector<float> kernel = gaussian_kernel(sensor.blur_px);
  std::vector<ImageU8> captures(count);
  for (std::size_t first = 0; first < count; first += kMany) {
    const std::vector<ImageF> levels = count - first == 1
                                           ? gather_light<1>(view, lights, first, count, threads)
                                           : gather_light<kMany>(view, lights, first, count, threads);
    parallel_for(int(levels.size()), threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const std::size_t frame = first + std::size_t(i);
        captures[frame] = develop(convolve(levels[std::size_t(i)], kernel), sensor, frame);
      }
    });
  }
  return captures;
}

}  // namespace procam::simulate::internal
