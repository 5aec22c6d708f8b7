#pragma once
/// A session folder -> which projector pixel lights each camera pixel, whatever the light falls on: the way from captures
/// to a scan. No board is needed.
///
///   OpenOptions options;
///   options.needs_board = false;
///   for (const session::CapturedLight& seen : session::read_light(session::open("captures", options)))
///     const scan::Scan room = scan::measure_depth(seen.light, rig, seen.camera, seen.projector);
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/io/image/exif.hpp"
#include "procam/session/reader.hpp"

namespace procam::session {

/// One camera's captures of one projector's pattern.
struct CapturedLight {
  std::string view, camera, projector;
  LightMap light;
  ImageU8 flat_lit;                   ///< the same view under flat light
  std::optional<io::ExifFocal> exif;  ///< of the first capture
  std::vector<InputFile> inputs;
};

/// Of the view of that name, or of the only one. Throws Error(kInput) for several views without a name, a name that the
/// session does not have, a pattern that lights points alone, and captures that cannot be read.
PROCAM_EXPORT std::vector<CapturedLight> read_light(const SessionPlan& plan, const std::string& view = "");

}  // namespace procam::session
