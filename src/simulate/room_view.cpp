#include "procam/simulate/room_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "blur_disc.hpp"
#include "defocus.hpp"
#include "indirect.hpp"
#include "record.hpp"
#include "room_sampling.hpp"

namespace procam::simulate {
namespace {

void check_lens(const ThinLens& lens) {
  require(lens.aperture >= 0 && lens.focus > 0,
          "room_view: a lens has a negative aperture, or its focus is not before it");
}

void check_view(const std::vector<RoomLight>& lights, const RoomViewOptions& options) {
  for (const RoomLight& light : lights) {
    const ImageSize size = light.projector.size();
    require(light.frames.size() == lights.front().frames.size() && !light.frames.empty(),
            "room_view: the lights show different numbers of frames, or none");
    for (const ImageU8& frame : light.frames)
      require(frame.size() == size && (frame.channels() == 1 || frame.channels() == 3),
              "room_view: a projector frame is " + std::to_string(frame.width()) + "x" +
                  std::to_string(frame.height()) + "x" + std::to_string(frame.channels()) +
                  ", the projector " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                  ", in 1 channel or 3");
    check_lens(light.lens);
    require(
        light.intensity >= 0 && light.blur_px >= 0 && light.gamma >= 0 && light.black >= 0 && light.black < 1,
        "room_view: a light's intensity, blur or gamma is negative, or its black not in [0, 1)");
  }
  check_lens(options.lens);
  require(options.crosstalk >= 0 && options.crosstalk < 0.5, "room_view: crosstalk not in [0, 0.5)");
  require(options.samples_per_axis >= 1 && options.samples_per_axis <= internal::kMaxPerAxis,
          "room_view: samples_per_axis not in 1..16");
  require(options.exposure >= 0 && options.brightest_grey > 0,
          "room_view: exposure is negative, or brightest_grey not above zero");
  require(options.camera_blur_px >= 0 && options.vignetting >= 0 && options.gamma >= 0,
          "room_view: blur, vignetting or gamma is negative");
  require(options.noise.at_black >= 0 && options.noise.per_level >= 0, "room_view: negative noise variance");
  require(std::isfinite(options.time) && std::isfinite(options.row_time), "room_view: a time is not finite");
}

void check_indirect(const Motion& room_from_camera, const std::vector<RoomLight>& lights) {
  require(room_from_camera.is_still(), "room_view: indirect light of a camera that moves is not simulated");
  for (const RoomLight& light : lights)
    for (const ImageU8& frame : light.frames)
      require(light.room_from_projector.is_still() && frame.channels() == 1,
              "room_view: indirect light of projectors that move, and of frames in colour, is not simulated");
}

/// The brightest pixel under full light of all projectors.
double brightest_level(const internal::SampledView& view, const std::vector<RoomLight>& lights) {
  double brightest = 0;
  const ImageSize size = view.ambient_level.size();
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      std::array<double, 3> level{};
      for (int band = 0; band < view.bands; ++band)
        level[std::size_t(band)] = view.ambient_level.at(x, y, band);
      const std::size_t first = view.first_ray_of(x, y);
      for (std::size_t l = 0; l < lights.size(); ++l)
        for (std::size_t ray = first; ray < first + std::size_t(view.samples_per_pixel); ++ray) {
          const internal::LightSample& sample = view.of_light[l][ray];
          if (!lights[l].projector.size().contains(Vec2(sample.u, sample.v))) continue;
          for (std::size_t band = 0; band < std::size_t(view.bands); ++band)
            level[band] += sample.level * view.tint(ray, band);
        }
      brightest = std::max({brightest, level[0], level[1], level[2]});
    }
  require(brightest > 0, "room_view: no light reaches what the camera sees");
  return brightest;
}

ImageF discs_of(const ThinLens& lens, const Camera& camera, const ImageF& depth) {
  ImageF radius(depth.size());
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x)
      radius.at(x, y) =
          float(internal::disc_radius(lens, camera, depth.at(x, y) > 0 ? depth.at(x, y) : kInfinity));
  return radius;
}

}  // namespace

double blur_disc(const ThinLens& lens, const Camera& device, double depth) {
  check_lens(lens);
  require(depth > 0, "blur_disc: the depth is not above zero");
  return 2 * std::abs(internal::disc_radius(lens, device, depth));
}

RoomView room_view(const Room& room, const Camera& camera, const Motion& room_from_camera,
                   const std::vector<RoomLight>& lights, const RoomViewOptions& options) {
  check_view(lights, options);
  if (room.indirect) check_indirect(room_from_camera, lights);
  std::vector<internal::ShownFrames> shown;
  std::vector<double> reach;
  for (const RoomLight& light : lights) {
    shown.push_back({light.frames, light.blur_px, light.gamma, light.black});
    reach.push_back(double(internal::gaussian_kernel(light.blur_px).size()) +
                    (light.lens.aperture > 0 ? internal::kDiscRadii.back() + 1 : 0));
  }
  internal::RoomSamples samples =
      internal::sample_room(room, camera, room_from_camera, lights, reach, options);

  if (room.indirect) {
    require(samples.view.bands == 1,
            "room_view: the indirect light of surfaces with colour is not simulated");
    const Pose still = room_from_camera(options.time);
    internal::add_mirrored_light(room, camera, still, lights, options.threads, samples, shown);
    internal::add_diffuse_light(room, camera, still, lights, options.threads, samples);
  }
  internal::Sensor sensor;
  sensor.exposure = options.exposure > 0 ? options.exposure
                                         : options.brightest_grey / brightest_level(samples.view, lights);
  sensor.blur_px = options.camera_blur_px;
  if (options.lens.aperture > 0) sensor.discs = discs_of(options.lens, camera, samples.truth.depth);
  sensor.channels = options.colour ? 3 : 1;
  sensor.crosstalk = options.crosstalk;
  sensor.falloff = std::move(samples.falloff);
  sensor.noise = options.noise;
  sensor.gamma = options.gamma;
  sensor.seed = options.seed;
  RoomView view;
  view.exposure = sensor.exposure;
  view.captures = internal::record(samples.view, shown, lights.empty() ? 1 : lights.front().frames.size(),
                                   sensor, options.threads);
  view.truth = std::move(samples.truth);
  return view;
}

}  // namespace procam::simulate
