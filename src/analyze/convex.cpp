#include "convex.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace procam::analyze {

CentredWidth largest_rectangle(const Points2& quadrilateral, double height_by_width) {
  const std::vector<HalfPlane> sides = half_planes(quadrilateral);
  const double size = std::sqrt(std::abs(area(quadrilateral)));
  Points3 rows;
  for (const HalfPlane& side : sides)
    rows.emplace_back(side.normal.x(), side.normal.y(),
                      0.5 * (std::abs(side.normal.x()) + std::abs(side.normal.y()) * height_by_width));

  // Each side omitted once: the other three, all touched, give one candidate.
  CentredWidth best;
  int equally_good = 0;
  for (std::size_t held_out = 0; held_out < rows.size(); ++held_out) {
    const std::size_t i = (held_out + 1) % 4, j = (held_out + 2) % 4, k = (held_out + 3) % 4;
    const Vec3 jk = rows[j].cross(rows[k]), ki = rows[k].cross(rows[i]), ij = rows[i].cross(rows[j]);
    const double det = rows[i].dot(jk);
    if (std::abs(det) < 1e-12) continue;  // two of the three sides are parallel and say the same of w
    const Vec3 x = (sides[i].offset * jk + sides[j].offset * ki + sides[k].offset * ij) / det;
    if (rows[held_out].dot(x) > sides[held_out].offset + 1e-10 * size) continue;
    if (equally_good > 0 && std::abs(x[2] - best.width) <= 1e-9 * size) {
      best.centre += (x.head<2>() - best.centre) / double(++equally_good);
    } else if (x[2] > best.width) {
      best = {x.head<2>(), x[2]};
      equally_good = 1;
    }
  }
  return best;
}

}  // namespace procam::analyze
