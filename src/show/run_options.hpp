#pragma once
/// The meaning of a show's options: what may be combined, how it is drawn, and which files its contents are.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/run.hpp"
#include "procam/track/pose_correction.hpp"

namespace procam::show {

/// Of a file, and of a display that does not report its own; frames a second.
inline constexpr double kUsualRate = 60;

/// What a run that is recorded, or has no depth camera, cannot have.
void check_combination(const ShowOptions& options);

/// "cart,sign": its parts.
std::vector<std::string> split_names(const std::string& names);

/// Without poses the rig stands still; surfaces of a depth camera are then in its own frame.
bool rig_is_world(const ShowOptions& options);

/// How the frames are drawn, and from which poses.
ProjectionOptions projection_options(const ShowOptions& options, const Rig& rig);
/// Of a show whose camera corrects the localiser's poses.
track::PoseCorrectionOptions pose_correction(const ShowOptions& options, const ProjectionOptions& projection);

/// What frames depend on besides what a log holds.
std::string conditions_text(const ShowOptions& options, const ProjectionOptions& projection, const Rig& rig);

/// Of the first of several screens, as those of a show with this one alone.
ShowOptions of_first_screen(ShowOptions options);

/// Of a further screen's projector: it moves with the first one, which stands where `first` has it.
ProjectionOptions of_side_screen(const ProjectionOptions& first, const ShowOptions& options, const Rig& rig,
                                 const std::string& projector);

/// The folder that contents are relative to.
std::filesystem::path content_folder(const std::string& surfaces);

/// Contents of the options are relative to the working directory, those of a surface file to its folder.
std::map<std::string, std::string> absolute_contents(const ShowOptions& options);

/// What may be chosen as content at the control page.
std::vector<std::string> content_choices(const std::filesystem::path& folder, const SurfaceSet& set);

}  // namespace procam::show
