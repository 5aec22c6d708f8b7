#pragma once
/// A predicted error on the wall as a function of the covariance: derivatives once, for many covariances.
#include <optional>
#include <vector>

#include "procam/analyze/light_error.hpp"

namespace procam::analyze {

struct LightErrorModel {
  LightError kind;                  ///< distance, projector, camera and share; no figures
  std::vector<std::string> names;   ///< parameters of the rig that take part
  Points2 pixels;                   ///< of the grid that count
  std::vector<MatX> by_parameters;  ///< of the light's position, 2 x names, at each point of the grid
  MatX mean_square;                 ///< mean of J^T J over the grid: rms^2 = trace(mean_square C)

  double rms_mm(const NamedCovariance& covariance) const;
  LightError under(const NamedCovariance& covariance) const;
};

/// Throws as predicted_light_errors(); nullopt where the wall cannot be located so.
std::optional<LightErrorModel> light_error_model(const Rig& rig, double distance,
                                                 const std::string& projector, SurfaceLocated located);

}  // namespace procam::analyze
