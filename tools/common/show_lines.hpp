#pragma once
/// Of a show that ended: its hosts and robots on the console and in the summary.
#include "common/cli.hpp"
#include "procam/show/metrics.hpp"

namespace procam::tools {

void print_group(const show::GroupMetrics& group, Console& console);
void print_fleet(const show::FleetMetrics& fleet, Console& console);

}  // namespace procam::tools
