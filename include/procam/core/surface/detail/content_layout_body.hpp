#pragma once
/// The bodies of content_layout.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/surface/content_layout.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<std::string> fault_of(const ContentShape& shape) {
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
// NOLINTEND(misc-definitions-in-headers)
