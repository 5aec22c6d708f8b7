// How far the light of a calibrated rig lands from where it truly lands:   03_true_error truth.json rig.json
//
// Both rigs are looked at from their camera, and light is sent from a grid of projector pixels onto one wall,
// across the true projector's line of sight to its picture's centre and two metres away from it. The mean
// distance between the two spots is the true error; no real setup can measure it, a simulated one can.
#include <algorithm>
#include <iostream>

#include "procam/io/rig_file.hpp"

using namespace procam;

namespace {

constexpr double kWallDistance = 2.0;  // metres
constexpr int kGrid = 17;              // pixels a side of the grid

Plane wall_in_projector(const Projector& projector) {
  const Vec2 centre(0.5 * (projector.size().width - 1), 0.5 * (projector.size().height - 1));
  const std::optional<Ray> sight = projector.emit(centre);
  if (!sight)
    throw Error(ErrorKind::kDegenerate, "true projector", "its centre pixel emits no ray", "check its lens");
  return {-sight->direction, kWallDistance};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: 03_true_error truth.json rig.json\n";
    return 2;
  }
  const Rig truth = io::load_rig(argv[1]), rig = io::load_rig(argv[2]);
  const Projector &true_projector = truth.projector().projector, &projector = rig.projector().projector;
  if (projector.size() != true_projector.size()) {
    std::cerr << "the two projectors differ in size\n";
    return 3;
  }
  const Pose camera_from_true_projector = truth.projector_from_camera().inverse();
  const Pose camera_from_projector = rig.projector_from_camera().inverse();
  const Plane wall = wall_in_projector(true_projector);
  const Plane wall_seen_from_estimate = camera_from_projector.inverse() * (camera_from_true_projector * wall);

  double sum = 0, worst = 0;
  int count = 0;
  for (int row = 0; row < kGrid; ++row)
    for (int column = 0; column < kGrid; ++column) {
      const Vec2 pixel((projector.size().width - 1) * column / double(kGrid - 1),
                       (projector.size().height - 1) * row / double(kGrid - 1));
      const std::optional<Vec3> there = true_projector.intersect(pixel, wall);
      const std::optional<Vec3> here = projector.intersect(pixel, wall_seen_from_estimate);
      if (!there || !here) continue;
      const double error = (camera_from_true_projector * *there - camera_from_projector * *here).norm();
      sum += error;
      worst = std::max(worst, error);
      ++count;
    }
  if (count == 0) return 4;
  std::cout << "true error on a wall at " << kWallDistance << " m: mean " << 1000 * sum / count
            << " mm, worst " << 1000 * worst << " mm over " << count << " pixels\n";
  return 0;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
