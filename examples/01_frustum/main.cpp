// From a marker seen by the camera to the picture a renderer has to draw.
//
// A rig knows projector_from_camera; a detector says camera_from_marker. Their product places the renderer's
// eye, and the projector's intrinsics give the projection matrix. Drawn so, a point of the marker's world
// lights the pixel that the projector model says: off-centre, skewed, half pixels and all.
#include <iostream>

#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/frustum.hpp"
#include "procam/core/lens/projector.hpp"

using namespace procam;

int main() {
  // A table-top projector: its principal point lies below the picture (lens shift), and its axes are slightly
  // skewed.
  const Projector projector{{{1024, 768}, {1880, 1893, 502, 855, 0.4}, NoDistortion{}}};
  const Pose projector_from_camera(so3_exp(Vec3(0.12, -0.31, 0.02)), Vec3(0.095, -0.624, -0.240));
  const Pose camera_from_marker(so3_exp(Vec3(-0.4, 0.25, 0.1)), Vec3(0.15, 0.20, 1.80));

  // The inner names touch, so the chain is right.
  const Pose projector_from_marker = projector_from_camera * camera_from_marker;

  const Intrinsics& k = projector.inverse_camera.intrinsics;
  const double near = 0.1, far = 10;
  const Mat4 clip_from_eye_gl = clip_from_eye(k, projector.size(), near, far, GraphicsApi::kOpenGL);
  const Mat4 clip_from_marker = clip_from_optical(k, projector.size(), near, far, GraphicsApi::kOpenGL) *
                                projector_from_marker.matrix();
  std::cout << "projector_from_marker:\n"
            << projector_from_marker.matrix34() << "\n\n"
            << "OpenGL projection matrix:\n"
            << clip_from_eye_gl << "\n\n";

  // What the graphics card does with a point, by hand: divide, then the viewport transform; rows grow
  // downwards.
  const Vec3 point_in_marker(0.05, -0.03, 0.0);
  const Vec4 clip = clip_from_marker * point_in_marker.homogeneous();
  const Vec2 ndc = clip.head<2>() / clip.w();
  const Vec2 drawn(0.5 * (ndc.x() + 1) * projector.size().width - 0.5,
                   0.5 * (1 - ndc.y()) * projector.size().height - 0.5);

  const std::optional<Vec2> lit = projector.project(projector_from_marker * point_in_marker);
  if (!lit) return 1;
  std::cout << "the renderer draws the point at " << drawn.transpose() << ", the projector model says "
            << lit->transpose() << "\n";
  return (drawn - *lit).norm() < 1e-9 ? 0 : 1;
}
