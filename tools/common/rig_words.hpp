#pragma once
/// What calibrate-projector says of a rig, in words and in the summary.
#include <string>
#include <vector>

#include "common/cli.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/core/rig.hpp"

namespace procam::tools {

/// Where a figure of one projector goes in the summary: "/wall/rms_mm", or "/wall/left/rms_mm" of several.
std::string of_projector(const Rig& rig, const std::string& group, const RigProjector& projector,
                         const std::string& figure);
/// "of left " where there are several projectors.
std::string said_of(const Rig& rig, const RigProjector& projector);

void say_lens(Console& console, const std::string& device, const Camera& lens,
              const NamedCovariance& covariance);
void say_gates(Console& console, const std::vector<Gate>& gates);
/// How far the light is predicted to be off on the wall, of every projector in the rig's order.
void say_predicted_light(Console& console, const Rig& rig, const std::vector<analyze::LightError>& predicted);
/// The true light of every projector against the estimated, and how many parameters lie inside three sigmas.
void say_truth(Console& console, const Rig& rig, const Rig& truth, double wall);

}  // namespace procam::tools
