#pragma once
/// The sender's clock as seen from here: which local moment a stamp speaks of.
///
/// A message stamped s arrives at a = time(s) + delay, delay = d_0 + jitter, jitter >= 0. Clocks differ by an
/// offset and a drift, so arrival - stamp lies above a line
///   a - s >= offset + drift (s - s_0),
/// and touches it where a message met no jitter. The line is the edge of the lower convex hull of the points
/// (s, a - s) below their middle: of all lines below every point, the one with the least sum of distances to
/// them. Source: S. Moon, P. Skelly, D. Towsley, "Estimation and removal of clock skew from network delay
/// measurements", INFOCOM 1999; the hull as in L. Zhang, Z. Liu, C. Honghui Xia, "Clock synchronization
/// algorithms for network measurements", INFOCOM 2002. Here over a sliding window, in bins of which the
/// minimum is kept.
///
/// One-way messages do not separate the constant part d_0 from the offset: time(s) is late by it. It
/// belongs to the one delay number that is measured by looking at the light (TrackOptions::delay).
///
/// A sender's clock that is set (NTP's step, a restart) shows as stamps that would arrive before they were
/// sent, or all too late by the same amount. Such messages are doubtful until `confirm` of them in a row
/// agree with each other; then the clock starts anew with them.
#include <array>
#include <cstdint>
#include <optional>

#include "procam/core/base/export.hpp"

namespace procam::track {

struct ClockOptions {
  double window = 60;       ///< seconds of the sender's clock that the line is fitted to
  double max_drift = 5e-4;  ///< 500 ppm: NTP slews no faster, crystals are ten times better
  /// A message that is later than the fastest by more than this is doubtful. After `confirm` of them that
  /// agree over 2 * jump seconds the clock was set back by as much. Steps back by less are absorbed after
  /// three bins (1/20 of the window) whose messages all stay above the line. Steps forward show as messages
  /// faster than any: from 10 ms on, `confirm` of them are enough.
  double jump = 0.2;
  int confirm = 5;  ///< messages in a row
  /// local - sender, for clocks that are known to agree (one machine, PTP): local_from_unix() when stamps are
  /// Unix time. Nothing is estimated then, and no constant delay is hidden.
  std::optional<double> known_offset;
};

/// What observe() made of a message.
enum class ClockVerdict {
  kTaken,     ///< its time is to be believed
  kDoubtful,  ///< its stamp contradicts the others; wait for more
  kJumped     ///< the sender's clock was set: this message confirmed it, and its time is to be believed
};

class PROCAM_EXPORT Clock {
 public:
  struct Estimate {
    double offset = 0;  ///< local - sender at the last stamp, seconds, with the shortest delay in it
    double drift = 0;   ///< local seconds a sender's second, less one
    double sigma =
        0;  ///< of the line at the last stamp, from how well the bins' minima agree with it, seconds
    double jitter = 0;  ///< mean of arrival - time, seconds
    std::uint64_t jumps = 0;
  };
  explicit Clock(const ClockOptions& options = {});

  /// Takes one (stamp, arrival); both finite (std::invalid_argument).
  ClockVerdict observe(double stamp, double arrival);
  /// The local moment that a stamp speaks of, later by the shortest delay. Before the first message: the
  /// stamp plus the known offset, or plus zero.
  double time(double stamp) const;
  Estimate estimate() const;

 private:
  struct Point {
    double stamp = 0, lateness = 0;  ///< lateness: arrival - stamp - base_, so that digits are not lost
  };
  static constexpr int kBins = 60;

  Point& bin_at(int i) { return bins_[std::size_t((first_ + i) % kBins)]; }
  void restart(double stamp, double arrival);
  void take(double stamp, double lateness);
  void fit();
  bool has_risen();
  double line(double stamp) const { return level_ + drift_ * (stamp - origin_); }

  ClockOptions options_;
  bool started_ = false;
  double base_ = 0;                     ///< arrival - stamp of the first message
  std::array<Point, kBins> bins_ = {};  ///< ring: the least late message of each bin
  int first_ = 0, count_ = 0;
  double bin_end_ = 0;  ///< the newest bin takes stamps below this
  double origin_ = 0, level_ = 0, drift_ = 0, sigma_ = 0, jitter_ = 0, newest_ = 0;
  Point doubtful_first_;  ///< of a row that agrees with itself
  int doubtful_count_ = 0;
  std::uint64_t jumps_ = 0;
};

/// steady_now() less the system clock's Unix time, now: ClockOptions::known_offset for stamps in Unix time of
/// this machine, or of one that PTP keeps with it. It changes when the system clock is set.
PROCAM_EXPORT double local_from_unix();

}  // namespace procam::track
