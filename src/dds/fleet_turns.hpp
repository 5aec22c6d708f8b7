#pragma once
/// A robot of a fleet without DDS: which surfaces it lights, asks for and grants (the rules are in procam/dds/fleet.hpp).
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/dds/fleet.hpp"

namespace procam::dds::internal {

enum class Taken {
  kNew,
  kOlder,   ///< than the one at hand
  kRefused  ///< one robot too many
};

class FleetTurns {
 public:
  /// Before `begins` the robot asks for nothing. Times: of one steady clock, seconds.
  FleetTurns(const FleetOptions& options, std::uint64_t incarnation, double begins);

  /// Of this robot, without a fault (fleet_checks.hpp).
  void claim(const std::vector<FleetClaim>& claims);
  /// Of another robot, without a fault.
  Taken take(const FleetAnnouncement& announcement);
  /// The robot is gone. `begins`: for this robot, when the one that is gone had its name.
  void forget(const std::string& robot, double begins);
  void shown(const std::vector<std::string>& surfaces, double light_time);

  /// Decides anew. true: what is to be announced has changed.
  bool step(double now);
  /// The next one to be sent.
  FleetAnnouncement announce(double stamp);

  std::vector<std::string> lit() const;
  bool is_superseded() const { return is_superseded_; }
  FleetStatus status() const;

 private:
  enum class State {
    kDark,
    kAsks,    ///< in a turn, dark
    kLights,  ///< in a turn
    kEnds     ///< in a turn, until its last light is gone
  };
  struct Own {
    FleetClaim claim;                ///< announced
    std::optional<FleetClaim> next;  ///< nullopt: given up
    State state = State::kDark;
    std::uint64_t turn = 0;
    double asked = 0;
    std::optional<double> dark_from;  ///< when the last light is gone
  };

  void step(Own& own, bool should, double now);
  /// The claim of now, where that needs no new turn.
  static bool keeps_turn(Own& own);
  bool is_granted(const Own& own) const;
  /// A claim in conflict that should light instead, and would as soon as this robot is dark.
  bool has_successor(const Own& own, const std::vector<std::string>& chosen) const;
  bool is_granted_by_others(const std::string& robot, const FleetAnnouncement::Claim& asked) const;
  FleetAnnouncement content() const;
  std::vector<FleetAnnouncement::Grant> grants() const;

  FleetOptions options_;
  std::uint64_t incarnation_, next_turn_, sequence_ = 0;
  double begins_;
  bool is_superseded_ = false;
  std::map<std::string, Own> own_;                   ///< by surface
  std::map<std::string, FleetAnnouncement> others_;  ///< by robot
  FleetAnnouncement announced_;                      ///< at the last step
  std::uint64_t turns_ = 0;
  double last_wait_ = 0;
};

}  // namespace procam::dds::internal
