#pragma once
/// A rig refreshed by one or two new views, when something was bumped, zoomed or focused since its calibration.
///
///   UpdateOptions options;
///   options.changed = {{"projector", RigChange::kPose}};
///   const UpdateResult fresh = update_rig(rig, correspondences, options);
///   io::save_rig("rig.json", fresh.rig);
///
/// The estimate is the maximum of the posterior: with theta all parameters of the rig (lenses, and poses as
/// increments xi of device_from_rig), theta_0 and P the rig's values and covariance, Q the variance of the stated
/// changes, and r the residuals of the new views in sigmas,
///   theta = argmin (theta - theta_0)^T (P + Q)^-1 (theta - theta_0) + sum rho(|r(theta, board poses)|^2)
/// with rho Huber's. Its covariance is ((P + Q)^-1 + S)^-1, S the information of the views after their board poses are
/// eliminated (D. Simon, "Optimal State Estimation", 2006, section 3.3: recursive least squares). What did not
/// change keeps the knowledge of the first calibration, so that one view suffices; devices that no new view shows
/// follow through their correlation.
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::calibrate {

/// A possible change of one device. Its variance is added to the rig's covariance.
struct RigChange {
  enum class Kind {
    kPose,  ///< bumped or mounted again: 10 degrees, 0.2 m. Of the first camera: of all others against it
    kZoom,  ///< focal lengths by a common 30 %, principal point by 10 % of the picture, distortion by 2 % at the corner
    kFocus,  ///< focal lengths by a common 2 %, principal point by 1 %, distortion by 0.5 %
  };
  std::string device;
  Kind kind = Kind::kPose;
};

/// "pose", "zoom", "focus".
PROCAM_EXPORT const char* to_string(RigChange::Kind kind);

struct UpdateOptions {
  std::vector<RigChange>
      changed;  ///< empty: the views are checked against the rig, and refine it within its sigmas
  /// As Options::outlier_sigmas. A view is rejected where fewer than half of a device's points lie within, or where
  /// the residuals of those are twice as long as the rig's own.
  double outlier_sigmas = 5;
};

/// The difference of one device between the rig and the refreshed rig. Sigmas are those of the difference.
struct DeviceChange {
  std::string device;
  double rotation = 0, rotation_sigma = 0;        ///< radians, of the device about any axis
  double translation = 0, translation_sigma = 0;  ///< metres, of the device's centre in the rig
  double focal_ratio = 1, focal_ratio_sigma = 0;  ///< new fx over old fx
};

struct UpdatedView {
  std::string name;
  Pose rig_from_board;
  std::vector<double> rms_px;  ///< by device, over the used points; 0 where there are none
  bool used = true;
  std::string note;  ///< why it was rejected
};

struct UpdateResult {
  /// As given, with new lenses, poses and covariance. quality.rms_px is that of the new views where they have any,
  /// quality.views_used counts both.
  Rig rig;
  std::vector<Device> devices;        ///< of the rig: cameras, then projectors
  std::vector<DeviceChange> changes;  ///< of every device that was stated to have changed
  std::vector<UpdatedView> views;
  Diagnostics diagnostics;
};

/// Each device of the views is one of the rig's, by name and size. Throws Error(kInput) for devices that the rig lacks
/// and for a rig without covariance; kNotEnoughData when no view is usable or none shows a changed device; kDegenerate
/// when half of the views or more contradict the rig, naming the changes that would explain the views, if any do.
PROCAM_EXPORT UpdateResult update_rig(const Rig& before, const Correspondences& views,
                                      const UpdateOptions& options = {});

}  // namespace procam::calibrate
