#pragma once
/// A wall before a rig that is not known exactly.
#include "analyze/uncertain_rig.hpp"
#include "procam/analyze/error_sources.hpp"

namespace procam::test {

/// Content of 0.7 m by 0.5 m on a wall in the world, oblique to a lopsided rig that drives, where the middle
/// of the projector's picture lands.
struct UncertainRoom {
  Rig rig = uncertain_rig();
  Pose world_from_rig = lopsided_pose();
  Mat3 plane_from_content;
  analyze::ErrorSources sources;

  UncertainRoom() {
    const Vec2 middle = *analyze::landing_place(path(), Vec2(520, 370));
    plane_from_content << 0.7, 0, middle.x() - 0.35, 0, 0.5, middle.y() - 0.25, 0, 0, 1;
    sources.calibration = rig.covariance;
    sources.rig_pose = analyze::isotropic_pose_covariance(0.004, 0.2 * kDegree);
    sources.map = analyze::isotropic_pose_covariance(0.003, 0);
    sources.motion.twist << 0, -0.4, 0, 0.1, 0, 0.3;
    sources.motion.delay = 0.06;
  }
  analyze::LightPath path() const {
    const Pose rig_from_wall(so3_exp(Vec3(0.1, -0.6, 0.05)), Vec3(0.2, -0.1, 2.1));
    return analyze::light_path(rig.projector(), "world", world_from_rig * rig_from_wall, world_from_rig);
  }
};

}  // namespace procam::test
