#pragma once
/// Markers and boards of known size in the captures of a room: where each camera position sees them.
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/board/board.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/room/calibrate_room.hpp"
#include "procam/session/light.hpp"

namespace procam::tools {

class TargetSearch {
 public:
  TargetSearch(const std::optional<MarkerMap>& marker, const std::optional<Board>& board);

  /// Looks at the view under flat light, once for each camera and view.
  void look(const session::CapturedLight& seen);
  /// Those that were given. Throws Error(kNotEnoughData) for one that fewer than two positions show.
  std::vector<room::KnownTarget> found() const;

 private:
  std::optional<MarkerMap> marker_;
  std::optional<Board> board_;
  std::set<std::pair<std::string, std::string>> seen_;
  room::KnownTarget marker_target_, board_target_;
};

}  // namespace procam::tools
