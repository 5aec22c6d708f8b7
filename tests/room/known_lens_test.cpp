/// Known lenses that are wrong: none makes walls that are silently wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "procam/room/calibrate_room.hpp"
#include "room_cases.hpp"

namespace procam::test {
namespace {

constexpr int kLensStep = 44;

NumericWorld corner() {
  return numeric_world(1, 2, 1);
}
NumericWorld plane() {
  return numeric_world(1, 2, 1, flat_room());
}
/// A ball on a wall: little more than a plane.
NumericWorld ball_on_a_wall() {
  NumericRoom room = flat_room();
  room.balls.push_back({{0.1, 0.05, 2.05}, 0.2});
  return numeric_world(1, 2, 1, room);
}
NumericWorld one_position_room() {
  return numeric_world(1, 1, 1);
}

/// By how much the given lens is off; nothing of this is stated.
struct WrongLens {
  double focal = 1, centre_px = 0;
  bool without_distortion = false;
};

Camera changed(Camera lens, const WrongLens& wrong) {
  lens.intrinsics.fx *= wrong.focal;
  lens.intrinsics.fy *= wrong.focal;
  lens.intrinsics.cx += wrong.centre_px;
  lens.intrinsics.cy -= 0.6 * wrong.centre_px;
  if (wrong.without_distortion) lens.distortion = NoDistortion{};
  return lens;
}

struct Solved {
  NumericWorld world;
  room::RoomCalibration result;
  double error = 0;  ///< of the walls, metres
};

Solved solve(const NumericWorld& world, const WrongLens& wrong, std::optional<double> sigma,
             unsigned seed = 4) {
  const room::RoomPoints points = read_points(world, kLensStep, {0.05, 0.01, seed});
  room::RoomOptions options = known_cameras(world);
  options.cameras["camera"] = {changed(world.cameras[0], wrong), {}, sigma};
  options.distances = {wall_distance(world, points)};
  if (world.positions.size() == 1) {
    const Projector& projector = world.projectors[0].projector;
    room::LensSheet& sheet = options.projectors["projector"];
    sheet.throw_ratio = room::Estimate{projector.throw_ratio(), 1e-3 * projector.throw_ratio()};
    sheet.shift_x = room::Estimate{projector.lens_shift().x(), 1e-3};
    sheet.shift_y = room::Estimate{projector.lens_shift().y(), 1e-3};
  }
  Solved out{world, room::calibrate_room(points, options), 0};
  out.error = wall_error(world, out.result.rig);
  return out;
}

struct LensCase {
  const char* name;
  NumericWorld (*world)();
  WrongLens wrong;
  const char* remark;  ///< that a solved room carries; "|" separates what may be
};

std::ostream& operator<<(std::ostream& out, const LensCase& test) {
  return out << test.name;
}

class UnstatedLens : public ::testing::TestWithParam<LensCase> {};

/// A lens of which nothing is stated: the walls' error is within three stated deviations, or the room is refused.
TEST_P(UnstatedLens, IsNeverSilentlyWrong) {
  const LensCase& test = GetParam();
  try {
    const Solved solved = solve(test.world(), test.wrong, std::nullopt);
    EXPECT_LE(solved.error, 3 * solved.result.wall_sigma_95);
    const std::string remarks = test.remark;
    bool found = false;
    for (std::size_t at = 0; at <= remarks.size();) {
      const std::size_t end = std::min(remarks.find('|', at), remarks.size());
      found |= solved.result.diagnostics.find(remarks.substr(at, end - at)) != nullptr;
      at = end + 1;
    }
    EXPECT_TRUE(found) << "none of " << remarks << "; wall sigma " << solved.result.wall_sigma << " m, error "
                       << solved.error << " m";
  } catch (const Error& error) {
    EXPECT_FALSE(error.next().empty()) << error.what();
  }
}

const char kDisagrees[] = "known_lens_disagrees", kUnchecked[] = "lens_unchecked",
           kEither[] = "known_lens_disagrees|lens_unchecked";

INSTANTIATE_TEST_SUITE_P(Lenses, UnstatedLens,
                         ::testing::Values(LensCase{"Shorter3", corner, {0.97}, kEither},
                                           LensCase{"Shorter10", corner, {0.9}, kDisagrees},
                                           LensCase{"Longer10", corner, {1.1}, kDisagrees},
                                           LensCase{"Shorter30", corner, {0.7}, kDisagrees},
                                           LensCase{"Longer30", corner, {1.3}, kDisagrees},
                                           LensCase{"Centre", corner, {1, 40}, kDisagrees},
                                           LensCase{"NoDistortion", corner, {1, 0, true}, kDisagrees},
                                           LensCase{"All", corner, {1.07, 30, true}, kDisagrees},
                                           LensCase{"PlaneRight", plane, {1}, kUnchecked},
                                           LensCase{"Plane10", plane, {1.1}, kUnchecked},
                                           LensCase{"Plane30", plane, {1.3}, kUnchecked},
                                           LensCase{"Ball10", ball_on_a_wall, {1.1}, kEither},
                                           LensCase{"OnePosition10", one_position_room, {0.9}, kUnchecked},
                                           LensCase{"OnePosition30", one_position_room, {1.3}, kUnchecked}),
                         [](const auto& info) { return std::string(info.param.name); });

/// The light corrects a lens that it contradicts.
TEST(KnownLens, IsCorrectedByTheLight) {
  const Solved given = solve(corner(), {1.1}, 0.0), corrected = solve(corner(), {1.1}, std::nullopt);
  EXPECT_LT(corrected.error, given.error / 3);
  const Solved sheet = solve(corner(), {1.1}, 0.1);
  EXPECT_LT(sheet.error, given.error / 3);
  EXPECT_LE(sheet.error, 3 * sheet.result.wall_sigma_95);
  EXPECT_GT(sheet.result.rig.covariance.sigma("camera.fx"), 1);
}

/// The right lens is as good as when it is stated to be exact, though its stated deviation is that of a lens that may
/// be wrong.
TEST(KnownLens, KeepsTheRightOne) {
  for (const auto& world : {corner, plane}) {
    const Solved exact = solve(world(), {}, 0.0), unstated = solve(world(), {}, std::nullopt);
    EXPECT_EQ(parameters_of(unstated.result.rig.cameras[0].camera), parameters_of(world().cameras[0]));
    EXPECT_NEAR(unstated.error, exact.error, 1e-6);
    EXPECT_GT(unstated.result.wall_sigma, 3 * exact.result.wall_sigma);
    EXPECT_EQ(exact.result.diagnostics.find("known_lens_disagrees"), nullptr);
    EXPECT_EQ(unstated.result.diagnostics.find("known_lens_disagrees"), nullptr);
  }
}

/// A lens that is stated to be exact, and is not: a failure.
TEST(KnownLens, ThatIsStatedAndWrongFails) {
  for (const WrongLens& wrong : {WrongLens{0.9}, WrongLens{1.3}, WrongLens{1, 40}, WrongLens{1, 0, true}}) {
    const Solved solved = solve(corner(), wrong, 0.0);
    EXPECT_NE(solved.result.diagnostics.find("known_lens_disagrees"), nullptr)
        << wrong.focal << " " << wrong.centre_px;
    EXPECT_TRUE(solved.result.diagnostics.failed());
  }
}

/// The same where it is stated to half a percent: the solution may move there by many of these.
TEST(KnownLens, ThatIsFartherOffThanStatedFails) {
  for (const double focal : {0.8, 0.9, 1.1, 1.2}) {
    try {
      const Solved solved = solve(corner(), {focal}, 0.005);
      EXPECT_TRUE(solved.result.diagnostics.failed())
          << focal << ": " << solved.error << " m, stated " << solved.result.wall_sigma << " m";
    } catch (const Error& error) {
      EXPECT_NE(error.kind(), ErrorKind::kUnsupported) << error.what();
    }
  }
}

}  // namespace
}  // namespace procam::test
