#include "procam/simulate/capture.hpp"

#include <cmath>
#include <string>

#include "record.hpp"
#include "sampling.hpp"
#include "scene.hpp"

namespace procam::simulate {
namespace {

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
  internal::Sensor sensor;
  sensor.exposure = gain;
  sensor.blur_px = options.camera_blur_px;
  sensor.noise = options.noise;
  sensor.seed = options.seed;
  return internal::record(view, {{projector_frames, options.projector_blur_px}}, projector_frames.size(),
                          sensor, options.threads);
}

}  // namespace procam::simulate
