#include "record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "blur.hpp"
#include "defocus.hpp"
#include "noise.hpp"
#include "procam/core/base/parallel.hpp"

namespace procam::simulate::internal {
namespace {

constexpr std::size_t kMaxPlanes = 16;

/// The linear levels of a camera channel for each plane: what falls on the sensor of a lens without blur.
template <std::size_t kPlanes>
std::vector<ImageF> gather_light(const SampledView& view, const std::vector<ShownFrames>& lights,
                                 const std::vector<LightPlane>& planes, std::size_t band, int threads) {
  using Field = LightField<kPlanes>;
  const ImageSize size = view.ambient_level.size();
  std::vector<ImageF> levels(planes.size(), ImageF(size));
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        levels[i].at(x, y) = planes[i].white() * view.ambient_level.at(x, y, int(band));
  for (std::size_t i = 0; i < planes.size() && !view.received.by_frame.empty(); ++i)
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        levels[i].at(x, y) +=
            planes[i].white() * view.albedo.at(x, y) * view.received.at(planes[i].frame, x, y);

  /// `share(ray)`: how much of a ray's light takes this field.
  const auto add = [&](std::size_t l, const Field& field, const auto& share) {
    parallel_for(size.height, threads, [&](int begin, int end) {
      for (int y = begin; y < end; ++y)
        for (int x = 0; x < size.width; ++x) {
          typename Field::Levels sum{};
          const std::size_t first = view.first_ray_of(x, y);
          for (std::size_t ray = first; ray < first + std::size_t(view.samples_per_pixel); ++ray) {
            const LightSample& sample = view.of_light[l][ray];
            const float level = sample.level * view.tint(ray, band) * share(ray);
            if (level > 0) field.add(sample.u, sample.v, level, sum);
          }
          for (std::size_t i = 0; i < levels.size(); ++i) levels[i].at(x, y) += sum[i];
        }
    });
  };
  for (std::size_t l = 0; l < lights.size(); ++l) {
    if (view.discs[l].empty()) {
      add(l, Field(lights[l], planes, {}, threads), [](std::size_t) { return 1.f; });
      continue;
    }
    const std::vector<double>& radii = view.disc_radii;
    std::vector<bool> used(radii.size() + 1);
    for (std::size_t ray = 0; ray < view.discs[l].size(); ++ray)
      if (view.of_light[l][ray].level > 0)
        for (const int disc : {0, 1})
          used[std::size_t(disc_mix(view.discs[l][ray], radii).disc + disc)] = true;
    for (int disc = 0; disc < int(radii.size()); ++disc)
      if (used[std::size_t(disc)])
        add(l, Field(lights[l], planes, disc_kernel(radii[std::size_t(disc)]), threads),
            [&](std::size_t ray) { return disc_mix(view.discs[l][ray], radii).share(disc); });
  }
  return levels;
}

std::vector<ImageF> gather_light(const SampledView& view, const std::vector<ShownFrames>& lights,
                                 const std::vector<LightPlane>& planes, std::size_t band, int threads) {
  if (planes.size() == 1) return gather_light<1>(view, lights, planes, band, threads);
  if (planes.size() <= 4) return gather_light<4>(view, lights, planes, band, threads);
  return gather_light<kMaxPlanes>(view, lights, planes, band, threads);
}

/// What a channel of the sensor sees of red, green and blue light; sum 1.
std::array<float, 3> response(const Sensor& sensor, int channel) {
  if (sensor.channels == 1) return {1 / 3.f, 1 / 3.f, 1 / 3.f};
  std::array<float, 3> weights;
  float sum = 0;
  for (int band = 0; band < 3; ++band) {
    const int apart = std::abs(band - channel);
    weights[std::size_t(band)] = apart == 0 ? 1 : apart == 1 ? float(sensor.crosstalk) : 0;
    sum += weights[std::size_t(band)];
  }
  for (float& weight : weights) weight /= sum;
  return weights;
}

/// Levels of the sensor's channels, frame by frame: numbers [first, end) of count * channels.
std::vector<ImageF> levels_of(const SampledView& view, const std::vector<ShownFrames>& lights,
                              std::size_t first, std::size_t end, const Sensor& sensor, int threads) {
  const std::size_t channels = std::size_t(sensor.channels);
  std::vector<LightPlane> planes;
  for (std::size_t i = first; i < end; ++i)
    planes.push_back({i / channels, response(sensor, int(i % channels))});
  if (view.bands == 1) return gather_light(view, lights, planes, 0, threads);
  // Surfaces with colour: each band's light by itself.
  std::vector<ImageF> sum(planes.size(), ImageF(view.ambient_level.size()));
  for (std::size_t band = 0; band < 3; ++band) {
    std::vector<LightPlane> of_band = planes;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      of_band[i].bands = {};
      of_band[i].bands[band] = planes[i].bands[band];
    }
    const std::vector<ImageF> levels = gather_light(view, lights, of_band, band, threads);
    const std::ptrdiff_t pixels = std::ptrdiff_t(sum[0].width()) * sum[0].height();
    for (std::size_t i = 0; i < planes.size(); ++i)
      std::transform(levels[i].data(), levels[i].data() + pixels, sum[i].data(), sum[i].data(),
                     std::plus<>());
  }
  return sum;
}

/// Widths of the light that surfaces and the lens scatter, in image widths.
constexpr double kIndirectWidth = 0.06, kGlareWidth = 0.15;

}  // namespace

ImageF through_lens(ImageF levels, const ImageF& albedo, const Sensor& sensor,
                    const std::vector<float>& kernel) {
  const std::ptrdiff_t pixels = std::ptrdiff_t(levels.width()) * levels.height();
  if (sensor.indirect > 0) {
    const ImageF around = low_pass(levels, kIndirectWidth * levels.width());
    for (std::ptrdiff_t i = 0; i < pixels; ++i)
      levels.data()[i] += float(sensor.indirect) * albedo.data()[i] * around.data()[i];
  }
  if (!(sensor.glare > 0)) return convolve(levels, kernel);
  const ImageF veil = low_pass(levels, kGlareWidth * levels.width());
  ImageF seen = convolve(levels, kernel);
  for (std::ptrdiff_t i = 0; i < pixels; ++i)
    seen.data()[i] += float(sensor.glare) * (veil.data()[i] - seen.data()[i]);
  return seen;
}

namespace {

/// The image moved by `shift`, linear between pixels; beyond the border the outermost pixels repeat.
ImageF shifted(const ImageF& image, const Vec2& shift) {
  ImageF result(image.size());
  const float left = float(shift.x() - std::floor(shift.x())), top = float(shift.y() - std::floor(shift.y()));
  const int dx = int(std::floor(shift.x())), dy = int(std::floor(shift.y()));
  const auto at = [&](int x, int y) {
    return image.at(std::clamp(x, 0, image.width() - 1), std::clamp(y, 0, image.height() - 1));
  };
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const int u = x - dx, v = y - dy;
      result.at(x, y) = (1 - top) * ((1 - left) * at(u, v) + left * at(u - 1, v)) +
                        top * ((1 - left) * at(u, v - 1) + left * at(u - 1, v - 1));
    }
  return result;
}

/// The sensor's levels with the reflection of a lamp and what this frame suffers.
ImageF spoiled(ImageF levels, const Sensor& sensor, std::size_t frame) {
  if (sensor.spot > 0) {
    const double top = 255 * sensor.spot / sensor.exposure;
    const int reach = int(4 * sensor.spot_radius_px);
    const int x0 = int(sensor.spot_at.x()), y0 = int(sensor.spot_at.y());
    for (int y = std::max(0, y0 - reach); y < std::min(levels.height(), y0 + reach); ++y)
      for (int x = std::max(0, x0 - reach); x < std::min(levels.width(), x0 + reach); ++x)
        levels.at(x, y) += float(top * std::exp(-0.5 * (Vec2(x, y) - sensor.spot_at).squaredNorm() /
                                                (sensor.spot_radius_px * sensor.spot_radius_px)));
  }
  if (sensor.faults.empty()) return levels;
  const FrameFault& fault = sensor.faults.at(frame);
  if (fault.blur_px > 0) levels = convolve(levels, gaussian_kernel(fault.blur_px));
  if (fault.shift_px != Vec2::Zero()) levels = shifted(levels, fault.shift_px);
  for (int y = 0; y < levels.height(); ++y) {
    const double wave = std::sin(2 * kPi * (y / fault.ripple_rows + fault.ripple_phase));
    const float factor = float(fault.gain * (1 + fault.ripple * wave));
    for (int x = 0; x < levels.width(); ++x) levels.at(x, y) *= factor;
  }
  return levels;
}

constexpr int kCurveSteps = 1000;

}  // namespace

std::vector<std::uint8_t> response_curve(double gamma) {
  std::vector<std::uint8_t> curve;
  if (gamma == 1) return curve;
  for (int i = 0; i <= 255 * kCurveSteps; ++i)
    curve.push_back(std::uint8_t(255 * value_of_light(float(i) / (255 * kCurveSteps), gamma) + 0.5f));
  return curve;
}

ImageU8 develop(const ImageF& levels, const Sensor& sensor, const std::vector<std::uint8_t>& curve,
                std::uint64_t number) {
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
      Random random(sensor.seed, number, std::uint64_t(y));
      std::uint64_t bits = 0;
      for (std::size_t x = 0; x < row.size(); ++x, bits >>= 16) {
        if (x % 4 == 0) bits = random.next();
        row[x] += std::sqrt(at_black + per_level * row[x]) * normal[bits & 0xffff];
      }
    }
    for (float& value : row) value = std::min(std::max(value, 0.f), 255.f);
    if (curve.empty())
      std::transform(row.begin(), row.end(), grey.row(y),
                     [](float value) { return std::uint8_t(value + 0.5f); });
    else
      std::transform(row.begin(), row.end(), grey.row(y),
                     [&](float value) { return curve[std::size_t(value * kCurveSteps + 0.5f)]; });
  }
  return grey;
}

namespace {

/// Channels of one picture put together.
ImageU8 interleaved(const ImageU8* channels, int count) {
  ImageU8 picture(channels[0].size(), count);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < count; ++c) picture.at(x, y, c) = channels[c].at(x, y);
  return picture;
}

}  // namespace

std::vector<ImageU8> record(const SampledView& view, const std::vector<ShownFrames>& lights,
                            std::size_t count, const Sensor& sensor, int threads) {
  const std::vector<float> kernel = gaussian_kernel(sensor.blur_px);
  const std::vector<std::uint8_t> curve = response_curve(sensor.gamma);
  const std::size_t channels = std::size_t(sensor.channels);
  std::vector<ImageU8> developed(count * channels);
  for (std::size_t first = 0; first < developed.size(); first += kMaxPlanes) {
    const std::size_t end = std::min(first + kMaxPlanes, developed.size());
    std::vector<ImageF> levels = levels_of(view, lights, first, end, sensor, threads);
    if (!sensor.discs.empty()) defocus(levels, sensor.discs, threads);
    parallel_for(int(levels.size()), threads, [&](int part, int part_end) {
      for (std::size_t i = std::size_t(part); i < std::size_t(part_end); ++i)
        developed[first + i] =
            develop(spoiled(through_lens(std::move(levels[i]), view.albedo, sensor, kernel), sensor,
                            (first + i) / channels),
                    sensor, curve, first + i);
    });
  }
  if (channels == 1) return developed;
  std::vector<ImageU8> captures;
  for (std::size_t i = 0; i < count; ++i)
    captures.push_back(interleaved(developed.data() + i * channels, sensor.channels));
  return captures;
}

}  // namespace procam::simulate::internal
