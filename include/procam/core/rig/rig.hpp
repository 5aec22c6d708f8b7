#pragma once
/// The rig: cameras and projectors fixed to one body, with what is known about their uncertainty. The waist
/// of procam: calibration ends in it, everything that draws begins with it.
#include <map>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/core/lens/projector.hpp"

namespace procam {

struct RigCamera {
  std::string name = "camera";
  Camera camera;
  Pose rig_from_camera;
};

struct RigProjector {
  std::string name = "projector";
  Projector projector;
  Pose rig_from_projector;
};

/// A file that a result was made from.
struct InputFile {
  std::string path;    ///< relative to the session where possible
  std::string sha256;  ///< lower-case hex
};

/// Where a result comes from, so that it can be made again.
struct Provenance {
  std::string tool;                            ///< "calibrate-projector"
  std::string version;                         ///< procam's
  std::string created;                         ///< ISO 8601, UTC
  std::map<std::string, std::string> options;  ///< as given, by option name
  std::vector<InputFile> inputs;
};

/// One quality gate, as it came out.
struct Gate {
  std::string name;
  bool passed = true;
  std::string detail;  ///< measured value against limit, and what to do when it failed
};

/// How the calibration went, in numbers that a reader of the file needs.
struct RigQuality {
  int views_used = 0;
  std::map<std::string, double> rms_px;      ///< by device name
  std::map<std::string, double> holdout_px;  ///< by device name; empty when not asked for
  /// By device name: the held-out error that the rig's covariance explains (1 sigma of its parameters, with
  /// the residuals of the fit). Absent where it cannot be computed.
  std::map<std::string, double> expected_holdout_px;
  std::vector<Gate> gates;

  bool passed() const {
    for (const Gate& gate : gates)
      if (!gate.passed) return false;
    return true;
  }
};

struct Rig {
  std::vector<RigCamera>
      cameras;  ///< the first one's frame is the rig's frame, unless the user chose another
  std::vector<RigProjector> projectors;
  /// Rows are named "<device>.fx" ... "<device>.k1" and "rig_from_<device>.rx" ... ".tz"; a parameter that is
  /// not named was held fixed.
  NamedCovariance covariance;
  RigQuality quality;
  Provenance provenance;

  /// The only camera / projector, or the one of that name. Throws Error(kInput) with the names there are.
  PROCAM_EXPORT const RigCamera& camera(const std::string& name = "") const;
  PROCAM_EXPORT const RigProjector& projector(const std::string& name = "") const;

  PROCAM_EXPORT Pose projector_from_camera(const std::string& projector_name = "",
                                           const std::string& camera_name = "") const;
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/rig/detail/rig_body.hpp"
#endif
