#pragma once
/// How a picture lies on a surface, and which part of the surface shows it. All in fractions, so that nothing
/// depends on a picture's resolution.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam {

/// For a picture whose width over height is not that of the content's area.
enum class Fit {
  kStretch,  ///< the picture's corners on the area's corners, whatever that does to circles
  kContain,  ///< all of the picture, undistorted and in the middle; beside it nothing is drawn
  kCover     ///< all of the area, undistorted; what stands over on two sides is cut off
};

struct ContentLayout {
  Fit fit = Fit::kStretch;
  /// The part of the picture that is shown, in fractions of the picture; fitted as if it were the picture.
  Vec2 crop_from = Vec2(0, 0), crop_to = Vec2(1, 1);
};

/// Where on the surface content may be: all of [0, 1] x [0, 1], or inside an outline, outside holes, and with
/// a mask's alpha. Polygons in content coordinates (u, v), each a ring of three corners or more, in either
/// sense, whose last corner joins the first. No ring may cross itself or another; holes lie in the outline
/// and not in each other.
struct ContentShape {
  Points2 outline;  ///< empty: the whole area
  std::vector<Points2> holes;
  std::string mask_file;                ///< beside the surfaces file; may be empty
  std::shared_ptr<const ImageU8> mask;  ///< 8-bit grey, its corners on the area's; set by io::load_surfaces

  bool is_whole() const { return outline.empty() && holes.empty() && !mask; }
};

/// Twice the signed area of a ring; positive clockwise as seen (v runs down).
inline double twice_area(const Points2& ring) {
  double sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum;
}

/// Even-odd rule, a ring's border counts to either side.
inline bool contains(const Points2& ring, const Vec2& point) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if ((a.y() > point.y()) != (b.y() > point.y()) &&
        point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

/// Is there content at this place, by outline and holes?
inline bool in_shape(const ContentShape& shape, const Vec2& uv) {
  if (!shape.outline.empty() && !contains(shape.outline, uv)) return false;
  return std::none_of(shape.holes.begin(), shape.holes.end(),
                      [&](const Points2& hole) { return contains(hole, uv); });
}

/// Do the segments ab and cd have a point in common?
inline bool segments_meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const auto side = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    const double twice = (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
    return (twice > 0) - (twice < 0);
  };
  const auto between = [](const Vec2& p, const Vec2& q, const Vec2& r) {  // r on the line pq
    return std::min(p.x(), q.x()) <= r.x() && r.x() <= std::max(p.x(), q.x()) &&
           std::min(p.y(), q.y()) <= r.y() && r.y() <= std::max(p.y(), q.y());
  };
  const int c_side = side(a, b, c), d_side = side(a, b, d), a_side = side(c, d, a), b_side = side(c, d, b);
  if (c_side * d_side < 0 && a_side * b_side < 0) return true;
  return (c_side == 0 && between(a, b, c)) || (d_side == 0 && between(a, b, d)) ||
         (a_side == 0 && between(c, d, a)) || (b_side == 0 && between(c, d, b));
}

/// Why nothing can be cut out by it, in words; nullopt for a good shape.
PROCAM_EXPORT std::optional<std::string> fault_of(const ContentShape& shape);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/surface/detail/content_layout_body.hpp"
#endif
