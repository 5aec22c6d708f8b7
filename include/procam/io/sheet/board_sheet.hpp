#pragma once
/// A board laid out on paper, and the paper as a file: PDF and SVG as vector shapes true to scale, PNG as
/// pixels of a stated pitch. All three draw the same list of shapes.
///
/// On the sheet, lengths are metres from the paper's top-left corner, x right, y down. Below the board lie a
/// ruler of exactly 100 mm, to measure after printing, and the board's text.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/board.hpp"
#include "procam/core/board/board_artwork.hpp"

namespace procam::io {

/// The ruler on every sheet.
inline constexpr double kRulerLength = 0.1;

struct Paper {
  std::string name;  ///< "a4"
  Vec2 size;         ///< metres, upright
};

/// "a4", "letter" ...: ISO A sizes a0 to a5, letter, legal, tabloid. Throws Error(kInput) naming those known.
PROCAM_EXPORT Paper parse_paper(const std::string& name);

struct BoardSheet {
  struct Text {
    Vec2 at = Vec2::Zero();  ///< left end of the base line
    double height = 0;       ///< of a line (font size), metres
    std::string text;        ///< ASCII
  };
  Vec2 size = Vec2::Zero();
  std::vector<ArtworkRectangle> rectangles;
  std::vector<ArtworkDisc> discs;
  std::vector<Text> texts;
  Vec2 board_origin = Vec2::Zero();  ///< where the board's first point lies
};

/// The board in the middle of the paper, upright or turned as it fits, with its light rim, ruler and text.
/// Throws Error(kInput) when it does not fit, naming both sizes and the smallest paper that would do.
PROCAM_EXPORT BoardSheet board_sheet(const Board& board, const BoardArtwork& artwork, const Paper& paper);

/// The board as the printer made it: every length times `ruler` / kRulerLength, in whole tenths of a micrometre. Throws
/// Error(kInput) for a ruler that is off by a tenth or more.
PROCAM_EXPORT Board board_as_measured(const Board& board, double ruler);

/// By the name's extension: .pdf, .svg or .png. Throws Error(kUnsupported) for another one.
PROCAM_EXPORT void save_sheet(const std::filesystem::path& path, const BoardSheet& sheet,
                              double dots_per_inch);

}  // namespace procam::io
