#pragma once
/// The line of a blend in the log of a run (run_log.hpp): all that its map depends on besides the rig and the options, with
/// 17 digits.
///
///   {"blend":["left","right"],"rig_from_projector":[qw,qx,qy,qz,x,y,z],"surfaces":{...}}
#include <filesystem>
#include <optional>
#include <string>

#include "show_blend.hpp"

namespace procam::show {

inline constexpr const char* kBlendLine = "{\"blend\":";

std::string blend_line(const BlendScene& scene);
/// nullopt: it is no such line. Mesh files that the surfaces name are beside the file `surfaces`. Throws Error as
/// io::surfaces_from_text() does.
std::optional<BlendScene> read_blend_line(const std::string& line, const std::filesystem::path& surfaces);

}  // namespace procam::show
