#pragma once
/// A folder of captures of one projected board (chessboard, charuco, markers, circles) on a surface.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

struct ProjectedBoardCapture {
  ProjectedBoardPoints light;  ///< the points found, the flat-lit image, warnings
  std::string pattern;         ///< as used
  std::vector<InputFile> inputs;
};

/// Reads the captures of `pattern`; empty: what session.json states, in the folder or the one above. Throws
/// Error(kInput) for a pattern that is no projected board, for images of another size than the camera's, and
/// where the pattern is not found.
PROCAM_EXPORT ProjectedBoardCapture read_projected_board(const std::filesystem::path& captures,
                                                         const std::string& pattern, ImageSize projector_size,
                                                         ImageSize camera_size);

}  // namespace procam::session
