// A camera that is known, four boards before it, and the camera found again from what it saw.
#include <cmath>

#include "procam/calibrate/calibrate.hpp"

using namespace procam;

int main() {
  const Camera truth{{1280, 960}, {1052, 1047, 633, 491}, NoDistortion{}};
  Correspondences seen{Chessboard{9, 6, 0.036}, {{"camera", DeviceKind::kCamera, truth.size}}, {}, {}};
  for (const Vec3& tilt :
       {Vec3(0.4, 0.1, 0), Vec3(-0.3, 0.5, 0.1), Vec3(0.1, -0.5, 0.2), Vec3(-0.4, -0.3, 0)}) {
    const Pose camera_from_board(so3_exp(tilt), Vec3(-0.15, -0.1, 0.7));
    View view{"", {{}}};
    for (int i = 0; i < 54; ++i)
      view.observations[0].push_back({i, *truth.project(camera_from_board * points_in_board(seen.board)[i])});
    seen.views.push_back(view);
  }
  const calibrate::CalibrationResult result = calibrate::calibrate_camera(seen);
  return std::abs(result.rig.camera().camera.intrinsics.fx - 1052) < 1e-3 ? 0 : 1;
}
