#pragma once
/// The chain from a projector's pixel to a surface and its derivatives: what closed form and Monte Carlo
/// share.
#include <optional>

#include "procam/analyze/error_sources.hpp"

namespace procam::analyze {

/// One set of errors of the whole chain. Increments as in error_sources.hpp; `mount` is the left increment of
/// rig_from_projector, which stands in the rig's frame like the others.
struct ChainErrors {
  VecX lens;  ///< added to parameters_of(lens); empty: none
  Vec6 mount = Vec6::Zero();
  Vec6 rig = Vec6::Zero();
  Vec6 surface = Vec6::Zero();
  Vec2 pixel = Vec2::Zero();
};

/// How the landing place moves with each error, metres along the surface's axes.
struct ChainDerivatives {
  Vec2 pixel;  ///< that lights the point
  double incidence_deg = 0;
  Mat2 by_pixel;
  MatX by_lens;                        ///< 2 x number of lens parameters
  Eigen::Matrix<double, 2, 6> by_rig;  ///< the rig's increment; the mount's acts alike
  Eigen::Matrix<double, 2, 6> by_surface;
};

/// How the pixel of a point moves with the point (optical frame) and with the lens.
struct PixelDerivatives {
  Vec2 pixel;
  Mat23 by_point;
  MatX by_lens;  ///< 2 x number of lens parameters
};

/// nullopt where the lens cannot image the point.
std::optional<PixelDerivatives> pixel_derivatives(const Camera& lens, const Vec3& point);

/// nullopt where no light of the projector reaches the point.
std::optional<ChainDerivatives> chain_derivatives(const LightPath& path, const Vec2& on_surface);

/// Where the light of the pixel truly lands when the chain is wrong by `errors`, on the surface.
std::optional<Vec2> land(const LightPath& path, const Vec2& pixel, const ChainErrors& errors);

/// The lens with `errors` added to its parameters, in the order of parameter_names().
Camera wrong_lens(const Camera& lens, const VecX& errors);

/// Of lens parameters and mount increment, 0 where the rig's file names none. Throws Error(kInput) when it
/// knows nothing of the projector.
MatX calibration_covariance(const NamedCovariance& calibration, const RigProjector& projector);

/// All that the calibration has wrong, as one vector: the projector's lens parameters, its mount's increment,
/// and what moves the rig's pose through its camera.
struct CalibrationErrors {
  std::vector<std::string> names;  ///< of the parameters, as in the rig's file
  MatX covariance;                 ///< 0 where the rig's file names none
  Eigen::Index lens = 0;
  Eigen::Matrix<double, 6, Eigen::Dynamic> rig_by_camera;  ///< the rig's increment by the last of them

  /// Throws Error(kInput) when the calibration knows nothing of the projector, std::invalid_argument when
  /// through_camera's names and columns differ in number. Only what acts on the path takes part.
  CalibrationErrors(const LightPath& path, const ErrorSources& sources);
  ChainErrors chain_errors(const VecX& errors) const;
  /// Of the landing place: 2 x all of them.
  MatX landing_by(const ChainDerivatives& chain) const;
  bool has_mount() const { return covariance.cols() > lens; }
};

/// S with S S^T = C, from the eigenvectors: C may be singular. Throws std::invalid_argument when C is not
/// finite, symmetric and positive semidefinite; `name` says which.
MatX square_root(const MatX& covariance, const std::string& name);

/// Of the rig's increment, from motion alone: mean and covariance.
struct MotionError {
  Vec6 mean = Vec6::Zero();
  Mat6 covariance = Mat6::Zero();
};
MotionError motion_error(const RobotMotion& motion);

}  // namespace procam::analyze
