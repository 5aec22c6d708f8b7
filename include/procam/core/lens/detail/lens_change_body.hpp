#pragma once
/// The bodies of lens_change.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <Eigen/QR>
#include <optional>

#include "procam/core/lens/lens_change.hpp"

namespace procam {

PROCAM_CORE_INLINE Points2 grid_over(const ImageSize& size, int across, int down) {
  Points2 points;
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i)
      points.emplace_back((i + 0.5) / across * size.width - 0.5, (j + 0.5) / down * size.height - 0.5);
  return points;
}

PROCAM_CORE_INLINE MatX lens_change(const Camera& lens, const std::vector<int>& free, const Points2& pixels,
                                    const MatX& displacements) {
  require(displacements.rows() == Eigen::Index(2 * pixels.size()),
          "lens_change: a displacement of two rows for each pixel");
  const VecX parameters = parameters_of(lens);
  const auto count = Eigen::Index(free.size());
  MatX by_lens(displacements.rows(), count), wanted(displacements.rows(), displacements.cols());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::optional<Vec3> bearing = lens.unproject(pixels[i]);
    bool seen = bearing.has_value();
    for (Eigen::Index k = 0; k < count && seen; ++k) {
      const int at = free[std::size_t(k)];
      const double step = at < Intrinsics::kNumParameters ? 0.1 : 1e-5;  // pixels; a coefficient
      VecX more = parameters, less = parameters;
      more[at] += step, less[at] -= step;
      const std::optional<Vec2> plus = with_parameters(lens, more).project(*bearing),
                                minus = with_parameters(lens, less).project(*bearing);
      seen = plus && minus;
      if (seen) by_lens.block<2, 1>(row, k) = (*plus - *minus) / (2 * step);
    }
    if (!seen) continue;
    wanted.middleRows<2>(row) = displacements.middleRows<2>(Eigen::Index(2 * i));
    row += 2;
  }
  if (count == 0 || row < Eigen::Index(pixels.size())) return MatX::Zero(count, displacements.cols());
  const VecX scale = by_lens.topRows(row).colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  const MatX scaled = by_lens.topRows(row) * scale.asDiagonal();
  return scale.asDiagonal() * MatX(scaled.colPivHouseholderQr().solve(wanted.topRows(row)));
}

PROCAM_CORE_INLINE Camera with_lens_change(const Camera& lens, const std::vector<int>& free,
                                           const VecX& change) {
  VecX parameters = parameters_of(lens);
  for (std::size_t k = 0; k < free.size(); ++k) parameters[free[k]] += change[Eigen::Index(k)];
  return with_parameters(lens, parameters);
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
