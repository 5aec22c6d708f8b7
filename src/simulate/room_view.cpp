#include "procam/simulate/room_view.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "record.hpp"
#include "room_sampling.hpp"

namespace procam::simulate {
namespace {

void check_view(const std::vector<RoomLight>& lights, const RoomViewOptions& options) {
  for (const RoomLight& light : lights) {
    const ImageSize size = light.projector.size();
    require(light.frames.size() == lights.front().frames.size() && !light.frames.empty(),
            "room_view: the lights show different numbers of frames, or none");
    for (const ImageU8& frame : light.frames)
      require(frame.size() == size && frame.channels() == 1,
              "room_view: a projector frame is " + std::to_string(frame.width()) + "x" +
                  std::to_string(frame.height()) + "x" + std::to_string(frame.channels()) +
                  ", the projector " + std::to_string(size.width) + "x" + std::to_string(size.height) + "x1");
    require(light.intensity >= 0 && light.blur_px >= 0 && light.gamma > 0,
            "room_view: a light's intensity or blur is negative, or its gamma not above zero");
  }
  require(options.samples_per_axis >= 1 && options.samples_per_axis <= 16,
          "room_view: samples_per_axis not in 1..16");
  require(options.exposure >= 0 && options.brightest_grey > 0,
          "room_view: exposure is negative, or brightest_grey not above zero");
  require(options.camera_blur_px >= 0 && options.vignetting >= 0 && options.gamma > 0,
          "room_view: blur or vignetting is negative, or gamma not above zero");
  require(options.noise.at_black >= 0 && options.noise.per_level >= 0, "room_view: negative noise variance");
  require(std::isfinite(options.time) && std::isfinite(options.row_time), "room_view: a time is not finite");
}

/// The brightest pixel under full light of all projectors.
double brightest_level(const internal::SampledView& view, const std::vector<RoomLight>& lights) {
  double brightest = 0;
  const ImageSize size = view.ambient_level.size();
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      double level = view.ambient_level.at(x, y);
      for (std::size_t l = 0; l < lights.size(); ++l) {
        const internal::LightSample* sample = view.of_row(l, y) + std::ptrdiff_t(x) * view.samples_per_pixel;
        for (int i = 0; i < view.samples_per_pixel; ++i, ++sample)
          if (lights[l].projector.size().contains(Vec2(sample->u, sample->v))) level += sample->level;
      }
      brightest = std::max(brightest, level);
    }
  require(brightest > 0, "room_view: no light reaches what the camera sees");
  return brightest;
}

}  // namespace

RoomView room_view(const Room& room, const Camera& camera, const Motion& room_from_camera,
                   const std::vector<RoomLight>& lights, const RoomViewOptions& options) {
  check_view(lights, options);
  std::vector<internal::ShownFrames> shown;
  std::vector<double> reach;
  for (const RoomLight& light : lights) {
    shown.push_back({light.frames, light.blur_px, light.gamma});
    reach.push_back(double(internal::gaussian_kernel(light.blur_px).size()));
  }
  internal::RoomSamples samples =
      internal::sample_room(room, camera, room_from_camera, lights, reach, options);

  internal::Sensor sensor;
  sensor.exposure = options.exposure > 0 ? options.exposure
                                         : options.brightest_grey / brightest_level(samples.view, lights);
  sensor.blur_px = options.camera_blur_px;
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
