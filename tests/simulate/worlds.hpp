#pragma once
/// A lopsided world for the tests: nothing centred, nothing square, every parameter alive.
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/capture.hpp"

namespace procam::simulate::test {

inline Rig lopsided_rig() {
  Rig rig;
  Camera camera{{640, 470}, {705, 718, 331, 221, 0.7}, BrownConrady{{-0.21, 0.06, 0.0011, -0.0008, 0.01}}};
  Camera inverse{{512, 390}, {820, 811, 240, 371, -0.9}, BrownConrady{{-0.09, 0.03, -0.0007, 0.0009, 0}}};
  const Vec6 camera_pose = (Vec6() << 0.3, -0.2, 0.1, 0.4, 0.1, -0.2).finished();
  Vec6 projector_pose;
  projector_pose << -0.16, -0.14, 0.05, 0.21, -0.07, 0.06;  // seen from the camera
  rig.cameras.push_back({"camera", camera, se3_exp(camera_pose)});
  rig.projectors.push_back({"projector", {inverse}, se3_exp(camera_pose) * se3_exp(projector_pose)});
  return rig;
}

/// Board, camera_from_board given as an SE(3) increment [rotation, translation of the board's middle].
inline World lopsided_world(const Vec3& rotation = Vec3(0.35, -0.28, 0.2),
                            const Vec3& middle_in_camera = Vec3(0.03, 0.02, 0.9)) {
  World world;
  world.rig = lopsided_rig();
  world.board = {Chessboard{8, 5, 0.041}, 0.05, 0.8, 0.05};
  const Eigen::Quaterniond q = so3_exp(rotation);
  const Pose camera_from_board(q, middle_in_camera - q * Vec3(3.5 * 0.041, 2 * 0.041, 0));
  const Pose rig_from_camera = world.rig.camera().rig_from_camera;
  world.rig_from_board = rig_from_camera * camera_from_board;
  world.wall_in_rig = rig_from_camera * Plane{Vec3(0.11, -0.07, -1).normalized(), 1.7};
  world.ambient = 0.05;
  return world;
}

inline ImageU8 full_light(const World& world) {
  return ImageU8(world.rig.projector().projector.size(), 1, 255);
}

}  // namespace procam::simulate::test
