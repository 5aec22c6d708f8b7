/// The rig on its base from floor and walls, as a depth sensor measures them (2 mm, 0.1 degrees a plane).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>

#include "mount_drives.hpp"

namespace procam::calibrate {
namespace {

using simulate::SightingKind;

/// A rig that looks ahead and 27 degrees down, turned and rolled a little.
Pose looking_down() {
  Mat3 optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {so3_exp(Vec3(0.03, 0.47, -0.21)) * Eigen::Quaterniond(optical), Vec3(0.17, -0.08, 0.93)};
}

MountDriveOptions room(std::uint64_t seed, SightingKind kind = SightingKind::kPlanes) {
  MountDriveOptions options = uneven(seed);
  options.kind = kind;
  options.base_from_rig = looking_down();
  return options;
}

MountOptions on_the_floor() {
  MountOptions options;
  options.floor = MountFloor{};
  return options;
}

double scale_sigma(const MountResult& result) {
  return std::sqrt(result.plane_sensor->covariance(0, 0));
}

TEST(MountFromPlanes, NeedsNoMarkersAndNoMeasuredHeight) {
  const MountDrive made = walk(room(801));
  const MountResult result = calibrate_mount(data_of(made), on_the_floor());
  const Deviation off = deviation(result, made);
  EXPECT_LT(off.chi2, kChi2Of6);
  EXPECT_LT(off.at_two_metres, 0.01);
  EXPECT_LT(std::abs(off.time_in_sigmas), 4);
  EXPECT_TRUE(result.unobservable().empty());
  // Of the stated floor 1 mm, and what the scale of the sensor leaves open.
  EXPECT_LT(result.directions[5].sigma, 0.002) << "height";
  ASSERT_TRUE(result.plane_sensor);
  EXPECT_LT(std::abs(result.plane_sensor->scale - 1), 4 * scale_sigma(result));
  EXPECT_LT(scale_sigma(result), 0.002);
  for (const std::size_t i : {0, 1, 2})
    EXPECT_GT(result.directions[i].sigma, 0.099 * kDegree) << "a turned sensor looks like a turned rig";
  EXPECT_TRUE(result.events.empty());
  EXPECT_TRUE(result.markers.empty());
  EXPECT_NEAR(result.plane_factor, 1, 0.1);
  ASSERT_EQ(result.planes.size(), 4u) << "floor and three walls";
  for (const MountPlane& found : result.planes) {
    const Pose& truth =
        made.sightings.planes[found.name == "plane_floor" ? 0 : std::size_t(found.name.back() - '0')];
    const Vec3 normal = truth.rotate(Vec3::UnitZ());
    EXPECT_GT(found.world_from_plane.rotate(Vec3::UnitZ()).dot(normal), std::cos(0.5 * kDegree))
        << found.name;
    EXPECT_NEAR(normal.dot(found.world_from_plane.translation - truth.translation), 0, 0.02) << found.name;
    EXPECT_GT(found.covariance.diagonal().minCoeff(), 0) << found.name;
  }
}

TEST(MountFromPlanes, FindsClocksThatAreFarApart) {
  MountDriveOptions options = room(802);
  options.latency = -0.55;
  const MountDrive made = walk(options);
  const MountResult result = calibrate_mount(data_of(made), on_the_floor());
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
  EXPECT_NEAR(result.time_offset, -0.55, 0.01);
}

TEST(MountFromPlanes, ThatAreWrongNowAndThenAreRejected) {
  MountDriveOptions options = room(803);
  options.outliers = 0.08;
  const MountDrive made = walk(options);
  const MountResult result = calibrate_mount(data_of(made), on_the_floor());
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
  EXPECT_GT(result.rejected_sightings.size(), made.sightings.outliers.size() / 2);
}

TEST(MountFromPlanes, OfABumpedRigIsThatOfTheTimeAfter) {
  MountDriveOptions options = room(804);
  options.bump_time = 30;
  const MountDrive made = walk(options);
  const MountResult result = calibrate_mount(data_of(made), on_the_floor());
  ASSERT_EQ(result.events.size(), 1u);
  EXPECT_EQ(result.events[0].kind, MountEvent::Kind::kRigBumped);
  EXPECT_NEAR(result.events[0].time, 30 + made.time_offset, 1);
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
}

/// The floor is 120 mm below the base's origin: a base_link at the axles.
TEST(MountFromPlanes, HeightIsAboveTheBasesOrigin) {
  MountDriveOptions options = room(805);
  const MountDrive made = walk(options);
  MountOptions stated = on_the_floor();
  stated.floor->below = 0.12;
  const MountResult result = calibrate_mount(data_of(made), stated);
  EXPECT_NEAR(result.base_from_rig.pose.translation.z(), looking_down().translation.z() - 0.12,
              4 * result.directions[5].sigma);
}

TEST(MountFromPlanes, AndMarkersAreUsedTogether) {
  const MountDrive made = walk(room(806, SightingKind::kBoth));
  const MountResult both = calibrate_mount(data_of(made), on_the_floor());
  EXPECT_LT(deviation(both, made).chi2, kChi2Of6);
  EXPECT_TRUE(both.unobservable().empty());
  EXPECT_EQ(both.markers.size(), 8u);
  MountData markers = data_of(made);
  markers.sightings.erase(std::remove_if(markers.sightings.begin(), markers.sightings.end(),
                                         [](const MarkerSighting& seen) { return seen.is_plane; }),
                          markers.sightings.end());
  const MountResult alone = calibrate_mount(markers, with_height(made, 806));
  for (const std::size_t i : {2, 3, 4})
    EXPECT_LT(both.directions[i].sigma, alone.directions[i].sigma) << both.directions[i].name;
}

/// Covariances half as large as the noise is: the factor is that of planes alone.
TEST(MountFromPlanes, ThatScatterMoreThanStatedAreReported) {
  const MountDrive made = walk(room(807, SightingKind::kBoth));
  MountData data = data_of(made);
  for (MarkerSighting& seen : data.sightings)
    if (seen.is_plane) seen.marker_from_rig.covariance /= 9;
  const MountResult result = calibrate_mount(data, on_the_floor());
  EXPECT_NEAR(result.plane_factor, 3, 0.3);
  EXPECT_NEAR(result.sighting_factor, 1, 0.15);
  EXPECT_NE(result.diagnostics.find("planes_noisier"), nullptr);
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
}

/// Reported distances of planes times `scale`, by a sensor that is turned against the rig.
MountData by_sensor(const MountDrive& made, double scale, const Vec3& turn = Vec3::Zero()) {
  MountData data = data_of(made);
  for (MarkerSighting& seen : data.sightings) {
    if (!seen.is_plane) continue;
    Pose& plane_from_rig = seen.marker_from_rig.pose;
    plane_from_rig.translation *= scale;
    plane_from_rig = plane_from_rig * Pose(so3_exp(turn), Vec3::Zero());
  }
  return data;
}

TEST(MountFromPlanes, ByADepthSensorOfAnotherScaleAreReported) {
  const MountDrive made = walk(room(805));
  const MountResult result = calibrate_mount(by_sensor(made, 1.02), on_the_floor());
  EXPECT_EQ(result.scale, 1) << "of the localiser";
  EXPECT_NEAR(result.plane_sensor->scale, 1.02, 0.004);
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6) << "the mount allows for it";
  const Diagnostic* const remark = result.diagnostics.find("lengths_disagree");
  ASSERT_NE(remark, nullptr);
  EXPECT_EQ(remark->severity, Severity::kFailure);
  EXPECT_NE(remark->message.find("depth sensor's scale"), std::string::npos) << remark->message;
}

/// As sensors are: the mount and its sigmas allow for it, without a remark.
TEST(MountFromPlanes, AllowForASensorThatIsHalfAPercentOff) {
  const MountDrive made = walk(room(811));
  const MountData data = by_sensor(made, 0.995);
  const MountResult result = calibrate_mount(data, on_the_floor());
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
  EXPECT_NEAR(result.plane_sensor->scale, 0.995, 4 * scale_sigma(result));
  EXPECT_EQ(result.diagnostics.find("lengths_disagree"), nullptr);
  MountOptions exact = on_the_floor();
  exact.plane_sensor = {0, 0};
  const MountResult believed = calibrate_mount(data, exact);
  EXPECT_GT(deviation(believed, made).chi2, kChi2Of6) << "the height is 4.7 mm off, by a sigma of 1 mm";
  EXPECT_LT(scale_sigma(believed), 2e-6);
}

TEST(MountFromPlanes, WithMarkersHaveTheMetresAndTheFrameOfTheMarkers) {
  const MountDrive made = walk(room(812, SightingKind::kBoth));
  const Vec3 turn(0.008, -0.003, 0.002);  // 0.5 degrees
  const MountResult result = calibrate_mount(by_sensor(made, 1.03, turn), on_the_floor());
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
  EXPECT_NEAR(result.plane_sensor->scale, 1.03, 4 * scale_sigma(result));
  EXPECT_LT((result.plane_sensor->turn - turn).norm(), 0.001) << result.plane_sensor->turn.transpose();
  const Diagnostic* const remark = result.diagnostics.find("plane_sensor_off");
  ASSERT_NE(remark, nullptr);
  EXPECT_EQ(remark->severity, Severity::kWarning);
}

/// A sensor does not tell which plane it sees.
MountData without_names(MountData data) {
  for (MarkerSighting& seen : data.sightings)
    if (seen.is_plane) seen.marker.clear();
  return data;
}

TEST(MountFromPlanes, NeedNoNames) {
  for (const std::uint64_t seed : {801, 813}) {
    const MountDrive made = walk(room(seed));
    const MountResult named = calibrate_mount(data_of(made), on_the_floor()),
                      result = calibrate_mount(without_names(data_of(made)), on_the_floor());
    EXPECT_LT(deviation(result, made).chi2, kChi2Of6) << seed;
    EXPECT_TRUE(result.events.empty()) << seed;
    EXPECT_EQ(result.planes.size(), named.planes.size()) << "walls that return are joined, " << seed;
    EXPECT_EQ(std::count_if(result.planes.begin(), result.planes.end(),
                            [](const MountPlane& plane) { return plane.name == "plane_floor"; }),
              1)
        << seed;
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_LT(result.directions[i].sigma, 1.2 * named.directions[i].sigma) << result.directions[i].name;
  }
}

TEST(MountFromPlanes, WithoutNamesStandBumpsOutliersAndClocks) {
  MountDriveOptions options = room(815);
  options.outliers = 0.05;
  options.bump_time = 20;
  options.latency = 0.4;
  const MountDrive made = walk(options, 40);
  const MountResult result = calibrate_mount(without_names(data_of(made)), on_the_floor());
  EXPECT_LT(deviation(result, made).chi2, kChi2Of6);
  ASSERT_EQ(result.events.size(), 1u);
  EXPECT_NEAR(result.events[0].time, 20 + made.time_offset, 1);
}

/// A ceiling is as steady as a floor, and a table lies between them.
TEST(MountFromPlanes, OfCeilingTableAndFloorTheFloorIsFound) {
  const MountDrive made = walk(room(816));
  MountData data = without_names(data_of(made));
  std::vector<MarkerSighting> more;
  const Pose rig_from_base = made.sightings.base_from_rig.inverse();
  const Pose ceiling(so3_exp(Vec3(kPi, 0, 0)), Vec3(0.6, -0.2, 2.6)),
      table(Pose().rotation, Vec3(0.9, 0.3, 0.7));
  for (std::size_t i = 0; i < data.sightings.size(); i += 2)
    for (const Pose& base_from_plane : {ceiling, table}) {
      MarkerSighting seen = data.sightings[i];
      seen.marker_from_rig.pose = (rig_from_base * base_from_plane).inverse();
      more.push_back(seen);
    }
  data.sightings.insert(data.sightings.end(), more.begin(), more.end());
  const MountResult result = calibrate_mount(data, on_the_floor());
  EXPECT_NEAR(result.base_from_rig.pose.translation.z(), looking_down().translation.z(),
              4 * result.directions[5].sigma);
  EXPECT_LT(deviation(result, made).at_two_metres, 0.015);
}

TEST(MountFromPlanes, WithoutNamesAndWithoutAFloorAreRefused) {
  const MountDrive made = walk(room(817), 30);
  MountData walls = data_of(made);
  walls.sightings.erase(
      std::remove_if(walls.sightings.begin(), walls.sightings.end(),
                     [](const MarkerSighting& seen) { return seen.marker == "plane_floor"; }),
      walls.sightings.end());
  const std::string words = refusal(without_names(walls), on_the_floor(), ErrorKind::kDegenerate);
  EXPECT_NE(words.find("as a floor does"), std::string::npos) << words;
}

TEST(MountFromPlanes, WithoutAStatedFloorDoNotGiveTheHeight) {
  const MountDrive made = walk(room(808), 30);
  MountOptions options;
  options.find_events = false;
  const std::string words = refusal(data_of(made), options, ErrorKind::kDegenerate);
  EXPECT_NE(words.find("height"), std::string::npos) << words;
  EXPECT_NE(words.find("--floor"), std::string::npos) << words;
}

TEST(MountFromPlanes, ThatDoNotSufficeAreRefusedWithTheRemedy) {
  const MountDrive made = walk(room(809), 30);
  const MountData data = data_of(made);
  const auto only = [&](const std::vector<std::string>& names) {
    MountData some = data;
    some.sightings.erase(std::remove_if(some.sightings.begin(), some.sightings.end(),
                                        [&](const MarkerSighting& seen) {
                                          return std::find(names.begin(), names.end(), seen.marker) ==
                                                 names.end();
                                        }),
                         some.sightings.end());
    return some;
  };
  const auto has = [](const std::string& words, const char* part) {
    EXPECT_NE(words.find(part), std::string::npos) << words;
  };
  has(refusal(only({"plane_floor"}), on_the_floor(), ErrorKind::kDegenerate), "walls");
  has(refusal(only({"plane_1", "plane_2", "plane_3", "plane_4"}), {}, ErrorKind::kDegenerate), "floor");
  has(refusal(only({"plane_1", "plane_2", "plane_3", "plane_4"}), on_the_floor(), ErrorKind::kInput),
      "plane_floor");
  MountData in_millimetres = data, inverted = data;
  for (MarkerSighting& seen : in_millimetres.sightings) seen.marker_from_rig.pose.translation *= 1000;
  for (MarkerSighting& seen : inverted.sightings)
    seen.marker_from_rig.pose = seen.marker_from_rig.pose.inverse();
  has(refusal(in_millimetres, on_the_floor(), ErrorKind::kInput), "metres");
  has(refusal(inverted, on_the_floor(), ErrorKind::kInput), "plane_from_rig");
  MountData mixed = data;
  mixed.sightings.front().is_plane = !mixed.sightings.front().is_plane;
  has(refusal(mixed, on_the_floor(), ErrorKind::kInput), "both a marker and a plane");
  MountOptions in_space = on_the_floor();
  in_space.motion = BaseMotion::kFull;
  has(refusal(data, in_space, ErrorKind::kInput), "--floor");
}

/// 95 % regions hold the truth in 93 % of drives or more, as those of markers.
TEST(TwoHundredMountsFromPlanes, AreAsGoodAsTheyState) {
  int inside = 0, in_time = 0, events = 0, drives = 200;
  if (const char* text = std::getenv("PROCAM_MOUNT_DRIVES")) drives = std::atoi(text);
  double squares = 0, time = 0;
  std::array<double, 6> in_sigmas{};  // mean square
  std::mt19937 random(8199);
  std::normal_distribution<double> normal;
  for (int drive = 0; drive < drives; ++drive) {
    const MountDrive made = walk(room(8200 + std::uint64_t(drive)));
    MountOptions stated = on_the_floor();
    const MountPlaneSensor& sensor = stated.plane_sensor;
    const double scale = 1 + sensor.scale_sigma * normal(random);
    const Vec3 turn = sensor.turn_sigma * Vec3(normal(random), normal(random), normal(random));
    stated.floor->below = stated.floor->sigma * normal(random);
    const MountResult result = calibrate_mount(without_names(by_sensor(made, scale, turn)), stated);
    const Deviation off = deviation(result, made);
    const Pose &found = result.base_from_rig.pose, &truth = made.sightings.base_from_rig;
    Vec6 error;
    error << so3_log(Eigen::Quaterniond(found.rotation * truth.rotation.conjugate())),
        found.translation - truth.translation;
    for (std::size_t i = 0; i < 6; ++i)
      in_sigmas[i] += std::pow(error[Eigen::Index(i)] / result.directions[i].sigma, 2) / drives;
    inside += off.chi2 < 12.592 ? 1 : 0;  // 95 % of 6 degrees of freedom
    in_time += std::abs(off.time_in_sigmas) < 1.96 ? 1 : 0;
    events += int(result.events.size());
    squares += off.at_two_metres * off.at_two_metres / drives;
    time += off.time / drives;
  }
  std::printf("inside %d, time %d of %d, %.2f mm rms at 2 m, time %.2f ms, events %d, in sigmas", inside,
              in_time, drives, 1e3 * std::sqrt(squares), 1e3 * time, events);
  for (const double square : in_sigmas) std::printf(" %.2f", std::sqrt(square));
  std::printf("\n");
  EXPECT_GE(inside, 0.93 * drives);
  EXPECT_GE(in_time, 0.915 * drives);
  EXPECT_LE(events, 0.03 * drives);
}

}  // namespace
}  // namespace procam::calibrate
