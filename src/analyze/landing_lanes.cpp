#include "landing_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "procam/core/dual.hpp"

// The loops run on the widest vectors that the machine has, chosen when the program starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PROCAM_WIDEST_VECTORS __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define PROCAM_WIDEST_VECTORS
#endif

namespace procam::analyze {
namespace {

/// Models with a formula on z = 1. A fisheye sees beyond it and is followed point by point.
template <typename Model>
constexpr bool kHasFormula = !std::is_same_v<Model, FisheyeDistortion>;

/// Steps of Newton's method with the believed lens's Jacobian (chord steps): the lens is wrong by parts in a
/// thousand, so each gains three digits.
constexpr int kSteps = 3, kMoreSteps = 8;
/// Squared residual on z = 1 before the last step, which gains two more digits at least: 1e-10 in the end, a
/// ten-millionth of a pixel.
constexpr double kConverged = 1e-16;

/// The place on the surface: t + s R d with z = 0, for every point's direction d = (x, y, 1).
struct SurfaceRay {
  double r00, r01, r02, r10, r11, r12, r20, r21, r22, tx, ty, tz;

  explicit SurfaceRay(const Pose& surface_from_projector) {
    const Mat3 r = surface_from_projector.rotation_matrix();
    const Vec3& t = surface_from_projector.translation;
    r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2), r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2);
    r20 = r(2, 0), r21 = r(2, 1), r22 = r(2, 2), tx = t.x(), ty = t.y(), tz = t.z();
  }
};

/// All points from `first` to `last`, each in registers from pixel to surface. Returns the largest squared
/// residual before the last step.
template <typename Model, int kNumSteps>
PROCAM_WIDEST_VECTORS double follow_lanes(const LandingLanes& lanes, const Intrinsics& k,
                                          const double* coefficients, const Pose& surface_from_projector,
                                          const double* shift_x, const double* shift_y,
                                          double* __restrict landed_x, double* __restrict landed_y,
                                          double* __restrict range) {
  const SurfaceRay ray(surface_from_projector);
  const double inverse_fx = 1 / k.fx, inverse_fy = 1 / k.fy, cx = k.cx, cy = k.cy, skew = k.skew;
  double c[Model::kNumCoefficients + 1] = {};
  for (int i = 0; i < Model::kNumCoefficients; ++i) c[i] = coefficients[i];
  const double *pixel_x = lanes.pixel_x.data(), *pixel_y = lanes.pixel_y.data(),
               *start_x = lanes.start_x.data(), *start_y = lanes.start_y.data(),
               *xx = lanes.inverse_xx.data(), *xy = lanes.inverse_xy.data(), *yx = lanes.inverse_yx.data(),
               *yy = lanes.inverse_yy.data();
  const std::size_t size = lanes.size();
  double worst = 0;
#pragma omp simd reduction(max : worst)
  for (std::size_t i = 0; i < size; ++i) {
    const double target_y = (pixel_y[i] + shift_y[i] - cy) * inverse_fy;
    const double target_x = (pixel_x[i] + shift_x[i] - cx - skew * target_y) * inverse_fx;
    double x = start_x[i], y = start_y[i], squared = 0;
#pragma GCC unroll 8
    for (int step = 0; step < kNumSteps; ++step) {
      double image_x, image_y;
      Model::formula(c, x, y, image_x, image_y);
      const double error_x = image_x - target_x, error_y = image_y - target_y;
      x -= xx[i] * error_x + xy[i] * error_y;
      y -= yx[i] * error_x + yy[i] * error_y;
      squared = error_x * error_x + error_y * error_y;
    }
    worst = worst > squared ? worst : squared;
    const double s = -ray.tz / (ray.r20 * x + ray.r21 * y + ray.r22);
    landed_x[i] = ray.tx + s * (ray.r00 * x + ray.r01 * y + ray.r02);
    landed_y[i] = ray.ty + s * (ray.r10 * x + ray.r11 * y + ray.r12);
    range[i] = s;
  }
  return worst;
}

/// For points that all were reached.
PROCAM_WIDEST_VECTORS void add_landings(std::size_t size, const double* __restrict intended_x,
                                        const double* __restrict intended_y,
                                        const double* __restrict landed_x, const double* __restrict landed_y,
                                        double* __restrict landed, double* __restrict x, double* __restrict y,
                                        double* __restrict xx, double* __restrict xy, double* __restrict yy,
                                        double* __restrict worst2) {
#pragma omp simd
  for (std::size_t i = 0; i < size; ++i) {
    const double dx = landed_x[i] - intended_x[i], dy = landed_y[i] - intended_y[i];
    const double squared = dx * dx + dy * dy;
    landed[i] += 1;
    x[i] += dx;
    y[i] += dy;
    xx[i] += dx * dx;
    xy[i] += dx * dy;
    yy[i] += dy * dy;
    worst2[i] = worst2[i] > squared ? worst2[i] : squared;
  }
}

void follow_one(const LandingLanes& lanes, std::size_t i, LandingDraw& draw) {
  const Vec2 pixel(lanes.pixel_x[i] + draw.shift_x[i], lanes.pixel_y[i] + draw.shift_y[i]);
  const auto ray = Projector{draw.lens}.emit(pixel);
  const auto hit =
      ray ? intersect(draw.surface_from_projector * *ray, Plane{Vec3::UnitZ(), 0}) : std::nullopt;
  draw.range[i] = hit ? 1 : 0;
  draw.landed_x[i] = hit ? hit->x() : 0;
  draw.landed_y[i] = hit ? hit->y() : 0;
}

}  // namespace

void LandingLanes::add(const Vec2& on_surface, const Camera& lens, const Vec2& pixel, const Vec3& bearing) {
  intended_x.push_back(on_surface.x());
  intended_y.push_back(on_surface.y());
  pixel_x.push_back(pixel.x());
  pixel_y.push_back(pixel.y());
  using D = Dual<2>;
  D image_x(0.0), image_y(0.0);
  const D x(bearing.x() / bearing.z(), 0), y(bearing.y() / bearing.z(), 1);
  start_x.push_back(x.a);
  start_y.push_back(y.a);
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
  inverse_xx.push_back(image_y.v[1] / determinant);
  inverse_xy.push_back(-image_x.v[1] / determinant);
  inverse_yx.push_back(-image_y.v[0] / determinant);
  inverse_yy.push_back(image_x.v[0] / determinant);
}

void follow_light(const LandingLanes& lanes, LandingDraw& draw) {
  draw.landed_x.resize(lanes.size());
  draw.landed_y.resize(lanes.size());
  draw.range.resize(lanes.size());
  const bool followed = std::visit(
      [&](const auto& model) {
        using Model = std::decay_t<decltype(model)>;
        if constexpr (kHasFormula<Model>) {
          const auto converges = [&](const auto& follow) {
            return follow(lanes, draw.lens.intrinsics, model.coefficients.data(), draw.surface_from_projector,
                          draw.shift_x.data(), draw.shift_y.data(), draw.landed_x.data(),
                          draw.landed_y.data(), draw.range.data()) <= kConverged;
          };
          return converges(follow_lanes<Model, kSteps>) || converges(follow_lanes<Model, kMoreSteps>);
        } else {
          return false;
        }
      },
      draw.lens.distortion);
  if (!followed)
    for (std::size_t i = 0; i < lanes.size(); ++i) follow_one(lanes, i, draw);
  draw.all_reached = std::all_of(draw.range.begin(), draw.range.end(), is_reached);
}

void LandingSums::add(const LandingLanes& lanes, const LandingDraw& draw) {
  if (draw.all_reached) {
    add_landings(lanes.size(), lanes.intended_x.data(), lanes.intended_y.data(), draw.landed_x.data(),
                 draw.landed_y.data(), landed.data(), x.data(), y.data(), xx.data(), xy.data(), yy.data(),
                 worst2.data());
    return;
  }
  for (std::size_t i = 0; i < lanes.size(); ++i)
    if (is_reached(draw.range[i]))
      add_landings(1, &lanes.intended_x[i], &lanes.intended_y[i], &draw.landed_x[i], &draw.landed_y[i],
                   &landed[i], &x[i], &y[i], &xx[i], &xy[i], &yy[i], &worst2[i]);
}

void LandingSums::add(const LandingSums& other) {
  for (std::size_t i = 0; i < landed.size(); ++i) {
    landed[i] += other.landed[i];
    x[i] += other.x[i];
    y[i] += other.y[i];
    xx[i] += other.xx[i];
    xy[i] += other.xy[i];
    yy[i] += other.yy[i];
    worst2[i] = std::max(worst2[i], other.worst2[i]);
  }
}

}  // namespace procam::analyze
