#pragma once
/// A view that was just captured: is it of use?
#include <string>

#include "procam/core/rig/light_map.hpp"
#include "procam/session/join.hpp"

namespace procam::session {

/// What one view's frames show.
struct Seen {
  ImageSize camera_size;
  Points2 in_camera, in_projector;  ///< board points and light points; without a board every decoded pixel
  std::string found;                ///< for people: "24 board points"; empty: the view is of no use
  Diagnostics why_not;
};

Seen see_board(const BoardView& view);
/// Light in less than 2 % of the camera's pixels counts as not found.
Seen see_light(const LightMap& light);

}  // namespace procam::session
