#pragma once
/// A robot's lamp and the walls around it, for tests of the running show.
#include <string>

#include "procam/core/geometry/se3.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::test {

/// Axes of a lamp that looks ahead, in a base with x ahead and z up.
inline Mat3 looks_ahead() {
  Mat3 axes;
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return axes;
}

/// The projector "lamp" of 320x200 pixels on the robot's base.
inline Rig lamp_rig() {
  Rig rig;
  RigProjector projector;
  projector.name = "lamp";
  projector.projector.inverse_camera.intrinsics = {410.0, 396.0, 171.3, 148.9, 1.7};
  projector.projector.inverse_camera.size = {320, 200};
  projector.rig_from_projector = Pose(looks_ahead(), Vec3(0.2, 0.03, 0.9));
  rig.projectors.push_back(projector);
  return rig;
}

/// One of four walls around the robot, so that light always meets one.
inline Surface wall_around(int i, const std::string& content) {
  PlanarSurface wall;
  const Pose turned(so3_exp(Vec3(0, 0, i * kPi / 2 + 0.1)), Vec3::Zero());
  wall.frame_from_surface = turned * Pose(looks_ahead(), Vec3(3.1, 1.7, 1.9));
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.points = {{0, 0}, {3.4, 0}, {3.4, 1.8}, {0, 1.8}};
  return {"wall " + std::to_string(i), wall, {}, content};
}

/// An area of the lamp's own pixels: lit without a pose.
inline Surface lamp_sign(const std::string& name, const std::string& content, const Vec2& offset = {0, 0}) {
  PixelSurface sign;
  sign.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec2& pixel : {Vec2(20, 110), Vec2(120, 101), Vec2(131, 170), Vec2(15, 185)})
    sign.pixels.push_back(pixel + offset);
  return {name, sign, {}, content};
}

}  // namespace procam::test
