#pragma once
/// A scan for people: as JSON, as lines, as a picture.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/scan/scan.hpp"
#include "procam/scan/scan_error.hpp"
#include "procam/scan/viewer_error.hpp"

namespace procam::report {

/// A scan, its mesh, and how far it is off where the truth is known.
struct ScannedSurface {
  std::string name;
  scan::Scan scan;
  Mesh mesh;
  std::optional<scan::ScanError> error = {};
  std::optional<scan::ViewerError> viewer = {};
};

/// "scans": pixels, median standard deviations, consistency, mesh, and the true error; metres.
PROCAM_EXPORT std::string to_json(const std::vector<ScannedSurface>& surfaces);

PROCAM_EXPORT std::vector<std::string> lines(const std::vector<ScannedSurface>& surfaces);

/// Left the surface shaded by its slopes, right the depths' standard deviation in colours with a legend. RGB.
PROCAM_EXPORT ImageU8 scan_picture(const scan::Scan& scan);

}  // namespace procam::report
