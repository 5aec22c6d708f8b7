#pragma once
/// A show of a robot in a fleet (dds/fleet.hpp): which of its surfaces it announces, and which stay dark.
#include <map>
#include <string>
#include <vector>

#include "lit_region.hpp"
#include "procam/dds/fleet.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/run.hpp"

namespace procam::show {

class FleetLink {
 public:
  /// `latency`: from a decision to the light, seconds. Throws as dds::RobotFleet does.
  FleetLink(const ShowOptions& options, double latency);

  /// The surfaces of the show that stay dark in the next frame: those that this robot does not light.
  std::vector<std::string> dark(const Show& show) const;
  /// After a new frame, for the light of a time (steady). `is_drawn`: false for one that is black because it failed.
  void shown(const Projection& projection, bool is_drawn, double light_time);
  /// After the same frame again.
  void held(double light_time) { fleet_.shown(lit_, light_time); }

  /// Surfaces whose robots have changed, in words.
  std::vector<std::string> take_news();
  FleetMetrics metrics() const;
  std::string description() const { return fleet_.description(); }

 private:
  dds::RobotFleet fleet_;
  std::string name_, robot_;
  int priority_;
  bool blends_;
  /// What this robot announces of a surface; all of it until another robot is ready to light it.
  struct Region {
    AnnouncedRegion announced;
    bool is_shared = false;
  };
  Points2 region_of(const std::string& surface, const Placement& placement, const Projector& projector,
                    const dds::FleetStatus& status, double light_time);
  std::map<std::string, Region> regions_;
  std::vector<std::string> lit_;  ///< in the last new frame
  dds::FleetStatus told_;
};

}  // namespace procam::show
