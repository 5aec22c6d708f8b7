#include "editor.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "control_messages.hpp"
#include "editor_points.hpp"
#include "editor_shapes.hpp"
#include "group_link.hpp"
#include "live_world.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/base/words.hpp"
#include "procam/surface/solve.hpp"
#include "support/expect_error.hpp"

namespace procam::show {
namespace {

class Edited : public testing::Test {
 protected:
  RigProjector projector_ = small_rig().projectors[0];
  Editor editor_{small_show().surfaces};
  SolvedSurfaceSet solved_;
  void SetUp() override { solve(); }
  void solve() { solved_ = surface::solve_surfaces(editor_.surfaces(), projector_, Pose()); }
  void apply(const Command& command) {
    editor_.apply(command, projector_.projector, solved_);
    solve();
  }
  std::vector<std::optional<Vec2>> points(std::size_t surface) {
    return points_in_frame(solved_.surfaces[surface], projector_.projector);
  }
};

/// Through the lens, onto the plane and back: the corner is where it was dropped.
TEST_F(Edited, ACornerGoesWhereItIsDragged) {
  for (const std::size_t surface : {0u, 2u}) {
    const std::string name = editor_.surfaces().surfaces[surface].name;
    const auto before = points(surface);
    const Vec2 to = *before[2] + Vec2(7.25, -3.5);
    apply({"move", name, 2, to, "", "drag 1"});
    EXPECT_LT((*points(surface)[2] - to).norm(), 1e-9) << name;
    EXPECT_LT((*points(surface)[1] - *before[1]).norm(), 1e-12) << "the others stay";
  }
  const auto before = points(0);
  apply({"nudge", "left", -1, {0.1, -0.3}, "", ""});
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((*points(0)[i] - *before[i] - Vec2(0.1, -0.3)).norm(), 1e-9);
}

/// The demo's wall: four corners and the middle. The outline is the content's, the fifth point is none of its corners.
TEST_F(Edited, TheOutlineIsTheContentsAndTheFitIsStated) {
  SurfaceSet set = small_show().surfaces;
  auto& plane = std::get<PlanarSurface>(set.surfaces[0].geometry);
  for (const auto& [content, at] : {std::pair(Vec2(0.5, 0.5), Vec2(0.34, 0.21))}) {
    plane.content.push_back(content);
    plane.points.push_back(at);
  }
  auto& sign = std::get<PixelSurface>(set.surfaces[2].geometry);
  sign.content.emplace_back(0.3, 0.6);
  sign.pixels.emplace_back(50, 151);
  editor_ = Editor(set);
  solve();
  for (const std::size_t surface : {0u, 2u}) {
    const std::string name = set.surfaces[surface].name;
    const auto to = *points(surface)[4] + Vec2(9.5, -4);
    apply({"move", name, 4, to, "", ""});
    const auto outline = outline_in_frame(solved_.surfaces[surface], projector_.projector);
    ASSERT_EQ(outline.size(), 4u) << name;
    double largest = 0;
    for (const std::size_t i : {0u, 1u, 2u, 3u}) {
      const double off = (*outline[i] - *points(surface)[i]).norm();
      EXPECT_LT(off, 12) << name << ", near its corner";
      largest = std::max(largest, off);
    }
    EXPECT_GT(largest, 0.5) << name << ": the fit gives way";
  }
  // By the solution's own residuals: 0.0127 m and 4.93 px were measured.
  const std::vector<double>& metres = solved_.surfaces[0].residuals;
  const double worst_mm = 1e3 * *std::max_element(metres.begin(), metres.end());
  EXPECT_GT(worst_mm, 3);
  EXPECT_EQ(fit_sentence(solved_.surfaces[0]), "5 points: fitted, up to " + fixed(worst_mm, 1) + " mm off");
  const std::string in_pixels = fit_sentence(solved_.surfaces[2]);
  EXPECT_EQ(in_pixels.substr(0, 24), "5 points: fitted, up to ") << in_pixels;
  EXPECT_EQ(in_pixels.substr(in_pixels.size() - 7), " px off") << in_pixels;
  EXPECT_EQ(fit_sentence(solved_.surfaces[1]), "") << "four points are met exactly";
  const auto four = outline_in_frame(solved_.surfaces[1], projector_.projector);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((*four[i] - *points(1)[i]).norm(), 1e-6);
}

/// A mask that is clicked in the frame is at this place of the content, and comes back to the frame where it was.
TEST_F(Edited, AMaskStaysWhereItIsClicked) {
  const Points2 rings[] = {{{70, 120}, {90, 118}, {84, 140}}, {{60, 130}, {82, 128}, {70, 150}, {58, 146}}};
  const auto mask = [&](const std::string& name, const Points2& ring) {
    Command command{"mask", name, -1, Vec2::Zero(), "", ""};
    command.ring = ring;
    apply(command);
  };
  // In pixels, and on a wall through the lens; the wall's ring is round its middle.
  Points2 on_wall;
  const auto corners = points(0);
  const Vec2 middle = 0.25 * (*corners[0] + *corners[1] + *corners[2] + *corners[3]);
  for (const Vec2& corner : rings[0]) on_wall.push_back(middle + 0.4 * (corner - Vec2(80, 126)));
  mask("sign", rings[0]);
  mask("left", on_wall);
  for (const auto& [surface, ring] :
       {std::pair(std::size_t(2), rings[0]), std::pair(std::size_t(0), on_wall)}) {
    const auto shown = masks_in_frame(solved_.surfaces[surface], projector_.projector);
    ASSERT_EQ(shown.size(), 1u);
    ASSERT_EQ(shown[0].size(), ring.size());
    for (std::size_t i = 0; i < ring.size(); ++i) EXPECT_LT((*shown[0][i] - ring[i]).norm(), 1e-6) << surface;
  }
  EXPECT_ERROR(mask("sign", {{70, 120}, {90, 118}}), kInput, "2 corners, not 3");
  EXPECT_ERROR(mask("sign", rings[1]), kInput, "meets");
  EXPECT_ERROR(mask("sign", {{1, 1}, {2, 1}, {1, 2}}), kInput, "twice");  // all at the content's corner
  ASSERT_EQ(editor_.surfaces().surfaces[2].shape.holes.size(), 1u) << "refused ones change nothing";
  EXPECT_ERROR(apply({"unmask", "sign", 1, {}, "", ""}), kInput, "no mask 1");
  apply({"unmask", "sign", -1, {}, "", ""});
  EXPECT_TRUE(editor_.surfaces().surfaces[2].shape.is_whole());
  EXPECT_TRUE(editor_.undo());
  EXPECT_EQ(editor_.surfaces().surfaces[2].shape.holes.size(), 1u);
}

/// From four corners to a grid or a patch: the surface stays where it is, and each point can be dragged.
TEST_F(Edited, ASurfaceInPixelsIsBentByItsPoints) {
  const auto sign = [&] { return std::get<PixelSurface>(editor_.surfaces().surfaces[2].geometry); };
  const SolvedSurface flat = solved_.surfaces[2];
  for (const std::string shape : {"grid 5x3", "bezier 4x4", "grid 2x2", "flat"}) {
    apply({"shape", "sign", -1, {}, shape, ""});
    EXPECT_EQ(shape_name(sign()), shape);
    const bool through = shape != "grid 2x2" && shape != "flat";  // those keep the corners alone
    for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1), Vec2(0.5, 0.5), Vec2(0.25, 0.5)}) {
      const bool is_corner = uv.x() != 0.5 && uv.x() != 0.25;
      if (!is_corner && !through) continue;
      const Vec2 at = *frame_at(solved_.surfaces[2], projector_.projector, uv);
      EXPECT_LT((at - *frame_at(flat, projector_.projector, uv)).norm(), is_corner ? 1e-6 : 1) << shape;
      const auto back = content_at(solved_.surfaces[2], projector_.projector, at);
      EXPECT_LT((*back - uv).norm(), is_corner ? 1e-6 : 0.01) << shape;
    }
  }
  apply({"shape", "sign", -1, {}, "grid 3x3", ""});
  EXPECT_EQ(points(2).size(), 9u);
  EXPECT_EQ(outline_in_frame(solved_.surfaces[2], projector_.projector).size(), 48u);
  EXPECT_EQ(fit_sentence(solved_.surfaces[2]), "");
  apply({"move", "sign", 4, {80, 160}, "", "drag"});
  EXPECT_EQ(*frame_at(solved_.surfaces[2], projector_.projector, Vec2(0.5, 0.5)), Vec2(80, 160));
  apply({"nudge", "sign", 4, {0.5, 0}, "", ""});
  EXPECT_EQ(sign().pixels[4], Vec2(80.5, 160));
  // A mask on it, and a click beside it, which counts for its border.
  Command mask{"mask", "sign", -1, Vec2::Zero(), "", ""};
  mask.ring = {{70, 130}, {0, 140}, {72, 145}};
  apply(mask);
  const Points2 hole = editor_.surfaces().surfaces[2].shape.holes.at(0);
  EXPECT_EQ(hole[1].x(), 0);
  EXPECT_LT((*frame_at(solved_.surfaces[2], projector_.projector, hole[0]) - Vec2(70, 130)).norm(), 0.2);
  for (const char* wrong :
       {"", "grid", "grid 3", "grid 1x3", "grid 17x3", "bezier 4x4 ", "mesh 3x3", "gridd 3x3"})
    EXPECT_THROW(apply({"shape", "sign", -1, {}, wrong, ""}), Error) << wrong;
  EXPECT_ERROR(apply({"shape", "left", -1, {}, "grid 3x3", ""}), kInput, "not in projector pixels");
  EXPECT_EQ(shape_name(sign()), "grid 3x3");
}

/// A corner that is dragged in the frame of one host of a group is, for all others, at that place on the surface.
TEST_F(Edited, AGroupGetsThePlaceOnTheSurface) {
  ProjectionOptions standing;
  standing.projector_from_world = Pose();
  Projection projection(small_rig(), standing);
  projection.set_show(small_show());
  for (const char* const name : {"left", "sign"}) {
    const Command dragged{"move", name, 2, {151.25, 120.5}, "", "drag 1"};
    const std::vector<Command> shared = shared_commands(dragged, &editor_, projection);
    ASSERT_EQ(shared.size(), 1u) << "the point that moved, and no other";
    const std::optional<Command> received = to_command(to_message(shared[0]));
    ASSERT_TRUE(received);
    EXPECT_EQ(received->gesture, "drag 1");
    Editor here(small_show().surfaces), elsewhere(small_show().surfaces);
    here.apply(dragged, projection.projector(), projection.solved());
    // Another projector, which does not matter.
    Projector other = projector_.projector;
    other.inverse_camera.intrinsics.fx *= 2;
    elsewhere.apply(*received, other, {});
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(*edited_points(elsewhere.surfaces().surfaces[i].geometry),
                *edited_points(here.surfaces().surfaces[i].geometry))
          << name;
    EXPECT_TRUE(elsewhere.undo());
  }
  EXPECT_EQ(shared_commands({"nudge", "sign", -1, {1, 0}, "", ""}, &editor_, projection).size(), 4u);
  Command mask{"mask", "left", -1, Vec2::Zero(), "", ""};
  const auto corners = points_in_frame(projection.solved().surfaces[0], projection.projector());
  mask.ring = {*corners[0], *corners[1], 0.5 * (*corners[2] + *corners[0])};
  const std::vector<Command> holes = shared_commands(mask, &editor_, projection);
  ASSERT_EQ(holes.size(), 1u);
  const std::optional<Command> hole = to_command(to_message(holes[0]));
  ASSERT_TRUE(hole);
  EXPECT_EQ(hole->verb, "hole");
  ASSERT_EQ(hole->ring.size(), 3u);
  EXPECT_LT((hole->ring[1] - Vec2(1, 0)).norm(), 1e-9);
  EXPECT_EQ(shared_commands({"undo", "", -1, {}, "", ""}, &editor_, projection).size(), 1u);
  EXPECT_ERROR(editor_.apply({"place", "sign", 4, {1, 1}, "", ""}, projector_.projector, {}), kInput,
               "no point 4");
  EXPECT_ERROR(editor_.apply({"place", "sign", 1, {1e6, 1}, "", ""}, projector_.projector, {}), kInput,
               "far away");
}

TEST_F(Edited, AsManyStepsAsTheLimitAreUndone) {
  for (std::size_t i = 0; i <= limits::kEditSteps; ++i) apply({"nudge", "sign", 0, {0.1, 0}, "", ""});
  std::size_t undone = 0;
  while (editor_.undo()) ++undone;
  EXPECT_EQ(undone, limits::kEditSteps) << "the oldest step is forgotten";
  solve();
  EXPECT_NEAR(points(2)[0]->x(), 20.1, 1e-9);
  while (editor_.redo()) --undone;
  EXPECT_EQ(undone, 0u);
}

TEST_F(Edited, ADragIsOneStep) {
  const auto before = points(2);
  for (int i = 1; i <= 20; ++i) apply({"move", "sign", 0, {20.0 + i, 110.0 - i}, "", "drag 7"});
  apply({"nudge", "sign", 0, {0.1, 0}, "", ""});
  EXPECT_TRUE(editor_.is_unsaved());
  EXPECT_TRUE(editor_.undo());
  solve();
  EXPECT_EQ(*points(2)[0], Vec2(40, 90));
  EXPECT_TRUE(editor_.undo());
  solve();
  EXPECT_EQ(*points(2)[0], *before[0]);
  EXPECT_FALSE(editor_.undo());
  EXPECT_TRUE(editor_.redo());
  EXPECT_TRUE(editor_.redo());
  EXPECT_FALSE(editor_.redo());
  solve();
  EXPECT_EQ(*points(2)[0], Vec2(40.1, 90));
  apply({"rename", "sign", -1, {}, "board", ""});
  EXPECT_FALSE(editor_.can_redo());
}

TEST_F(Edited, SurfacesComeAndGo) {
  apply({"add", "new one", -1, {}, "#ff8000", ""});
  ASSERT_EQ(editor_.surfaces().surfaces.size(), 4u);
  EXPECT_EQ(editor_.surfaces().surfaces[3].content, "#ff8000");
  for (const auto& point : points(3)) {
    EXPECT_GT(point->x(), 0);
    EXPECT_LT(point->x(), 320);
  }
  apply({"content", "new one", -1, {}, "clip.mp4", ""});
  EXPECT_EQ(editor_.surfaces().surfaces[3].content, "clip.mp4");
  apply({"remove", "left", -1, {}, "", ""});
  EXPECT_EQ(editor_.surfaces().surfaces[0].name, "right");
  EXPECT_TRUE(editor_.undo());
  EXPECT_EQ(editor_.surfaces().surfaces[0].name, "left");
}

TEST_F(Edited, WhatCannotBeChangesNothing) {
  const double nan = std::nan("");
  const Command refused[] = {{"move", "sign", 4, {1, 1}, "", ""},
                             {"move", "sign", -1, {1, 1}, "", ""},
                             {"move", "nobody", 0, {1, 1}, "", ""},
                             {"move", "sign", 0, {nan, 1}, "", ""},
                             {"move", "sign", 0, {1e9, 1}, "", ""},
                             {"add", "sign", -1, {}, "", ""},
                             {"add", "", -1, {}, "", ""},
                             {"add", "a\nb", -1, {}, "", ""},
                             {"add", std::string(limits::kSurfaceNameBytes + 1, 'x'), -1, {}, "", ""},
                             {"rename", "sign", -1, {}, "left", ""},
                             {"remove", "nobody", -1, {}, "", ""},
                             {"dance", "sign", -1, {}, "", ""},
                             {"nudge", "sign", 9, {1, 1}, "", ""}};
  for (const Command& command : refused) {
    EXPECT_THROW(editor_.apply(command, projector_.projector, solved_), Error)
        << command.verb << " " << command.surface;
    EXPECT_FALSE(editor_.can_undo());
  }
  EXPECT_FALSE(editor_.is_unsaved());
  apply({"add", std::string(limits::kSurfaceNameBytes, 'x'), -1, {}, "", ""});
  while (editor_.surfaces().surfaces.size() < limits::kEditedSurfaces)
    apply({"add", "s" + std::to_string(editor_.surfaces().surfaces.size()), -1, {}, "", ""});
  EXPECT_THROW(apply({"add", "one more", -1, {}, "", ""}), Error);
}

TEST_F(Edited, WhatCannotBeSolvedIsRevoked) {
  const auto before = std::get<PixelSurface>(editor_.surfaces().surfaces[2].geometry).pixels;
  editor_.apply({"move", "sign", 0, before[1], "", "drag 1"}, projector_.projector, solved_);
  EXPECT_THROW(solve(), Error) << "two corners in one place";
  editor_.revoke();
  EXPECT_EQ(std::get<PixelSurface>(editor_.surfaces().surfaces[2].geometry).pixels, before);
  solve();
}

}  // namespace
}  // namespace procam::show
