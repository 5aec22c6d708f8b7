#pragma once
/// Sessions of one photograph a view that shows a printed and a projected chessboard together, as in the seed
/// paper's way of calibration:
///
///   session/
///     shown.json           what the projector showed in each view (io/session/shown_file.hpp)
///     projected_0.png ...  the frames that were sent to the projector, where shown.json names files
///     view_00.png ...      a photograph each
///     view_00_unlit.png    optional: the same view without the projected board
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/pattern/shown_board.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

/// What flags state of such a session.
struct ShownFlags {
  std::filesystem::path shown;  ///< shown.json, or the frame that was shown in all views
  bool upright = false;
};

struct PhotographedView {
  std::string name;
  std::filesystem::path photograph;
  std::filesystem::path unlit;  ///< empty where there is none
  std::size_t board = 0;        ///< index into ShownViews::boards
};

struct ShownViews {
  std::vector<pattern::ShownBoard> boards;
  std::vector<PhotographedView> views;
  std::vector<std::filesystem::path> files;  ///< shown.json and frames that were read
  ImageSize projector_size;
  bool upright = false;
};

}  // namespace procam::session
