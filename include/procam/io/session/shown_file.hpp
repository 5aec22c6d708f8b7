#pragma once
/// shown.json -> what the projector showed in each of a session's photographs:
///
///   {
///     "format": "procam-shown",
///     "version": 1,
///     "upright": true,
///     "views": {
///       "view_00.png": "projected_0.png",
///       "view_01.png": "right half"
///     },
///     "boards": {
///       "right half": {"columns": 7, "rows": 5, "first_corner": [655.5, 93.5], "step": 44}
///     }
///   }
///
/// A view names a frame (an image file beside shown.json, as it was sent to the projector) or one of
/// `boards`: a chessboard's inner corners, the projector pixel of the first of them (up and left in the
/// frame; the centre of the top-left pixel is 0, 0) and the side of a square in pixels. `all_views` instead
/// of `views`: the same was shown in all of them.
#include <filesystem>
#include <map>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::io {

struct StatedBoard {
  int columns = 0, rows = 0;  ///< inner corners
  Vec2 first_corner = Vec2::Zero();
  double step = 0;
};

struct ShownInViews {
  bool upright = false;  ///< the projector's frame appears upright in the photographs, within 90 degrees
  std::map<std::string, std::string> views = {};  ///< file name, with or without extension -> frame or board
  std::string all_views = {};
  std::map<std::string, StatedBoard> boards = {};
};

/// Errors as for rig files.
PROCAM_EXPORT ShownInViews load_shown(const std::filesystem::path& path);
PROCAM_EXPORT void save_shown(const std::filesystem::path& path, const ShownInViews& shown);

}  // namespace procam::io
