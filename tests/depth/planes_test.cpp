#include "procam/depth/main_planes.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "pixels.hpp"
#include "plane_estimate.hpp"
#include "rooms.hpp"

namespace procam::depth {
namespace {

using test::add_score;
using test::lopsided_sensor;
using test::random_room;
using test::Score;

/// A view of planes, the nearest along each ray, without noise.
ImageF view_of(const RayTable& rays, const std::vector<Plane>& planes) {
  ImageF depth(rays.size());
  for (int y = 0; y < rays.size().height; ++y)
    for (int x = 0; x < rays.size().width; ++x) {
      const Vec3 ray(double(rays.u(x, y)), double(rays.v(x, y)), 1);
      double nearest = 100;
      for (const Plane& plane : planes) {
        const double z = -plane.offset / plane.normal.dot(ray);
        if (z > 0) nearest = std::min(nearest, z);
      }
      depth.at(x, y) = float(nearest);
    }
  return depth;
}

const Camera kSmall{{160, 120}, {146, 151, 77.3, 63.1, 0.6}, BrownConrady{{0.05, -0.06, 0.001, -0.002, 0}}};

TEST(Planes, WithoutNoiseAreExactThroughALensWithSkew) {
  const RayTable rays(kSmall);
  const std::vector<Plane> truth{{Vec3(-0.2, -0.1, -1).normalized(), 2.1},
                                 {Vec3(0.05, -1, -0.1).normalized(), 0.5},
                                 {Vec3(0.9, 0.1, -0.5).normalized(), 1.0}};
  const Planes found = find_planes(DepthImage(view_of(rays, truth)), rays);
  ASSERT_EQ(found.planes.size(), truth.size());
  for (const Plane& plane : truth) {
    double best = 1;
    for (const DetectedPlane& detected : found.planes)
      best = std::min(best, (detected.estimate.plane.normal - plane.normal).norm() +
                                std::abs(detected.estimate.plane.offset - plane.offset));
    EXPECT_LT(best, 1e-4);  // what the mean of 1 / (z + noise) is corrected by
  }
}

TEST(Planes, LabelsMeetAtTheCrease) {
  const RayTable rays(kSmall);
  const std::vector<Plane> truth{{Vec3(0, 0, -1), 2.0}, {Vec3(0, -1, 0), 0.5}};
  const Planes found = find_planes(DepthImage(view_of(rays, truth)), rays);
  ASSERT_EQ(found.planes.size(), 2u);
  int wrong = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const bool floor = rays.v(x, y) > 0.25f;  // they meet at y = 0.5, z = 2
      const int label = found.labels.at(x, y);
      const bool says_floor = label >= 0 && found.planes[std::size_t(label)].estimate.plane.normal.y() < -0.9;
      wrong += label < 0 || says_floor != floor;
    }
  EXPECT_LE(wrong, 160);  // one row of pixels
}

void record(const Score& score) {
  ::testing::Test::RecordProperty("there", score.there);
  ::testing::Test::RecordProperty("found", score.found);
  ::testing::Test::RecordProperty("determined", score.determined);
  ::testing::Test::RecordProperty("determined_found", score.determined_found);
  ::testing::Test::RecordProperty("planes", score.planes);
  ::testing::Test::RecordProperty("wrong", score.wrong);
}

TEST(Planes, OfSimulatedRoomsAreFoundAndTheirCovarianceIsHonest) {
  Score score;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    add_score(random_room(seed), lopsided_sensor(), seed, score);
  EXPECT_GE(score.found, 0.9 * score.there);
  EXPECT_LE(score.wrong, 0.06 * score.planes);
  EXPECT_LT(Score::median(score.angles_deg), 0.1);
  EXPECT_LT(Score::median(score.offsets), 0.002);
  // Of about 40 planes 95 % lie inside; 5 or more outside happen in 2 of 100 draws of seeds (binomial).
  EXPECT_GE(score.inside, int(score.angles_deg.size()) - 5);
}

/// Noise above the model's, clutter, walls that end, a camera held at an angle. Over 200 such rooms 95.8 % of
/// the planes that the readings determine are found and 0.7 % of the reported ones are false: of 153, 4 or
/// more false ones happen in 2 of 100 draws (binomial). By the noise model's limits it is 90 % and 5 false
/// ones here.
TEST(Planes, OfHardRoomsAreFoundByTheMeasuredNoise) {
  Score score;
  for (std::uint64_t seed = 81; seed <= 100; ++seed)
    add_score(test::hard_room(seed), test::hard_sensor(seed), seed, score);
  record(score);
  EXPECT_GE(score.found, 0.9 * score.there);
  EXPECT_GE(score.determined_found, 0.93 * score.determined);
  EXPECT_LE(score.wrong, 3);
  EXPECT_LT(Score::median(score.angles_deg), 0.2);
  EXPECT_LT(Score::median(score.offsets), 0.004);
}

/// A wall of which a part of the readings lies beyond the sensor's range: the mean of the others is too near,
/// by 0.1 m where half of them are missing.
TEST(Planes, BeyondTheRangeAreNotFoundTooNear) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    simulate::DepthSensor sensor = lopsided_sensor();
    sensor.axial_noise = 1.5;
    sensor.farthest = 7;
    simulate::Room room;
    room.bodies.push_back(test::hung("far", Vec3(0, 6.95, 1), Vec3(0.1, -1, 0), Vec2(9, 4), 0.5));
    room.bodies.push_back(test::hung("near", Vec3(-1, 2.5, 1), Vec3(0.3, -1, 0), Vec2(2, 4), 0.5));
    const Pose room_from_camera = test::looking_at(Vec3(0, 0, 1.1), Vec3(0.1, 3, 1), 0.1);
    const simulate::DepthView view = simulate::depth_view(room, sensor, room_from_camera, seed);
    const Planes found = find_planes(DepthImage(view.mm.view(), 0.001), RayTable(sensor.camera));
    ASSERT_GE(found.planes.size(), 1u);
    for (const DetectedPlane& plane : found.planes) {
      const bool is_far = plane.middle.z() > 4;
      const Plane truth =
          room_from_camera.inverse() * Plane::of_xy(room.bodies[is_far ? 0 : 1].room_from_body);
      // One in 10000 of chi-square with 3 degrees of freedom.
      EXPECT_LT(squared_sigmas(plane.estimate, truth), 21.1) << seed << " at " << plane.middle.z();
    }
  }
}

TEST(Planes, NoiseRatioTellsKindsOfSensorsApart) {
  const auto seen = random_room(7);
  simulate::DepthSensor sensor = lopsided_sensor({320, 240});
  sensor.disparity_step = 0;
  const RayTable rays(sensor.camera);
  for (const double factor : {0.25, 1.0, 2.0}) {
    sensor.axial_noise = factor;
    const auto view = simulate::depth_view(seen.room, sensor, seen.room_from_camera, 7);
    const DepthImage image(view.mm.view(), 0.001);
    const double by_its_own = noise_ratio(image, rays, DepthNoise::kinect_v1());
    // Cells that edges cross are in the quartile as well: a few percent.
    EXPECT_NEAR(by_its_own / factor, 1, 0.1) << factor;
    EXPECT_EQ(find_planes(image, rays).noise_ratio, by_its_own);
    EXPECT_GT(noise_ratio(image, rays, DepthNoise::time_of_flight()), 3 * by_its_own);
  }
  EXPECT_EQ(noise_ratio(DepthImage(ImageF(sensor.camera.size)), rays, DepthNoise::kinect_v1()), 0);
}

TEST(ManyRooms, MeetWhatIsPromised) {
  Score score;
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
    add_score(random_room(seed), lopsided_sensor(), seed, score);
  const double share = double(score.inside) / double(score.angles_deg.size());
  record(score);
  RecordProperty("inside", std::to_string(share));
  EXPECT_GE(score.found, 0.95 * score.there);
  EXPECT_LE(score.wrong, 0.02 * score.planes);
  EXPECT_LT(Score::median(score.angles_deg), 0.1);
  EXPECT_LT(Score::median(score.offsets), 0.002);
  EXPECT_GE(share, 0.93);
  EXPECT_LE(share, 0.97);
}

/// Seeds that no rule was chosen on. 842 planes of which the readings determine 779; 8 in 1000 false ones.
TEST(ManyRooms, ThatAreHardMeetWhatIsPromised) {
  Score score;
  for (std::uint64_t seed = 201; seed <= 300; ++seed)
    add_score(test::hard_room(seed), test::hard_sensor(seed), seed, score);
  record(score);
  EXPECT_GE(score.found, 0.92 * score.there);
  EXPECT_GE(score.determined_found, 0.95 * score.determined);
  EXPECT_LE(score.wrong, 0.015 * score.planes);
  const double share = double(score.inside) / double(score.angles_deg.size());
  EXPECT_GE(share, 0.92);
  EXPECT_LE(share, 0.97);
}

/// A frame with a lens, noise and holes, its last row and column of cells cut, by either instruction set:
/// 16-bit readings and floats.
TEST(Planes, AreTheSameBitsByEveryInstructionSet) {
  using internal::PixelPath;
  const simulate::DepthSensor sensor = lopsided_sensor({637, 475});
  const auto seen = random_room(4);
  const simulate::DepthView view = simulate::depth_view(seen.room, sensor, seen.room_from_camera, 4);
  ImageF metres(view.mm.size());
  for (int y = 0; y < metres.height(); ++y)
    for (int x = 0; x < metres.width(); ++x) metres.at(x, y) = 0.001f * float(view.mm.at(x, y));
  Camera pinhole = sensor.camera;
  pinhole.distortion = NoDistortion{};
  pinhole.intrinsics.skew = 0;
  for (const Camera& camera : {sensor.camera, pinhole})
    for (const bool of_units : {true, false}) {
      const RayTable rays(camera);
      const DepthImage image = of_units ? DepthImage(view.mm.view(), 0.001) : DepthImage(metres.view());
      ASSERT_TRUE(internal::use_pixel_kernels(PixelPath::kAnyProcessor));
      const Planes any = find_planes(image, rays);
      if (!internal::use_pixel_kernels(PixelPath::kAvx2)) GTEST_SKIP() << "this processor has no AVX2";
      const Planes wide = find_planes(image, rays);
      ASSERT_GE(any.planes.size(), 3u);
      ASSERT_EQ(any.planes.size(), wide.planes.size());
      ASSERT_EQ(any.curves.size(), wide.curves.size());
      for (std::size_t i = 0; i < any.planes.size(); ++i) {
        const DetectedPlane &a = any.planes[i], &b = wide.planes[i];
        EXPECT_EQ(a.estimate.plane.normal, b.estimate.plane.normal);
        EXPECT_EQ(a.estimate.plane.offset, b.estimate.plane.offset);
        EXPECT_EQ(a.estimate.covariance, b.estimate.covariance);
        EXPECT_EQ(a.pixels, b.pixels);
        EXPECT_EQ(a.area, b.area);
        EXPECT_EQ(a.rms, b.rms);
      }
      for (std::size_t i = 0; i < any.curves.size(); ++i) {
        EXPECT_EQ(any.curves[i].pixels, wide.curves[i].pixels);
        EXPECT_EQ(any.curves[i].rms, wide.curves[i].rms);
      }
      int different = 0;
      for (int y = 0; y < any.labels.height(); ++y)
        for (int x = 0; x < any.labels.width(); ++x) different += any.labels.at(x, y) != wide.labels.at(x, y);
      EXPECT_EQ(different, 0);
    }
}

TEST(MainPlanes, OfSimulatedRoomsAreTheTrueOnes) {
  Score fine, main;
  for (std::uint64_t seed = 301; seed <= 303; ++seed) {
    add_score(random_room(seed), lopsided_sensor(), seed, fine);
    add_score(random_room(seed), lopsided_sensor(), seed, main,
              [](const DepthImage& image, const RayTable& rays) {
                return main_planes(find_planes(image, rays), image, rays).planes;
              });
  }
  // A box that stands near a wall may become part of it (six times in 200 rooms).
  EXPECT_GE(main.found, fine.found - 2);
  EXPECT_LE(main.wrong, fine.wrong + 1);
  EXPECT_LT(Score::median(main.offsets), 0.002);
}

TEST(MainPlanes, TakeADoorWithItsWallAndNothingElse) {
  const simulate::DepthSensor sensor = lopsided_sensor();
  simulate::Room room;
  room.bodies.push_back(test::hung("wall", Vec3(0, 3, 1), Vec3(0, -1, 0), Vec2(6, 4), 0.5));
  room.bodies.push_back(test::hung("door", Vec3(0.5, 2.965, 1), Vec3(0, -1, 0), Vec2(1.1, 2.2), 0.5));
  room.bodies.push_back(test::hung("board", Vec3(-0.8, 2.6, 1), Vec3(0, -1, 0), Vec2(0.8, 1), 0.5));
  const Pose room_from_camera = test::looking_at(Vec3(0, 1, 1.1), Vec3(0.1, 3, 1), 0.1);
  const simulate::DepthView view = simulate::depth_view(room, sensor, room_from_camera, 5);
  const DepthImage image(view.mm.view(), 0.001);
  const RayTable rays(sensor.camera);
  const Planes fine = find_planes(image, rays);
  ASSERT_EQ(fine.planes.size(), 3u);
  const MainPlanes main = main_planes(fine, image, rays);
  ASSERT_EQ(main.planes.planes.size(), 2u);
  EXPECT_EQ(main.members[0].size(), 2u);
  ASSERT_EQ(main.members[1].size(), 1u);
  const DetectedPlane &both = main.planes.planes[0], &board = fine.planes[std::size_t(main.members[1][0])];
  EXPECT_EQ(main.planes.planes[1].estimate.plane.offset, board.estimate.plane.offset);
  // Between the two; the step is in its rms, and each of the two within what it is said to be uncertain by.
  EXPECT_GT(both.rms, 0.008);
  for (const int member : main.members[0]) {
    const PlaneEstimate& one = fine.planes[std::size_t(member)].estimate;
    EXPECT_LT(std::abs(one.plane.offset - both.estimate.plane.offset), 0.06);
    EXPECT_LT(squared_sigmas(both.estimate, one.plane), 7.81);
  }
}

TEST(MainPlanes, RefuseOtherSizesAndOptionsOutOfRange) {
  const Camera camera{{64, 48}, {60, 61, 30, 24, 0}, NoDistortion{}};
  const RayTable rays(camera);
  const Image<std::uint16_t> nothing(ImageSize{64, 48}), other(ImageSize{48, 64});
  const DepthImage image(nothing.view(), 0.001);
  const Planes none = find_planes(image, rays);
  const MainPlanes empty = main_planes(none, image, rays);
  EXPECT_TRUE(empty.planes.planes.empty());
  EXPECT_EQ(empty.planes.labels.at(3, 4), Planes::kNothing);
  EXPECT_THROW(main_planes(none, DepthImage(other.view(), 0.001), rays), std::invalid_argument);
  EXPECT_THROW(main_planes(none, image, rays, {0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(main_planes(none, image, rays, {0.01, 0.004, 6, 0}), std::invalid_argument);
}

TEST(Planes, AColumnIsACylinderAndABallASphere) {
  const simulate::DepthSensor sensor = lopsided_sensor();
  simulate::Room room;
  room.bodies.push_back(test::hung("wall", Vec3(0, 3, 1), Vec3(0, -1, 0), Vec2(6, 4), 0.5));
  room.bodies.push_back({"column", simulate::Cylinder{0.25, -1, 3},
                         Pose(Eigen::Quaterniond::Identity(), Vec3(0.4, 1.8, 0)), 0.5});
  room.bodies.push_back(
      {"ball", simulate::Sphere{0.3}, Pose(Eigen::Quaterniond::Identity(), Vec3(-0.5, 1.7, 1)), 0.5});
  const Pose room_from_camera = test::looking_at(Vec3(0, 0, 1.1), Vec3(0, 3, 1), 0.1);
  const auto view = simulate::depth_view(room, sensor, room_from_camera, 5);
  const Planes found = find_planes(DepthImage(view.mm.view(), 0.001), RayTable(sensor.camera));
  ASSERT_EQ(found.planes.size(), 1u);  // the wall
  ASSERT_EQ(found.curves.size(), 2u);
  bool column = false, ball = false;
  for (const DetectedCurve& curve : found.curves) {
    if (const auto* c = std::get_if<CylinderSurface>(&curve.shape)) {
      column = true;
      EXPECT_NEAR(c->radius, 0.25, 0.015);
      EXPECT_EQ(c->seen_from, SeenFrom::kOutside);
      EXPECT_EQ(c->fault(), nullptr);
      // The frame's y axis is the column's, downwards.
      const Vec3 down = room_from_camera.rotate(c->frame_from_surface.rotate(Vec3::UnitY()));
      EXPECT_LT(down.z(), -0.999);
      const Vec3 middle = room_from_camera * (c->frame_from_surface * c->point(Vec2(0.5, 0.5)));
      EXPECT_NEAR(middle.x(), 0.35, 0.05);  // its near side
      EXPECT_LT(middle.y(), 1.6);
    }
    if (const auto* s = std::get_if<SphereSurface>(&curve.shape)) {
      ball = true;
      EXPECT_NEAR(s->radius, 0.3, 0.02);
      EXPECT_LT((room_from_camera * s->frame_from_surface.translation - Vec3(-0.5, 1.7, 1)).norm(), 0.03);
    }
  }
  EXPECT_TRUE(column && ball);
}

TEST(Planes, TheSameImageGivesTheSamePlanes) {
  const simulate::DepthSensor sensor = lopsided_sensor({320, 240});
  const auto seen = random_room(3);
  const auto view = simulate::depth_view(seen.room, sensor, seen.room_from_camera, 3);
  const RayTable rays(sensor.camera);
  const Planes a = find_planes(DepthImage(view.mm.view(), 0.001), rays);
  const Planes b = find_planes(DepthImage(view.mm.view(), 0.001), rays);
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    EXPECT_EQ(a.planes[i].estimate.plane.normal, b.planes[i].estimate.plane.normal);
    EXPECT_EQ(a.planes[i].estimate.covariance, b.planes[i].estimate.covariance);
  }
  EXPECT_TRUE(std::equal(a.labels.data(), a.labels.data() + 320 * 240, b.labels.data()));
}

TEST(Planes, BadDepthHasNoPlanesAndNoNaN) {
  const RayTable rays(kSmall);
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  for (const float value : {0.0f, -1.0f, nan, infinity, 1e30f, 1e-30f}) {
    const Planes found = find_planes(DepthImage(ImageF(kSmall.size, 1, value)), rays);
    EXPECT_TRUE(found.planes.empty()) << value;
    EXPECT_EQ(found.labels.at(80, 60), Planes::kNothing);
  }
  // Noise that is no surface, with every kind of bad number in it.
  std::mt19937_64 random(1);
  ImageF wild(kSmall.size);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const double u = procam::test::uniform(random, 0, 1);
      wild.at(x, y) = u < 0.1 ? nan : u < 0.15 ? infinity : u < 0.2 ? -2.0f : float(0.3 + 5 * u);
    }
  EXPECT_TRUE(find_planes(DepthImage(wild), rays).planes.empty());
  // A pixel wide, and no multiple of a cell.
  for (const ImageSize size : {ImageSize{1, 1}, ImageSize{3, 200}, ImageSize{61, 45}}) {
    const Camera camera{size, {50, 51, size.width / 2.0, size.height / 2.0, 0}, NoDistortion{}};
    const Planes found = find_planes(DepthImage(ImageF(size, 1, 2.0f)), RayTable(camera));
    for (const DetectedPlane& plane : found.planes) {
      EXPECT_TRUE(plane.estimate.covariance.allFinite());
      EXPECT_NEAR(plane.estimate.plane.offset, 2, 1e-4);
    }
  }
}

TEST(Planes, RefuseAnImageOfAnotherSize) {
  EXPECT_THROW(find_planes(DepthImage(ImageF(160, 121)), RayTable(kSmall)), std::invalid_argument);
  EXPECT_THROW(RayTable(Camera{{0, 4}, {}, NoDistortion{}}), std::invalid_argument);
  const Image<std::uint16_t> units(160, 120);
  EXPECT_THROW(DepthImage(units.view(), 0), std::invalid_argument);
}

TEST(PlaneEstimate, CarriesItsCovarianceThroughAnUncertainPose) {
  // Against differences: plane and pose moved by small steps along each direction.
  PlaneEstimate estimate;
  estimate.plane = {Vec3(0.3, -0.5, -0.8).normalized(), 1.7};
  const auto turns = turns_of(estimate.plane.normal);
  Eigen::Matrix<double, 4, 3> spread = Eigen::Matrix<double, 4, 3>::Zero();
  spread.topLeftCorner<3, 2>() = turns * (Mat2() << 0.01, 0.002, -0.003, 0.02).finished();
  spread(3, 2) = 0.03;
  spread(3, 0) = 0.004;
  estimate.covariance = spread * spread.transpose();
  const Pose pose = procam::test::lopsided_pose();
  Vec6 sigma;
  sigma << 0.01, 0.02, 0.03, 0.04, 0.05, 0.06;
  const Mat6 of_pose = sigma.cwiseAbs2().asDiagonal();
  const PlaneEstimate moved = transformed(pose, estimate, of_pose);
  const double h = 1e-6;
  const auto as_vector = [](const Plane& p) {
    return Vec4(p.normal.x(), p.normal.y(), p.normal.z(), p.offset);
  };
  Mat4 expected = Mat4::Zero();
  const auto add = [&](const Plane& a, double scale) {
    const Vec4 d = (as_vector(a) - as_vector(moved.plane)) / h * scale;
    expected += d * d.transpose();
  };
  for (int i = 0; i < 3; ++i) {
    Plane p = estimate.plane;
    p.normal += h * spread.col(i).head<3>();
    p.offset += h * spread(3, i);
    add(pose * p, 1);
  }
  for (int i = 0; i < 6; ++i) add((se3_exp(Vec6(h * Vec6::Unit(i))) * pose) * estimate.plane, sigma[i]);
  EXPECT_LT((moved.covariance - expected).norm(), 1e-6);
  EXPECT_NEAR(squared_sigmas(moved, moved.plane), 0, 1e-12);
}

}  // namespace
}  // namespace procam::depth
