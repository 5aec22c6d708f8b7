// Light of a projector with lens shift, on a wall two metres away: there and back again.
#include "procam/core/lens/projector.hpp"

int main() {
  const procam::Projector projector{{{1024, 768}, {1880, 1893, 502, 855, 0.4}, procam::NoDistortion{}}};
  const procam::Plane wall{procam::Vec3(0, 0, -1), 2.0};
  const auto spot = projector.intersect(procam::Vec2(100, 200), wall);
  const auto pixel = spot ? projector.project(*spot) : std::nullopt;
  return pixel && (*pixel - procam::Vec2(100, 200)).norm() < 1e-9 ? 0 : 1;
}
