#pragma once
/// Every public header of procam::pattern.
#include "procam/pattern/board_light.hpp"
#include "procam/pattern/decoded_pixels.hpp"
#include "procam/pattern/frame_sequence.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/phase_shift.hpp"
#include "procam/pattern/projected_board.hpp"
#include "procam/pattern/sequence_check.hpp"
#include "procam/pattern/shown_board.hpp"
#include "procam/pattern/stripe_edges.hpp"
#include "procam/pattern/stripe_map.hpp"
