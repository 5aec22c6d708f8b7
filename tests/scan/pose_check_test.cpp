/// Known poses with the usual mistakes.
#include <gtest/gtest.h>

#include "procam/scan/merge.hpp"
#include "support/expect_error.hpp"
#include "true_room.hpp"

namespace procam::scan::test {
namespace {

/// Three stations of the alcove, their poses in a world that is moved away and turned, known to 10 mm and 0.5 degrees.
std::vector<Station> stations_in_a_world() {
  std::mt19937 random(31);
  const Rig truth = true_rig();
  SeenStations seen = see(alcove(), truth, truth, 3, random);
  know_poses(0.005, 0.25 * kDegree, random, seen.stations);
  const Pose world_from_room(so3_exp(Vec3(0.4, -0.7, 1.1)), Vec3(0.9, -1.7, 0.6));
  for (Station& station : seen.stations)
    station.world_from_rig =
        compose(PoseWithCovariance{world_from_room, Mat6::Zero()}, *station.world_from_rig);
  return seen.stations;
}

/// Also where the poses are kept.
void expect_named(const std::vector<Station>& stations, const std::string& mistake) {
  for (const bool refine : {true, false}) {
    RegistrationOptions options;
    options.refine = refine;
    const Error error = procam::test::error_of([&] { register_stations(stations, options); });
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_NE(std::string(error.what()).find(mistake), std::string::npos) << error.what();
  }
}

TEST(PoseCheck, PassesRightPoses) {
  const Registration at = register_stations(stations_in_a_world());
  EXPECT_FALSE(at.diagnostics.failed());
  EXPECT_EQ(at.diagnostics.find("poses_disagree"), nullptr);
}

TEST(PoseCheck, NamesExchangedPoses) {
  std::vector<Station> stations = stations_in_a_world();
  std::swap(stations[1].world_from_rig, stations[2].world_from_rig);
  expect_named(stations, "stations '2' and '3' are exchanged");
}

TEST(PoseCheck, NamesInvertedPoses) {
  std::vector<Station> stations = stations_in_a_world();
  for (Station& station : stations) station.world_from_rig = inverse(*station.world_from_rig);
  expect_named(stations, "inverted");
}

TEST(PoseCheck, AsksForTheUnit) {
  std::vector<Station> stations = stations_in_a_world();
  for (Station& station : stations) station.world_from_rig->pose.translation *= 1000;
  expect_named(stations, "millimetres");
}

TEST(PoseCheck, NamesAPoseThatIsGivenTwice) {
  std::vector<Station> stations = stations_in_a_world();
  stations[2].world_from_rig = stations[1].world_from_rig;
  expect_named(stations, "both have the same pose");
}

/// No usual mistake: the pose is 20 mm off, and a quarter of a millimetre is stated.
TEST(PoseCheck, FailsWhereTheSurfacesAreFarFromAKeptPose) {
  std::vector<Station> stations = stations_in_a_world();
  Vec6 bump = Vec6::Zero();
  bump[5] = 0.02;
  for (Station& station : stations) station.world_from_rig->covariance *= 0.0025;
  stations[1].world_from_rig->pose = stations[1].world_from_rig->pose * se3_exp(bump);
  RegistrationOptions keep;
  keep.refine = false;
  const Registration at = register_stations(stations, keep);
  ASSERT_NE(at.diagnostics.find("poses_disagree"), nullptr);
  EXPECT_TRUE(at.diagnostics.failed());
}

/// Of two stations that look at different things, only the known poses know more: no mistake is named.
TEST(PoseCheck, LetsKnownPosesPlaceAStationAlone) {
  std::vector<Station> stations = stations_in_a_world();
  stations.pop_back();
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      if (x > 110) stations[0].scans[0].depth.at(x, y) = 0;
      if (x < 230) stations[1].scans[0].depth.at(x, y) = 0;
    }
  const Registration at = register_stations(stations);
  EXPECT_FALSE(at.diagnostics.failed());
  EXPECT_NE(at.diagnostics.find("no_overlap"), nullptr);
}

/// A fifth of the points cannot be where another station sees through.
TEST(PoseCheck, FailsWhereMostIsSeenThrough) {
  std::mt19937 random(33);
  const Rig truth = true_rig();
  SeenStations seen = see({plane(Vec3(0, 0.1, 1), 1.5)}, truth, truth, 1, random);
  seen.stations.push_back(see({plane(Vec3(0, 0.1, 1), 1.8)}, truth, truth, 2, random).stations[1]);
  know_poses(1e-3, 0.02 * kDegree, random, seen.stations);
  RegistrationOptions keep;
  keep.refine = false;
  const MergedStations merged = merge_stations(seen.stations, register_stations(seen.stations, keep));
  ASSERT_NE(merged.diagnostics.find("contradictions"), nullptr);
  EXPECT_TRUE(merged.diagnostics.failed());
}

}  // namespace
}  // namespace procam::scan::test
