/// calibrate-projector --points as a program: a room measured with a tape and clicked with a cross-hair, the
/// projector known to be true.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

#include "e2e/tool_runner.hpp"
#include "procam/io/rig_file.hpp"
#include "support/lopsided.hpp"

namespace procam::test {
namespace {

/// A room in metres, its corner the origin, z up: a back wall 3.4 m from the projector, a side wall, and what
/// stands before them. The office projector hangs from the ceiling, upside down, so that its lens shift goes
/// down: its light covers 1.7 x 1.3 m of the back wall.
struct ClickedRoom {
  Projector projector{Camera{{1024, 768}, {2010, 2003, 671, 696, 0}, NoDistortion{}}};
  Pose room_from_projector{so3_exp<double>(Vec3(1.52, 0.06, -0.09)) * so3_exp<double>(Vec3(0.03, -0.02, 3.1)),
                           Vec3(1.9, 0.2, 2.35)};

  struct Mark {
    const char* name;
    Vec3 in_room;
  };
  std::vector<Mark> marks;

  /// Each where the light of a pixel meets something at that depth: what a person would choose to aim at.
  ClickedRoom() {
    aim("wall upper left", {62, 700}, 3.4);
    aim("wall upper right", {960, 715}, 3.4);
    aim("wall lower left", {90, 60}, 3.4);
    aim("wall lower right", {985, 96}, 3.4);
    aim("picture frame", {470, 380}, 3.38);
    aim("shelf left", {230, 540}, 2.9);
    aim("shelf right", {640, 560}, 2.9);
    aim("shelf foot", {250, 150}, 2.85);
    aim("cupboard", {845, 330}, 2.6);
    aim("cupboard top", {820, 610}, 2.62);
    aim("chair", {560, 110}, 2.1);
    aim("lamp", {380, 655}, 1.8);
    aim("table edge", {130, 330}, 1.9);
    aim("table corner", {720, 205}, 1.75);
  }
  void aim(const char* name, const Vec2& pixel, double depth) {
    const Ray ray = *projector.emit(pixel);
    marks.push_back({name, room_from_projector * Vec3(ray.direction * (depth / ray.direction.z()))});
  }

  Rig truth() const {
    Rig rig;
    rig.projectors.push_back({"projector", projector, room_from_projector});
    return rig;
  }

  /// What is written down: 1 mm of the tape in each coordinate (0.7 px at 2.9 m), rounded to it; the
  /// cross-hair moves by whole pixels and the hand puts it 0.7 px off.
  struct Click {
    std::string name;
    Vec3 in_room;
    Vec2 pixel;
  };
  std::vector<Click> clicked(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> gauss;
    std::vector<Click> clicks;
    for (const Mark& mark : marks) {
      const Vec2 at = *projector.project(room_from_projector.inverse() * mark.in_room);
      Click click{mark.name, mark.in_room, at};
      for (int i = 0; i < 3; ++i)
        click.in_room[i] = std::round(1e3 * (mark.in_room[i] + 0.001 * gauss(random))) / 1e3;
      for (int i = 0; i < 2; ++i) click.pixel[i] = std::round(at[i] + 0.7 * gauss(random));
      clicks.push_back(click);
    }
    return clicks;
  }
};

class PointsRoute : public ::testing::Test {
 protected:
  ToolRun calibrate(const std::vector<ClickedRoom::Click>& clicks, const std::string& more = "") {
    std::ofstream list(folder_ / "room.csv");
    list << "# from the corner by the door\nx, y, z, u, v, name\n";
    for (const auto& click : clicks) {
      char line[160];
      std::snprintf(line, sizeof line, "%.3f, %.3f, %.3f, %.0f, %.0f, %s\n", click.in_room.x(),
                    click.in_room.y(), click.in_room.z(), click.pixel.x(), click.pixel.y(),
                    click.name.c_str());
      list << line;
    }
    list.close();
    io::save_rig(folder_ / "truth.json", room_.truth());
    return run_tool("calibrate-projector", "--points " + (folder_ / "room.csv").string() +
                                               " --projector-size 1024x768 --wall 3m --truth " +
                                               (folder_ / "truth.json").string() + " --json -o " +
                                               rig().string() + " " + more);
  }
  std::filesystem::path rig() const { return folder_ / "rig.json"; }

  /// Those of the room's marks, in that order.
  static std::vector<ClickedRoom::Click> only(const std::vector<ClickedRoom::Click>& all,
                                              std::initializer_list<std::size_t> which) {
    std::vector<ClickedRoom::Click> some;
    for (const std::size_t i : which) some.push_back(all[i]);
    return some;
  }

  ClickedRoom room_;
  ScratchFolder folder_;
};

/// Ten rooms of 14 points. Ten parameters each with sigma from 18 redundant equations: 0.8 % of exact ones
/// lie outside 3 sigma (Student's t), 0.8 of 100, in clumps since a room's are correlated; six have a chance
/// of about 1e-3. The light's squared error over the predicted averages 1.1 over rooms, and as some four
/// combinations of the parameters matter on a wall its mean over ten has a spread of about 0.25.
TEST_F(PointsRoute, FindsTheProjectorOfARoomWithinItsSigmas) {
  double actual2 = 0, predicted2 = 0;
  int inside = 0, total = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ToolRun run = calibrate(room_.clicked(seed));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json said = run.json();
    actual2 += std::pow(said.at("truth").at("rms_mm").get<double>(), 2);
    predicted2 += std::pow(said.at("wall").at("rms_mm").get<double>(), 2);
    inside += said.at("truth").at("parameters_inside_3_sigma").get<int>();
    total += said.at("truth").at("parameters").get<int>();
    const Rig found = io::load_rig(rig());
    EXPECT_TRUE(found.quality.passed()) << seed;
  }
  std::printf("ten rooms of 14 points: light at 3 m off by %.2f mm rms, predicted %.2f; %d of %d inside\n",
              std::sqrt(actual2 / 10), std::sqrt(predicted2 / 10), inside, total);
  EXPECT_EQ(total, 100);
  EXPECT_GE(inside, 95);
  EXPECT_GT(actual2, 0.3 * predicted2);
  EXPECT_LT(actual2, 2.2 * predicted2);
  EXPECT_LT(std::sqrt(actual2 / 10), 4);  // millimetres: as good as the tape, not only as was said
}

/// Two names mixed up when the list was written: both are named and rejected, and the rest is the answer.
TEST_F(PointsRoute, NamesPairsThatWereMixedUp) {
  std::vector<ClickedRoom::Click> clicks = room_.clicked(21);
  std::swap(clicks[6].pixel, clicks[8].pixel);
  const ToolRun run = calibrate(clicks);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("'shelf right' is rejected"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("'cupboard' is rejected"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("'lamp'"), std::string::npos) << run.err;
  const nlohmann::json said = run.json();
  EXPECT_GE(said.at("truth").at("parameters_inside_3_sigma"), 9);
  EXPECT_LT(said.at("truth").at("rms_mm").get<double>(), 3 * said.at("wall").at("rms_mm").get<double>());

  // Kept when the user says so, and such a rig is marked.
  const ToolRun kept = calibrate(clicks, "--keep-outliers");
  EXPECT_EQ(kept.exit_code, 5) << kept.err;
  EXPECT_EQ(kept.err.find("is rejected"), std::string::npos) << kept.err;
  EXPECT_GT(kept.json().at("rms_px").get<double>(), 50);
}

/// Five, and seven all on the back wall: no number comes out, the way out is told, nothing is written.
TEST_F(PointsRoute, RefusesFewPairsWithoutADataSheet) {
  const std::vector<ClickedRoom::Click> five = only(room_.clicked(31), {0, 3, 5, 8, 11});
  room_.marks.resize(4);
  room_.aim("switch", {480, 360}, 3.4);
  room_.aim("socket", {700, 200}, 3.4);
  room_.aim("nail", {300, 520}, 3.4);
  for (const auto& few : {five, room_.clicked(31)}) {
    const ToolRun run = calibrate(few);
    EXPECT_EQ(run.exit_code, 4) << run.err;
    EXPECT_NE(run.err.find("throw ratio"), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(rig()));
  }
}

/// Five pairs and what the data sheet says, its numbers off by one of their sigmas. Three pairs are on the
/// lines of any of several wrong places: the right one explains all five.
TEST_F(PointsRoute, TakesFiveWithADataSheet) {
  const double ratio = room_.projector.throw_ratio() + 0.02;
  const Vec2 shift = room_.projector.lens_shift() - Vec2(0.01, -0.01);
  char sheet[160];
  std::snprintf(sheet, sizeof sheet, "--throw-ratio %.4f+-0.02 --lens-shift %.4f+-0.01,%.4f+-0.01", ratio,
                shift.x(), shift.y());
  double actual2 = 0, predicted2 = 0;
  int inside = 0;
  for (std::uint64_t seed = 41; seed <= 50; ++seed) {
    const ToolRun run = calibrate(only(room_.clicked(seed), {0, 3, 5, 8, 11}), sheet);
    ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 5) << run.err;
    const nlohmann::json said = run.json();
    actual2 += std::pow(said.at("truth").at("rms_mm").get<double>(), 2);
    predicted2 += std::pow(said.at("wall").at("rms_mm").get<double>(), 2);
    inside += said.at("truth").at("parameters_inside_3_sigma").get<int>();
  }
  std::printf(
      "five points and a data sheet: light at 3 m off by %.2f mm rms, predicted %.2f; %d of 100 inside\n",
      std::sqrt(actual2 / 10), std::sqrt(predicted2 / 10), inside);
  EXPECT_GE(inside, 95);
  EXPECT_LT(actual2, 3 * predicted2);
  EXPECT_LT(std::sqrt(predicted2 / 10), 15);
}

/// A sheet that states no tolerances is taken to 2 % of each; four points leave the lens to it.
TEST_F(PointsRoute, TakesTheSheetsNumbersToTwoPercent) {
  char sheet[160];
  const Vec2 shift = room_.projector.lens_shift();
  std::snprintf(sheet, sizeof sheet, "--throw-ratio %.4f --lens-shift %.4f,%.4f",
                room_.projector.throw_ratio(), shift.x(), shift.y());
  const ToolRun run = calibrate(only(room_.clicked(51), {0, 3, 5, 11}), sheet);
  ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 5) << run.err;
  const nlohmann::json sigma = run.json().at("projector").at("sigma");
  const auto is_up_to = [&](const char* name, double largest) {
    EXPECT_LE(sigma.at(name), 1.001 * largest) << name;
    EXPECT_GE(sigma.at(name), 0.3 * largest) << name;
  };
  is_up_to("fx", 0.02 * 2010);
  is_up_to("cx", 0.02 * 1024);
  is_up_to("cy", 0.02 * 768);
}

/// The room's projector has pixels that are not square, by 7 px of focal length.
TEST_F(PointsRoute, HoldsPixelsSquareWhenTold) {
  const auto fx_over_fy = [&](const std::string& more) {
    const nlohmann::json lens = calibrate(room_.clicked(62), more).json().at("projector");
    return lens.at("fx").get<double>() / lens.at("fy").get<double>();
  };
  EXPECT_GT(std::abs(fx_over_fy("") - 1), 1e-3);
  EXPECT_NEAR(fx_over_fy("--square-pixels"), 1, 1e-5);
}

}  // namespace
}  // namespace procam::test
