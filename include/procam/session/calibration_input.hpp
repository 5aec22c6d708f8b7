#pragma once
/// What calibrate-projector and calibrate-camera work on, whether it comes from images or from a table of
/// observations.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::session {

struct CalibrationInput {
  Correspondences correspondences;
  std::vector<InputFile> inputs;               ///< every file that was read
  std::map<std::string, std::string> options;  ///< for the rig's provenance
  int views = 0;                               ///< given, also those without enough points
  std::string title;                           ///< of the report
};

/// A table of observations (io/session/observations_file.hpp); `devices` and `board` as far as flags give them. Views
/// without four points in any camera are rejected with a warning, as in a session of images.
CalibrationInput read_observations(const std::filesystem::path& file, const std::vector<Device>& devices,
                                   const std::optional<Board>& board);

/// "1280x1024", the size of the device `kind` ("camera"), or "left=1280x1024", of the one called left.
Device parse_device(const std::string& text, DeviceKind kind);

}  // namespace procam::session
