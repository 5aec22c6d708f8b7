// Five points of a picture, found again on a wall: the map between them, and how far it can be trusted.
//
// Four pairs fix a homography exactly; more of them are fitted, weighted by how well each was measured, and
// the fit says how uncertain a mapped point is. Three points on one line are refused with the reason.
#include <iostream>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography_fit.hpp"

using namespace procam;

int main() {
  // Picture coordinates (u, v) run from 0 to 1; the wall was measured in metres. The last point was only
  // paced off.
  const Points2 in_picture = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.4}};
  const Points2 on_wall = {{0.101, 0.198}, {1.897, 0.102}, {2.003, 1.101}, {0.202, 1.399}, {1.02, 0.65}};

  HomographyOptions options;
  options.sigma = 0.002;                                // metres, for a point of weight one
  options.weights = {1, 1, 1, 1, 1.0 / (25.0 * 25.0)};  // 1 / variance: the paced point is off by some 5 cm
  const HomographyFit fit = fit_homography(in_picture, on_wall, options);

  const Vec2 corner(1, 0);
  const std::optional<Vec2> landed = fit.destination_from_source.apply(corner);
  const std::optional<Mat2> covariance = mapped_covariance(fit, corner);
  if (!landed || !covariance) return 1;
  std::cout << "the picture's top-right corner lands at " << landed->transpose() << " m, give or take "
            << 1000 * std::sqrt(covariance->trace()) << " mm\n";

  try {
    homography_from_four_points({Vec2(0, 0), Vec2(0.5, 0), Vec2(1, 0), Vec2(0, 1)},
                                {Vec2(0, 0), Vec2(1, 0), Vec2(2, 0.3), Vec2(0, 1)});
  } catch (const Error& error) {
    std::cout << error.subject() << ": " << error.why() << ".\n  " << error.next() << "\n";
    return (*landed - on_wall[1]).norm() < 0.01 ? 0 : 1;
  }
  return 1;
}
