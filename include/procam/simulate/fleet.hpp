#pragma once
/// A session of several cameras and projectors round one board, for one seed. The devices stand side by side
/// and look at one place; the projectors show their patterns one after the other. In every second view one
/// camera alone takes part, each in turn (a person hides the others), so that no camera sees all.
#include <cstdint>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/simulate/session.hpp"

namespace procam::simulate {

struct Fleet {
  /// A board pose, and the devices (by number in the rig) that take part: the whole print lies before them.
  struct View {
    Pose rig_from_board;
    std::vector<std::size_t> cameras, projectors;
  };
  Rig rig;      ///< the first camera's frame is the rig's
  World world;  ///< board, wall and light; its rig is to be replaced by a pair of devices
  CaptureOptions capture;
  std::vector<View> views;
};

/// The level's lenses, board and noise; four views a camera, eight at least. Equal seeds give equal fleets.
/// Throws std::invalid_argument unless there is one of each at least, Error(kNotConverged) when no board pose
/// is found that the devices cover.
PROCAM_EXPORT Fleet make_fleet(Level level, std::uint64_t seed, int cameras, int projectors);
/// Under other conditions than the level's; no view has defects of its own.
PROCAM_EXPORT Fleet make_fleet(Level level, std::uint64_t seed, int cameras, int projectors,
                               const Conditions& conditions);

/// What one camera records of one projector's frames in one view.
PROCAM_EXPORT std::vector<ImageU8> capture_pair(const Fleet& fleet, std::size_t view, std::size_t camera,
                                                std::size_t projector, const std::vector<ImageU8>& frames);

}  // namespace procam::simulate
