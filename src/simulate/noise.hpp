#pragma once
/// Random numbers that are the same on every machine: splitmix64 and a table of normal quantiles. (The
/// standard library leaves std::normal_distribution's algorithm open.)
#include <cstdint>
#include <vector>

namespace procam::simulate::internal {

/// S. Vigna's splitmix64 step: a full-period generator that also decorrelates consecutive seeds.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// A stream of its own for each (seed, a, b).
  Random(std::uint64_t seed, std::uint64_t a, std::uint64_t b) : state_(seed) {
    state_ = next() ^ a;
    state_ = next() ^ b;
    state_ = next();
  }

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// In [low, high).
  double uniform(double low, double high) { return low + (high - low) * (double(next() >> 11) * 0x1p-53); }

 private:
  std::uint64_t state_;
};

/// 65536 equally likely values with mean 0 and variance 1: the standard normal's quantiles at (i + 1/2) /
/// 65536, largest 4.2. Four indices come from one Random::next().
const std::vector<float>& normal_table();

}  // namespace procam::simulate::internal
