#pragma once
/// One short piece of a straight edge between dark and light, fitted to the pixels themselves.
#include <optional>

#include "procam/core/base/image.hpp"

namespace procam::detect {

/// Where to look: a box round `middle`, `half_length` along the edge and `reach` to both sides.
struct EdgeBox {
  Vec2 middle;
  Vec2 normal;  ///< unit, towards the light side
  double half_length = 0, reach = 0;
  double blur = 1;  ///< a first guess, pixels
  /// By which share a pixel the light changes: a ramp across the edge would pull it towards the lamp.
  Vec2 light_gradient = Vec2::Zero();
};

struct EdgeProfile {
  double offset = 0;  ///< of the edge from `middle` along the normal, pixels
  double blur = 0, contrast = 0;
  double light = 0;               ///< grey level of the light side
  double noise = 0;               ///< variance of a pixel, as the residuals have it
  double variance_per_noise = 0;  ///< of the offset, for noise 1
};

/// Gauss-Newton on I(p) = (a + b Phi((d - offset) / blur)) (1 + light_gradient . (p - middle)). nullopt when
/// the box leaves the image, holds too few pixels, or shows no such edge.
std::optional<EdgeProfile> fit_edge_profile(const ViewU8& image, const EdgeBox& box);

}  // namespace procam::detect
