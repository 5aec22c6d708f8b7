#pragma once
/// How a lens changes to follow displacements of its picture, as far as its model can: least squares over pixels p_i with
/// displacements d_i,
///
///   min over a:  sum_i |J_i a - d_i|^2,   J_i the derivative of the pixel by the free parameters, at p_i's bearing
///
/// by a column-pivoting QR decomposition. What remains of d is what the model has no term for.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam {

/// Points of a picture, evenly over it, pixels.
PROCAM_EXPORT Points2 grid_over(const ImageSize& size, int across, int down);

/// a above, a column for each column of `displacements` (2 n rows: x and y of each pixel in turn, pixels). `free`: positions
/// in parameters_of(lens). Pixels where the lens has no inverse do not count; all zero where fewer than half are left.
/// Throws std::invalid_argument when the rows do not match the pixels.
PROCAM_EXPORT MatX lens_change(const Camera& lens, const std::vector<int>& free, const Points2& pixels,
                               const MatX& displacements);

/// The lens with a change of its free parameters.
PROCAM_EXPORT Camera with_lens_change(const Camera& lens, const std::vector<int>& free, const VecX& change);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/detail/lens_change_body.hpp"
#endif
