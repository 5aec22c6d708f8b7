#pragma once
/// How a picture lies on a surface, and which part of the surface shows it. All in fractions, so that nothing
/// depends on a picture's resolution.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

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
inline std::optional<std::string> fault_of(const ContentShape& shape) {
  constexpr std::size_t kMaxCorners = 4096;  // each pair of sides is looked at
  std::vector<const Points2*> rings;
  if (!shape.outline.empty()) rings.push_back(&shape.outline);
  for (const Points2& hole : shape.holes) rings.push_back(&hole);
  const auto name = [&](std::size_t i) {
    if (shape.outline.empty()) return "hole " + std::to_string(i);
    return i == 0 ? std::string("the outline") : "hole " + std::to_string(i - 1);
  };
  std::size_t corners = 0;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Points2& ring = *rings[r];
    corners += ring.size();
    if (ring.size() < 3) return name(r) + " has " + std::to_string(ring.size()) + " corners, not 3 or more";
    for (const Vec2& corner : ring)
      if (!(corner.x() >= 0 && corner.x() <= 1 && corner.y() >= 0 && corner.y() <= 1))
        return name(r) + " has a corner outside 0 .. 1: content coordinates are fractions of the area";
    if (corners > kMaxCorners)
      return "outline and holes have more than " + std::to_string(kMaxCorners) + " corners";
  }
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Points2& ring = *rings[r];
    const std::size_t n = ring.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 &a = ring[i], &b = ring[(i + 1) % n], &c = ring[(i + 2) % n];
      if (a == b) return name(r) + " has corner " + std::to_string(i) + " twice";
      const double bend = (b - a).x() * (c - b).y() - (b - a).y() * (c - b).x();
      if (bend == 0 && (b - a).dot(c - b) < 0)
        return name(r) + " turns back on itself at corner " + std::to_string((i + 1) % n);
      for (std::size_t j = i + 2; j < n && j < i + n - 1; ++j)
        if (segments_meet(a, b, ring[j], ring[(j + 1) % n]))
          return name(r) + " crosses or touches itself: its sides " + std::to_string(i) + " and " +
                 std::to_string(j) + " (from 0) meet";
    }
    if (!(std::abs(twice_area(ring)) > 1e-9)) return name(r) + " has no area";
    for (std::size_t q = 0; q < r; ++q) {
      const Points2& other = *rings[q];
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < other.size(); ++j)
          if (segments_meet(ring[i], ring[(i + 1) % n], other[j], other[(j + 1) % other.size()]))
            return name(r) + " meets " + name(q);
      const bool in_outline = q == 0 && !shape.outline.empty();
      if (contains(other, ring[0]) != in_outline || (!in_outline && contains(ring, other[0])))
        return name(r) + (in_outline ? " lies outside " : " and ") + name(q) +
               (in_outline ? "" : " lie in each other");
    }
  }
  if (shape.mask && (shape.mask->empty() || shape.mask->channels() != 1))
    return "its mask is not a grey picture";
  return std::nullopt;
}

}  // namespace procam
