#pragma once
/// Every public header of procam::detect.
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/chessboard.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/detect/projected_board.hpp"
#include "procam/detect/shown_board.hpp"
