/// Frames of five depth cameras, against planes that sequential RANSAC finds in them (band 10 mm + 4 mm z^2,
/// every second pixel, 0.3 to 6 m).
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "procam/depth/planes.hpp"
#include "procam/io/depth_file.hpp"
#include "support/test_data.hpp"

namespace procam::depth {
namespace {

struct Baseline {
  const char* name;
  Vec3 normal;
  double offset;
};

struct Frame {
  std::string file;
  double unit = 0.001;
  Intrinsics intrinsics{525, 525, 319.5, 239.5, 0};
  std::vector<Baseline> baselines;
};

/// What other programs packed otherwise: SUN RGB-D turns 16 bits by three, NYU's are Kinect disparities.
Image<std::uint16_t> unpacked(const Frame& frame) {
  Image<std::uint16_t> depth = io::load_depth(procam::test::test_data() / frame.file);
  const bool sun = frame.file.find("/sun/") != std::string::npos;
  const bool nyu = frame.file.find("/nyu/") != std::string::npos;
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      std::uint16_t& value = depth.at(x, y);
      if (sun) value = std::uint16_t(value >> 3 | value << 13);
      if (nyu) {
        const double metres = value >= 2047 ? 0 : 351.3 / (1092.5 - value);
        value = metres > 0 && metres < 20 ? std::uint16_t(std::lround(1000 * metres)) : std::uint16_t(0);
      }
    }
  return depth;
}

double angle_deg(const Plane& a, const Baseline& b) {
  return std::acos(std::min(a.normal.dot(b.normal.normalized()), 1.0)) / kDegree;
}

bool same(const Plane& plane, const Baseline& baseline) {
  const double off = std::abs(plane.offset - baseline.offset);
  return angle_deg(plane, baseline) < 2 && (off < 0.015 || off < 0.02 * baseline.offset);
}

/// What the baseline's own rule makes of a plane: the points within its band, wherever they are, fitted,
/// again until nothing changes. It joins a door to its wall, which find_planes() keeps apart.
Plane by_band(const DepthImage& image, const RayTable& rays, Plane plane) {
  for (int round = 0; round < 30; ++round) {
    Vec3 sum = Vec3::Zero();
    Mat3 squares = Mat3::Zero();
    double n = 0;
    for (int y = 0; y < rays.size().height; y += 2)
      for (int x = 0; x < rays.size().width; x += 2) {
        const double z = double(image.at(x, y));
        if (z < 0.3 || z > 6) continue;
        const Vec3 p = z * Vec3(double(rays.u(x, y)), double(rays.v(x, y)), 1);
        if (std::abs(plane.signed_distance(p)) > 0.010 + 0.004 * z * z) continue;
        sum += p;
        squares += p * p.transpose();
        n += 1;
      }
    const Vec3 mean = sum / n;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(squares / n - mean * mean.transpose());
    Vec3 normal = eigen.eigenvectors().col(0);
    if (normal.dot(plane.normal) < 0) normal = -normal;
    plane = {normal, -normal.dot(mean)};
  }
  return plane;
}

struct Match {
  bool direct = false, by_rule = false;
};

Match match(const Planes& found, const DepthImage& image, const RayTable& rays, const Baseline& baseline) {
  Match out;
  for (const DetectedPlane& plane : found.planes) out.direct |= same(plane.estimate.plane, baseline);
  for (const DetectedPlane& plane : found.planes)
    if (!out.direct && angle_deg(plane.estimate.plane, baseline) < 10)
      out.by_rule |= same(by_band(image, rays, plane.estimate.plane), baseline);
  return out;
}

void expect_found(const Frame& frame, int at_least_direct) {
  int direct = 0;
  const Image<std::uint16_t> depth = unpacked(frame);
  const DepthImage image(depth.view(), frame.unit);
  const RayTable rays(Camera{depth.size(), frame.intrinsics, NoDistortion{}});
  const Planes found = find_planes(image, rays);
  for (const Baseline& baseline : frame.baselines) {
    const Match m = match(found, image, rays, baseline);
    EXPECT_TRUE(m.direct || m.by_rule) << frame.file << ": " << baseline.name;
    direct += m.direct;
    ::testing::Test::RecordProperty(baseline.name, m.direct ? "direct" : m.by_rule ? "by rule" : "missing");
  }
  EXPECT_GE(direct, at_least_direct) << frame.file;
}

TEST(RealFrames, RedwoodsWallAndFloor) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/redwood");
  expect_found({"rgbd/redwood/depth_00000.png",
                0.001,
                {525, 525, 319.5, 239.5, 0},
                {{"wall", Vec3(-0.298, -0.003, -0.955), 2.099}, {"floor", Vec3(0.001, -1, -0.026), 0.444}}},
               2);
}

TEST(RealFrames, CorridorOfSun) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/sun");
  expect_found(
      {"rgbd/sun/SUN_depth.png",
       0.001,
       {525, 525, 319.5, 239.5, 0},
       {{"left", Vec3(0.997, -0.029, 0.067), 0.795}, {"floor", Vec3(-0.022, -0.998, -0.064), 1.138}}},
      1);
}

TEST(RealFrames, DeskOfTum) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/tum");
  expect_found({"rgbd/tum/TUM_depth.png",
                0.0002,
                {525, 525, 319.5, 239.5, 0},
                {{"floor", Vec3(0.011, -0.874, -0.486), 1.782},
                 {"board", Vec3(-0.020, 0.472, -0.881), 2.653},
                 {"table", Vec3(0.013, -0.856, -0.517), 1.134}}},
               1);
}

TEST(RealFrames, BasementOfNyu) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/nyu");
  expect_found({"rgbd/nyu/NYU_depth_raw11bit.png",
                0.001,
                {525, 525, 319.5, 239.5, 0},
                {{"floor", Vec3(-0.048, -0.962, -0.268), 1.613}}},
               1);
}

/// What people call one surface may be several to a sensor: a door and the wall around it (sun, 67 mm apart),
/// a board with what hangs on it (tum), a row of cabinets (nyu).
void expect_one(const Frame& frame, double within) {
  const Image<std::uint16_t> depth = unpacked(frame);
  const DepthImage image(depth.view(), frame.unit);
  const RayTable rays(Camera{depth.size(), frame.intrinsics, NoDistortion{}});
  PlaneOptions options;
  EXPECT_FALSE(match(find_planes(image, rays, options), image, rays, frame.baselines[0]).direct);
  options.one_within = within;
  const Planes found = find_planes(image, rays, options);
  EXPECT_TRUE(match(found, image, rays, frame.baselines[0]).direct) << frame.file;
  // The step shows.
  for (const DetectedPlane& plane : found.planes)
    if (same(plane.estimate.plane, frame.baselines[0])) EXPECT_GT(plane.rms, 0.008);
}

TEST(RealFrames, WhatIsOneWithinATolerance) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/sun");
  const Intrinsics usual{525, 525, 319.5, 239.5, 0};
  expect_one({"rgbd/sun/SUN_depth.png", 0.001, usual, {{"right", Vec3(-0.998, 0.031, -0.057), 0.622}}}, 0.04);
  expect_one({"rgbd/tum/TUM_depth.png", 0.0002, usual, {{"board", Vec3(-0.020, 0.472, -0.881), 2.653}}},
             0.05);
  expect_one(
      {"rgbd/nyu/NYU_depth_raw11bit.png", 0.001, usual, {{"cabinet", Vec3(-0.460, 0.249, -0.852), 2.466}}},
      0.08);
}

const Frame kTunnel{"rgbd/cape/depth_0.png",
                    0.001,
                    {575.93, 576.41, 315.15, 230.59, 0},
                    {{"floor", Vec3(-0.040, -0.935, -0.354), 1.363}}};

TEST(RealFrames, FloorOfTheTunnel) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/cape");
  expect_found(kTunnel, 0);
}

TEST(RealFrames, TheTunnelsWallIsOneCylinder) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/cape");
  const Image<std::uint16_t> depth = unpacked(kTunnel);
  const RayTable rays(Camera{depth.size(), kTunnel.intrinsics, NoDistortion{}});
  const Planes found = find_planes(DepthImage(depth.view(), 0.001), rays);
  ASSERT_FALSE(found.curves.empty());
  const auto largest = std::max_element(found.curves.begin(), found.curves.end(),
                                        [](const auto& a, const auto& b) { return a.pixels < b.pixels; });
  ASSERT_TRUE(std::holds_alternative<CylinderSurface>(largest->shape));
  const auto& cylinder = std::get<CylinderSurface>(largest->shape);
  EXPECT_EQ(cylinder.seen_from, SeenFrom::kInside);
  EXPECT_NEAR(cylinder.radius, 1.58, 0.1);
  EXPECT_GT(largest->pixels, 140000);
  // What is left as planes besides the floor is less than a tenth of the picture.
  int others = 0;
  for (const DetectedPlane& plane : found.planes)
    if (plane.estimate.plane.normal.y() > -0.8) others += plane.pixels;
  EXPECT_LT(others, depth.width() * depth.height() / 10);
  // Nor does a tolerance flatten it.
  PlaneOptions options;
  options.one_within = 0.08;
  const Planes again = find_planes(DepthImage(depth.view(), 0.001), rays, options);
  EXPECT_EQ(again.curves.size(), found.curves.size());
  EXPECT_EQ(again.planes.size(), found.planes.size());
}

}  // namespace
}  // namespace procam::depth
