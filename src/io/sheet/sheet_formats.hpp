#pragma once
/// A sheet as the bytes of a file, and as pixels.
#include "procam/io/sheet/board_sheet.hpp"

namespace procam::io {

/// PDF 1.4, one page, PrintScaling none; the same sheet gives the same bytes.
std::string sheet_pdf(const BoardSheet& sheet);

/// SVG 1.1, lengths in millimetres.
std::string sheet_svg(const BoardSheet& sheet);

/// Grey PNG, each pixel the share of white on it, with its pitch in the file (pHYs).
std::string sheet_png(const BoardSheet& sheet, double dots_per_inch);

/// The pixels of sheet_png().
ImageU8 sheet_pixels(const BoardSheet& sheet, double dots_per_inch);

}  // namespace procam::io
