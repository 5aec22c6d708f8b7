#pragma once
/// Private to calibrate: the refusals and remarks of calibrate_mount, in words.
#include "mount_analysis.hpp"

namespace procam::calibrate::mount {

constexpr double kRejectChi2 = 33;  // 6 degrees of freedom: 1 of 100 000 good ones

/// No recording has so many changes: one with as many contradicts itself.
constexpr int kMaxEvents = 6;

/// MountDirection::name, in order.
std::vector<std::string> direction_names(MountCarrier carrier);

/// Throws for a direction that neither the motion nor a statement supplies.
void require_observable(const MountInformation& information, const Model& model);

/// Throws where most poses or sightings are rejected: what is left is no recording of the motion.
void require_agreement(const Model& model);

/// Throws where the clocks' difference is at the end of the range that is searched.
void require_time_offset(const Model& model);

/// Adds the remarks of calibrate_mount() to the diagnostics.
void remark(MountResult& result, const MountOptions& options, const MountInformation& information);

}  // namespace procam::calibrate::mount
