/// One photograph a view that shows a printed and a projected chessboard together: simulated sessions, and
/// the captures of an independent world.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "procam/calibrate/calibrate.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/shown_file.hpp"
#include "procam/session/reader.hpp"
#include "procam/simulate/session.hpp"
#include "support/test_data.hpp"
#include "tool_runner.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A chessboard in full light, its first inner corner at `first` (halves: between pixels).
ImageU8 frame_with(ImageSize size, const Chessboard& layout, const Vec2& first) {
  ImageU8 frame(size, 1, 255);
  const int step = int(layout.square_size), left = int(first.x() + 0.5) - step,
            top = int(first.y() + 0.5) - step;
  for (int y = 0; y < (layout.rows + 1) * step; ++y)
    for (int x = 0; x < (layout.columns + 1) * step; ++x)
      if ((x / step + y / step) % 2 == 0) frame.at(left + x, top + y) = 0;
  return frame;
}

/// Eight views, two positions of the projected board in turn; in view 5 the projector still shows view 4's.
struct SimulatedViews {
  static constexpr std::size_t kViews = 8, kStale = 5;
  const Chessboard projected{7, 5, 40};
  const Vec2 firsts[2] = {Vec2(231.5, 180.5), Vec2(531.5, 380.5)};
  simulate::SimulatedSession session;
  io::ShownInViews shown;

  SimulatedViews(simulate::Level level, std::uint64_t seed, const fs::path& folder) {
    const ImageSize size = simulate::projector_size(level);
    const Eigen::AlignedBox2d lit(firsts[0] - Vec2(60, 60), firsts[1] + Vec2(7 * 40 + 20, 5 * 40 + 20));
    session = simulate::make_session(level, seed, lit);
    session.capture.samples_per_axis = 1;  // for speed
    std::vector<ImageU8> frames;
    for (const Vec2& first : firsts) frames.push_back(frame_with(size, projected, first));
    shown.upright = true;
    shown.boards["second"] = {projected.columns, projected.rows, firsts[1], projected.square_size};
    io::save_image(folder / "projected_0.png", frames[0]);
    for (std::size_t v = 0; v < kViews; ++v) {
      const std::string name = "view_" + std::to_string(v) + ".png";
      const std::size_t in_light = (v == kStale ? v - 1 : v) % 2;
      io::save_image(folder / name, simulate::capture_view(session, v, {frames[in_light]}).front());
      shown.views[name] = v % 2 == 0 ? "projected_0.png" : "second";
    }
    session.views.resize(kViews);
    io::save_shown(folder / "shown.json", shown);
    io::save_rig(folder / "truth.json", session.rig());
  }
};

TEST(ShownViews, CalibrateAProjectorAndNameTheStaleOne) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "session");
  const SimulatedViews views(simulate::Level::kEasy, 3, scratch / "session");
  io::SessionInfo stated;
  stated.board = views.session.board().layout;
  const session::SessionContents contents = session::read(session::open(scratch / "session", {stated, {}}));
  const Correspondences& data = contents.correspondences;
  ASSERT_EQ(data.views.size(), SimulatedViews::kViews);
  for (const View& view : data.views) {
    EXPECT_GE(view.observations[0].size(), 60u) << view.name;  // of 70
    EXPECT_GE(view.light_points.size(), 30u) << view.name;     // of 35
  }
  ASSERT_EQ(contents.view_images.size(), data.views.size());
  EXPECT_EQ(contents.view_images[3].view, data.views[3].name);
  EXPECT_EQ(contents.view_images[3].camera, "camera");
  const calibrate::CalibrationResult result = calibrate::calibrate_rig(data);
  for (const calibrate::ViewResult& view : result.views)
    EXPECT_EQ(view.note.find("what was shown in view view_4: a stale frame") != std::string::npos,
              view.name == "view_5")
        << view.name << ": " << view.note;
  // Where the light falls on the boards, as the rig's own camera locates them.
  const auto on_board = [](const RigProjector& device, const Pose& rig_from_board, const Vec2& pixel) {
    const auto bearing = device.projector.inverse_camera.unproject(pixel);
    const auto hit =
        intersect(device.rig_from_projector * Ray{Vec3::Zero(), *bearing}, Plane::of_xy(rig_from_board));
    return Vec2((rig_from_board.inverse() * *hit).head<2>());
  };
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (const LightPoint& light : data.views[v].light_points) {
      const Vec2 truth = on_board(views.session.rig().projector(), views.session.views[v].rig_from_board,
                                  light.projector_pixel);
      sum += (on_board(result.rig.projector(), result.views[v].rig_from_board, light.projector_pixel) - truth)
                 .squaredNorm();
      ++count;
    }
  const double error_mm = 1e3 * std::sqrt(sum / count);
  RecordProperty("error_mm", std::to_string(error_mm));
  std::printf("error on the boards %.3f mm\n", error_mm);
  // A camera pixel is 0.6 to 1.1 mm on these boards, and corners have 0.02 px: a tenth of a pixel is too
  // much.
  EXPECT_LT(error_mm, 0.1);

  // The same by the tool, with shown.json found beside the photographs.
  const ToolRun run = run_tool("calibrate-projector", "--json --captures " + (scratch / "session").string() +
                                                          " --board chessboard:10x7:30mm -o " +
                                                          (scratch / "rig.json").string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("stale frame"), std::string::npos);
  EXPECT_TRUE(fs::exists(scratch / "rig.json"));
}

/// Photographs of one view whose print cannot be read in the projector's light: NAME_unlit.png beside NAME.png shows it.
TEST(ShownViews, ReadThePrintInThePhotographWithoutLight) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "session";
  fs::create_directory(folder);
  SimulatedViews views(simulate::Level::kEasy, 3, folder);
  const ImageU8 unlit =
      simulate::capture_view(views.session, 0, {ImageU8(simulate::projector_size(simulate::Level::kEasy), 1)})
          .front();
  ImageU8 covered = io::to_gray(io::load_image(folder / "view_0.png").image);
  const std::vector<Observation> corners = simulate::board_in_camera(views.session.views[0]);
  for (const Observation& corner : corners)  // a dark spot on each corner of the print
    for (int y = -5; y <= 5; ++y)
      for (int x = -5; x <= 5; ++x) covered.at(int(corner.pixel.x()) + x, int(corner.pixel.y()) + y) = 0;
  io::save_image(folder / "view_0.png", covered);
  io::SessionInfo stated;
  stated.board = views.session.board().layout;
  const auto printed = [&] {
    const auto contents = session::read(session::open(folder, {stated, {}}));
    const auto& all = contents.correspondences.views;
    const auto view = std::find_if(all.begin(), all.end(), [](const View& v) { return v.name == "view_0"; });
    return view == all.end() ? std::vector<Observation>() : view->observations[0];
  };
  EXPECT_TRUE(printed().empty());
  io::save_image(folder / "view_0_unlit.png", unlit);
  const std::vector<Observation> found = printed();
  ASSERT_EQ(found.size(), corners.size());
  for (const Observation& o : found)
    EXPECT_LT((o.pixel - corners[std::size_t(o.point)].pixel).norm(), 0.2) << o.point;
}

/// White paper at 1.6 times full scale: the remark, and none of the views exposed as they should be.
TEST(ShownViews, NameOverexposedPhotographs) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "session";
  fs::create_directory(folder);
  SimulatedViews views(simulate::Level::kEasy, 6, folder);
  views.session.capture.brightest_grey = 1.6 * 255;
  const ImageU8 shown =
      frame_with(simulate::projector_size(simulate::Level::kEasy), views.projected, views.firsts[0]);
  for (const std::size_t v : {2u, 4u})
    io::save_image(folder / ("view_" + std::to_string(v) + ".png"),
                   simulate::capture_view(views.session, v, {shown}).front());
  io::SessionInfo stated;
  stated.board = views.session.board().layout;
  const auto contents = session::read(session::open(folder, {stated, {}}));
  std::string named;
  for (const Diagnostic& remark : contents.correspondences.diagnostics.items)
    if (remark.code == "overexposed") named += remark.message.substr(0, remark.message.find(':')) + ";";
  EXPECT_NE(named.find("view_2"), std::string::npos) << named;
  EXPECT_NE(named.find("view_4"), std::string::npos) << named;
  EXPECT_EQ(std::count(named.begin(), named.end(), ';'), 2) << named;
}

/// A projected chessboard with two odd counts looks the same after half a turn: ":upright" states the order, from
/// making the frames to the rig.
TEST(ShownViews, CalibrateByABoardOfOddCountsThatIsStatedUpright) {
  const ScratchFolder scratch;
  const std::string session = (scratch / "s").string(), rig = (scratch / "rig.json").string();
  const ToolRun made =
      run_tool("simulate-captures",
               "--seed 2 --level easy --views 6 --pattern chessboard:9x7:64px:upright -o " + session);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ToolRun run = run_tool("calibrate-projector", "--json --accept 100mm --captures " + session +
                                                          " --truth " + session + "/truth.json -o " + rig);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Rig truth = io::load_rig(scratch / "s" / "truth.json"), found = io::load_rig(rig);
  const Vec2 off(found.projector().projector.inverse_camera.intrinsics.cx -
                     truth.projector().projector.inverse_camera.intrinsics.cx,
                 found.projector().projector.inverse_camera.intrinsics.cy -
                     truth.projector().projector.inverse_camera.intrinsics.cy);
  EXPECT_LT(off.norm(), 10);
  EXPECT_LT(
      (found.projector().rig_from_projector.translation - truth.projector().rig_from_projector.translation)
          .norm(),
      0.01);
}

TEST(ShownViews, RefusesWhatCannotBeRead) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "s");
  const auto refusal = [&](const std::string& flags) {
    const ToolRun run = run_tool("calibrate-projector", "--captures " + (scratch / "s").string() + " " +
                                                            flags + " -o " + (scratch / "rig.json").string());
    EXPECT_EQ(run.exit_code, 3) << run.err;
    return run.err;
  };
  io::save_image(scratch / "s" / "view_0.png", ImageU8(64, 48, 1, 90));
  io::save_image(scratch / "frame.png", frame_with({320, 240}, {7, 5, 20}, Vec2(79.5, 59.5)));
  const std::string frame = "--shown " + (scratch / "frame.png").string();
  EXPECT_NE(refusal("--board chessboard:9x6:36mm " + frame).find("--upright"), std::string::npos);
  EXPECT_NE(refusal("--board chessboard:5x7:36mm --upright " + frame).find("same counts"), std::string::npos);
  EXPECT_NE(refusal("--board chessboard:9x6:36mm --upright --projector-size 640x480 " + frame)
                .find("320x240, the projector's frame 640x480"),
            std::string::npos);
  io::ShownInViews shown;
  shown.upright = true;
  shown.views["view_7"] = "frame.png";
  io::save_image(scratch / "s" / "frame.png", frame_with({320, 240}, {7, 5, 20}, Vec2(79.5, 59.5)));
  io::save_shown(scratch / "s" / "shown.json", shown);
  EXPECT_NE(refusal("--board chessboard:9x6:36mm").find("has no photograph"), std::string::npos);
}

/// The captures of an independent world; `level` is "paper" or "hard".
class WorldOfPhotographs : public ::testing::TestWithParam<const char*> {};

Pose pose_of(const json& r, const json& t) {
  Mat3 rotation;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) rotation(i, j) = r[std::size_t(i)][std::size_t(j)];
  return Pose(Eigen::Quaterniond(rotation), 1e-3 * Vec3(t[0], t[1], t[2]));
}

Camera lens_of(const json& lens) {
  const json &k = lens["K"], &d = lens["dist"];
  return {{lens["size"][0], lens["size"][1]},
          {k[0][0], k[1][1], k[0][2], k[1][2], k[0][1]},
          BrownConrady{{d[0], d[1], d[2], d[3], d[4]}}};
}

/// shown.json as its user would write it: what was shown in each view.
void write_shown(const fs::path& world, const fs::path& file) {
  const json set = json::parse(slurp(world / "set.json"));
  io::ShownInViews shown;
  shown.upright = true;
  for (const json& view : set["views"]) {
    const json& board = set["projected"][view["projected"].get<std::size_t>()];
    const std::string name = board["image"];
    shown.boards[name] = {board["inner_corners"][0], board["inner_corners"][1],
                          Vec2(board["first_corner"][0], board["first_corner"][1]), board["step_px"]};
    shown.views[view["image"]] = name;
  }
  io::save_shown(file, shown);
}

TEST_P(WorldOfPhotographs, IsCalibratedAsItIs) {
  const std::string folder = "worlds/chess2_" + std::string(GetParam());
  PROCAM_REQUIRE_TEST_DATA(folder + "/truth.json");
  const fs::path world = test_data() / folder;
  const json truth = json::parse(slurp(world / "truth.json"));
  const ScratchFolder scratch;
  session::ShownFlags shown{world / "projected_0.png", true};  // one frame was shown in all views
  if (fs::exists(world / "projected_1.png")) {
    shown = {scratch / "shown.json", false};
    write_shown(world, shown.shown);
  }
  io::SessionInfo stated;
  stated.board = Chessboard{9, 6, 0.036};
  stated.projector_size = ImageSize{1024, 768};
  const session::SessionPlan plan = session::open(world, {stated, shown});
  const Correspondences data = session::read(plan).correspondences;
  ASSERT_EQ(data.views.size(), truth["views"].size()) << "a view without its printed board";

  // Detections against the truth.
  double print = 0, light = 0;
  std::size_t prints = 0, lights = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const json& true_view = truth["views"][v];
    ASSERT_EQ(data.views[v].name, true_view["name"].get<std::string>());
    EXPECT_GE(data.views[v].light_points.size(), 30u) << data.views[v].name;     // of 35
    EXPECT_GE(data.views[v].observations[0].size(), 40u) << data.views[v].name;  // of 54
    for (const Observation& o : data.views[v].observations[0]) {
      const json& at = true_view["camera_corners"][std::size_t(o.point)];
      print += (o.pixel - Vec2(at[0], at[1])).squaredNorm();
      ++prints;
    }
    for (const LightPoint& point : data.views[v].light_points) {
      const json& at = true_view["projected_camera"][std::size_t(point.point)];
      light += (point.camera_pixel - Vec2(at[0], at[1])).squaredNorm();
      ++lights;
    }
  }
  std::printf("%s: printed corners %.3f px rms, projected %.3f px\n", GetParam(),
              std::sqrt(print / (2 * double(prints))), std::sqrt(light / (2 * double(lights))));
  EXPECT_LT(std::sqrt(print / (2 * double(prints))), 0.15);
  EXPECT_LT(std::sqrt(light / (2 * double(lights))), 0.15);

  Rig true_rig;
  true_rig.cameras.push_back({"camera", lens_of(truth["camera"]), Pose()});
  true_rig.projectors.push_back(
      {"projector", Projector{lens_of(truth["projector"])}, pose_of(truth["R"], truth["t"]).inverse()});
  const calibrate::CalibrationResult result = calibrate::calibrate_rig(data);

  // The bound: a bundle adjustment of the same detections, with the lenses' true terms, begun at the truth
  // and without the stale view.
  calibrate::BundleState state;
  state.lenses = {true_rig.camera().camera, true_rig.projector().projector.inverse_camera};
  state.device_from_rig = {Pose(), true_rig.projector().rig_from_projector.inverse()};
  state.points_in_board = points_in_board(data.board);
  Correspondences good = data;
  simulate::SimulatedSession session;
  for (std::size_t v = 0; v < good.views.size(); ++v) {
    const json& true_view = truth["views"][v];
    state.rig_from_board.push_back(
        pose_of(true_view["camera_from_board"]["R"], true_view["camera_from_board"]["t"]));
    const bool stale = true_view["outlier"];
    if (stale) good.views[v].light_points.clear();
    EXPECT_EQ(result.views[v].note.find("a stale frame") != std::string::npos, stale)
        << data.views[v].name << ": " << result.views[v].note;
  }
  calibrate::UsedMask used = calibrate::use_all(good);
  for (int v = 0; v < int(good.views.size()); ++v)
    for (int d = 0; d < 2; ++d)
      for (const calibrate::Measurement& m : calibrate::measurements_of(good, v, d)) {
        const auto r = calibrate::reprojection_residual(state, m);
        used[std::size_t(v)][std::size_t(d)][std::size_t(m.index)] = r && r->norm() < 1;
      }
  calibrate::BundleOptions bundle;
  bundle.held = {{"skew"}, {}};
  bundle.noise.resize(2);
  bundle.hold_pose = {true, false};
  bundle.huber_sigmas = 0;
  const calibrate::BundleState solved = calibrate::bundle_adjust(good, used, state, bundle).state;

  // Where the light of the projected boards falls on the boards themselves, as the rig's own camera locates
  // them: millimetres in the board's frame.
  const auto error_mm = [&](const Camera& lens, const Pose& rig_from_projector, const auto& rig_from_board) {
    double sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < good.views.size(); ++v)
      for (const LightPoint& point : good.views[v].light_points) {
        const auto bearing = lens.unproject(point.projector_pixel);
        const auto hit =
            intersect(rig_from_projector * Ray{Vec3::Zero(), *bearing}, Plane::of_xy(rig_from_board(v)));
        const json& at = truth["views"][v]["projected_board"][std::size_t(point.point)];
        const Vec3 on_board = rig_from_board(v).inverse() * *hit;
        sum += (1e3 * on_board.head<2>() - Vec2(at[0], at[1])).squaredNorm(), ++count;
      }
    return std::sqrt(sum / count);
  };
  const double error =
      error_mm(result.rig.projector().projector.inverse_camera, result.rig.projector().rig_from_projector,
               [&](std::size_t v) { return result.views[v].rig_from_board; });
  const double bound = error_mm(solved.lenses[1], solved.device_from_rig[1].inverse(),
                                [&](std::size_t v) { return solved.rig_from_board[v]; });
  std::printf("%s: error on the boards %.3f mm, bound %.3f mm\n", GetParam(), error, bound);
  EXPECT_LT(error, 1.3 * bound);
}

INSTANTIATE_TEST_SUITE_P(Levels, WorldOfPhotographs, ::testing::Values("paper", "hard"));

}  // namespace
}  // namespace procam::test
