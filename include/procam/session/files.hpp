#pragma once
/// Writing a session folder, view by view, so that nothing is lost when it is cut short:
///
///   session/
///     session.json                what is shown
///     coverage.png                where the board has been
///     view_00/frame_00.png ...    complete views; rejected/ in it holds frames that were not taken
///     .view_01.partial/           the view being captured: renamed when it is complete
///     .view_01.set_aside_0/       a view that was given up (the board had moved, or was not found)
///     .checks_0/                  the frames of the light checks
///
/// The reader leaves names that begin with a dot alone.
#include <filesystem>
#include <optional>
#include <string>

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

/// Throws Error(kInput) when the folder holds a session of another pattern, size, step or board.
PROCAM_EXPORT void require_same_session(const std::filesystem::path& folder, const io::SessionInfo& session);

/// One view on its way to disk.
class PROCAM_EXPORT ViewWriter {
 public:
  /// Picks up what an earlier run has left of this view.
  ViewWriter(const std::filesystem::path& session, std::size_t view);

  /// Frames 0 .. kept() - 1 are on disk.
  int kept() const { return kept_; }
  std::filesystem::path frame_file(int frame) const;
  /// Throws Error(kIo), and has then written nothing.
  void keep(ViewU8 frame);
  void keep_rejected(ViewU8 frame, const std::string& why);
  /// The view is complete.
  void finish();
  /// The view is not to be used; begins it anew.
  void set_aside();

 private:
  void begin();

  std::filesystem::path session_, place_, work_;
  int kept_ = 0;
};

/// session/view_NN of an earlier run, complete?
PROCAM_EXPORT bool is_complete(const std::filesystem::path& session, std::size_t view);

/// session/.checks_N: a new folder for the frames of the checks.
PROCAM_EXPORT std::filesystem::path make_checks_folder(const std::filesystem::path& session);

}  // namespace procam::session
