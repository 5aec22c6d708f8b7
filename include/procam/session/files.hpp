#pragma once
/// Writing a session folder, view by view, so that nothing is lost when it is cut short:
///
///   session/
///     session.json                what is shown
///     coverage.png                where the board has been
///     view_00/frame_00.png ...    complete views; rejected/ in it holds frames that were not taken. With several
///                                 projectors and cameras: view_00/lamp/left/frame_00.png ... (io/session/captures.hpp)
///     .view_01.partial/           the view being captured: renamed when it is complete
///     .view_01.set_aside_0/       a view that was given up (the board had moved, or was not found)
///     .checks_0/                  the frames of the light checks
///
/// The reader leaves names that begin with a dot alone.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

/// "view_07", "frame_12.png": at least two digits.
PROCAM_EXPORT std::string numbered(const std::string& stem, std::size_t number,
                                   const std::string& extension = "");

/// Makes the folder unless it is there. Throws Error(kIo).
PROCAM_EXPORT void make_folder(const std::filesystem::path& folder);

/// session.json's contents.
PROCAM_EXPORT io::SessionInfo describe_session(const SessionPattern& pattern, ImageSize projector_size,
                                               const std::optional<Board>& board, int step);

/// Throws Error(kInput) when the folder holds a session of another pattern, size, set of projectors, step or board.
PROCAM_EXPORT void require_same_session(const std::filesystem::path& folder, const io::SessionInfo& session);

/// One view on its way to disk.
class PROCAM_EXPORT ViewWriter {
 public:
  /// Picks up what an earlier run has left of this view. `stacks` are the folders of the view that hold frames
  /// (io::Stack): "" for the view's own, "lamp/left" for the frames of the projector lamp that the camera left took.
  ViewWriter(const std::filesystem::path& session, std::size_t view, std::vector<std::string> stacks = {""});

  /// Frames 0 .. kept() - 1 of the stack are on disk.
  int kept(std::size_t stack = 0) const { return kept_[stack]; }
  std::filesystem::path frame_file(int frame, std::size_t stack = 0) const;
  /// Throws Error(kIo), and has then written nothing.
  void keep(ViewU8 frame, std::size_t stack = 0);
  void keep_rejected(ViewU8 frame, const std::string& why, std::size_t stack = 0);
  /// The view is complete.
  void finish();
  /// The view is not to be used; begins it anew.
  void set_aside();

 private:
  void begin();

  std::filesystem::path session_, place_, work_;
  std::vector<std::string> stacks_;
  std::vector<int> kept_;
};

/// session/view_NN of an earlier run, complete?
PROCAM_EXPORT bool is_complete(const std::filesystem::path& session, std::size_t view);

/// session/.checks_N: a new folder for the frames of the checks.
PROCAM_EXPORT std::filesystem::path make_checks_folder(const std::filesystem::path& session);

}  // namespace procam::session
