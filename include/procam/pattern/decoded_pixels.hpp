#pragma once
/// Projector pixels that another program has decoded -> LightMap.
///
/// In: for each camera pixel the projector pixel whose light it sees, two channels, x (column) and y (row);
/// the centre of the top-left projector pixel is (0, 0), so that the frame spans [-1/2, size - 1/2]. NaN,
/// negative values and a fill value beyond the frame mean undecoded.
///
/// The maps carry no error, so it is estimated from them. Where the surface is smooth, a coordinate is linear
/// over three neighbouring camera pixels, and
///   d = c(x-1) - 2 c(x) + c(x+1)   has variance 6 sigma^2.
/// The median of |d| in classes of brightness gives sigma by brightness: dark print is noisier than light
/// paper. Codes in whole stripes have at least the error of their rounding, width / sqrt(12).
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/light_map.hpp"

namespace procam::pattern {

/// `white`: the scene under the projector's full light, for the classes of brightness.
///
/// Throws Error(kInput) when no pixel is decoded, when all values are between 0 and 1 (shares of the frame),
/// or when most are beyond the frame. Remarks: "projector_size" (a part is beyond the frame), "map_mirrored"
/// (columns and rows are exchanged, or one of them runs backwards; a print cannot be seen so),
/// "zeros_undecoded" and "decoded_share". Throws std::invalid_argument unless `pixels` has two channels and
/// the size of `white`.
PROCAM_EXPORT LightMap light_map(const ImageF& pixels, const ViewU8& white, ImageSize projector_size);

}  // namespace procam::pattern
