#pragma once
/// Of a show that ended: its hosts, robots and tracked surfaces on the console and in the summary.
#include <vector>

#include "common/cli.hpp"
#include "procam/show/metrics.hpp"

namespace procam::tools {

void print_group(const show::GroupMetrics& group, Console& console);
void print_fleet(const show::FleetMetrics& fleet, Console& console);
void print_tracked(const std::vector<show::MovingMetrics>& surfaces, Console& console);

}  // namespace procam::tools
