#pragma once
/// The result of calibrate-mount for people: as JSON, as lines, as a picture.
#include <string>
#include <vector>

#include "procam/calibrate/mount.hpp"
#include "procam/core/base/export.hpp"

namespace procam::report {

PROCAM_EXPORT std::string to_json(const calibrate::MountResult& result);
PROCAM_EXPORT std::vector<std::string> lines(const calibrate::MountResult& result);

/// Left the drive from above: the localiser's poses, the path, the markers and the moments of events. Right the position
/// of the rig on the base with its 95 % ellipse, magnified, and the direction in which its first camera looks. A
/// complete SVG file.
PROCAM_EXPORT std::string mount_picture(const calibrate::MountResult& result, const MountData& data);

}  // namespace procam::report
