#pragma once
/// The covariance that the bundle adjustment assigns to a measured point.
#include "procam/calibrate/bundle.hpp"

namespace procam::calibrate {

/// What the detector believes of the measurement, as covariance of that residual: a light point's is the
/// camera's, carried over the sheet into the projector; light read at a corner has what is left of its
/// covariance C_p without the corner's share, C_p - J C_c J^T. nullopt where the residual has no value.
std::optional<Mat2> believed_covariance(const BundleState& state, const Measurement& measurement);

}  // namespace procam::calibrate
