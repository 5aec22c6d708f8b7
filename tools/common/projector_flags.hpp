#pragma once
/// The options of calibrate-projector.
#include <filesystem>
#include <optional>
#include <string>

#include "common/calibration_flags.hpp"
#include "common/known_before.hpp"
#include "procam/analyze/accept.hpp"
#include "procam/calibrate/update.hpp"
#include "procam/core/board/board.hpp"
#include "procam/io/session/pattern_file.hpp"
#include "procam/session/reader.hpp"

namespace procam::tools {

/// What calibrate-projector works on and how.
struct ProjectorFlags : CalibrationFlags {
  std::filesystem::path captures, points, truth, check, compare;
  io::SessionInfo stated;     ///< what session.json need not say
  session::ShownFlags shown;  ///< of a session of photographs
  double wall = 2;            ///< metres
  analyze::AcceptedError accepted;
  double metres_per_unit = 0;  ///< of an OpenCV file to check
  std::filesystem::path mirror_view;
  std::optional<Board> mirror_board;
  double mirror_depth = 0;  ///< metres
  std::string camera_model = "auto", projector_model = "auto";
  DataSheet sheet;  ///< of the projector
  std::filesystem::path known_camera, update;
  std::vector<calibrate::RigChange> changed;  ///< with `update`; an empty name is the only projector
};

/// --observations, with the sizes that flags give. Throws Error(kInput) where no projector is among them.
session::SessionContents read_observations(const ProjectorFlags& flags);

/// The rig of a file; nullopt without a file.
std::optional<Rig> load_if_given(const std::filesystem::path& rig_file);

void declare_projector(CLI::App& app, ProjectorFlags& flags);

}  // namespace procam::tools
