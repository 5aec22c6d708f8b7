#pragma once
/// The projector as RViz draws it: its frustum, the surfaces, and where their light may be.
#include <string>
#include <vector>

#include "procam/dds/projector_publisher.hpp"
#include "procam/show/projection.hpp"

namespace procam::show {

/// Lines along the rays of the image's border, and the border at `length` metres along the optical axis; of a lens that bends
/// them, eight pieces a side.
dds::GraphMarker frustum_marker(const Camera& inverse_camera, const std::string& frame, double length);

/// A surface in its own frame: the content's area of a plane, the border of a mesh; no points for a pixel surface.
dds::GraphMarker outline_marker(const SolvedSurface& surface, const std::string& frame);

/// For a plane in the world: the ellipse on it that holds the light of the content's middle with 95 %, true to scale, and its
/// semi-axes in millimetres as a text. None where the covariance is unknown (zero), or the middle is edge-on or behind the projector.
std::vector<dds::GraphMarker> error_markers(const SolvedSurface& surface, const std::string& frame,
                                            const Pose& world_from_projector, const Mat6& covariance);

}  // namespace procam::show
