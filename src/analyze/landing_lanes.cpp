#include "landing_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "procam/core/dual.hpp"

namespace procam::analyze {
namespace {

/// Models with a formula on z = 1. A fisheye sees beyond it and is followed point by point.
template <typename Model>
constexpr bool kHasFormula = !std::is_same_v<Model, FisheyeDistortion>;

/// Steps of Newton's method with the believed lens's Jacobian (chord steps). The lens is wrong by parts in a
/// thousand, so each gains two to three digits: two, and more where these do not do.
constexpr int kMoreSteps = 6;
/// Before the last step the residual must be down to a hundredth of what the draw's lens and pixel moved the
/// light by (squared: 1e-4). The last step shrinks it about as much again. Below 1e-9 on z = 1, two
/// millionths of a pixel, it is done in any case.
constexpr double kGain = 1e-4, kNothing = 1e-18;
/// A ray that meets the surface only this far away, in depths of the projector, misses it.
constexpr double kInfinity = 1e12;

/// `x` and `y` are offsets on the surface.
PROCAM_ALWAYS_INLINE void add_landing(const Chosen& landed, const Four& x, const Four& y,
                                      LandingSums::Group& sums) {
  const Four dx = only(landed, x), dy = only(landed, y), xx = dx * dx, yy = dy * dy;
  sums.landed += only(landed, 1);
  sums.x += dx;
  sums.y += dy;
  sums.xx += xx;
  sums.xy += dx * dy;
  sums.yy += yy;
  sums.worst2 = larger(xx + yy, sums.worst2);
}

/// Exactly, wherever the light goes.
std::optional<Vec2> landing_of(const LandingDraw& draw, const Vec2& pixel) {
  const auto ray = Projector{draw.lens}.emit(pixel);
  const auto hit =
      ray ? intersect(draw.surface_from_projector * *ray, Plane{Vec3::UnitZ(), 0}) : std::nullopt;
  if (!hit) return std::nullopt;
  return Vec2(hit->head<2>());
}

}  // namespace

/// One draw's loops over all points. Each does one short chain of operations a point, so that the processor
/// works on several points at once: the long chain from pixel to sums in one loop leaves half of it waiting.
template <typename Model>
struct LandingSums::Loops {
  const LandingLanes::Group* points;
  std::size_t size;
  const LandingDraw& draw;
  const PixelShift* shifts;
  const Model& model;
  Group* sums;
  Ray* rays;

  /// Adds all points whose steps converge and says whether all did.
  PROCAM_ALWAYS_INLINE bool add() const {
    Four c[Model::kNumCoefficients + 1];
    for (std::size_t i = 0; i < Model::kNumCoefficients; ++i) c[i] = model.coefficients[i];
    first_step(c);
    bool all = last_step(c);
    land();
    if (all) return true;
    for (int step = 0; step < kMoreSteps; ++step)
      for (std::size_t i = 0; i < size; ++i) take_step(c, i);
    all = last_step(c);
    land();
    return all;
  }

 private:
  /// Returns the squared residual before it.
  PROCAM_ALWAYS_INLINE static Four take_step(const Four* c, const LandingLanes::Group& point,
                                             const Four& target_x, const Four& target_y, Four& x, Four& y) {
    Four image_x, image_y;
    Model::formula(c, x, y, image_x, image_y);
    const Four error_x = image_x - target_x, error_y = image_y - target_y;
    x = x - point.inverse_xx * error_x - point.inverse_xy * error_y;
    y = y - point.inverse_yx * error_x - point.inverse_yy * error_y;
    return error_x * error_x + error_y * error_y;
  }
  PROCAM_ALWAYS_INLINE Four take_step(const Four* c, std::size_t i) const {
    Ray& ray = rays[i];
    Four x = ray.x, y = ray.y;
    const Four squared = take_step(c, points[i], ray.target_x, ray.target_y, x, y);
    ray.x = x;
    ray.y = y;
    return squared;
  }

  PROCAM_ALWAYS_INLINE void first_step(const Four* c) const {
    const Intrinsics& k = draw.lens.intrinsics;
    const Four inverse_fx = 1 / k.fx, inverse_fy = 1 / k.fy, cx = k.cx, cy = k.cy, skew = k.skew;
    for (std::size_t i = 0; i < size; ++i) {
      const LandingLanes::Group& point = points[i];
      const Four target_y = (point.pixel_y + shifts[i].y - cy) * inverse_fy;
      const Four target_x = (point.pixel_x + shifts[i].x - cx - skew * target_y) * inverse_fx;
      Four x = point.start_x, y = point.start_y;
      const Four first = take_step(c, point, target_x, target_y, x, y);
      rays[i] = {target_x, target_y, x, y, first, 1, 0};
    }
  }

  /// Settles the rays that have converged; are none left?
  PROCAM_ALWAYS_INLINE bool last_step(const Four* c) const {
    Four left = 0;
    for (std::size_t i = 0; i < size; ++i) {
      Ray& ray = rays[i];
      const Four last = take_step(c, i);
      ray.settled = only(last < kGain * ray.first + kNothing, ray.pending);
      ray.pending = ray.pending - ray.settled;
      left += ray.pending;
    }
    return left[0] + left[1] + left[2] + left[3] == 0;
  }

  /// Adds the settled rays that meet the surface, t + s R d with z = 0.
  PROCAM_ALWAYS_INLINE void land() const {
    const Mat3 r = draw.surface_from_projector.rotation_matrix();
    const Vec3& t = draw.surface_from_projector.translation;
    const Four r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2), r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2),
               r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2), tx = t.x(), ty = t.y(), minus_tz = -t.z();
    for (std::size_t i = 0; i < size; ++i) {
      const Ray& ray = rays[i];
      const Four s = minus_tz / (r20 * ray.x + r21 * ray.y + r22);
      const Four x = tx + s * (r00 * ray.x + r01 * ray.y + r02) - points[i].intended_x;
      const Four y = ty + s * (r10 * ray.x + r11 * ray.y + r12) - points[i].intended_y;
      add_landing((0 < ray.settled) & (0 < s) & (s < kInfinity), x, y, sums[i]);
    }
  }
};

namespace {

template <typename Loops>
bool add_plain(const Loops& loops) {
  return loops.add();
}

#ifdef PROCAM_WIDE_VECTORS
template <typename Loops>
PROCAM_WIDE_VECTORS bool add_wide(const Loops& loops) {
  return loops.add();
}

template <typename Loops>
bool add_all(const Loops& loops) {
  static const bool wide = PROCAM_HAS_WIDE_VECTORS;
  return wide ? add_wide(loops) : add_plain(loops);
}
#else
template <typename Loops>
bool add_all(const Loops& loops) {
  return add_plain(loops);
}
#endif

}  // namespace

void LandingLanes::add(const Vec2& on_surface, const Camera& lens, const Vec2& pixel, const Vec3& bearing) {
  using D = Dual<2>;
  const D x(bearing.x() / bearing.z(), 0), y(bearing.y() / bearing.z(), 1);
  D image_x = x, image_y = y;
  std::visit(
      [&](const auto& model) {
        using Model = std::decay_t<decltype(model)>;
        if constexpr (kHasFormula<Model>) {
          std::array<D, Model::kNumCoefficients> constants;
          for (std::size_t i = 0; i < constants.size(); ++i) constants[i] = D(model.coefficients[i]);
          Model::formula(constants.data(), x, y, image_x, image_y);
        }
      },
      lens.distortion);
  const double determinant = image_x.v[0] * image_y.v[1] - image_x.v[1] * image_y.v[0];
  const std::size_t lane = size_++ % Four::kSize;
  if (lane == 0) groups.emplace_back();
  Group& group = groups.back();
  // The last one's copies fill up the last four.
  for (std::size_t i = lane; i < Four::kSize; ++i) {
    group.intended_x[i] = on_surface.x();
    group.intended_y[i] = on_surface.y();
    group.pixel_x[i] = pixel.x();
    group.pixel_y[i] = pixel.y();
    group.start_x[i] = x.a;
    group.start_y[i] = y.a;
    group.inverse_xx[i] = image_y.v[1] / determinant;
    group.inverse_xy[i] = -image_x.v[1] / determinant;
    group.inverse_yx[i] = -image_y.v[0] / determinant;
    group.inverse_yy[i] = image_x.v[0] / determinant;
  }
}

void LandingSums::add(const LandingLanes& lanes, const LandingDraw& draw,
                      const std::vector<PixelShift>& shifts) {
  const bool all = std::visit(
      [&](const auto& model) {
        using Model = std::decay_t<decltype(model)>;
        if constexpr (kHasFormula<Model>) {
          return add_all(Loops<Model>{lanes.groups.data(), lanes.groups.size(), draw, shifts.data(), model,
                                      groups_.data(), rays_.data()});
        } else {
          for (Ray& ray : rays_) ray.pending = 1;
          return false;
        }
      },
      draw.lens.distortion);
  if (all) return;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const std::size_t group = i / Four::kSize, lane = i % Four::kSize;
    if (rays_[group].pending[lane] == 0) continue;
    const LandingLanes::Group& point = lanes.groups[group];
    const PixelShift& shift = shifts[group];
    const auto place =
        landing_of(draw, Vec2(point.pixel_x[lane] + shift.x[lane], point.pixel_y[lane] + shift.y[lane]));
    if (!place) continue;
    Four landed, dx, dy;
    landed[lane] = 1;
    dx[lane] = place->x() - point.intended_x[lane];
    dy[lane] = place->y() - point.intended_y[lane];
    add_landing(0 < landed, dx, dy, groups_[group]);
  }
}

void LandingSums::add(const LandingSums& other) {
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    Group& sum = groups_[i];
    const Group& more = other.groups_[i];
    sum.landed += more.landed;
    sum.x += more.x;
    sum.y += more.y;
    sum.xx += more.xx;
    sum.xy += more.xy;
    sum.yy += more.yy;
    sum.worst2 = larger(more.worst2, sum.worst2);
  }
}

}  // namespace procam::analyze
