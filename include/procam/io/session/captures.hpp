#pragma once
/// A session on disk: one folder a board pose, each with the numbered frames of one pattern stack.
///
///   session/
///     session.json            optional: what was shown, to spare the flags
///     pose_1/graycode_00.png  ... graycode_41.png
///     pose_2/...
///
/// With several projectors, which show their patterns one after the other, a view has a folder for each; with
/// several cameras, a folder for each camera's frames in that:
///
///     pose_1/lamp/left/frame_00.png ...     the projector lamp, as the camera left saw it
///     pose_1/lamp/right/...
///     pose_1/beamer/left/...
///
/// One projector or one camera needs no folder. Folders that are missing tell that a camera had nothing to
/// see.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/board.hpp"

namespace procam::io {

/// The frames of one view, in the order of their numbers.
struct CaptureFolder {
  std::vector<ImageU8> frames;               ///< grey or R G B, all of one size
  std::vector<std::filesystem::path> files;  ///< a frame each
  Diagnostics diagnostics;  ///< one note when the files have 16 bits, or colour that is not asked for
};

/// Reads the numbered images (png, jpg, bmp, tif) of a folder; the number is the last run of digits in the
/// name. Other files are left alone. With `size`, images of another size are rejected and named in a warning
/// ("image_size_differs"); where fewer than `expected_frames` remain then, there are no frames. Throws
/// Error(kInput) for: no image, an image without a number, two series or two files of one number, a gap
/// (naming the missing file), another count than expected, frames of two sizes, a damaged frame, a grey frame
/// where `channels` is 3; Error(kIo) when the folder cannot be read.
PROCAM_EXPORT CaptureFolder load_capture_folder(const std::filesystem::path& folder, int expected_frames,
                                                int channels = 1, const std::optional<ImageSize>& size = {});

/// The size that most images in the folders have, by their headers; the first one's among equals, nullopt
/// without a readable image.
PROCAM_EXPORT std::optional<ImageSize> common_image_size(const std::vector<std::filesystem::path>& folders);

/// The images (png, jpg, bmp, tif) of a folder in natural order of their names. Throws Error(kIo) when it
/// cannot be read.
PROCAM_EXPORT std::vector<std::filesystem::path> list_images(const std::filesystem::path& folder);

/// The sub-folders that hold images, or folders with images, in natural order of their names. Throws
/// Error(kInput) when there is none, Error(kIo) when the folder cannot be read.
PROCAM_EXPORT std::vector<std::filesystem::path> list_views(const std::filesystem::path& session_folder);

/// One camera's frames of one projector's patterns in one view.
struct Stack {
  std::string projector, camera;  ///< as the folders are named; empty where there is no folder
  std::filesystem::path folder;
};

/// The stacks of a view, in natural order; a folder with the name of one of `projectors` is that projector's,
/// any other a camera's. Folders named "rejected" and those that hold neither images nor a stack are left
/// alone. Throws Error(kInput) for images beside folders of images, Error(kIo) when a folder cannot be read.
PROCAM_EXPORT std::vector<Stack> list_stacks(const std::filesystem::path& view_folder,
                                             const std::vector<std::string>& projectors);

/// What was shown while the session was captured; unknown values are omitted.
struct SessionInfo {
  std::string pattern;  ///< as --pattern is typed: "gray", "phase:16px"; empty when not stated
  std::optional<ImageSize> projector_size;  ///< of the only projector
  std::optional<Board> board;
  std::optional<int> step;  ///< projector pixels a finest stripe
  /// Sizes of several projectors by their names, which are those of their folders; then there is no
  /// projector_size.
  std::map<std::string, ImageSize> projectors = {};
};

/// session.json in the folder; nullopt when there is no such file. Errors as for rig files.
PROCAM_EXPORT std::optional<SessionInfo> load_session(const std::filesystem::path& session_folder);
PROCAM_EXPORT void save_session(const std::filesystem::path& session_folder, const SessionInfo& session);

}  // namespace procam::io
