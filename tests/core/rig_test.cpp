#include "procam/core/rig/rig.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

std::string refusal(const Rig& rig, const std::string& name) {
  try {
    rig.projector(name);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    return error.what();
  }
  return "";
}

TEST(Rig, PicksTheOnlyDeviceOrTheNamedOne) {
  Rig rig;
  rig.cameras.push_back({"camera", {}, {}});
  rig.projectors.push_back({"left", {}, {}});
  EXPECT_EQ(rig.projector().name, "left");
  rig.projectors.push_back({"right", {}, {}});
  EXPECT_EQ(rig.projector("right").name, "right");
  EXPECT_EQ(rig.camera().name, "camera");
}

TEST(Rig, RefusesWithTheNamesThereAre) {
  Rig rig;
  EXPECT_EQ(refusal(rig, ""), "rig projector: the rig has none; use a rig file with a projector");
  rig.projectors = {{"left", {}, {}}, {"right", {}, {}}};
  EXPECT_EQ(refusal(rig, ""), "rig projector: the rig has several; name one of: left, right");
  EXPECT_EQ(refusal(rig, "middle"),
            "rig projector 'middle': the rig has none of that name; name one of: left, right");
}

TEST(Rig, ProjectorFromCameraGoesThroughTheRig) {
  Rig rig;
  rig.cameras.push_back({"camera", {}, test::lopsided_pose()});
  rig.projectors.push_back({"projector", {}, test::other_lopsided_pose()});
  const Vec3 point_in_camera(0.3, -0.2, 1.7);
  const Vec3 point_in_rig = test::lopsided_pose() * point_in_camera;
  EXPECT_LT(
      (test::other_lopsided_pose() * (rig.projector_from_camera() * point_in_camera) - point_in_rig).norm(),
      1e-14);
}

TEST(RigQuality, PassesOnlyWhenEveryGateDoes) {
  RigQuality quality;
  EXPECT_TRUE(quality.passed());
  quality.gates = {{"rms", true, ""}, {"principal_point", false, "cy 384"}};
  EXPECT_FALSE(quality.passed());
}

}  // namespace
}  // namespace procam
