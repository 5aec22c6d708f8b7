#pragma once
/// Private to simulate: random numbers.
#include <cmath>
#include <cstdint>
#include <random>

#include "procam/core/base/types.hpp"

namespace procam::simulate {

/// Equal on every machine, which the standard's distributions are not.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t stream) : random_(seed * 0x9e3779b97f4a7c15u + stream) {
    random_.discard(8);
  }
  double uniform(double low, double high) { return low + (high - low) * double(random_() >> 11) * 0x1p-53; }
  double gauss() {
    const double u = 1 - uniform(0, 1), v = uniform(0, 2 * kPi);
    return std::sqrt(-2 * std::log(u)) * std::cos(v);
  }
  Vec3 gauss3() {
    const double x = gauss(), y = gauss(), z = gauss();
    return {x, y, z};
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace procam::simulate
