#pragma once
/// Report of a rig, as text and in the summary.
#include <string>
#include <vector>

#include "common/cli.hpp"
#include "procam/analyze/accept.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::tools {

/// Where a figure of one projector goes in the summary: "/wall/rms_mm", or "/wall/left/rms_mm" of several.
std::string of_projector(const Rig& rig, const std::string& group, const RigProjector& projector,
                         const std::string& figure);
/// "left: " where there are several projectors.
std::string said_of(const Rig& rig, const RigProjector& projector);

void say_lens(Console& console, const std::string& device, const Camera& lens,
              const NamedCovariance& covariance);
/// Logs all remarks but failed checks, which say_gates() lists; the summary gets every one.
void say_remarks(Console& console, const Diagnostics& diagnostics);
void say_gates(Console& console, const std::vector<Gate>& gates);
/// The headline: may the rig be used, and its predicted error of the kind that was selected; below it the
/// other kind. `next` points to the view that was advised, where there is one.
void say_result(Console& console, const Rig& rig, const RigQuality& quality,
                const std::vector<analyze::LightErrors>& predicted, const analyze::AcceptedError& accepted,
                bool next_view);
/// The true errors of every projector, and how many parameters lie inside three sigmas.
void say_truth(Console& console, const Rig& rig, const Rig& truth, double wall);

}  // namespace procam::tools
