#include "landing_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "procam/core/base/dual.hpp"

namespace procam::analyze {
namespace {

/// A fisheye sees beyond z = 1, has no formula there, and is followed point by point.
template <typename Model>
constexpr bool kHasFormula = procam::internal::HasFormula<Model>::value;

/// Steps of Newton's method with the believed lens's Jacobian (chord steps). The lens is wrong by parts in a
/// thousand, so each gains two to three digits: two, and more where these do not do.
constexpr int kMoreSteps = 6;
/// Before the last step the residual must be down to a hundredth of what the draw's lens and pixel moved the
/// light by (squared: 1e-4). The last step shrinks it about as much again. Below 1e-9 on z = 1, two
/// millionths of a pixel, it is done in any case.
constexpr double kGain = 1e-4, kNothing = 1e-18;
/// Draws whose numbers stay in the nearest cache while all points pass.
constexpr std::size_t kDrawsAtOnce = 16;
/// A ray that meets the surface only this far away, in depths of the projector, misses it.
constexpr double kInfinity = 1e12;

/// `x` and `y` are offsets on the surface.
PROCAM_ALWAYS_INLINE void add_landing(const Double4& x, const Double4& y, LandingSums::Group& sums) {
  const Double4 yy = y * y;
  sums.x += x;
  sums.y += y;
  sums.xx += x * x;
  sums.xy += x * y;
  sums.yy += yy;
  sums.worst2 = larger(x * x + yy, sums.worst2);
}
PROCAM_ALWAYS_INLINE void add_landing(const Mask4& landed, const Double4& x, const Double4& y,
                                      LandingSums::Group& sums) {
  sums.landed += only(landed, 1);
  add_landing(only(landed, x), only(landed, y), sums);
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

/// Group by group of points, the draws within, so that a group's sums stay in registers while the draws pass.
/// Each loop over the draws does one short chain of operations, so that the processor works on several draws
/// at once: the long chain from pixel to sums in one loop leaves half of it waiting.
template <typename Model>
struct LandingSums::Loops {
  const LandingLanes::Group* points;
  std::size_t size;
  const LandingDraw* draws;
  std::size_t count;
  const PixelShift* shifts;  ///< nullptr: none
  Group* sums;

  /// Adds all points whose steps converge; what is left goes to `left`.
  PROCAM_ALWAYS_INLINE void add(std::vector<Left>& left) const {
    Chain chains[kDrawsAtOnce];
    for (std::size_t first = 0; first < count; first += kDrawsAtOnce) {
      const std::size_t some = std::min(kDrawsAtOnce, count - first);
      for (std::size_t i = 0; i < some; ++i) chains[i].set(draws[first + i]);
      const auto shift = [&](std::size_t draw, std::size_t group) {
        return shifts[(first + draw) * size + group];
      };
      const auto no_shift = [](std::size_t, std::size_t) { return PixelShift{}; };
      for (std::size_t g = 0; g < size; ++g)
        if (!(shifts ? add_quickly(chains, some, g, shift) : add_quickly(chains, some, g, no_shift)))
          for (std::size_t i = 0; i < some; ++i) {
            const Mask4 open = shifts ? add_surely(chains[i], g, shift(i, g)) : add_surely(chains[i], g, {});
            if (any(open)) left.push_back({first + i, g, only(open, 1)});
          }
    }
  }

 private:
  /// A draw, each number in all lanes.
  struct Chain {
    Double4 c[Model::kNumCoefficients + 1];
    // Pixel (u, v) to z = 1: y = v / fy + y_0 and x = u / fx + x_y y + x_0.
    Double4 inverse_fx, x_y, x_0, inverse_fy, y_0;
    // The surface from the projector: R and t, and the row of R that is the surface's z by -1 / t.z.
    Double4 r00, r01, r02, r10, r11, r12, z0, z1, z2, tx, ty;

    PROCAM_ALWAYS_INLINE void set(const LandingDraw& draw) {
      const Model& model = *std::get_if<Model>(&draw.lens.distortion);
      for (std::size_t i = 0; i < Model::kNumCoefficients; ++i) c[i] = model.coefficients[i];
      const Intrinsics& k = draw.lens.intrinsics;
      inverse_fx = 1 / k.fx, x_y = -k.skew / k.fx, x_0 = -k.cx / k.fx;
      inverse_fy = 1 / k.fy, y_0 = -k.cy / k.fy;
      const Mat3 r = draw.surface_from_projector.rotation_matrix();
      const Vec3& t = draw.surface_from_projector.translation;
      r00 = r(0, 0), r01 = r(0, 1), r02 = r(0, 2), r10 = r(1, 0), r11 = r(1, 1), r12 = r(1, 2);
      // In the surface's plane, the projector lights nothing of it.
      const double near = t.z() == 0 ? 0 : -1 / t.z();
      z0 = near * r(2, 0), z1 = near * r(2, 1), z2 = near * r(2, 2);
      tx = t.x(), ty = t.y();
    }
  };

  /// From a point's pixel through a chain.
  struct Ray {
    const LandingLanes::Group& point;
    const Chain& chain;
    Double4 target_x, target_y;  ///< where on z = 1 the lens must take it
    Double4 x, y;                ///< its direction (x, y, 1) so far

    PROCAM_ALWAYS_INLINE Ray(const LandingLanes::Group& of, const Chain& through, const PixelShift& shift)
        : point(of), chain(through), x(of.start_x), y(of.start_y) {
      target_y = (of.pixel_y + shift.y) * chain.inverse_fy + chain.y_0;
      target_x = (of.pixel_x + shift.x) * chain.inverse_fx + (chain.x_y * target_y + chain.x_0);
    }
    PROCAM_ALWAYS_INLINE Ray(const LandingLanes::Group& of, const Chain& through, const Double4& to_x,
                             const Double4& to_y, const Double4& from_x, const Double4& from_y)
        : point(of), chain(through), target_x(to_x), target_y(to_y), x(from_x), y(from_y) {}
    /// Returns the squared residual before it.
    PROCAM_ALWAYS_INLINE Double4 take_step() {
      Double4 image_x, image_y;
      Model::formula(chain.c, x, y, image_x, image_y);
      const Double4 error_x = image_x - target_x, error_y = image_y - target_y;
      x = x - point.inverse_xx * error_x - point.inverse_xy * error_y;
      y = y - point.inverse_yx * error_x - point.inverse_yy * error_y;
      return error_x * error_x + error_y * error_y;
    }
  };

  /// Where the ray (x, y, 1) meets the surface, beside the intended place: t + s R (x, y, 1) with z = 0.
  struct Hit {
    Mask4 there;  ///< in front of the projector, and not at infinity
    Double4 x, y;

    PROCAM_ALWAYS_INLINE Hit(const LandingLanes::Group& point, const Chain& chain, const Double4& ray_x,
                             const Double4& ray_y) {
      const Double4 inverse = chain.z0 * ray_x + (chain.z1 * ray_y + chain.z2), s = 1 / inverse;
      there = 1 / kInfinity < inverse;
      x = s * (chain.r00 * ray_x + (chain.r01 * ray_y + chain.r02)) + (chain.tx - point.intended_x);
      y = s * (chain.r10 * ray_x + (chain.r11 * ray_y + chain.r12)) + (chain.ty - point.intended_y);
    }
  };

  /// With two steps. Adds nothing and says false unless they bring every draw of every point to its end on
  /// the surface.
  template <typename Shift>
  PROCAM_ALWAYS_INLINE bool add_quickly(const Chain* chains, std::size_t some, std::size_t g,
                                        const Shift& shift) const {
    Double4 target_x[kDrawsAtOnce], target_y[kDrawsAtOnce], x[kDrawsAtOnce], y[kDrawsAtOnce];
    Double4 enough[kDrawsAtOnce];
    for (std::size_t i = 0; i < some; ++i) {
      Ray ray(points[g], chains[i], shift(i, g));
      enough[i] = kGain * ray.take_step() + kNothing;
      target_x[i] = ray.target_x;
      target_y[i] = ray.target_y;
      x[i] = ray.x;
      y[i] = ray.y;
    }
    Mask4 open = 0 < Double4(0);
    for (std::size_t i = 0; i < some; ++i) {
      Ray ray(points[g], chains[i], target_x[i], target_y[i], x[i], y[i]);
      open = open | !(ray.take_step() < enough[i]);
      x[i] = ray.x;
      y[i] = ray.y;
    }
    Group sum = sums[g];
    for (std::size_t i = 0; i < some; ++i) {
      const Hit hit(points[g], chains[i], x[i], y[i]);
      open = open | !hit.there;
      add_landing(hit.x, hit.y, sum);
    }
    if (any(open)) return false;
    sum.landed += double(some);
    sums[g] = sum;
    return true;
  }

  /// With as many steps as it takes. Returns where they do not converge.
  PROCAM_ALWAYS_INLINE Mask4 add_surely(const Chain& chain, std::size_t g, const PixelShift& shift) const {
    Ray ray(points[g], chain, shift);
    const Double4 enough = kGain * ray.take_step() + kNothing;
    Mask4 open = !(ray.take_step() < enough);
    if (any(open)) {
      for (int step = 0; step < kMoreSteps; ++step) ray.take_step();
      open = !(ray.take_step() < enough);
    }
    const Hit hit(points[g], chain, ray.x, ray.y);
    add_landing(!open & hit.there, hit.x, hit.y, sums[g]);
    return open;
  }
};

namespace {

template <typename Loops, typename Left>
void add_plain(const Loops& loops, Left& left) {
  loops.add(left);
}

#ifdef PROCAM_WIDE_VECTORS
template <typename Loops, typename Left>
PROCAM_WIDE_VECTORS void add_wide(const Loops& loops, Left& left) {
  loops.add(left);
}

template <typename Loops, typename Left>
void add_all(const Loops& loops, Left& left) {
  static const bool wide = PROCAM_HAS_WIDE_VECTORS;
  wide ? add_wide(loops, left) : add_plain(loops, left);
}
#else
template <typename Loops, typename Left>
void add_all(const Loops& loops, Left& left) {
  add_plain(loops, left);
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
  const std::size_t lane = size_++ % Double4::kSize;
  if (lane == 0) groups.emplace_back();
  Group& group = groups.back();
  // The last one's copies fill up the last four.
  for (std::size_t i = lane; i < Double4::kSize; ++i) {
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

void LandingSums::add(const LandingLanes& lanes, const std::vector<LandingDraw>& draws,
                      const std::vector<PixelShift>& shifts) {
  if (draws.empty()) return;
  const std::size_t groups = lanes.groups.size();
  require(shifts.empty() || shifts.size() == draws.size() * groups,
          "LandingSums: one shift a draw and group, or none");
  std::vector<Left> left;
  std::visit(
      [&](const auto& model) {
        using Model = std::decay_t<decltype(model)>;
        if constexpr (kHasFormula<Model>) {
          add_all(Loops<Model>{lanes.groups.data(), groups, draws.data(), draws.size(),
                               shifts.empty() ? nullptr : shifts.data(), groups_.data()},
                  left);
        } else {
          for (std::size_t i = 0; i < draws.size(); ++i)
            for (std::size_t g = 0; g < groups; ++g) left.push_back({i, g, 1});
        }
      },
      draws.front().lens.distortion);
  for (const Left& one : left)
    for (std::size_t lane = 0; lane < Double4::kSize; ++lane) {
      if (one.lanes[lane] == 0 || one.group * Double4::kSize + lane >= lanes.size()) continue;
      const LandingLanes::Group& point = lanes.groups[one.group];
      const PixelShift moved = shifts.empty() ? PixelShift{} : shifts[one.draw * groups + one.group];
      const auto place = landing_of(
          draws[one.draw], Vec2(point.pixel_x[lane] + moved.x[lane], point.pixel_y[lane] + moved.y[lane]));
      if (!place) continue;
      Double4 landed = 0, dx = 0, dy = 0;
      landed[lane] = 1;
      dx[lane] = place->x() - point.intended_x[lane];
      dy[lane] = place->y() - point.intended_y[lane];
      add_landing(0 < landed, dx, dy, groups_[one.group]);
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
