#include "mean_content.hpp"

namespace procam::render {

namespace {

template <typename Pixel>
Points point_of(const Footprint& f, const TexelsView<Pixel>& level) {
  Points point;
  const double inverse = 1 / f.centre.z();
  const Vec2 uv = inverse * f.centre.head<2>(), size(level.width, level.height);
  const auto set = [&](const Vec2& texels, float* u, float* v) {
    *u = float(texels.x());
    *v = float(texels.y());
  };
  set(size.cwiseProduct(uv), point.u, point.v);
  const auto slope = [&](const Vec3& of_q) {
    return Vec2(inverse * size.cwiseProduct(of_q.head<2>() - uv * of_q.z()));
  };
  set(slope(f.slope_x), point.u_x, point.v_x);
  set(slope(f.slope_y), point.u_y, point.v_y);
  return point;
}

template <typename Pixel>
Rgba rgba_of(const Pixel* pixel, int full) {
  return Rgba(pixel[0], pixel[1], pixel[2], pixel[3]) / float(full);
}

}  // namespace

Rgba mean_content(const LightTexture& texture, const Kernels& kernels, const Footprint& footprint,
                  bool area) {
  Taps taps;
  if (area) {
    const TexelsView<Light> finest = texture.level(0);
    const PixelSize size = pixel_size(footprint, Vec2::Zero(), {finest.width, finest.height});
    taps = choose_taps(size, size, size, texture.levels());
  }
  const TexelsView<Light> level = texture.level(taps.level);
  alignas(32) Light mean[4 * kLanes];
  kernels.sample_light(level, taps, point_of(footprint, level), 0, 1, mean);
  return rgba_of(mean, kFull);
}

Rgba mean_content(const ValueTexture& texture, const Kernels& kernels, const Footprint& footprint, bool) {
  const TexelsView<Value> level = texture.level(0);
  alignas(32) Value value[4 * kLanes];
  kernels.sample_values(level, point_of(footprint, level), 0, 1, value);
  return rgba_of(value, 255);
}

}  // namespace procam::render
