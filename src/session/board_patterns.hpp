#pragma once
/// What the patterns of a session share, and the makers of those that project a board (board_patterns.cpp).
#include <memory>
#include <string>

#include "procam/pattern/projected_board.hpp"
#include "procam/pattern/sequence_check.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

/// Throws Error about a pattern as it was typed.
[[noreturn]] void refuse(const std::string& text, const std::string& why, const std::string& next);

/// The cause that the sequence shows, and that the view keeps its camera corners without the projector's.
void add_remarks(const pattern::SequenceCheck& sequence, Detections& in_camera);

Points2 pixels_of(const Detections& detections);

/// The board of a pattern's text ("markers", "charuco:9x7:80px:60px"). Throws Error(kInput) for a pattern that is no projected
/// board.
pattern::ProjectedBoard projected_board_of(const std::string& text, ImageSize projector_size);

std::unique_ptr<SessionPattern> make_chessboard(const std::string& parameters, ImageSize size, int);
std::unique_ptr<SessionPattern> make_charuco(const std::string& parameters, ImageSize size, int);
std::unique_ptr<SessionPattern> make_markers(const std::string& parameters, ImageSize size, int);
std::unique_ptr<SessionPattern> make_circles(const std::string& parameters, ImageSize size, int);

}  // namespace procam::session
