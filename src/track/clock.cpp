#include "procam/track/clock.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {
namespace {

/// A line through bins that span less has no slope worth telling from jitter.
constexpr double kShortestSpan = 10;
/// No message of so many bins touches the line: it has risen. And what counts as a step at all, seconds.
constexpr int kRisenBins = 3;
constexpr double kSmallestRise = 0.01;

}  // namespace

double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double local_from_unix() {
  const std::chrono::duration<double> unix_time = std::chrono::system_clock::now().time_since_epoch();
  return steady_now() - unix_time.count();
}

Clock::Clock(const ClockOptions& options) : options_(options) {
  require(options.window > 0 && options.max_drift >= 0 && options.jump > 0 && options.confirm >= 1 &&
              std::isfinite(options.known_offset.value_or(0)),
          "Clock: window, jump and confirm must be positive, the drift not negative");
}

void Clock::restart(double stamp, double arrival) {
  started_ = true;
  base_ = arrival - stamp;
  origin_ = stamp;
  level_ = drift_ = 0;
  first_ = count_ = 0;
  take(stamp, 0);
}

void Clock::take(double stamp, double lateness) {
  const double width = options_.window / kBins;
  if (count_ == 0 || stamp >= bin_end_) {
    if (count_ == kBins) {
      first_ = (first_ + 1) % kBins;
      --count_;
    }
    bin_at(count_++) = {stamp, lateness};
    bin_end_ = stamp + width;
  } else if (stamp >= bin_end_ - width && lateness < bin_at(count_ - 1).lateness) {
    bin_at(count_ - 1) = {stamp, lateness};
  } else {
    return;  // above the line's points, or of a bin that is closed: nothing changes
  }
  while (count_ > 1 && bin_at(0).stamp < stamp - options_.window) {
    first_ = (first_ + 1) % kBins;
    --count_;
  }
  fit();
}

/// The edge of the lower hull below the middle of the stamps (Andrew's monotone chain; the stamps grow).
void Clock::fit() {
  std::array<Point, kBins> hull;
  int corners = 0;
  double middle = 0;
  for (int i = 0; i < count_; ++i) {
    const Point p = bin_at(i);
    middle += p.stamp / count_;
    while (corners >= 2) {
      const Point &a = hull[std::size_t(corners - 2)], &b = hull[std::size_t(corners - 1)];
      const double turn =
          (b.stamp - a.stamp) * (p.lateness - a.lateness) - (p.stamp - a.stamp) * (b.lateness - a.lateness);
      if (turn > 0) break;
      --corners;
    }
    hull[std::size_t(corners++)] = p;
  }
  drift_ = 0;
  origin_ = bin_at(count_ - 1).stamp;
  if (bin_at(count_ - 1).stamp - bin_at(0).stamp >= kShortestSpan) {
    int edge = 1;
    while (edge < corners - 1 && hull[std::size_t(edge)].stamp < middle) ++edge;
    const Point &a = hull[std::size_t(edge - 1)], &b = hull[std::size_t(edge)];
    drift_ =
        std::clamp((b.lateness - a.lateness) / (b.stamp - a.stamp), -options_.max_drift, options_.max_drift);
  }
  level_ = hull[0].lateness - drift_ * (hull[0].stamp - origin_);
  for (int i = 1; i < corners; ++i)
    level_ =
        std::min(level_, hull[std::size_t(i)].lateness - drift_ * (hull[std::size_t(i)].stamp - origin_));
  sigma_ = 0;
  for (int i = 0; i < count_; ++i) sigma_ += (bin_at(i).lateness - line(bin_at(i).stamp)) / count_;
}

bool Clock::has_risen() {
  if (count_ <= 2 * kRisenBins) return false;
  // The newest bin is still filling; those before it are complete. What the others miss the line by is known.
  double others = 0, recent = 0;
  const int old = count_ - 1 - kRisenBins;
  for (int i = 0; i < old; ++i) others += (bin_at(i).lateness - line(bin_at(i).stamp)) / old;
  recent = 1e300;
  for (int i = old; i < count_; ++i) recent = std::min(recent, bin_at(i).lateness - line(bin_at(i).stamp));
  if (recent < std::max(kSmallestRise, 8 * others)) return false;
  first_ = (first_ + old) % kBins;
  count_ -= old;
  fit();
  return true;
}

ClockVerdict Clock::observe(double stamp, double arrival) {
  if (!std::isfinite(stamp) || !std::isfinite(arrival))
    throw std::invalid_argument("Clock::observe: stamp or arrival is not finite");
  if (options_.known_offset) {
    newest_ = stamp;
    started_ = true;
    jitter_ += 0.02 * (arrival - time(stamp) - jitter_);
    return ClockVerdict::kTaken;
  }
  if (!started_) {
    restart(stamp, arrival);
    newest_ = stamp;
    return ClockVerdict::kTaken;
  }
  const double lateness = (arrival - stamp) - base_;
  const double above = lateness - line(stamp);
  // No message was faster for seconds: one that is by more than the minima scatter has another clock.
  const double below =
      count_ > 2 * kRisenBins ? std::min(options_.jump, std::max(kSmallestRise, 8 * sigma_)) : options_.jump;
  if (above > options_.jump || above < -below) {
    // Messages that queued up somewhere are late as well, by less and less; those of a set clock agree.
    if (doubtful_count_ == 0 || std::abs(lateness - doubtful_first_.lateness) > options_.jump / 2) {
      doubtful_count_ = 0;
      doubtful_first_ = {stamp, lateness};
    }
    ++doubtful_count_;
    const bool lasted = above < 0 || std::abs(stamp - doubtful_first_.stamp) > 2 * options_.jump;
    if (doubtful_count_ < options_.confirm || !lasted) return ClockVerdict::kDoubtful;
    doubtful_count_ = 0;
    ++jumps_;
    restart(stamp, arrival);
    newest_ = stamp;
    return ClockVerdict::kJumped;
  }
  doubtful_count_ = 0;
  newest_ = std::max(newest_, stamp);
  const bool new_bin = stamp >= bin_end_;
  take(stamp, lateness);
  jitter_ += 0.02 * (lateness - line(stamp) - jitter_);
  if (new_bin && has_risen()) {
    ++jumps_;
    return ClockVerdict::kJumped;
  }
  return ClockVerdict::kTaken;
}

double Clock::time(double stamp) const {
  if (options_.known_offset) return stamp + *options_.known_offset;
  return started_ ? (stamp + base_) + line(stamp) : stamp;
}

Clock::Estimate Clock::estimate() const {
  Clock::Estimate result;
  result.offset = options_.known_offset ? *options_.known_offset : base_ + line(newest_);
  result.drift = drift_;
  // One or two bins do not tell how well they repeat.
  result.sigma = options_.known_offset ? 0 : count_ < 3 ? std::max(sigma_, jitter_) : sigma_;
  result.jitter = jitter_;
  result.jumps = jumps_;
  return result;
}

}  // namespace procam::track
