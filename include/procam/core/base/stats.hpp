#pragma once
/// Order statistics of numbers without NaN. Cost: linear in their count.
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace procam {

/// The number that would stand at `rank` (0: the smallest) after sorting; rank < size. Reorders `values`.
template <typename T>
T at_rank(std::vector<T>& values, std::size_t rank) {
  const auto place = values.begin() + std::ptrdiff_t(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}
template <typename T>
T at_rank(std::vector<T>&& values, std::size_t rank) {
  return at_rank(values, rank);
}

/// The upper median, rank size / 2, of at least one number.
template <typename T>
T median(std::vector<T> values) {
  return at_rank(values, values.size() / 2);
}
/// The lower median, rank (size - 1) / 2, of at least one number.
template <typename T>
T lower_median(std::vector<T> values) {
  return at_rank(values, (values.size() - 1) / 2);
}
/// The upper median, or `otherwise` of no numbers.
template <typename T>
T median_or(std::vector<T> values, T otherwise) {
  return values.empty() ? otherwise : median(std::move(values));
}

/// The number at rank floor(share (size - 1)) of at least one number; share 0: the smallest, 1: the largest.
template <typename T>
T quantile(std::vector<T> values, double share) {
  return at_rank(values, std::size_t(share * double(values.size() - 1)));
}

}  // namespace procam
