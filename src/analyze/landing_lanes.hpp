#pragma once
/// Many points of one surface, followed through a wrong chain at once: four by four (four.hpp), no branch a
/// point.
#include <vector>

#include "light_chain.hpp"
#include "procam/core/base/detail/four.hpp"

namespace procam::analyze {

using detail::any;
using detail::Double4;
using detail::Mask4;
using detail::only;

/// What does not change from draw to draw: each point's place on the surface, its pixel, the normalised image
/// point that the believed lens undistorts it to, and there the inverse of the lens model's Jacobian.
struct LandingLanes {
  struct Group {
    Double4 intended_x, intended_y;
    Double4 pixel_x, pixel_y;
    Double4 start_x, start_y;
    Double4 inverse_xx, inverse_xy, inverse_yx, inverse_yy;
  };
  std::vector<Group> groups;

  std::size_t size() const { return size_; }
  void add(const Vec2& on_surface, const Camera& lens, const Vec2& pixel, const Vec3& bearing);

 private:
  std::size_t size_ = 0;
};

/// One draw of everything.
struct LandingDraw {
  Camera lens;
  Pose surface_from_projector;
};
/// Of four pixels.
struct PixelShift {
  Double4 x, y;
};

/// Over draws, by point, of the offsets from the intended places. A draw whose light does not meet the
/// surface in front of the projector, on this side of infinity, is missing in `landed` and has no part in the
/// rest.
class LandingSums {
 public:
  struct Group {
    Double4 landed, x, y, xx, xy, yy, worst2;
  };

  explicit LandingSums(std::size_t groups) : groups_(groups) {}
  /// Follows the light of every point through every draw; the lenses are all of one model. `shifts`: of the
  /// pixels, draw by draw one a group; empty where they do not move.
  void add(const LandingLanes& lanes, const std::vector<LandingDraw>& draws,
           const std::vector<PixelShift>& shifts);
  void add(const LandingSums& other);
  double of(Double4 Group::*sum, std::size_t point) const {
    return (groups_[point / Double4::kSize].*sum)[point % Double4::kSize];
  }

 private:
  /// Must be followed to its end one by one: 1 in those lanes, 0 in the others.
  struct Left {
    std::size_t draw, group;
    Double4 lanes;
  };
  template <typename Model>
  struct Loops;

  std::vector<Group> groups_;
};

}  // namespace procam::analyze
