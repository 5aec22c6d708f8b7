#pragma once
/// Stripe edges to sub-pixel: where in the camera image the light changes from one projector stripe to the
/// next.
///
/// The boundary between the stripes k-1 and k lies at projector coordinate k*step - 1/2 and changes exactly
/// one bit b (the lowest set bit of k) of the Gray code. Along a camera row or column,
///   D(x) = (pattern_b - inverse_b) / (pattern_b + inverse_b - 2 black)
/// runs from -1 to 1 or back, free of the surface's albedo, and the edge is where it crosses zero. A sharp
/// edge seen through blur makes D(x) = 2 Phi((x - edge) / blur) - 1, so u = Phi^-1((1 + D)/2) is a straight
/// line at any blur; the edge is the zero of a line fitted to u over the edge's own width (two samples
/// of a sharp edge, up to nine of a defocused one), weighted by their noise.
///
/// Bit b of two neighbouring pixels identifies a boundary among all others of that bit as soon as the coarser
/// bits are decided on both sides. The finer ones need not be: a camera that does not resolve the finest
/// stripes still yields the edges of the coarser ones.
///
/// One decoded pixel gives one integer code, right to half a stripe; a stripe edge is right to some
/// hundredths of one.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/stripe_edge.hpp"
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

struct StripeEdgeOptions {
  DecodeOptions decode;  ///< what counts as lit, and which bits as decided: as given to decode()
  /// Codes of the two sides of an edge may differ by this many stripes. More than one only where the camera
  /// samples more coarsely than the projector; larger jumps are taken for the border of a surface.
  int max_code_jump = 4;
  /// The slope of u across the edge must stand out of its noise by this many standard deviations: stripes
  /// that blur has made unreadable yield no edges.
  double min_step_sigmas = 5.0;
  /// Edges expected to be less certain than this are rejected (camera pixels).
  double max_sigma_px = 0.5;
  /// The camera's own blur (standard deviation, camera pixels). Where the albedo changes by a share g per
  /// pixel, blur shifts the zero by blur^2 g towards the darker side. That is put back, and counts
  /// as uncertainty too.
  double camera_blur_px = 0.8;
  /// Only edges whose first pixel is not zero here; all of them if empty. Of the captures' size.
  ViewU8 area;
};

/// All edges of both axes, row-major in the camera for the columns, then for the rows. Each axis is scanned
/// along the camera direction in which its codes vary faster; mirrored and turned projectors are read like
/// any other. `captures` are those that `decoded` came from: throws procam::Error as decode() does, and
/// std::invalid_argument if sizes or steps of the three do not belong together.
PROCAM_EXPORT std::vector<StripeEdge> stripe_edges(const std::vector<ViewU8>& captures,
                                                   const DecodedMap& decoded, const GrayCode& gray_code,
                                                   const StripeEdgeOptions& options = {});

}  // namespace procam::pattern
