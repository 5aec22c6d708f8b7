#pragma once
/// pattern.json -> the frames of another program's pattern, in the order of capture:
///
///   {
///     "format": "procam-pattern",
///     "version": 1,
///     "step": 1,
///     "offset": [0, 128],
///     "frames": [
///       {"kind": "white"},
///       {"kind": "black"},
///       {"kind": "gray", "axis": "columns", "bit": 9},
///       {"kind": "gray", "axis": "columns", "bit": 9, "inverse": true},
///       {"kind": "phase", "axis": "rows", "period": 18.5, "phase_deg": 120},
///       {"kind": "ignore"}
///     ]
///   }
///
/// The fields are those of core/rig/frame_sequence.hpp. `step` (default 1), `offset` (0, 0) and `inverse` (false)
/// may be absent.
#include <filesystem>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/frame_sequence.hpp"

namespace procam::io {

/// Errors as for rig files.
PROCAM_EXPORT FrameSequence load_pattern(const std::filesystem::path& path);
PROCAM_EXPORT void save_pattern(const std::filesystem::path& path, const FrameSequence& sequence);

}  // namespace procam::io
