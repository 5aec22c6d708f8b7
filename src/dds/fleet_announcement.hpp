#pragma once
/// The announcement of a robot of a fleet <-> its message.
#include <string>

#include "dds/dds.h"
#include "fleet_messages.h"
#include "procam/dds/fleet.hpp"
#include "refusal.hpp"

namespace procam::dds::internal {

/// Throws Refusal for an announcement that is invalid, too large, or of another fleet.
FleetAnnouncement read_announcement(const procam_fleet_Announcement& message, const std::string& fleet);
dds_return_t write_announcement(dds_entity_t writer, const std::string& fleet,
                                FleetAnnouncement announcement);

}  // namespace procam::dds::internal
