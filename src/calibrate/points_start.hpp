#pragma once
/// A device from points: where a solve may begin, and least squares from there.
#include <optional>
#include <string>
#include <vector>

#include "procam/calibrate/points.hpp"

namespace procam::calibrate {

struct PointsFit {
  Camera lens;
  Pose device_from_world;
  double within_px = 1e300;  ///< as many pairs as must agree (agreeing_pairs) lie within this
};

/// What the solve is about, once.
struct PointsProblem {
  const Device& device;
  const std::vector<PointPair>& pairs;
  const PointsOptions& options;
};

/// Pixels; nullopt behind the device.
std::optional<Vec2> residual_of(const PointsFit& fit, const PointPair& pair);

/// Least squares from a start, the residuals in units of `sigma_px`; nullopt when it leads nowhere.
std::optional<PointsFit> refine_points(const PointsProblem& problem, const PointsFit& start,
                                       const std::vector<char>& used, double sigma_px, bool lens_known);

/// All starts worth refining; `why` says what is missing where there are none.
std::vector<PointsFit> points_starts(const PointsProblem& problem, std::string& why);

}  // namespace procam::calibrate
