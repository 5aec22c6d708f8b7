#include "procam/simulate/capture.hpp"

#include <cmath>
#include <string>

#include "blur.hpp"
#include "light_field.hpp"
#include "noise.hpp"
#include "parallel.hpp"
#include "sampling.hpp"
#include "scene.hpp"

namespace procam::simulate {
namespace {

using internal::LightField;

void check(const World& world, const std::vector<ImageU8>& frames, const CaptureOptions& options) {
  const ImageSize size = world.rig.projector().projector.size();
  for (const ImageU8& frame : frames)
    require(frame.size() == size && (frame.channels() == 1 || frame.channels() == 3) &&
                frame.channels() == frames.front().channels(),
            "capture: a projector frame is " + std::to_string(frame.width()) + "x" +
                std::to_string(frame.height()) + "x" + std::to_string(frame.channels()) + ", the projector " +
                std::to_string(size.width) + "x" + std::to_string(size.height) + ", in 1 channel or 3");
  require(options.samples_per_axis >= 1 && options.samples_per_axis <= 16,
          "capture: samples_per_axis not in 1..16");
  require(options.camera_blur_px >= 0 && options.projector_blur_px >= 0, "capture: negative blur");
  require(options.noise.at_black >= 0 && options.noise.per_level >= 0, "capture: negative noise variance");
  require(options.crosstalk >= 0 && options.crosstalk < 0.5, "capture: crosstalk not in [0, 0.5)");
  require(options.brightest_grey > 0, "capture: brightest_grey must be above zero");
}

/// Grey levels per unit of albedo * irradiance, so that the sheet's brightest corner reads brightest_grey.
double exposure(const World& world, double brightest_grey) {
  const Vec3 light_in_board =
      world.rig_from_board.inverse() * world.rig.projector().rig_from_projector.translation;
  double brightest = 0;
  for (const Vec3& corner : sheet_corners_in_board(world.board)) {
    const Vec3 to_light = light_in_board - corner;
    const double irradiance = std::abs(to_light.z()) / std::pow(to_light.norm(), 3);
    brightest = std::max(brightest, world.board.white_albedo * (irradiance + world.ambient));
  }
  require(brightest > 0, "capture: no light reaches the sheet (projector in its plane, or albedo 0)");
  return brightest_grey / brightest;
}

/// The linear levels of up to LightField::kFrames frames: what falls on the sensor of a perfect camera lens.
std::vector<ImageF> collect(const internal::SampledView& view, const LightField& light, int count,
                            int threads) {
  const ImageSize size = view.ambient_level.size();
  std::vector<ImageF> levels(static_cast<std::size_t>(count), ImageF(size));
  internal::parallel_for(size.height, threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      const internal::LightSample* sample = view.of_row(y);
      for (int x = 0; x < size.width; ++x) {
        LightField::Levels sum;
        sum.fill(view.ambient_level.at(x, y));
        for (int i = 0; i < view.samples_per_pixel; ++i, ++sample)
          if (sample->level > 0) light.add(sample->u, sample->v, sample->level, sum);
        for (int i = 0; i < count; ++i) levels[std::size_t(i)].at(x, y) = sum[std::size_t(i)];
      }
    }
  });
  return levels;
}

/// Exposure, noise, 8 bits. Every (frame, row) has a random stream of its own, so threads change nothing.
ImageU8 develop(const ImageF& levels, double exposure, const CaptureOptions& options, std::uint64_t frame) {
  const std::vector<float>& normal = internal::normal_table();
  const bool noisy = options.noise.at_black > 0 || options.noise.per_level > 0;
  ImageU8 grey(levels.size());
  std::vector<float> row(std::size_t(levels.width()));
  for (int y = 0; y < levels.height(); ++y) {
    const float* in = levels.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) row[x] = float(exposure) * in[x];
    if (noisy) {
      const float at_black = float(options.noise.at_black), per_level = float(options.noise.per_level);
      internal::Random random(options.seed, frame, std::uint64_t(y));
      std::uint64_t bits = 0;
      for (std::size_t x = 0; x < row.size(); ++x, bits >>= 16) {
        if (x % 4 == 0) bits = random.next();
        row[x] += std::sqrt(at_black + per_level * row[x]) * normal[bits & 0xffff];
      }
    }
    std::uint8_t* out = grey.row(y);
    for (std::size_t x = 0; x < row.size(); ++x)
      out[x] = std::uint8_t(std::min(std::max(row[x], 0.f), 255.f) + 0.5f);
  }
  return grey;
}

/// What one channel of the sensor sees of a colour frame's light.
ImageU8 light_in(const ImageU8& frame, int channel, double crosstalk) {
  ImageU8 light(frame.size());
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      double sum = 0, weights = 0;
      for (int c = 0; c < 3; ++c) {
        const double weight = c == channel ? 1 : std::abs(c - channel) == 1 ? crosstalk : 0;
        sum += weight * frame.at(x, y, c);
        weights += weight;
      }
      light.at(x, y) = std::uint8_t(std::lround(sum / weights));
    }
  return light;
}

/// The three channels as grey frames, one after the other, captured and put together again.
std::vector<ImageU8> capture_colour(const World& world, const std::vector<ImageU8>& frames,
                                    const CaptureOptions& options) {
  std::vector<ImageU8> channels;
  for (const ImageU8& frame : frames)
    for (int c = 0; c < 3; ++c) channels.push_back(light_in(frame, c, options.crosstalk));
  const std::vector<ImageU8> seen = capture(world, channels, options);
  std::vector<ImageU8> captures;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ImageU8& out = captures.emplace_back(seen[3 * i].size(), 3);
    for (int y = 0; y < out.height(); ++y)
      for (int x = 0; x < out.width(); ++x)
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = seen[3 * i + std::size_t(c)].at(x, y);
  }
  return captures;
}

}  // namespace

std::vector<ImageU8> capture(const World& world, const std::vector<ImageU8>& projector_frames,
                             const CaptureOptions& options) {
  check(world, projector_frames, options);
  if (!projector_frames.empty() && projector_frames.front().channels() == 3)
    return capture_colour(world, projector_frames, options);
  const double gain = exposure(world, options.brightest_grey);
  const internal::SampledView view = internal::sample_view(world, options.samples_per_axis, options.threads);
  const std::vector<float> projector_kernel = internal::gaussian_kernel(options.projector_blur_px);
  const std::vector<float> camera_kernel = internal::gaussian_kernel(options.camera_blur_px);

  std::vector<ImageU8> captures(projector_frames.size());
  for (std::size_t first = 0; first < projector_frames.size(); first += LightField::kFrames) {
    const int count = int(std::min(projector_frames.size() - first, std::size_t(LightField::kFrames)));
    const LightField light(projector_frames, first, projector_kernel, options.threads);
    const std::vector<ImageF> levels = collect(view, light, count, options.threads);
    internal::parallel_for(count, options.threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const std::size_t frame = first + std::size_t(i);
        captures[frame] =
            develop(internal::convolve(levels[std::size_t(i)], camera_kernel), gain, options, frame);
      }
    });
  }
  return captures;
}

}  // namespace procam::simulate
