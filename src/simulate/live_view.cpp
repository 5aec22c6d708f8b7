#include "procam/simulate/live_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "blur.hpp"
#include "procam/core/base/parallel.hpp"
#include "record.hpp"
#include "room_sampling.hpp"
#include "tone.hpp"

namespace procam::simulate {
namespace {

/// Variances of the light's blur: two Gaussians are drawn, and a pixel's is a mixture of them with its variance.
constexpr int kBlurs = 2;

/// What a camera pixel gets of a frame.
struct LiveTap {
  float u = 0, v = 0;       ///< projector pixel
  float lit = 0;            ///< level under full light
  float variance = 0;       ///< of the light's blur, projector pixels^2
  float share_of_wide = 0;  ///< of the second Gaussian
};

float at(const ImageF& light, float x, float y) {
  if (!(x >= 0 && y >= 0 && x < float(light.width() - 1) && y < float(light.height() - 1))) return 0;
  const int column = int(x), row = int(y);
  const float right = x - float(column), down = y - float(row);
  const float *top = light.row(row) + column, *bottom = light.row(row + 1) + column;
  return (1 - down) * ((1 - right) * top[0] + right * top[1]) +
         down * ((1 - right) * bottom[0] + right * bottom[1]);
}

}  // namespace

/// Blurred by both Gaussians, with a dark border.
class LiveView::Light {
 public:
  int pad = 0;
  std::array<ImageF, kBlurs> by_width;
};

struct LiveView::State {
  /// One a projector.
  struct Lit {
    ImageSize frame_size;
    std::vector<LiveTap> taps;
    std::array<std::vector<float>, kBlurs> kernels;
    std::array<float, 256> light_of{};
    ProjectorMap truth;
  };
  std::vector<Lit> lit;
  ImageF unlit;
  std::vector<float> camera_kernel;
  internal::Sensor sensor;
  std::vector<std::uint8_t> curve;
  int threads = 0;

  Light light_of_frame(const Lit& of, ViewU8 frame) const {
    Light light;
    light.pad = int(of.kernels.back().size()) + 1;
    ImageF sharp(frame.width + 2 * light.pad, frame.height + 2 * light.pad);
    for (int y = 0; y < frame.height; ++y) {
      float* out = sharp.row(y + light.pad) + light.pad;
      const std::uint8_t* in = frame.row(y);
      if (frame.channels == 1)
        for (int x = 0; x < frame.width; ++x) out[x] = of.light_of[in[x]];
      else
        for (int x = 0; x < frame.width; ++x, in += frame.channels)
          out[x] = (of.light_of[in[0]] + of.light_of[in[1]] + of.light_of[in[2]]) / 3;
    }
    parallel_each(kBlurs, threads, [&](int i) {
      light.by_width[std::size_t(i)] = internal::convolve(sharp, of.kernels[std::size_t(i)]);
    });
    return light;
  }

  void add(const Lit& of, const Light& light, ImageF& levels) const {
    const float pad = float(light.pad);
    parallel_for(levels.height(), threads, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        float* out = levels.row(y);
        const LiveTap* tap = &of.taps[std::size_t(y) * std::size_t(levels.width())];
        for (int x = 0; x < levels.width(); ++x, ++tap) {
          if (!(tap->lit > 0)) continue;
          const float u = tap->u + pad, v = tap->v + pad;
          const float narrow = at(light.by_width[0], u, v), wide = at(light.by_width[1], u, v);
          out[x] += tap->lit * (narrow + tap->share_of_wide * (wide - narrow));
        }
      }
    });
  }
};

namespace {

/// The rays of a pixel as one tap.
LiveTap mean_tap(const internal::SampledView& view, std::size_t light, std::size_t first, double blur_px) {
  LiveTap tap;
  double u = 0, v = 0, radius2 = 0, lit = 0;
  for (std::size_t ray = first; ray < first + std::size_t(view.samples_per_pixel); ++ray) {
    const internal::LightSample& sample = view.of_light[light][ray];
    const double level = sample.level * view.tint(ray, 0);
    lit += level;
    u += level * sample.u;
    v += level * sample.v;
    if (!view.discs[light].empty()) radius2 += level * std::pow(view.discs[light][ray], 2);
  }
  if (!(lit > 0)) return tap;
  tap.u = float(u / lit), tap.v = float(v / lit), tap.lit = float(lit);
  tap.variance = float(blur_px * blur_px + 0.25 * radius2 / lit);  // a disc's variance an axis: r^2 / 4
  return tap;
}

/// A square of that width has this share of the width's square as its variance.
constexpr float kBoxVariance = 1.f / 12;
/// Neighbours farther apart than this belong to other bodies.
constexpr float kLargestFootprint = 6;

void add_footprints(std::vector<LiveTap>& taps, ImageSize size) {
  std::vector<float> more(taps.size());
  for (int y = 0; y + 1 < size.height; ++y)
    for (int x = 0; x + 1 < size.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(size.width) + std::size_t(x);
      const LiveTap &here = taps[i], &right = taps[i + 1], &below = taps[i + std::size_t(size.width)];
      if (!(here.lit > 0 && right.lit > 0 && below.lit > 0)) continue;
      const float across = std::hypot(right.u - here.u, below.u - here.u),
                  down = std::hypot(right.v - here.v, below.v - here.v);
      if (across < kLargestFootprint && down < kLargestFootprint)
        more[i] = 0.5f * kBoxVariance * (across * across + down * down);
    }
  for (std::size_t i = 0; i < taps.size(); ++i) taps[i].variance += more[i];
}

/// The narrowest and the widest blur, and each tap's share of the latter.
std::array<double, kBlurs> mix_blurs(std::vector<LiveTap>& taps) {
  float low = 1e30f, high = 0;
  for (const LiveTap& tap : taps)
    if (tap.lit > 0) low = std::min(low, tap.variance), high = std::max(high, tap.variance);
  if (low > high) low = high = 0;
  for (LiveTap& tap : taps)
    tap.share_of_wide = high > low ? std::clamp((tap.variance - low) / (high - low), 0.f, 1.f) : 0;
  return {std::sqrt(double(low)), std::sqrt(double(high))};
}

}  // namespace

LiveView::LiveView(const Room& room, const Camera& camera, const Pose& room_from_camera,
                   const RoomLight& light, const LiveViewOptions& options)
    : LiveView(room, camera, room_from_camera, std::vector<RoomLight>{light}, options) {}

LiveView::LiveView(const Room& room, const Camera& camera, const Pose& room_from_camera,
                   const std::vector<RoomLight>& lights, const LiveViewOptions& options)
    : state_(std::make_unique<State>()) {
  require(options.glare >= 0 && options.glare < 1, "LiveView: glare not in [0, 1)");
  require(options.view.exposure >= 0 && options.view.brightest_grey > 0 && options.view.gamma >= 0 &&
              options.view.camera_blur_px >= 0,
          "LiveView: exposure, blur or gamma out of range");
  std::vector<double> reaches;
  for (const RoomLight& light : lights) {
    require(light.blur_px >= 0 && light.gamma >= 0, "LiveView: a light's blur or gamma out of range");
    reaches.push_back(double(internal::gaussian_kernel(light.blur_px).size()) + 4);
  }
  internal::RoomSamples samples =
      internal::sample_room(room, camera, room_from_camera, lights, reaches, options.view);
  State& s = *state_;
  s.threads = options.view.threads;
  ImageF full = samples.view.ambient_level;
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const RoomLight& light = lights[k];
    State::Lit& lit = s.lit.emplace_back();
    lit.frame_size = light.projector.size();
    lit.taps.resize(std::size_t(camera.size.width) * std::size_t(camera.size.height));
    for (int y = 0; y < camera.size.height; ++y)
      for (int x = 0; x < camera.size.width; ++x) {
        LiveTap& tap = lit.taps[std::size_t(y) * std::size_t(camera.size.width) + std::size_t(x)];
        tap = mean_tap(samples.view, k, samples.view.first_ray_of(x, y), light.blur_px);
        full.at(x, y) += tap.lit;
      }
    add_footprints(lit.taps, camera.size);
    const auto sigmas = mix_blurs(lit.taps);
    for (std::size_t i = 0; i < kBlurs; ++i) lit.kernels[i] = internal::gaussian_kernel(sigmas[i]);
    for (std::size_t i = 0; i < 256; ++i)
      lit.light_of[i] =
          float(light.black + (1 - light.black) * internal::light_of_value(double(i) / 255, light.gamma));
    lit.truth = std::move(samples.truth.light[k]);
  }
  const double brightest =
      *std::max_element(full.data(), full.data() + std::ptrdiff_t(full.width()) * full.height());
  s.unlit = std::move(samples.view.ambient_level);
  s.camera_kernel = internal::gaussian_kernel(options.view.camera_blur_px);
  require(options.view.exposure > 0 || brightest > 0, "LiveView: no light reaches what the camera sees");
  s.sensor.exposure =
      options.view.exposure > 0 ? options.view.exposure : options.view.brightest_grey / brightest;
  s.sensor.glare = options.glare;
  s.sensor.falloff = std::move(samples.falloff);
  s.sensor.noise = options.view.noise;
  s.sensor.gamma = options.view.gamma;
  s.sensor.seed = options.view.seed;
  s.curve = internal::response_curve(options.view.gamma);
}

LiveView::~LiveView() = default;
LiveView::LiveView(LiveView&&) noexcept = default;
LiveView& LiveView::operator=(LiveView&&) noexcept = default;

double LiveView::exposure() const {
  return state_->sensor.exposure;
}
const ProjectorMap& LiveView::light(std::size_t projector) const {
  return state_->lit.at(projector).truth;
}

std::shared_ptr<const LiveView::Light> LiveView::light_of(ViewU8 frame, std::size_t projector) const {
  const State::Lit& lit = state_->lit.at(projector);
  require(frame.size() == lit.frame_size && (frame.channels == 1 || frame.channels == 3),
          "LiveView: a frame of another size than the projector's, or not of 1 channel or 3");
  return std::make_shared<const Light>(state_->light_of_frame(lit, frame));
}

ImageU8 LiveView::capture(ViewU8 frame, std::uint64_t number) const {
  return capture(*light_of(frame), number);
}

ImageU8 LiveView::capture(const Light& light, std::uint64_t number) const {
  // Not owned: it outlives the call.
  return capture({std::shared_ptr<const Light>(std::shared_ptr<void>(), &light)}, number);
}

ImageU8 LiveView::capture(const std::vector<std::shared_ptr<const Light>>& lights,
                          std::uint64_t number) const {
  const State& s = *state_;
  require(lights.size() == s.lit.size(), "LiveView: one light is needed for each projector");
  ImageF levels = s.unlit;
  for (std::size_t k = 0; k < lights.size(); ++k) s.add(s.lit[k], *lights[k], levels);
  return internal::develop(internal::through_lens(std::move(levels), {}, s.sensor, s.camera_kernel), s.sensor,
                           s.curve, number);
}

}  // namespace procam::simulate
