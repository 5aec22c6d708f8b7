#pragma once
/// What the levels of a simulated session are, before a seed moves them, and the rigs that are drawn from them.
#include <array>

#include "noise.hpp"
#include "procam/simulate/session.hpp"

namespace procam::simulate::internal {

struct Lens {
  ImageSize size;
  Intrinsics intrinsics;
  std::array<double, 5> distortion;  ///< k1 k2 p1 p2 k3
};

/// What a level is, before the seed moves it.
struct Recipe {
  Level level;
  const char* name;
  Lens camera, projector;
  Vec3 projector_in_camera;
  PrintedBoard board;
  int views;
  double nearest, farthest;  ///< camera to board centre, metres
  double tilt_deg;           ///< largest, against the line of sight
  int partly_lit_every;      ///< every such view has points outside the projector's picture; 0: none
  double ambient;
  CaptureOptions capture;
};

const std::vector<Recipe>& recipes();
/// Throws std::invalid_argument for a level without one.
const Recipe& recipe_of(Level level);

/// Takes as many random numbers from any range, so that one condition does not move the others.
double draw(const Range& range, Random& random);
Vec3 vary(const Vec3& v, double by, Random& random);

/// Camera and projector look at the same point: the middle of the projected frame falls on the camera's axis
/// in the middle of the working distances, or `offset` metres right of it.
Rig make_rig(const Recipe& recipe, double offset, const Conditions& conditions, Random& random,
             Random& random_terms);

}  // namespace procam::simulate::internal
