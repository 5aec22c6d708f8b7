#pragma once
/// Robots that light one room (docs/live.md): each announces the surfaces it can light, and all decide alike who lights which.
///
///   dds::RobotFleet fleet({"hall", "spot"});
///   while (showing) {
///     fleet.claim({{"wall", 10, false, true}});         // surface, priority, blend, ready
///     const std::vector<std::string> lit = fleet.lit(); // the surfaces that this robot may light now
///     ... show a frame with them ...
///     fleet.shown(lit, light_time);
///   }
///
/// | topic | key | QoS |
/// |---|---|---|
/// | procam/fleet/NAME/robot | robot | reliable, transient local, keep last 1, liveliness of 0.4 s |
///
/// Two claims of one surface are in conflict when their regions overlap and not both robots blend. Claims that are ready are
/// ordered: greatest priority first, of equal ones the robot that lights already, then the lesser name. In this order a robot
/// lights a surface unless a robot before it does and their claims are in conflict (fleet_decision()).
///
/// Hand-over: a robot that should light asks by a number, its turn. It lights when every other robot has granted that turn. A
/// robot grants all turns except those in conflict with a turn of its own; a robot that lights ends its turn once all others
/// have granted the next one, and after the light of its last frame with the surface is gone. So one announcement, from the
/// robot that goes dark, begins the light of the next.
///
/// Never two: if r lights in turn k and o in turn j, in conflict, then r granted j before k began (it grants no conflict in a
/// turn) and after j began, and o granted k before j began and after k began. The order would be a circle. Delays, losses
/// and the order of messages do not matter (Ricart and Agrawala, CACM 24(1), 1981). It needs that the robots know each
/// other: discovery within kFirstWait, and no network that is cut for longer than the liveliness of 0.4 s.
///
/// Dark time of a hand-over: one message, the next frame of the robot that begins, and its delay to the light.
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::dds {

/// A surface that a robot can light.
struct FleetClaim {
  std::string surface;
  int priority = 0;    ///< -1000 to 1000
  bool blend = false;  ///< it may be lit together with other robots that blend
  bool ready = false;  ///< a frame with it is rendered
  Points2 region =
      {};  ///< what the projector reaches, convex, metres of the surface (core/geometry/convex.hpp);
           ///< empty: all of it
};

/// Two claims that may not be lit at the same time. Regions that only touch do not overlap.
PROCAM_EXPORT bool in_conflict(const FleetClaim& a, const FleetClaim& b);

/// What a robot sends of itself. All of it is sent again at each change and each half second.
struct FleetAnnouncement {
  struct Claim {
    FleetClaim claim;
    std::uint64_t turn = 0;  ///< 0: it does not ask for it
    bool lights = false;
  };
  /// The robot that announces is dark wherever this turn of the other robot lights.
  struct Grant {
    std::string robot, surface;
    std::uint64_t turn = 0;
  };
  std::string robot;
  std::uint64_t incarnation = 0;  ///< greater: a later start of the robot of this name
  std::uint64_t sequence = 0;     ///< of two of one incarnation, the greater is newer
  double stamp = 0;               ///< when it was sent, Unix time, seconds
  double latency = 0;             ///< from the last grant to its light on the surface, seconds
  std::vector<Claim> claims = {};
  std::vector<Grant> grants = {};
};

/// By surface, the robots that should light it, by name. It depends on the set of announcements alone: equal for every robot
/// that has them, in any order. Claims that are not ready light nothing.
PROCAM_EXPORT std::map<std::string, std::vector<std::string>> fleet_decision(
    const std::vector<FleetAnnouncement>& announcements);

struct FleetOptions {
  std::string name;    ///< of the fleet: 1 to 64 letters of a-z A-Z 0-9 _ -
  std::string robot;   ///< the same letters; no two robots of a fleet have one name
  double latency = 0;  ///< FleetAnnouncement::latency, seconds
};

struct FleetStatus {
  int robots = 1;  ///< with this one
  std::map<std::string, std::vector<std::string>>
      by;                             ///< surface: the robots that announce that they light it
  std::map<std::string, int> others;  ///< surface: other robots that are ready to light it
  std::uint64_t turns = 0;            ///< times that this robot began to light a surface
  double last_wait = 0;        ///< from the request to the last grant, in the last of these turns, seconds
  std::uint64_t rejected = 0;  ///< announcements that were invalid or too large
  bool is_superseded = false;  ///< another robot has this name and was started later: this one is dark
  double largest_latency = 0;  ///< that any robot announces, seconds
};

/// A robot of a fleet. Its thread receives, decides and announces; the calls only exchange values with it.
class PROCAM_EXPORT RobotFleet {
 public:
  static constexpr double kFirstWait =
      1.0;  ///< from the start to the first turn: robots find each other, seconds

  /// Throws Error(kInput) for invalid options, Error(kUnsupported) in a build without DDS, Error(kDevice) where DDS finds no
  /// network.
  explicit RobotFleet(const FleetOptions& options);
  ~RobotFleet();  ///< its claims end at once: the caller is dark before
  RobotFleet(const RobotFleet&) = delete;
  RobotFleet& operator=(const RobotFleet&) = delete;

  /// All surfaces that this robot can light now; others are given up. Another region or blend begins another turn, with a dark
  /// time. Throws Error(kInput) for a claim that cannot be.
  void claim(const std::vector<FleetClaim>& claims);
  /// The surfaces that may be lit in a frame that is drawn now.
  std::vector<std::string> lit() const;
  /// The frame just shown has light on these surfaces, from the steady time `light_time` (steady_now()) on. The frame before is
  /// on the wall until then.
  void shown(const std::vector<std::string>& surfaces, double light_time);

  FleetStatus status() const;
  /// Domain, network and topic, in words.
  std::string description() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace procam::dds
