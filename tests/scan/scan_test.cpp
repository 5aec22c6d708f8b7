#include "procam/scan/scan.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/scan/scan_error.hpp"
#include "procam/scan/scan_mesh.hpp"
#include "support/expect_error.hpp"

namespace procam::scan {
namespace {

/// Skewed, distorted lenses, their axes off the middle; the projector stands to the right, turned and rolled.
Rig lopsided_rig() {
  Rig rig;
  RigCamera camera;
  camera.camera = {{96, 64}, {110, 113, 50.5, 29, 0.7}, BrownConrady{{-0.08, 0.02, 0.001, -0.0008, 0}}};
  camera.rig_from_camera = Pose(so3_exp(Vec3(0.02, -0.01, 0.03)), Vec3(0.01, 0.02, -0.03));
  RigProjector projector;
  projector.projector.inverse_camera = {
      {200, 150}, {215, 206, 96, 141, -0.9}, BrownConrady{{0.05, -0.03, -0.001, 0.002, 0}}};
  projector.rig_from_projector = Pose(so3_exp(Vec3(-0.2, -0.17, 0.1)), Vec3(0.31, 0.12, 0.05));
  rig.cameras.push_back(camera);
  rig.projectors.push_back(projector);
  return rig;
}

const Plane kWall{Vec3(0.15, -0.1, -0.98).normalized(), 1.6};  // in the rig

struct Look {
  LightMap light;
  ImageF depth;  ///< true; 0 where the projector does not light
};

/// The exact light on `surface_depth(pixel, ray in the rig)`, with that standard deviation drawn from `seed`.
template <typename DepthOf>
Look look_at(const Rig& rig, const DepthOf& depth_of, double sigma, unsigned seed) {
  const RigCamera& camera = rig.camera();
  const RigProjector& projector = rig.projector();
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  Look look;
  look.light.projector_size = projector.projector.size();
  look.light.pixel = ImageF(camera.camera.size, 2);
  look.light.sigma = ImageF(camera.camera.size, 2);
  look.depth = ImageF(camera.camera.size);
  for (int y = 0; y < camera.camera.size.height; ++y)
    for (int x = 0; x < camera.camera.size.width; ++x) {
      const Vec3 bearing = *camera.camera.unproject(Vec2(x, y));
      const double z = depth_of(x, y, Vec3(bearing / bearing.z()));
      const Vec3 point = camera.rig_from_camera * Vec3(bearing * (z / bearing.z()));
      const auto pixel = projector.projector.project(projector.rig_from_projector.inverse() * point);
      if (!pixel || !projector.projector.size().contains(*pixel)) continue;
      look.depth.at(x, y) = float(z);
      for (int c = 0; c < 2; ++c) {
        look.light.pixel.at(x, y, c) = float((*pixel)[c] + noise(random));
        look.light.sigma.at(x, y, c) = float(sigma);
      }
    }
  return look;
}

Look look_at_wall(const Rig& rig, double sigma, unsigned seed) {
  const Pose rig_from_camera = rig.camera().rig_from_camera;
  return look_at(
      rig,
      [&](int, int, const Vec3& ray) {
        const Vec3 direction = rig_from_camera.rotation * ray;
        return -(kWall.offset + kWall.normal.dot(rig_from_camera.translation)) / kWall.normal.dot(direction);
      },
      sigma, seed);
}

ScanOptions quiet() {
  ScanOptions options;
  options.threads = 2;
  return options;
}

TEST(Scan, OfExactLightIsExact) {
  const Rig rig = lopsided_rig();
  const Look look = look_at_wall(rig, 0.01, 0);
  Look exact = look_at_wall(rig, 1e-9, 0);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x)
      for (int c = 0; c < 2; ++c) exact.light.sigma.at(x, y, c) = look.light.sigma.at(x, y, c);
  const Scan scan = measure_depth(exact.light, rig, "", "", quiet());
  EXPECT_GT(scan.counts.measured, 1500);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x) {
      EXPECT_EQ(scan.measured(x, y), exact.depth.at(x, y) > 0) << x << " " << y;
      // Linear interpolation of the projector's lens on four pixels, and float: some thousandths of its pixels.
      EXPECT_NEAR(scan.depth.at(x, y), exact.depth.at(x, y), 1e-4) << x << " " << y;
    }
  EXPECT_NE(scan.diagnostics.find("no_rig_covariance"), nullptr);
}

/// Errors of both coordinates, weighted: the mean of (error / sigma)^2 is 1 with a standard deviation of sqrt(2 / n); five of them,
/// one false alarm in 1.7 million seeds.
TEST(Scan, StatesTheStandardDeviationOfTheLight) {
  const Rig rig = lopsided_rig();
  Look look = look_at_wall(rig, 0.05, 11);
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  double sum = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x)
      if (scan.measured(x, y)) {
        const double off = (scan.depth.at(x, y) - look.depth.at(x, y)) / scan.sigma.at(x, y);
        sum += off * off;
      }
  const double n = scan.counts.measured;
  EXPECT_GT(n, 1500);
  EXPECT_NEAR(sum / n, 1, 5 * std::sqrt(2 / n) + 0.02);  // pixels beyond four sigmas are rejected
  EXPECT_NEAR(scan.consistency, 1, 0.15);
}

/// The same light read by 400 rigs drawn from the covariance: the spread of a pixel's depth is the stated one. Its standard
/// error is 3.5 %; five of them.
TEST(Scan, StatesTheStandardDeviationOfTheRig) {
  Rig rig = lopsided_rig();
  rig.covariance.names = {"projector.fx", "projector.cy", "rig_from_projector.ry", "rig_from_projector.tz",
                          "camera.cx"};
  const Vec3 a(0.8, 0.5, 0.002);
  rig.covariance.matrix = MatX::Zero(5, 5);
  rig.covariance.matrix.diagonal() << a.x() * a.x(), a.y() * a.y(), a.z() * a.z(), 1e-6, 0.04;
  rig.covariance.matrix(0, 2) = rig.covariance.matrix(2, 0) = -0.6 * a.x() * a.z();
  Look look = look_at_wall(rig, 1e-9, 0);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x)
      for (int c = 0; c < 2; ++c)
        if (look.depth.at(x, y) > 0) look.light.sigma.at(x, y, c) = c == 0 ? 0.04f : 0.08f;
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  ScanOptions all = quiet();
  all.consistency_sigmas = 1e6;
  const MatX root = Eigen::LLT<MatX>(rig.covariance.matrix).matrixL();
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const std::pair<int, int> pixels[] = {{30, 20}, {50, 32}, {60, 45}};
  std::map<int, std::pair<double, double>> sums;
  constexpr int kDraws = 400;
  for (int draw = 0; draw < kDraws; ++draw) {
    VecX unit(5);
    for (double& value : unit) value = normal(random);
    const VecX e = root * unit;
    Rig other = rig;
    Camera& lens = other.projectors[0].projector.inverse_camera;
    lens.intrinsics.fx += e[0];
    lens.intrinsics.cy += e[1];
    Vec6 increment = Vec6::Zero();
    increment[1] = e[2];
    increment[5] = e[3];
    other.projectors[0].rig_from_projector = se3_exp(increment) * other.projectors[0].rig_from_projector;
    other.cameras[0].camera.intrinsics.cx += e[4];
    other.covariance = {};
    const Scan drawn = measure_depth(look.light, other, "", "", all);
    for (int i = 0; i < 3; ++i) {
      const double off = drawn.depth.at(pixels[i].first, pixels[i].second) -
                         scan.depth.at(pixels[i].first, pixels[i].second);
      sums[i].first += off;
      sums[i].second += off * off;
    }
  }
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(scan.measured(pixels[i].first, pixels[i].second));
    const double mean = sums[i].first / kDraws, spread = std::sqrt(sums[i].second / kDraws - mean * mean);
    EXPECT_NEAR(scan.rig_sigma.at(pixels[i].first, pixels[i].second) / spread, 1, 0.18) << i;
  }
}

TEST(Scan, RejectsPixelsThatWereDecodedWrongly) {
  const Rig rig = lopsided_rig();
  Look look = look_at_wall(rig, 0.05, 3);
  int wrong = 0;
  for (int y = 5; y < 60; y += 7)
    for (int x = 4; x < 90; x += 9)
      if (look.depth.at(x, y) > 0) {
        look.light.pixel.at(x, y, wrong % 2) += wrong % 3 == 0 ? -16.0f : 12.0f;
        ++wrong;
      }
  ASSERT_GT(wrong, 30);
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  const ScanError error = compare(scan, look.depth);
  EXPECT_EQ(error.outliers, 0);
  EXPECT_GE(scan.counts.inconsistent + scan.counts.isolated + scan.counts.out_of_range, wrong);
  EXPECT_LE(scan.counts.inconsistent + scan.counts.isolated, wrong + scan.counts.lit / 100);
  EXPECT_GT(error.inside_3_sigma, 0.99);
}

TEST(Scan, SaysThatTheRigHasMoved) {
  const Rig rig = lopsided_rig();
  const Look look = look_at_wall(rig, 0.05, 4);
  EXPECT_EQ(measure_depth(look.light, rig, "", "", quiet()).diagnostics.find("rig_inconsistent"), nullptr);
  Rig bumped = rig;
  Pose& place = bumped.projectors[0].rig_from_projector;
  place = place * Pose(so3_exp(Vec3(0.01, 0, 0)), Vec3::Zero());  // three pixels across the base line
  const Scan scan = measure_depth(look.light, bumped, "", "", quiet());
  EXPECT_NE(scan.diagnostics.find("rig_inconsistent"), nullptr);
  EXPECT_GT(scan.consistency_px, 1);
}

TEST(Scan, RefusesWhatCannotBe) {
  const Rig rig = lopsided_rig();
  const Look look = look_at_wall(rig, 0.05, 4);
  LightMap dark = look.light;
  dark.sigma = ImageF(96, 64, 2);
  EXPECT_EQ(procam::test::error_of([&] { measure_depth(dark, rig); }).kind(), ErrorKind::kNotEnoughData);
  LightMap other = look.light;
  other.projector_size = {150, 200};
  EXPECT_EQ(procam::test::error_of([&] { measure_depth(other, rig); }).kind(), ErrorKind::kInput);
  Rig one_place = rig;
  one_place.projectors[0].rig_from_projector.translation = rig.camera().rig_from_camera.translation;
  EXPECT_EQ(procam::test::error_of([&] { measure_depth(look.light, one_place); }).kind(),
            ErrorKind::kDegenerate);
  EXPECT_EQ(procam::test::error_of([&] { measure_depth(look.light, rig, "nobody"); }).kind(),
            ErrorKind::kInput);
  // The projector on the other side: all light would have to come from behind the camera.
  Rig mirrored = rig;
  mirrored.projectors[0].rig_from_projector.translation.x() -= 0.9;
  EXPECT_EQ(procam::test::error_of([&] { measure_depth(look.light, mirrored); }).kind(),
            ErrorKind::kNotEnoughData);
  LightMap broken = look.light;
  broken.pixel.at(40, 30, 0) = std::nanf("");
  EXPECT_FALSE(measure_depth(broken, rig).measured(40, 30));
}

/// How often each edge belongs to a triangle.
std::map<std::pair<int, int>, int> edges_of(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> count;
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) ++count[std::minmax(t[std::size_t(i)], t[std::size_t((i + 1) % 3)])];
  return count;
}

/// Edges whose middle is a vertex of another triangle: cracks.
int cracks_of(const Mesh& mesh) {
  const auto pixel = [&](int vertex) {
    const Vec2& uv = mesh.uv[std::size_t(vertex)];
    return std::pair<int, int>(int(std::lround(uv.x() * 96 - 0.5)), int(std::lround(uv.y() * 64 - 0.5)));
  };
  std::set<std::pair<int, int>> vertices;
  for (int i = 0; i < int(mesh.vertices.size()); ++i) vertices.insert(pixel(i));
  int cracks = 0;
  for (const auto& [edge, count] : edges_of(mesh)) {
    const auto [ax, ay] = pixel(edge.first);
    const auto [bx, by] = pixel(edge.second);
    if (std::abs(ax - bx) > 1 || std::abs(ay - by) > 1)
      cracks += int(vertices.count({(ax + bx) / 2, (ay + by) / 2}));
  }
  return cracks;
}

TEST(ScanMesh, OfAWallHasFewTrianglesAndNoCracks) {
  const Rig rig = lopsided_rig();
  const Look look = look_at_wall(rig, 0.01, 8);
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  ASSERT_GE(scan.counts.measured, scan.counts.lit - 5);  // one in 16000 is beyond four sigmas
  MeshOptions options;
  options.max_deviation = 5e-3;
  const Mesh mesh = mesh_of(scan, options);
  EXPECT_FALSE(fault_of(mesh));
  EXPECT_LT(mesh.triangles.size(), 2 * std::size_t(scan.counts.measured) / 4);
  double area = 0;
  for (const auto& t : mesh.triangles) area += 0.5 * area_vector(mesh, t).norm();
  for (const Vec3& vertex : mesh.vertices) EXPECT_LT(std::abs(kWall.signed_distance(vertex)), 5e-3);
  // Whole: as large as the mesh of single pixels, and an edge belongs to two triangles, or lies on the border.
  options.max_deviation = 1e-9;
  options.max_sigmas = 0;
  const Mesh fine = mesh_of(scan, options);
  double fine_area = 0;
  for (const auto& t : fine.triangles) fine_area += 0.5 * area_vector(fine, t).norm();
  EXPECT_NEAR(area / fine_area, 1, 0.01);
  int border = 0, fine_border = 0;
  for (const auto& [edge, count] : edges_of(mesh)) {
    EXPECT_LE(count, 2);
    border += count == 1;
  }
  for (const auto& [edge, count] : edges_of(fine)) fine_border += count == 1;
  EXPECT_LE(border, fine_border);
}

TEST(ScanMesh, KeepsStepsAndHoles) {
  const Rig rig = lopsided_rig();
  const auto step = [](int x, int, const Vec3&) { return x < 47 ? 1.3 : 1.7; };
  Look look = look_at(rig, step, 0.01, 2);
  for (int y = 20; y < 32; ++y)
    for (int x = 60; x < 72; ++x) look.light.sigma.at(x, y, 0) = 0;
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  const Mesh mesh = mesh_of(scan);
  EXPECT_EQ(cracks_of(mesh), 0);
  EXPECT_LT(mesh.triangles.size(), std::size_t(scan.counts.measured));
  const Pose camera_from_rig = rig.camera().rig_from_camera.inverse();
  for (const auto& t : mesh.triangles) {
    double nearest = 9, farthest = 0;
    Vec2 middle = Vec2::Zero();
    for (const int corner : t) {
      const double z = (camera_from_rig * mesh.vertices[std::size_t(corner)]).z();
      nearest = std::min(nearest, z);
      farthest = std::max(farthest, z);
      middle += mesh.uv[std::size_t(corner)] / 3;
    }
    EXPECT_LT(farthest - nearest, 0.1);
    const double x = middle.x() * 96 - 0.5, y = middle.y() * 64 - 0.5;
    EXPECT_FALSE(x > 59.5 && x < 71.5 && y > 19.5 && y < 31.5) << x << " " << y;
  }
}

/// Specks that were not decoded would be black specks in the content; a gap at a step belongs to neither side.
TEST(ScanMesh, BridgesSmallHolesWithinOneSurfaceAlone) {
  const Rig rig = lopsided_rig();
  const Look whole = look_at_wall(rig, 0.01, 4);
  const auto step = [&](int x, int y, const Vec3&) {
    return double(whole.depth.at(x, y)) - (x < 47 ? 0.06 : 0.0);
  };
  Look look = look_at(rig, step, 0.01, 4);
  const auto omit = [&](int left, int top, int width, int height) {
    for (int y = top; y < top + height; ++y)
      for (int x = left; x < left + width; ++x) look.light.sigma.at(x, y, 0) = 0;
  };
  omit(45, 0, 4, 64);
  std::vector<std::pair<int, int>> specks;
  for (int y = 12; y < 56; y += 6)
    for (int x = 60; x < 90; x += 7) specks.emplace_back(x, y);
  for (const auto& [x, y] : specks) omit(x, y, 1, 1);
  omit(20, 16, 5, 12);
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  const auto area_between = [&](const Mesh& mesh, double left, double right) {
    double area = 0;
    for (const auto& t : mesh.triangles) {
      Vec2 middle = Vec2::Zero();
      for (const int corner : t) middle += mesh.uv[std::size_t(corner)] / 3;
      const double x = middle.x() * 96 - 0.5;
      if (x > left && x < right) area += 0.5 * area_vector(mesh, t).norm();
    }
    return area;
  };
  const Mesh mesh = mesh_of(scan);
  EXPECT_EQ(cracks_of(mesh), 0);
  EXPECT_EQ(area_between(mesh, 44.1, 48.9), 0) << "the step is open";
  // The whole wall, but for the pixels at the picture's border that a triangle needs.
  const Mesh without_holes = mesh_of(measure_depth(whole.light, rig, "", "", quiet()));
  EXPECT_NEAR(area_between(mesh, 50, 96) / area_between(without_holes, 50, 96), 1, 0.01);
  MeshOptions options;
  options.max_hole = 0;
  EXPECT_LT(area_between(mesh_of(scan, options), 50, 96) / area_between(without_holes, 50, 96), 0.98);
  // What bridges them lies on the wall, and on the one that is 60 mm nearer.
  const Pose camera_from_rig = rig.camera().rig_from_camera.inverse();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const int x = int(std::lround(mesh.uv[i].x() * 96 - 0.5)),
              y = int(std::lround(mesh.uv[i].y() * 64 - 0.5));
    const double z = (camera_from_rig * mesh.vertices[i]).z();
    EXPECT_NEAR(z, step(x, y, Vec3::Zero()), 3e-3) << x << " " << y;
  }
}

TEST(ScanMesh, RefusesAScanWithoutASurface) {
  const Rig rig = lopsided_rig();
  const Look look = look_at_wall(rig, 0.01, 2);
  Scan scan = measure_depth(look.light, rig, "", "", quiet());
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x)
      if (x % 12 != 0 || y % 12 != 0) scan.depth.at(x, y) = 0;
  EXPECT_EQ(procam::test::error_of([&] { mesh_of(scan); }).kind(), ErrorKind::kNotEnoughData);
}

TEST(PointCloud, HasTheWallsNormalAndStandardDeviation) {
  const Rig rig = lopsided_rig();
  const Look look = look_at_wall(rig, 0.01, 2);
  const Scan scan = measure_depth(look.light, rig, "", "", quiet());
  const PointCloud cloud = point_cloud(scan);
  ASSERT_EQ(cloud.points.size(), std::size_t(scan.counts.measured));
  std::vector<double> angle, ratio;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    angle.push_back(std::acos(std::clamp(cloud.normals[i].dot(kWall.normal), -1.0, 1.0)));
    ratio.push_back(std::abs(kWall.signed_distance(cloud.points[i])) / cloud.sigma[i]);
  }
  EXPECT_LT(median(angle), 2 * kDegree);  // towards the camera: as the wall's normal
  EXPECT_LT(quantile(ratio, 0.99), 3);
}

}  // namespace
}  // namespace procam::scan
