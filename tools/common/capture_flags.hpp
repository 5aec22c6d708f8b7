#pragma once
/// The flags of capture-session.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/board/board.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/session/recorder.hpp"

namespace procam::tools {

struct CaptureFlags {
  std::vector<std::string> cameras, displays;  ///< as typed: PLACE, or of several NAME=PLACE
  std::filesystem::path watch;
  device::CameraOptions camera_options;
  std::filesystem::path dds_security;
  bool list_displays = false;
  std::string pattern = "gray";
  std::optional<Board> board;
  std::optional<int> views;
  session::RecorderOptions recorder;
};

void declare_capture(CLI::App& app, CaptureFlags& flags);

/// Name and place of each. Of several each is NAME=PLACE. The only one needs no name, "0" or "http://host/?a=b"; a name that it has
/// is dropped. Throws Error(kInput).
std::vector<std::pair<std::string, std::string>> named_places(const std::string& flag,
                                                              const std::vector<std::string>& typed);

/// Views that are captured without --views: poses of a board, places of the only camera, or one where several cameras stand.
int default_views(const CaptureFlags& flags);

}  // namespace procam::tools
