#pragma once
/// Stripe edges -> LightMap: the projector position of every camera pixel that lies between two edges, to a fraction of a
/// stripe, with its standard deviation. No surface is assumed; only neighbouring edges are joined.
///
/// Along the scanned camera line the edges i and i+1 at p_i, p_i+1 have the projector coordinates c_i, c_i+1, so a pixel
/// at p between them sees
///
///   c(p) = (1 - t) c_i + t c_i+1,   t = (p - p_i) / (p_i+1 - p_i),
///   sigma(p)^2 = slope^2 ((1 - t)^2 sigma_i^2 + t^2 sigma_i+1^2),   slope = (c_i+1 - c_i) / (p_i+1 - p_i).
///
/// The edges' standard deviations are those of the images' noise. What else moves edges (blur across stripes of unequal
/// width, tone curves, the projector's pixels) differs from edge to edge, and shows between neighbours: the middle one of
/// three edges lies off the line through the others by
///
///   d = c_i - (1 - t) c_i-1 - t c_i+1,   E[d^2] = slope^2 (s_i^2 + (1 - t)^2 s_i-1^2 + t^2 s_i+1^2) on a smooth surface.
///
/// The median of |d| over what noise explains, if it is more than one, multiplies the axis' standard deviations; around a
/// pixel the median of its neighbourhood, where that is more than twice as large: what a glossy surface mirrors moves edges
/// there alone.
///
/// An edge that alone is off the line of two neighbours on either side by more than four standard deviations is not used: the edges of
/// wide stripes are moved by the diffuse light of other surfaces (a white corner), which is alike for fine ones.
///
/// Between two edges the line is fitted to these and to the next one on either side, as long as all four lie on one line.
/// At the border of a surface it goes on over one stripe, as far as the decoded stripes agree: to one stripe, and where the
/// edges of finer stripes were not found, to the distance of the two edges. Pixels without edges whose
/// neighbours decoded to near stripes have the middle of their stripe, with the standard deviation of its width.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/stripe_edge.hpp"

namespace procam::pattern {

struct StripeMapOptions {
  /// Edges farther apart than this many stripes are not joined: they lie on two surfaces. On dark surfaces the edges of the
  /// fine stripes are lost in the noise; those of every eighth stripe remain.
  int max_stripes = 8;
  /// Nor edges farther apart than this many camera pixels.
  double max_gap_px = 16;
};

/// `edges` are those of stripe_edges() for the same captures; a line of the image at a time, each axis along its own
/// scan direction. Pixels that decoded to another stripe than their neighbouring edges stay undecoded. Throws
/// std::invalid_argument for edges outside of the map.
PROCAM_EXPORT LightMap light_map(const DecodedMap& decoded, const std::vector<StripeEdge>& edges,
                                 const StripeMapOptions& options = {});

}  // namespace procam::pattern
