#pragma once
/// Whole calibration sessions from a seed: a rig, a board in several poses, and how it was photographed.
///
///   easy   in focus, little noise and distortion; camera 1280x1024, board 10x7
///   paper  the rig of an office projector on a table: picture above the axis (principal point near the
///   bottom edge),
///          camera 1280x960 with moderate distortion, noise of 2 grey levels; board 9x6
///   hard   strong barrel distortion, skew, projector lens distorted too and its axis below the picture, out
///   of focus,
///          noise of 4 grey levels, grey print, room light; every third board partly outside the projector's
///          picture; board 7x9 (odd x odd: a detector may turn it by 180 degrees)
///
/// The seed moves every parameter of the rig and every pose; equal seeds give equal sessions. The camera's
/// frame is the rig's frame. The whole sheet is on the camera's image, and every board point is lit unless
/// said above.
#include <cstdint>
#include <string>

#include "procam/pattern/gray_code.hpp"
#include "procam/simulate/capture.hpp"

namespace procam::simulate {

enum class Level { kEasy, kPaper, kHard };

const char* to_string(Level level);
/// Throws Error(kUnsupported) for an unknown name.
Level level_named(const std::string& name);

struct Session {
  Level level = Level::kEasy;
  pattern::GrayCode gray_code;
  std::vector<World> views;  ///< one a board pose; the same rig, board and wall in each
  CaptureOptions capture;

  const Rig& rig() const { return views.front().rig; }
  const PrintedBoard& board() const { return views.front().board; }
};

Session make_session(Level level, std::uint64_t seed);

/// The captures of one view, in the order of pattern::frames(). Noise differs from view to view.
std::vector<ImageU8> capture_view(const Session& session, std::size_t view);

}  // namespace procam::simulate
