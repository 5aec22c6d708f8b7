#pragma once
/// A projected board: a chessboard, ChArUco board, marker grid or circle grid that the projector shows beside
/// a printed board on one flat sheet.
///
/// Frames, in order:  flat (all light), board (its dark shapes; light everywhere else).
/// The flat frame shows the print alone: the reflectance of the paper; the board frame divided by it shows
/// the light alone. In colour one frame is both: its red is the flat frame, its blue the board, its green
/// dark.
///
/// The layout is a board like any other, with projector pixels for metres. Straight edges lie between pixels,
/// so that a pixel is dark or light; where the rim of a disc runs through a pixel, it is as light as its
/// share. A board whose two ends look alike in an image is refused, as a projector may hang upside down; of a
/// chessboard the statement that the frame appears upright in the images settles it.
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/board_artwork.hpp"

namespace procam::pattern {

struct ProjectedBoard {
  ImageSize projector_size;
  Board layout;          ///< every length in projector pixels
  BoardArtwork artwork;  ///< what is dark of it
  Vec2 origin;           ///< the projector pixel of the layout's origin
  bool colour = false;
  bool upright = false;  ///< the frame appears upright in the images, within 90 degrees (equal counts: 45)
};

/// In the middle of the picture. `artwork` is detect::board_artwork(layout). Throws Error(kInput) when half a
/// pitch of light (a gap and a module at least round markers) does not fit round it, when it looks the same
/// turned and is no upright chessboard, or when its edges do not fall between pixels.
PROCAM_EXPORT ProjectedBoard projected_board(ImageSize projector_size, const Board& layout,
                                             const BoardArtwork& artwork, bool colour = false,
                                             bool upright = false);

/// The projector pixels of the layout's points, by point index.
PROCAM_EXPORT Points2 point_pixels(const ProjectedBoard& board);
/// The part of the picture that must land on the sheet, so that all of it can be read: the dark shapes and
/// half a pitch of light round them.
PROCAM_EXPORT Eigen::AlignedBox2d area_needed(const ProjectedBoard& board);
/// Flat and board, one channel; or one frame of three.
PROCAM_EXPORT std::vector<ImageU8> frames(const ProjectedBoard& board);
PROCAM_EXPORT int frame_count(const ProjectedBoard& board);

/// Boards that fill the picture, of a sixteenth of its longer side a pitch (circles: two, staggered): for
/// 1024x768 12x9 corners; 15x11 squares; 10x7 markers; 7x11 discs.
PROCAM_EXPORT Chessboard chessboard_filling(ImageSize projector_size);
PROCAM_EXPORT CharucoBoard charuco_filling(ImageSize projector_size);
PROCAM_EXPORT MarkerGrid markers_filling(ImageSize projector_size);
PROCAM_EXPORT CircleGrid circles_filling(ImageSize projector_size);

}  // namespace procam::pattern
