#include "simulated_clock.hpp"

#include <algorithm>
#include <iterator>

namespace procam::dds::internal {
namespace {

constexpr double kJump_s =
    10;  // forward; a simulation that runs faster than that between two messages is none to watch
constexpr double kRateSpan_s = 1;  // local time that the rate is taken over
constexpr double kSpan_s = 10;     // local time that is remembered
constexpr std::size_t kMaxSamples = 4096;

}  // namespace

SimulatedClock::Change SimulatedClock::take(double simulated, double arrival) {
  Change change = Change::kAdvanced;
  if (!samples_.empty()) {
    const Sample& newest = samples_.back();
    arrival = std::max(arrival, newest.local);
    if (simulated < newest.simulated || simulated > newest.simulated + kJump_s) {
      samples_.clear();
      change = Change::kJumped;
    } else if (simulated == newest.simulated) {
      change = Change::kStands;
      // Only the first and the newest of a pause count.
      if (samples_.size() > 1 && (samples_.end() - 2)->simulated == simulated) samples_.pop_back();
    }
  }
  samples_.push_back({simulated, arrival});
  while (samples_.size() > kMaxSamples || samples_.front().local < arrival - kSpan_s) samples_.pop_front();
  return change;
}

std::optional<double> SimulatedClock::local(double simulated, double arrival) const {
  if (samples_.empty()) return std::nullopt;
  const auto after =
      std::upper_bound(samples_.begin(), samples_.end(), simulated,
                       [](double value, const Sample& sample) { return value < sample.simulated; });
  double time = samples_.front().local;
  if (after == samples_.end()) {
    const double now = rate();
    time = samples_.back().local + (now > 0 ? (simulated - samples_.back().simulated) / now : 0);
  } else if (after != samples_.begin()) {
    const Sample& before = *std::prev(after);
    time = before.local + (simulated - before.simulated) / (after->simulated - before.simulated) *
                              (after->local - before.local);
  } else if (const double now = rate(); now > 0) {
    time -= (samples_.front().simulated - simulated) / now;  // older than what is remembered
  }
  return std::min(time, arrival);
}

double SimulatedClock::rate() const {
  if (samples_.size() < 2) return 1;
  const Sample& newest = samples_.back();
  if ((samples_.end() - 2)->simulated == newest.simulated) return 0;
  // Back to a pause, or over the last second.
  auto oldest = std::prev(samples_.end());
  while (oldest != samples_.begin() && newest.local - oldest->local < kRateSpan_s &&
         std::prev(oldest)->simulated < oldest->simulated)
    --oldest;
  const double span = newest.local - oldest->local;
  return span > 0 ? (newest.simulated - oldest->simulated) / span : 1;
}

}  // namespace procam::dds::internal
