#pragma once
/// rig.json <-> Rig. The fields are listed in docs/file-formats.md and docs/schema/rig.schema.json.
///
/// Numbers are written with the fewest digits that read back as the same double, fields in a fixed order,
/// matrices a row a line: files of two calibrations can be compared by eye.
#include <filesystem>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::io {

/// Throws Error(kInput) naming file, line and field ("rig.json:17: cameras[0].intrinsics.fx") for anything
/// that is missing, unknown, not finite or not a rig: quaternions off unit length by more than 1e-6 (closer
/// ones are normalised), sizes and focal lengths not positive, two devices of one name, a covariance that is
/// not symmetric and positive semi-definite or names a parameter the rig does not have. Throws
/// Error(kUnsupported) for a file of a later version, Error(kIo) when it cannot be read.
PROCAM_EXPORT Rig load_rig(const std::filesystem::path& path);

/// Written at once or not at all. Throws std::invalid_argument for a rig that load_rig would refuse (NaN
/// ...), Error(kIo) when the file cannot be written.
PROCAM_EXPORT void save_rig(const std::filesystem::path& path, const Rig& rig);

}  // namespace procam::io
