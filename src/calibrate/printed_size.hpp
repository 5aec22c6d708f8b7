#pragma once
/// What images do not show: the scale of the printed board. Boards of twice the size at twice the distance
/// give the same images, so that a wrong size fits as well as the right one, and every distance is off by its
/// factor.
#include <string>

#include "procam/core/board/board.hpp"

namespace procam::calibrate {

/// The measurement that shows it, along the longer side of the board, and what an error of it does.
std::string printed_size_to_measure(const Board& board);

}  // namespace procam::calibrate
