#pragma once
/// The camera's rays through a room, followed once a view.
#include "procam/simulate/room_view.hpp"
#include "sampling.hpp"

namespace procam::simulate::internal {

struct RoomSamples {
  SampledView view;
  RoomTruth truth;
  ImageF falloff;  ///< cos(field angle)^vignetting; empty: none
};

/// Levels are albedo * irradiance (full light), averaged over the rays of a pixel. `light_reach`: how far
/// light reaches beyond each projector's picture by its blur, projector pixels.
RoomSamples sample_room(const Room& room, const Camera& camera, const Motion& room_from_camera,
                        const std::vector<RoomLight>& lights, const std::vector<double>& light_reach,
                        const RoomViewOptions& options);

}  // namespace procam::simulate::internal
