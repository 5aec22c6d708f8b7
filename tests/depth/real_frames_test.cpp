/// Frames of five depth cameras, against planes that sequential RANSAC finds in them (band 10 mm + 4 mm z^2,
/// every second pixel, 0.3 to 6 m): what find_planes() finds of them, and main_planes() with one setting.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "plane_estimate.hpp"
#include "procam/depth/main_planes.hpp"
#include "procam/io/image/depth_file.hpp"
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

/// Calls visit(point) for every second pixel's readings in a plane's band, as the baselines were found.
template <typename Visit>
void for_band(const DepthImage& image, const RayTable& rays, const Plane& plane, const Visit& visit) {
  for (int y = 0; y < rays.size().height; y += 2)
    for (int x = 0; x < rays.size().width; x += 2) {
      const double z = double(image.at(x, y));
      if (z < 0.3 || z > 6) continue;
      const Vec3 p = z * Vec3(double(rays.u(x, y)), double(rays.v(x, y)), 1);
      if (std::abs(plane.signed_distance(p)) < 0.010 + 0.004 * z * z) visit(p);
    }
}

/// What the baseline's own rule makes of a plane: the points within its band, wherever they are, fitted,
/// again until nothing changes. It joins a door to its wall, which find_planes() keeps apart.
Plane by_band(const DepthImage& image, const RayTable& rays, Plane plane) {
  for (int round = 0; round < 30; ++round) {
    Vec3 sum = Vec3::Zero();
    Mat3 squares = Mat3::Zero();
    double n = 0;
    for_band(image, rays, plane, [&](const Vec3& p) {
      sum += p;
      squares += p * p.transpose();
      n += 1;
    });
    const Vec3 mean = sum / n;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(squares / n - mean * mean.transpose());
    Vec3 normal = eigen.eigenvectors().col(0);
    if (normal.dot(plane.normal) < 0) normal = -normal;
    plane = {normal, -normal.dot(mean)};
  }
  return plane;
}

/// What the baseline's RANSAC looks for most of.
int readings_in_band(const DepthImage& image, const RayTable& rays, const Plane& plane) {
  int count = 0;
  for_band(image, rays, plane, [&](const Vec3&) { ++count; });
  return count;
}

/// A frame and both levels of planes in it.
struct Seen {
  Image<std::uint16_t> depth;
  DepthImage image;
  RayTable rays;
  Planes fine;
  MainPlanes main;

  explicit Seen(const Frame& frame)
      : depth(unpacked(frame)),
        image(depth.view(), frame.unit),
        rays(Camera{depth.size(), frame.intrinsics, NoDistortion{}}),
        fine(find_planes(image, rays)),
        main(main_planes(fine, image, rays)) {}
};

bool has(const Planes& found, const Baseline& baseline) {
  return std::any_of(found.planes.begin(), found.planes.end(),
                     [&](const DetectedPlane& plane) { return same(plane.estimate.plane, baseline); });
}

/// Fine planes that the baseline's rule turns into it.
bool has_by_rule(const Seen& seen, const Baseline& baseline) {
  return std::any_of(seen.fine.planes.begin(), seen.fine.planes.end(), [&](const DetectedPlane& plane) {
    return angle_deg(plane.estimate.plane, baseline) < 10 &&
           same(by_band(seen.image, seen.rays, plane.estimate.plane), baseline);
  });
}

void expect_main(const Seen& seen, const std::vector<Baseline>& baselines) {
  for (const Baseline& baseline : baselines) EXPECT_TRUE(has(seen.main.planes, baseline)) << baseline.name;
}

/// What holds for any main planes: pixels are counted, members are named once at least, and none is called as
/// exact as what it is made of.
void expect_sound(const Seen& seen) {
  const Planes& planes = seen.main.planes;
  ASSERT_EQ(seen.main.members.size(), planes.planes.size());
  std::vector<int> counts(planes.planes.size() + planes.curves.size());
  for (int y = 0; y < planes.labels.height(); ++y)
    for (int x = 0; x < planes.labels.width(); ++x)
      if (const int label = planes.labels.at(x, y); label >= 0) ++counts.at(std::size_t(label));
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    const DetectedPlane& plane = planes.planes[i];
    EXPECT_EQ(plane.pixels, counts[i]);
    EXPECT_TRUE(i == 0 || planes.planes[i - 1].pixels >= plane.pixels);
    EXPECT_NEAR(plane.estimate.plane.signed_distance(plane.middle), 0, 1e-6);
    const std::vector<int>& members = seen.main.members[i];
    ASSERT_FALSE(members.empty());
    if (members.size() == 1) continue;
    const Eigen::Vector3d own = turn_covariance(plane.estimate).diagonal();
    EXPECT_TRUE(own.allFinite());
    EXPECT_GT(plane.rms, 0.003);
    for (const int member : members)
      if (std::size_t(member) < seen.fine.planes.size() &&
          seen.fine.planes[std::size_t(member)].pixels > plane.pixels / 2)
        EXPECT_GT(own.z(), seen.fine.planes[std::size_t(member)].estimate.covariance(3, 3));
  }
  for (std::size_t i = 0; i < planes.curves.size(); ++i)
    EXPECT_EQ(planes.curves[i].pixels, counts[planes.planes.size() + i]);
}

TEST(RealFrames, RedwoodsWallFloorAndFoldingScreen) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/redwood");
  const Baseline wall{"wall", Vec3(-0.298, -0.003, -0.955), 2.099},
      floor{"floor", Vec3(0.001, -1, -0.026), 0.444}, screen{"screen", Vec3(0.917, 0.013, -0.399), 1.061};
  const Seen seen({"rgbd/redwood/depth_00000.png"});
  EXPECT_TRUE(has(seen.fine, wall) && has(seen.fine, floor));
  // No leaf of the screen lies along it: it is the plane through the middle of the folds.
  EXPECT_FALSE(has(seen.fine, screen) || has_by_rule(seen, screen));
  expect_main(seen, {wall, floor, screen});
  expect_sound(seen);
}

TEST(RealFrames, CorridorOfSun) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/sun");
  const Baseline right{"right", Vec3(-0.998, 0.031, -0.057), 0.622},
      left{"left", Vec3(0.997, -0.029, 0.067), 0.795}, floor{"floor", Vec3(-0.022, -0.998, -0.064), 1.138};
  const Seen seen({"rgbd/sun/SUN_depth.png"});
  EXPECT_TRUE(has(seen.fine, floor));
  // A door and the wall around it, 67 mm apart.
  EXPECT_FALSE(has(seen.fine, right));
  expect_main(seen, {right, floor});
  expect_sound(seen);
  // The left baseline runs from a wall to what lies 114 mm behind it, whose other half is beyond its band.
  // The plane that main_planes() finds, 0.9 degrees and 35 mm from it, has more readings in that very band.
  EXPECT_TRUE(has_by_rule(seen, left));
  const auto& planes = seen.main.planes.planes;
  const auto found = std::find_if(planes.begin(), planes.end(), [&](const DetectedPlane& plane) {
    return angle_deg(plane.estimate.plane, left) < 2 &&
           std::abs(plane.estimate.plane.offset - left.offset) < 0.04;
  });
  ASSERT_NE(found, planes.end());
  const int ours = readings_in_band(seen.image, seen.rays, found->estimate.plane),
            baselines = readings_in_band(seen.image, seen.rays, {left.normal.normalized(), left.offset});
  RecordProperty("readings", std::to_string(ours) + " against " + std::to_string(baselines));
  EXPECT_GT(ours, baselines);
}

TEST(RealFrames, DeskOfTum) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/tum");
  const Baseline floor{"floor", Vec3(0.011, -0.874, -0.486), 1.782},
      board{"board", Vec3(-0.020, 0.472, -0.881), 2.653}, table{"table", Vec3(0.013, -0.856, -0.517), 1.134};
  const Seen seen({"rgbd/tum/TUM_depth.png", 0.0002});
  EXPECT_TRUE(has_by_rule(seen, floor) && has_by_rule(seen, board) && has_by_rule(seen, table));
  expect_main(seen, {floor, board, table});
  expect_sound(seen);
}

TEST(RealFrames, BasementOfNyu) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/nyu");
  const Baseline floor{"floor", Vec3(-0.048, -0.962, -0.268), 1.613},
      cabinet{"cabinet", Vec3(-0.460, 0.249, -0.852), 2.466};
  const Seen seen({"rgbd/nyu/NYU_depth_raw11bit.png"});
  EXPECT_TRUE(has(seen.fine, floor));
  expect_main(seen, {floor, cabinet});
  expect_sound(seen);
}

TEST(RealFrames, TheTunnelsWallIsOneCylinderAndStaysSo) {
  PROCAM_REQUIRE_TEST_DATA("rgbd/cape");
  const Baseline floor{"floor", Vec3(-0.040, -0.935, -0.354), 1.363};
  const Seen seen({"rgbd/cape/depth_0.png", 0.001, {575.93, 576.41, 315.15, 230.59, 0}});
  EXPECT_TRUE(has_by_rule(seen, floor));
  expect_main(seen, {floor});
  expect_sound(seen);
  // Bands of main planes would cut it into slabs.
  const auto most = [](const Planes& found) {
    int pixels = 0;
    for (const DetectedCurve& curve : found.curves) pixels = std::max(pixels, curve.pixels);
    return pixels;
  };
  EXPECT_EQ(most(seen.main.planes), most(seen.fine));
  for (const Planes* const found : {&seen.fine, &seen.main.planes}) {
    ASSERT_FALSE(found->curves.empty());
    const auto largest = std::max_element(found->curves.begin(), found->curves.end(),
                                          [](const auto& a, const auto& b) { return a.pixels < b.pixels; });
    ASSERT_TRUE(std::holds_alternative<CylinderSurface>(largest->shape));
    const auto& cylinder = std::get<CylinderSurface>(largest->shape);
    EXPECT_EQ(cylinder.seen_from, SeenFrom::kInside);
    EXPECT_NEAR(cylinder.radius, 1.58, 0.1);
    EXPECT_GT(largest->pixels, 140000);
    // What is left as planes besides the floor is less than a tenth of the picture.
    int others = 0;
    for (const DetectedPlane& plane : found->planes)
      if (plane.estimate.plane.normal.y() > -0.8) others += plane.pixels;
    EXPECT_LT(others, seen.depth.width() * seen.depth.height() / 10);
  }
}

}  // namespace
}  // namespace procam::depth
