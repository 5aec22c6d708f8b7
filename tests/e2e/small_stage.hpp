#pragma once
/// A projector of 320x240 pixels, a camera of 400x300 and a small board: few enough pixels to be simulated
/// while a real window shows pictures.
#include <array>

#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/world.hpp"

namespace procam::test {

constexpr int kStagePoses = 3;
constexpr ImageSize kStageProjector{320, 240};

inline Rig stage_rig() {
  Rig rig;
  rig.cameras.push_back(
      {"camera",
       {{400, 300}, {470, 474, 206, 143, 0}, BrownConrady{{0.03, -0.02, 0.0006, -0.0004, 0}}},
       Pose::identity()});
  const Camera lens{{320, 240}, {455, 451, 166, 133, 0}, BrownConrady{{-0.02, 0.01, 0.0003, 0.0005, 0}}};
  rig.projectors.push_back(
      {"projector", Projector{lens}, Pose(so3_exp(Vec3(-0.07, -0.24, 0.02)), Vec3(0.25, -0.09, 0.03))});
  return rig;
}

/// The board's place in one of kStagePoses poses, all of it in both pictures.
inline simulate::World stage(int pose) {
  simulate::World world;
  world.rig = stage_rig();
  world.board.layout = Chessboard{8, 5, 0.045};
  world.board.margin = 0.03;
  world.ambient = 0.03;
  struct Place {
    Vec3 turn, middle;
  };
  static const std::array<Place, kStagePoses> kPlaces{{{Vec3(0.45, 0.12, 0.05), Vec3(-0.09, -0.06, 0.90)},
                                                       {Vec3(-0.38, 0.25, -0.10), Vec3(0.08, 0.06, 0.98)},
                                                       {Vec3(0.10, -0.50, 0.14), Vec3(0.07, -0.07, 0.92)}}};
  const Place& place = kPlaces[std::size_t(pose % kStagePoses)];
  const Mat3 rotation = so3_exp(place.turn).toRotationMatrix();
  const Vec3 middle_in_board = 0.5 * 0.045 * Vec3(7, 4, 0);
  world.rig_from_board = Pose(rotation, place.middle - rotation * middle_in_board);
  return world;
}

}  // namespace procam::test
