#pragma once
/// A chessboard of light: the projector's own calibration board, shown beside a printed one on one flat
/// sheet.
///
/// Frames, in order:  flat (all light), board (dark squares; light everywhere else).
/// The flat frame shows the print alone and says what the paper reflects; the board frame divided by it shows
/// the light alone. The board is (columns + 1) x (rows + 1) squares of square_px projector pixels from pixel
/// (left, top) on, the first square dark, and light round it to the picture's rim.
///
/// With pixel centres at integers, inner corner (c, r) lies exactly at
///   (left + (c + 1) * square_px - 1/2,  top + (r + 1) * square_px - 1/2).
/// One count is odd and the other even, so that the corners of a projector that hangs upside down are not
/// taken for each other.
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "procam/core/board.hpp"
#include "procam/core/image.hpp"
#include "procam/core/types.hpp"

namespace procam::pattern {

struct ChessboardPattern {
  ImageSize projector_size;
  int columns = 0;  ///< inner corners a row
  int rows = 0;     ///< rows of inner corners
  int square_px = 0;
  int left = 0, top = 0;  ///< first pixel of the first dark square
};

/// In the middle of the picture. Throws Error(kInput) when it does not leave half a square of light on every
/// side, has fewer than 3x3 corners, or both counts are odd or both even.
ChessboardPattern chessboard_pattern(ImageSize projector_size, int columns, int rows, int square_px);
/// Squares of a sixteenth of the width, as many as the picture holds: 12x9 corners for 1024x768.
ChessboardPattern chessboard_pattern(ImageSize projector_size);

/// The projector pixels of the inner corners, row by row.
Points2 corner_pixels(const ChessboardPattern& chessboard);
/// The part of the picture that must land on the sheet: the squares and half a square of light round them.
Eigen::AlignedBox2d area_needed(const ChessboardPattern& chessboard);
/// Flat and board, one channel, 0 and 255.
std::vector<ImageU8> frames(const ChessboardPattern& chessboard);

/// "2 frames for 1024x768 (flat, 12x9 corners of 64 px squares)".
std::string describe(const ChessboardPattern& chessboard);

}  // namespace procam::pattern
