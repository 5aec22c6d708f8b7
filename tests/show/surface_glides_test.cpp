#include "surface_glides.hpp"

#include <gtest/gtest.h>

#include "live_world.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::show {
namespace {

const SurfaceGlides::Frames kFrames{Pose(so3_exp(Vec3(0.03, -0.07, 0.11)), Vec3(0.12, -0.05, 0.21)),
                                    Pose(so3_exp(Vec3(0.2, 0.1, -0.3)), Vec3(0.5, 0.1, -0.4))};

const Pose& placed(const SurfaceSet& set, std::size_t i) {
  return place_of(set.surfaces[i].geometry)->frame_from_surface;
}
double apart(const Pose& a, const Pose& b) {
  return se3_log(Pose(a * b.inverse())).norm();
}

/// Surfaces of all frames move by the same increment of the rig's frame; a second correction goes on from the first.
TEST(SurfaceGlides, MoveInTheRigsFrameAndBack) {
  Vec6 moved;
  moved << 0.02, -0.03, 0.01, 0.004, -0.006, 0.02;
  for (const char* const frame : {"world", "rig", "projector"}) {
    SurfaceSet set;
    set.surfaces = {wall("other", {0.3, 0.1}), wall("sheet", {-0.75, -0.3}), pixel_area("sign")};
    place_of(set.surfaces[1].geometry)->frame = frame;
    const SurfaceSet before = set;
    const Pose rig_from_frame = std::string(frame) == "world"       ? kFrames.rig_from_world
                                : std::string(frame) == "projector" ? kFrames.rig_from_projector
                                                                    : Pose();
    const Pose rig_from_sheet = rig_from_frame * placed(before, 1);
    SurfaceGlides glides;
    glides.begin(set, "absent", moved, 0.01, kFrames, 100);
    glides.begin(set, "sign", moved, 0.01, kFrames, 100);  // pixels are nowhere in the room
    EXPECT_TRUE(glides.is_idle());
    glides.begin(set, "sheet", moved, 0.01, kFrames, 100);  // two seconds at 5 mm a second
    glides.apply(set, 101);
    EXPECT_FALSE(glides.is_idle());
    const Pose way = rig_from_frame * placed(set, 1) * rig_from_sheet.inverse();
    EXPECT_LT((se3_log(way) - 0.5 * moved).norm(), 1e-12) << frame;
    glides.apply(set, 102);
    EXPECT_TRUE(glides.is_idle());
    EXPECT_LT(apart(rig_from_frame * placed(set, 1), se3_exp(moved) * rig_from_sheet), 1e-12) << frame;
    EXPECT_EQ(placed(set, 0).matrix(), placed(before, 0).matrix());

    glides.begin(set, "sheet", moved, 0.01, kFrames, 200);
    glides.apply(set, 300);
    EXPECT_GT(apart(placed(set, 1), placed(before, 1)), 0.07);
    glides.undo(set, 300);
    glides.apply(set, 302);
    EXPECT_FALSE(glides.is_idle());  // 20 mm are undone in four seconds
    glides.apply(set, 304);
    EXPECT_TRUE(glides.is_idle());
    EXPECT_LT(apart(placed(set, 1), placed(before, 1)), 1e-12) << frame;
    glides.undo(set, 400);
    EXPECT_TRUE(glides.is_idle());  // nothing is left to undo
  }
}

}  // namespace
}  // namespace procam::show
