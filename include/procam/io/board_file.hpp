#pragma once
/// A board on disk: what was printed, with the sizes that the sheet has.
#include <filesystem>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/board/board.hpp"

namespace procam::io {

/// board.json. Errors as for rig files; a board that nobody can print or find is refused.
PROCAM_EXPORT Board load_board(const std::filesystem::path& path);
PROCAM_EXPORT void save_board(const std::filesystem::path& path, const Board& board);

/// What `--board` takes: a text as parse_board() reads it, or the name of a board file (.json) or of Kalibr's
/// description of a target (.yaml: aprilgrid, checkerboard).
PROCAM_EXPORT Board read_board(const std::string& text_or_file);

}  // namespace procam::io
