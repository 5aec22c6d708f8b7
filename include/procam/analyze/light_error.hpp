#pragma once
/// The error of the projected light on a wall, because of the calibration.
///
/// The wall is perpendicular to the projector's optical axis at a given distance from its lens. The error
/// depends on how the user locates the wall, so there are two:
///
/// **Surface located externally** (a map and a localiser, a tape measure, a tracker): the wall is known in
/// the rig's frame. With r the ray of pixel p, and hat for the estimated rig,
///
///   X = rig_from_projector r(p) on the wall,   e(p) = |X^ - X|.
///
/// All errors of the projector's lens and of its pose in the rig count.
///
/// **Surface located by this camera** (markers or a board on it, seen by a camera of the same rig): for the
/// points X (surface frame, known geometry) on which the pixels of the grid fall,
///
///   c = pixel of X in the true camera
///   camera_from_surface^ = argmin over T of sum over X of |project(camera lens^, T X) - c|^2      (PnP)
///   p = project(projector lens^, projector_from_camera^ camera_from_surface^ X)
///   X' = where the true projector's ray through p meets the surface,   e(X) = |X' - X|.
///
/// The pose of the surface is that of known points because markers and boards are located so. Errors that
/// camera and projector share (of the boards' poses during calibration, above all) move the located surface
/// and the light alike, and cancel: this error is often much smaller. The camera that sees most of the grid
/// locates the surface; points outside its image neither locate nor count, and `share` states how many do.
///
/// Not included: detection noise of markers, the surface's own shape, the error of a map or localiser, motion
/// (landing_error.hpp has them).
///
/// Both are taken over the same grid of 17 x 13 pixels that spans the projector's picture. Predicted errors
/// are first order: with J the derivative of X by all parameters that take part, and C the rig's covariance,
///
///   rms^2 = mean over the grid of trace(J C J^T).
///
/// The error of a single calibration differs from this RMS by chance, and by much: nearly all of it is often
/// one direction of the parameters, and then its error is |z| rms with one normal number z. With M the mean of
/// J^T J, the squared error is a sum of squares of normal numbers with the cumulants k_i = tr (M C)^i (i - 1)!
/// 2^(i - 1). rms95^2 is its 95 % quantile, by the chi-squared distribution with the same first three cumulants
/// (P. Hall, "Chi squared approximations to the distribution of a sum of independent random variables", Annals
/// of Probability 11, 1983): 1.94 times rms for one direction, 1.37 times for nine equal ones.
///
/// The covariance allows for detection noise in the calibration's own images, so a wrong square size or a
/// wrong lens model is not predicted.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::analyze {

/// How the user of the rig knows where a surface is.
enum class SurfaceLocated {
  kExternally,  ///< in the rig's frame, by other means than the rig
  kByCamera     ///< by a camera of the rig, from points of known geometry on the surface
};

/// "externally", "by camera"
PROCAM_EXPORT const char* to_string(SurfaceLocated located);

struct LightError {
  double distance = 0;         ///< metres from the lens to the wall
  double mean_mm = 0;          ///< mean distance between true and estimated light; not set for a prediction
  double rms_mm = 0;           ///< root of the mean squared distance; NaN when no light reaches the wall
  double worst_mm = 0;         ///< largest on the grid (predicted: root of the largest trace)
  std::string projector = "";  ///< whose light
  SurfaceLocated located = SurfaceLocated::kExternally;
  std::string camera = "";  ///< that located the surface
  double share = 1;         ///< of the grid that counts: what the camera sees of it
  double rms95_mm = 0;      ///< predictions only: 95 of 100 such calibrations have a smaller RMS error
};

/// Both errors of one projector.
struct LightErrors {
  LightError externally;
  /// Missing when no camera of the rig sees a tenth of the grid on the wall.
  std::optional<LightError> by_camera;

  /// The error of that kind; externally where the camera cannot locate the wall.
  const LightError& of(SurfaceLocated located) const {
    return located == SurfaceLocated::kByCamera && by_camera ? *by_camera : externally;
  }
};

/// What the rig's covariance means on the wall. Parameters without a covariance (a camera whose lens was
/// given) are taken as exact. Throws Error(kInput) when the rig carries no covariance of that projector,
/// std::invalid_argument unless distance > 0.
PROCAM_EXPORT LightErrors predicted_light_errors(const Rig& rig, double distance,
                                                 const std::string& projector = "");

/// An error pixel by pixel of the projector's picture: what LightError summarises.
struct LightErrorMap {
  LightError error;            ///< rms_mm is the root mean square of the list below, worst_mm its maximum
  int columns = 0, rows = 0;   ///< of the grid, which reaches from the picture's first pixel to its last
  Points2 pixels;              ///< of the grid that count: on the wall and, by camera, seen by it
  std::vector<double> rms_mm;  ///< by pixel: the distance on the wall; predicted: its root mean square
};

/// The map of one kind of predicted error; nullopt when no camera can locate the wall. Throws as
/// predicted_light_errors().
PROCAM_EXPORT std::optional<LightErrorMap> predicted_error_map(
    const Rig& rig, double distance, const std::string& projector = "",
    SurfaceLocated located = SurfaceLocated::kExternally);

/// The errors of an estimated rig against the true one, without approximation. The first kind needs both
/// rigs in the same rig frame. Throws Error(kInput) when the two have different devices.
PROCAM_EXPORT LightErrors true_light_errors(const Rig& estimated, const Rig& truth, double distance,
                                            const std::string& projector = "");

/// The map of true_light_errors(), surface located externally: also of two rigs of which neither is true.
PROCAM_EXPORT LightErrorMap true_error_map(const Rig& estimated, const Rig& truth, double distance,
                                           const std::string& projector = "");

/// How many parameters of the rig's covariance differ from the true rig's by three sigmas or less.
struct WithinTruth {
  int inside_3_sigma = 0, parameters = 0;
};
PROCAM_EXPORT WithinTruth parameters_within_truth(const Rig& estimated, const Rig& truth);

/// Of a surface that is located externally.
PROCAM_EXPORT LightError predicted_light_error(const Rig& rig, double distance,
                                               const std::string& projector = "");
PROCAM_EXPORT LightError true_light_error(const Rig& estimated, const Rig& truth, double distance,
                                          const std::string& projector = "");

}  // namespace procam::analyze
