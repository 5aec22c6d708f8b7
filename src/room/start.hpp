#pragma once
/// Where bundle adjustment begins: two devices by epipolar geometry, the others by resection.
#include <optional>
#include <string>
#include <vector>

#include "adjust.hpp"
#include "procam/room/calibrate_room.hpp"
#include "resect.hpp"

namespace procam::room {

/// What is known of each lens.
struct LensPlan {
  std::vector<Camera> lenses;                   ///< by lens, to begin with
  std::vector<std::optional<LensGuess>> guess;  ///< of lenses that are not known
  std::vector<LensKnowledge> known;
  std::vector<std::vector<char>> free;  ///< in the last adjustment
  std::vector<char> unstated;           ///< by lens: known, but nothing is stated of how well
  bool cameras_known = true;
};

LensPlan plan_lenses(const RoomPoints& points, const RoomOptions& options);

/// The plan's knowledge with the weak priors of unknown lenses scaled to the lenses as solved.
std::vector<LensKnowledge> knowledge_at(const LensPlan& plan, const RoomState& state);

/// A plan in which the lenses of known cameras, chosen by lens, are as unknown as those of a data sheet: what the light
/// says about them.
LensPlan widened(const LensPlan& plan, const std::vector<char>& chosen);

/// The same lens by a model whose distortion can be estimated.
Camera with_distortion(const Camera& lens);

struct Started {
  RoomState state;
  double merit = 0;  ///< -2 log of the likelihood with the priors, up to a constant: the smallest is best
};

/// Every device with a place, the first position at the origin, scale arbitrary. Throws as calibrate_room().
Started start_room(const RoomPoints& points, const LensPlan& plan, int threads);

/// Throws Error(kDegenerate) with the cause why a room gives no rig: one plane, no parallax, one camera position.
/// `seen` is what shows it; `parallax` in radians where it is known, else negative.
[[noreturn]] void refuse_room(const RoomPoints& points, const LensPlan& plan, const std::string& seen,
                              double parallax = -1);

/// Throws Error(kDegenerate) when all camera positions differ by rotations alone.
void refuse_if_turned_only(const RoomPoints& points, const LensPlan& plan,
                           const std::string& seen = "no depth follows");

}  // namespace procam::room
