/// A part of a room's points.
#include <algorithm>

#include "route.hpp"

namespace procam::room {

std::vector<char> evenly_by_map(const RoomPoints& points, const std::vector<char>& used) {
  constexpr std::size_t kPoints = 8000, kFewestOfMap = 400;
  const auto map_of = [&](std::size_t point) { return std::size_t(points.points[point].readings[0].map); };
  std::vector<std::size_t> of_map(points.maps.size()), seen(points.maps.size());
  for (std::size_t i = 0; i < used.size(); ++i) of_map[map_of(i)] += used[i] != 0;
  const std::size_t wanted = std::max(kFewestOfMap, kPoints / points.maps.size());
  std::vector<char> chosen(used.size(), 0);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const std::size_t all = of_map[map_of(i)], k = seen[map_of(i)]++;
    // Of `all` as many as are wanted, equally far apart.
    chosen[i] = all <= wanted || (k + 1) * wanted / all != k * wanted / all;
  }
  return chosen;
}

RoomPoints part_of(const RoomPoints& points, const std::vector<char>& chosen) {
  RoomPoints part{points.cameras, points.projectors, points.positions, points.maps, {}, {}};
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) part.points.push_back(points.points[i]);
  return part;
}

}  // namespace procam::room
