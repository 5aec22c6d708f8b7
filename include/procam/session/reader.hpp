#pragma once
/// A session folder -> correspondences, whatever pattern it was captured with. The one home of this reading:
/// tools and end-to-end tests share it.
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "procam/core/rig/rig.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/shown_views.hpp"

namespace procam::session {

struct PlannedProjector {
  std::string name;
  ImageSize size;
  std::unique_ptr<SessionPattern> pattern;  ///< none in sessions of photographs and of decoded maps
};

struct PlannedView {
  std::string name;
  std::vector<io::Stack> stacks;
};

/// A session with everything known that its reading needs.
struct SessionPlan {
  std::filesystem::path folder;
  std::vector<std::string> cameras;  ///< natural order; the first one's frame will be the rig's
  std::vector<PlannedProjector> projectors;
  int step = 1;
  std::filesystem::path
      pattern_file;  ///< of another program's frames (io/session/pattern_file.hpp); empty: none
  Board board;
  std::vector<PlannedView> views;
  std::optional<ShownViews> shown;  ///< a session of one photograph a view; then `views` have no stacks
  bool decoded = false;  ///< views hold decoded maps (io/session/decoded_view.hpp) instead of frames
  bool through_mirror =
      false;  ///< turn every frame left to right before it is read (core/geometry/mirror.hpp)
};

constexpr const char* kDecodedMaps = "decoded";

/// u -> width - 1 - u.
void turn_left_to_right(ImageU8& image);
void turn_left_to_right(ImageF& image);

/// `stated` (flags) first, then session.json; without either the pattern is "gray". Throws Error(kInput)
/// naming the flag that would answer what neither says, and for folders that do not tell which device they
/// belong to. The pattern kDecodedMaps stands for views that another program has decoded.
SessionPlan open_session(const std::filesystem::path& folder, const io::SessionInfo& stated,
                         const ShownFlags& shown = {});

/// As --pattern states it; of photographs "shown", of decoded maps "decoded".
std::string pattern_text(const SessionPlan& plan);

/// Called before each view is read: name, number done, number of all.
using ReadingProgress = std::function<void(const std::string& view, int done, int total)>;

struct SessionContents {
  Correspondences correspondences;
  std::vector<InputFile> inputs;  ///< every frame that was read
};

/// Reads and joins all views: cameras first among the devices, then projectors. A board missed in one view is
/// a remark; one found in none of the first three views is an Error(kInput), as is whatever is wrong with a
/// view's files. An image whose size is not that of most of its camera's images is rejected by name; a view
/// that then has too few frames is rejected with it.
SessionContents read_session(const SessionPlan& plan, const ReadingProgress& progress = {});

/// The devices of a session with one of each, in the order of kCameraDevice, kProjectorDevice.
std::vector<Device> session_devices(ImageSize camera_size, ImageSize projector_size);

}  // namespace procam::session
