#include "noise.hpp"

#include <cmath>

namespace procam::simulate::internal {
namespace {

std::vector<float> make_normal_table() {
  constexpr int kCount = 65536;
  std::vector<double> quantile(kCount);
  double x =
      0;  // upwards from the median: the neighbour's quantile is a start from which Newton needs few steps
  double sum2 = 0;
  for (int i = kCount / 2; i < kCount; ++i) {
    const double tail = 1 - (i + 0.5) / kCount;
    for (int step = 0; step < 8; ++step) {
      const double density = std::exp(-0.5 * x * x) * 0.3989422804014327;  // 1/sqrt(2 pi)
      x += (0.5 * std::erfc(x * 0.7071067811865476) - tail) / density;
    }
    quantile[std::size_t(i)] = x;
    sum2 += 2 * x * x;
  }
  const double to_unit_variance = std::sqrt(kCount / sum2);
  std::vector<float> table(kCount);
  for (int i = kCount / 2; i < kCount; ++i) {
    table[std::size_t(i)] = float(quantile[std::size_t(i)] * to_unit_variance);
    table[std::size_t(kCount - 1 - i)] = -table[std::size_t(i)];
  }
  return table;
}

}  // namespace

const std::vector<float>& normal_table() {
  static const std::vector<float> table = make_normal_table();
  return table;
}

}  // namespace procam::simulate::internal
