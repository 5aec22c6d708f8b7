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
  require(options.projector_lens.aperture >= 0 && options.projector_lens.focus > 0,
          "capture: the projector's aperture is negative, or its focus not before it");
  require(options.indirect >= 0 && options.glare >= 0 && options.glare < 1,
          "capture: negative indirect light, or glare not in [0, 1)");
  require(options.vignetting >= 0 && options.gamma > 0, "capture: negative vignetting, or gamma not above 0");
  require(options.faults.empty() || options.faults.size() == frames.size(),
          "capture: faults for another number of frames");
  require(options.spot >= 0 && options.spot_radius_px > 0, "capture: spot or its radius out of range");
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

}  // namespace

std::vector<ImageU8> capture(const World& world, const std::vector<ImageU8>& projector_frames,
                             const CaptureOptions& options) {
  check(world, projector_frames, options);
  const double gain = exposure(world, options.brightest_grey);
  internal::SampledView view = internal::sample_view(world, options);
  internal::Sensor sensor;
  sensor.exposure = gain;
  sensor.blur_px = options.camera_blur_px;
  sensor.channels = projector_frames.empty() ? 1 : projector_frames.front().channels();
  sensor.crosstalk = options.crosstalk;
  sensor.indirect = options.indirect;
  sensor.glare = options.glare;
  sensor.falloff = std::move(view.falloff);
  sensor.gamma = options.gamma;
  sensor.faults = options.faults;
  sensor.spot = options.spot;
  sensor.spot_radius_px = options.spot_radius_px;
  sensor.spot_at = options.spot_at;
  sensor.noise = options.noise;
  sensor.seed = options.seed;
  return internal::record(view, {{projector_frames, options.projector_blur_px}}, projector_frames.size(),
                          sensor, options.threads);
}

}  // namespace procam::simulate
