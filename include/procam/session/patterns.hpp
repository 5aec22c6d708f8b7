#pragma once
/// The patterns that a session may be captured with: what the projector shows, and how one view's captures
/// become what camera and projector saw of the board. See docs/patterns.md for when to choose which.
///
/// To add one: a class that implements SessionPattern and one row in the table, both in session_patterns.cpp.
/// Every tool that shows, simulates or reads a session then knows it, and tests/tools tries what it shows.
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/session/join.hpp"

namespace procam::session {

/// Device numbers of all sessions: Correspondences::devices.
constexpr int kCameraDevice = 0, kProjectorDevice = 1;

/// A projected board by itself, on whatever it falls.
struct ProjectedBoardPoints {
  std::vector<LightPoint> points;
  ImageU8 flat_lit;         ///< the same view under flat light
  Diagnostics diagnostics;  ///< why there are no points
};

/// Which projector pixel lights each camera pixel, whatever the light falls on.
struct PatternLight {
  LightMap light;
  ImageU8 flat_lit;  ///< the same view under flat light
};

class PROCAM_EXPORT SessionPattern {
 public:
  virtual ~SessionPattern() = default;

  /// As --pattern and session.json state it; make_pattern() reads it back.
  virtual std::string text() const = 0;
  /// For people: "42 frames for 1024x768 (columns 10 bits, rows 10 bits, white, black)".
  virtual std::string describe() const = 0;
  /// What the projector shows, the projector's size, in the order of capture.
  virtual std::vector<ImageU8> frames() const = 0;
  virtual int frame_count() const = 0;
  /// Files beside session.json that text() names; most patterns have none.
  virtual void save_files(const std::filesystem::path& session_folder) const {
    static_cast<void>(session_folder);
  }
  /// Of the frames and of their captures: 1, grey, or 3, colour.
  virtual int channels() const { return 1; }
  /// The part of the picture that must land on blank paper beside the print; none where the print may be lit.
  virtual std::optional<Eigen::AlignedBox2d> on_blank_paper() const { return std::nullopt; }
  /// Does the light in a mirror look like the light itself? Then a session with a plain printed board cannot show that the
  /// camera's images are mirrored.
  virtual bool looks_same_mirrored() const { return false; }
  /// One board pose from its captures, frame by frame. A board that is not found is a remark in the
  /// detections; throws Error(kInput) for captures that are not of this pattern.
  virtual session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                                  const Board& board) const = 0;
  /// Every camera pixel's light, for a scan of any shape; nullopt of patterns that light points alone. Throws
  /// Error(kInput) for captures that are not of this pattern.
  virtual std::optional<PatternLight> read_light_map(const std::vector<ViewU8>& captures) const {
    static_cast<void>(captures);
    return std::nullopt;
  }
  /// The points of a projected board, with no printed board round it; nullopt of patterns that have none.
  /// Throws Error(kInput) for pictures that show no light, or whose order is not that of frames().
  virtual std::optional<ProjectedBoardPoints> read_light(const std::vector<ViewU8>& captures) const {
    static_cast<void>(captures);
    return std::nullopt;
  }
};

/// "gray", a name with parameters after a colon, or a pattern file (.json, io/session/pattern_file.hpp). Throws
/// Error(kInput) with the names there are.
PROCAM_EXPORT std::unique_ptr<SessionPattern> make_pattern(const std::string& text, ImageSize projector_size,
                                                           int step = 1);

/// The table as help for --pattern: "gray (...) | phase (...)".
PROCAM_EXPORT std::string pattern_help();

}  // namespace procam::session
