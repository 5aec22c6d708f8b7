#pragma once
/// Simulated time (rosgraph_msgs/Clock on /clock): which local moment a stamp of it speaks of.
///
/// Clock messages are pairs of simulated time and arrival. Between two of them time is interpolated, after the newest one it
/// goes on at the rate of the last second, and never beyond the arrival of what carries the stamp. A stamp at which the
/// simulation stands speaks of the newest moment at which it did.
#include <deque>
#include <optional>

namespace procam::dds::internal {

class SimulatedClock {
 public:
  /// What a Clock message changed. A jump (back, or forward by more than ten seconds) begins anew.
  enum class Change { kAdvanced, kStands, kJumped };

  /// Both in seconds; `arrival` by steady_now(). Finite.
  Change take(double simulated, double arrival);

  /// By steady_now(), seconds; nullopt before the first message.
  std::optional<double> local(double simulated, double arrival) const;

  /// Simulated seconds a local second; 0 while it stands, 1 before it is known.
  double rate() const;

 private:
  struct Sample {
    double simulated = 0, local = 0;
  };
  std::deque<Sample> samples_;  ///< neither of both decreases
};

}  // namespace procam::dds::internal
