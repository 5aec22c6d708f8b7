#pragma once
#include <cstddef>
#include <vector>

#include "motion_bank.hpp"

namespace procam::track::internal {

/// The messages that are kept, oldest first.
class History {
 public:
  History() : ring_(kKept) {}
  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
  Kept& operator[](std::size_t i) { return ring_[(first_ + i) % kKept]; }
  const Kept& operator[](std::size_t i) const { return ring_[(first_ + i) % kKept]; }
  const Kept& newest() const { return (*this)[count_ - 1]; }
  void clear() { count_ = 0; }
  /// Room for one at position i; the oldest goes when all is full.
  std::size_t insert(std::size_t i) {
    if (count_ == kKept) {
      first_ = (first_ + 1) % kKept;
      --count_;
      --i;
    }
    ++count_;
    for (std::size_t k = count_ - 1; k > i; --k) (*this)[k] = (*this)[k - 1];
    return i;
  }

 private:
  static constexpr std::size_t kKept = 128;  ///< messages: 0.6 s at 200 Hz

  std::vector<Kept> ring_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace procam::track::internal
