#pragma once
/// Fixtures without any symmetry to hide behind: fx != fy, skew, off-centre, w != h, a rotation about no
/// axis.
#include <random>

#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::test {

/// Uniform in [low, high].
inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Vec3 random_vec3(std::mt19937_64& random, double size) {
  return Vec3{uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}

/// Rotation angle below pi, translation within two metres.
inline Pose random_pose(std::mt19937_64& random) {
  const Vec3 axis = random_vec3(random, 1).normalized();
  return Pose(so3_exp(Vec3(axis * uniform(random, 0.1, 3.0))), random_vec3(random, 2));
}

inline Pose lopsided_pose() {
  return Pose(so3_exp(Vec3(0.31, -0.57, 0.83)), Vec3(0.42, -0.19, 1.37));
}
inline Pose other_lopsided_pose() {
  return Pose(so3_exp(Vec3(-1.21, 0.23, 0.47)), Vec3(-0.61, 0.88, 0.29));
}

inline Intrinsics lopsided_intrinsics() {
  return {1210.0, 1175.0, 517.3, 402.9, 2.7};
}

}  // namespace procam::test
