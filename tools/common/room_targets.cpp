#include "common/room_targets.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/image/images.hpp"

namespace procam::tools {

TargetSearch::TargetSearch(const std::optional<MarkerMap>& marker, const std::optional<Board>& board)
    : marker_(marker), board_(board) {
  constexpr double kPrinted = 2e-3;  // printers and rulers
  marker_target_.size_sigma = board_target_.size_sigma = kPrinted;
  if (marker_) {
    const PlacedMarker& placed = marker_->markers.front();
    marker_target_.name = "--marker " + std::to_string(placed.id);
    for (const Vec2& corner : marker_corners())
      marker_target_.places.emplace_back(placed.size * corner.x(), placed.size * corner.y(), 0);
  }
  if (board_) {
    board_target_.name = "--board";
    board_target_.places = points_in_board(*board_);
  }
}

void TargetSearch::look(const session::CapturedLight& seen) {
  if ((!marker_ && !board_) || !seen_.insert({seen.camera, seen.view}).second) return;
  const ImageU8 image = io::green_channel(seen.flat_lit);
  if (marker_) {
    const MarkerDetections found =
        detect::detect_marker_edges(image, detect::marker_cells(marker_->dictionary));
    for (const SeenMarker& marker : found.markers) {
      if (marker.id != marker_->markers.front().id) continue;
      room::KnownTarget::View view{seen.camera, seen.view, {0, 1, 2, 3}, {}, 0};
      view.pixels.assign(marker.corners.begin(), marker.corners.end());
      view.sigma = std::sqrt(std::max(1e-4, marker.covariance.trace() / 8));
      marker_target_.views.push_back(view);
    }
  }
  if (board_) {
    room::KnownTarget::View view{seen.camera, seen.view, {}, {}, 0};
    double variance = 0;
    for (const Observation& point : detect::detect_board(image, *board_).observations) {
      view.points.push_back(point.point);
      view.pixels.push_back(point.pixel);
      variance += point.covariance.trace() / 2;
    }
    if (view.points.empty()) return;
    view.sigma = std::sqrt(std::max(1e-4, variance / double(view.points.size())));
    board_target_.views.push_back(view);
  }
}

std::vector<room::KnownTarget> TargetSearch::found() const {
  std::vector<room::KnownTarget> targets;
  if (marker_) targets.push_back(marker_target_);
  if (board_) targets.push_back(board_target_);
  for (const room::KnownTarget& target : targets)
    if (target.views.size() < 2)
      throw Error(ErrorKind::kNotEnoughData, target.name,
                  "it is found in " + std::to_string(target.views.size()) + " of the " +
                      std::to_string(seen_.size()) + " camera positions, and two are needed",
                  "let it stand still where two positions see all of it, lit by the projector's flat light");
  return targets;
}

}  // namespace procam::tools
