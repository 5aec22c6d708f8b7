/// The blend of a running show, judged by what two walls in a corner show: the light of all projectors added up.
#include "show_blend.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "blend_log.hpp"
#include "corner_world.hpp"
#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/core/base/color.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/frame_files.hpp"
#include "procam/show/run.hpp"
#include "procam/surface/solve.hpp"
#include "support/expect_error.hpp"

namespace procam::show {
namespace {

TEST(ShowBlend, ACornerLitByAllIsAsBrightAsByOne) {
  const Corner corner;
  for (const ProjectorNames& lit :
       {ProjectorNames{"left", "right"}, ProjectorNames{"far", "left", "right"}}) {
    for (const std::uint8_t value : {255, 124}) {
      const Wall wall = seen_light(corner, lit, frames_of(corner, lit, value));
      EXPECT_GT(wall.by_several, 200);
      EXPECT_NEAR(wall.mean, light_from_srgb(value / 255.0), 2e-3);
      // As render-to-image's, with 8-bit values: half a step is 0.5 % of the light of 200, 0.9 % of that of 124.
      EXPECT_LT(wall.worst, 0.02) << int(value);
      EXPECT_LT(wall.deviation, 0.004) << int(value);
      const std::string of = std::to_string(lit.size()) + "_" + std::to_string(value);
      RecordProperty("worst_1e4_" + of, int(1e4 * wall.worst));
      RecordProperty("deviation_1e5_" + of, int(1e5 * wall.deviation));
    }
  }
  std::vector<ImageU8> plain;
  for (const char* name : {"left", "right"})
    plain.push_back(corner.frame(name, {name}, ImageU8(8, 8, 3, 255)));
  EXPECT_GT(seen_light(corner, {"left", "right"}, plain).worst, 0.25) << "unblended it is twice as bright";
}

TEST(ShowBlend, BlackIsLiftedWhereOneProjectorIsAlone) {
  const Corner corner;
  const ProjectorNames lit = {"left", "right"};
  BlendSettings settings;
  settings.black = {{"left", 0.02}, {"right", 0.02}};
  const Wall black = seen_light(corner, lit, frames_of(corner, lit, 0, settings), 0.02);
  EXPECT_NEAR(black.mean, 0.04, 1e-3);
  EXPECT_LT(black.worst, 0.03);
  EXPECT_GT(seen_light(corner, lit, frames_of(corner, lit, 0), 0.02).worst, 0.3);
}

/// The frames that render-to-image --blend writes, bit for bit.
TEST(ShowBlend, FramesAreThoseOfRenderToImage) {
  test::Scratch folder;
  const Corner corner;
  io::save_image(folder / "picture.png", colourful(61, 47, 2));
  const std::vector<std::string> names = {"left", "right"};
  for (const std::string& name : names) {
    std::vector<SolvedSurfaceSet> sets;
    std::vector<surface::BlendInput> lit;
    sets.reserve(2);
    for (const std::string& one : {name, name == "left" ? names[1] : names[0]}) {
      sets.push_back(surface::solve_surfaces(corner.surfaces, corner.rig.projector(one),
                                             corner.projector_from_world(one)));
      lit.push_back({corner.rig.projector(one).projector, &sets.back(), 1, 0.001});
    }
    FrameFilesOptions files;
    files.output = (folder / "frame.png").string();
    files.contents = {{"left wall", (folder / "picture.png").string()},
                      {"right wall", (folder / "picture.png").string()}};
    files.blend.emplace();
    files.blend->sets = sets;
    files.blend->maps = surface::blend_maps(lit).maps;
    files.blend->brightness = {1, 1};
    files.blend->black = {0.001, 0.001};
    write_frames(corner.rig, sets[0], files);
    const ImageU8 written = io::load_image(folder / "frame.png").image;
    BlendSettings settings;
    settings.black = {{"left", 0.001}, {"right", 0.001}};
    const ImageU8 shown = corner.frame(name, {"left", "right"}, colourful(61, 47, 2), settings);
    int different = 0;
    for (int i = 0; i < shown.width() * shown.height() * 3; ++i)
      different += shown.data()[i] != written.data()[i];
    EXPECT_EQ(different, 0) << name;
  }
}

TEST(ShowBlend, SurfacesThatOneProjectorHasAloneAndThoseOfAMovingRigAreNotBlended) {
  Corner corner;
  BlendPlan moving = corner.plan("left");
  moving.rig_from_world.reset();
  EXPECT_TRUE(has_moving_surfaces(moving, corner.surfaces));
  EXPECT_EQ(make_blend(moving, corner.scene("left", {"left", "right"})).blend->changed_share(), 0);
  for (Surface& surface : corner.surfaces.surfaces) place_of(surface.geometry)->frame = "rig";
  EXPECT_FALSE(has_moving_surfaces(moving, corner.surfaces));
  for (Surface& surface : corner.surfaces.surfaces)
    place_of(surface.geometry)->frame_from_surface =
        corner.rig_from_world * place_of(surface.geometry)->frame_from_surface;
  const MadeBlend in_rig = make_blend(moving, corner.scene("left", {"far", "left", "right"}));
  EXPECT_GT(in_rig.blend->changed_share(), 0.2);
  EXPECT_EQ(in_rig.neighbours, (ProjectorNames{"far", "right"}));
  for (Surface& surface : corner.surfaces.surfaces) place_of(surface.geometry)->frame = "projector";
  corner.surfaces.surfaces.push_back(pixel_area("sign"));
  EXPECT_EQ(make_blend(moving, corner.scene("left", {"left", "right"})).blend->changed_share(), 0);
}

TEST(ShowBlend, TheOptionsAreCheckedAgainstTheRig) {
  const Corner corner;
  ShowOptions options;
  options.surfaces = "surfaces.json";
  ProjectionOptions standing;
  standing.projector = "left";
  standing.projector_from_world = corner.projector_from_world("left");
  const auto plan = [&](const ProjectionOptions& projection) {
    return plan_blend(options, corner.rig, projection, corner.surfaces);
  };
  EXPECT_FALSE(plan(standing)) << "without a group it is asked for";
  options.blend.emplace().projectors = {"right"};
  EXPECT_EQ(plan(standing)->fixed, (ProjectorNames{"left", "right"}));
  options.blend->projectors = {"all"};
  EXPECT_EQ(plan(standing)->fixed, (ProjectorNames{"far", "left", "right"}));
  options.blend->projectors = {"middle"};
  EXPECT_ERROR(plan(standing), kInput, "the rig has no projector 'middle'");
  options.blend->projectors = {"left"};
  EXPECT_ERROR(plan(standing), kInput, "no other projector than 'left'");
  options.blend->projectors = {"right"};
  options.blend->black = {{"rigth", 0.001}};
  EXPECT_ERROR(plan(standing), kInput, "black of 'rigth'");
  options.blend->black.clear();
  ProjectionOptions moving;
  moving.projector = "left";
  EXPECT_ERROR(plan(moving), kInput, "the rig moves");
  options.blend->projectors = {"off"};
  EXPECT_FALSE(plan(moving));
  options.blend.reset();
  options.group = "stage";
  EXPECT_TRUE(plan(moving)) << "the hosts blend what can be blended";
  EXPECT_TRUE(plan(standing)->fixed.empty());
}

TEST(ShowBlend, ATurnHasThoseWithLightAndWhatMayFollow) {
  const BlendTurn alone = blend_turn({"left"}, std::nullopt, {}, 10);
  EXPECT_TRUE(alone.is_dark) << "it is not announced yet";
  EXPECT_EQ(alone.now, ProjectorNames{"left"});
  EXPECT_TRUE(alone.next.empty());
  EXPECT_TRUE(blend_turn({"left"}, 10.5, {}, 10).is_dark);
  EXPECT_FALSE(blend_turn({"left"}, 10.5, {}, 10.5).is_dark);
  const BlendTurn turn = blend_turn({"left"}, 1, {{"right", 3, 1}, {"far", 11, 2}, {"right", 4, 3}}, 10);
  EXPECT_EQ(turn.now, (ProjectorNames{"left", "right"}));
  EXPECT_EQ(turn.announced, (ProjectorNames{"far", "left", "right"}));
  const std::vector<ProjectorNames> next = {{"far", "left", "right"}, {"far", "left"}, {"left", "right"}};
  EXPECT_EQ(turn.next, next) << "the one that comes, then without one of them each";
  EXPECT_EQ(blend_turn({"left"}, 1, {{"far", 11}}, 11).now, (ProjectorNames{"far", "left"}));
  // Two hosts with two projectors each: a host that fails takes both of its projectors with it.
  const BlendTurn both = blend_turn({"left", "low"}, 1, {{"right", 3, 7}, {"far", 3, 7}}, 10);
  EXPECT_EQ(both.now, (ProjectorNames{"far", "left", "low", "right"}));
  EXPECT_EQ(both.next, (std::vector<ProjectorNames>{{"left", "low"}}));
}

bool waits_for(const std::function<bool()>& is_done) {
  for (int i = 0; i < 2000; ++i) {
    if (is_done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

/// A map that is there before its projectors are: a failure is followed in the next frame.
TEST(BlendMaker, MapsAreMadeBeforeTheyAreNeededAndTheOldOneStaysMeanwhile) {
  Corner corner;
  BlendMaker maker(corner.plan("right"));
  const ProjectorNames all = {"far", "left", "right"}, failed = {"left", "right"}, last = {"far", "right"};
  maker.want(1, corner.scene("right", {}), {all, failed, last});
  ASSERT_TRUE(
      waits_for([&] { return maker.is_ready(all) && maker.is_ready(failed) && maker.is_ready(last); }));
  EXPECT_EQ(maker.find(all)->blend, maker.find(failed)->blend) << "'far' lights no place of 'right'";
  EXPECT_EQ(maker.find(failed)->scene.projectors, failed);
  EXPECT_NE(maker.find(all)->blend, maker.find(last)->blend);
  const auto before = maker.find(all);
  std::get<PlanarSurface>(corner.surfaces.surfaces[0].geometry).frame_from_surface.translation.z() += 0.2;
  maker.want(2, corner.scene("right", {}), {all});
  EXPECT_TRUE(maker.find(all)) << "that of the surfaces before goes on";
  ASSERT_TRUE(waits_for([&] { return maker.is_ready(all); }));
  EXPECT_NE(maker.find(all), before);
  EXPECT_FALSE(maker.find(last)) << "forgotten";
  corner.surfaces.surfaces[0].name.clear();  // cannot be solved
  maker.want(3, corner.scene("right", {}), {all});
  std::optional<std::string> fault;
  ASSERT_TRUE(waits_for([&] { return (fault = maker.take_fault()).has_value(); }));
  EXPECT_TRUE(maker.find(all));
}

TEST(BlendLog, ALineIsReadBackBitForBit) {
  Corner corner;
  const BlendScene scene = corner.scene("left", {"le\"ft,", "right"});
  const auto read = read_blend_line(blend_line(scene), "surfaces.json");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->projectors, scene.projectors);
  EXPECT_EQ(read->rig_from_projector.matrix(), scene.rig_from_projector.matrix());
  EXPECT_EQ(io::surfaces_to_text(read->surfaces), io::surfaces_to_text(scene.surfaces));
  for (const char* wrong :
       {"", "{\"blend\":3}", "{\"blend\":[1],\"rig_from_projector\":[1,0,0,0,0,0,0],\"surfaces\":{}}",
        "{\"blend\":[],\"rig_from_projector\":[1,0,0,0,0,0],\"surfaces\":{}}",
        "{\"blend\":[],\"rig_from_projector\":[2,0,0,0,0,0,0],\"surfaces\":{}}"})
    EXPECT_FALSE(read_blend_line(wrong, "surfaces.json")) << wrong;
}

/// Moves a wall while the show runs.
struct Mover : ShowListener {
  explicit Mover(KeptFrames& sink) : sink_(sink) {}
  /// Ends some frames after the map of the edit, which is made in the background.
  void on_frame(const ShowReport& report) override {
    last = report.metrics;
    if (last.blend && last.blend->changes >= 2 && last.frames >= 20) sink_.wish(device::WindowEvent::kClose);
  }
  std::vector<std::string> commands() override {
    if (last.frames != 3 || moved) return {};
    moved = true;
    return {R"({"do":"nudge","surface":"left wall","point":0,"pixels":[40,25]})"};
  }
  Metrics last;
  bool moved = false;

 private:
  KeptFrames& sink_;
};

TEST(ShowBlend, AnEditIsFollowedAndARecordedRunIsShownAgain) {
  test::Scratch folder;
  const Corner corner;
  io::save_surfaces(folder / "surfaces.json", corner.surfaces);
  io::save_pose(folder / "pose.json", {"rig", "world", {corner.rig_from_world, Mat6::Zero()}});
  ShowOptions options;
  options.projector = "left";
  options.surfaces = folder / "surfaces.json";
  options.pose = folder / "pose.json";
  options.blend.emplace().projectors = {"right"};
  options.output = "none";
  options.control = "off";
  options.fps = 50;
  options.duration_s = 60;
  options.record = folder / "run.log";
  KeptFrames sink(corner.rig.projector("left").projector.size());
  Mover mover(sink);
  const ShowReport report = run(corner.rig, options, sink, &mover);
  ASSERT_TRUE(report.metrics.blend);
  EXPECT_EQ(report.metrics.blend->projectors, (ProjectorNames{"left", "right"}));
  EXPECT_FALSE(report.metrics.blend->is_dark);
  EXPECT_GE(report.metrics.blend->changes, 2u) << "the first one, and after the edit";
  EXPECT_GT(report.metrics.blend->last_change_s, 0);
  const ReplayReport again = replay(corner.rig, options, folder / "run.log");
  EXPECT_GT(again.frames, 10u);
  EXPECT_EQ(again.equal, again.frames);
  options.blend->black = {{"right", 0.01}};
  EXPECT_EQ(replay(corner.rig, options, folder / "run.log").equal, 0u) << "the blend is in the frames";
  options.blend->projectors = {"right"};
  options.group = "stage";
  EXPECT_ERROR(run(corner.rig, options), kInput, "the hosts announce their projectors");
}

}  // namespace
}  // namespace procam::show
