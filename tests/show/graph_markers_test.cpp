#include "graph_markers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "procam/core/geometry/se3.hpp"
#include "procam/surface/solve.hpp"

namespace procam::show {
namespace {

Pose twisted(const Vec3& w, const Vec3& v) {
  return Pose(so3_exp(w), v);
}

SolvedSurface slanted_wall() {
  SolvedSurface wall;
  wall.surface.name = "wall";
  PlacedPlane plane;
  plane.plane_from_content << 1.4, 0.1, -0.6, 0.05, 0.9, -0.3, 0.02, 0.01, 1;
  plane.projector_from_surface = twisted(Vec3(0.3, -0.5, 0.1), Vec3(0.2, -0.1, 2.3));
  wall.placement = plane;
  return wall;
}

TEST(GraphMarkers, TheEllipseHoldsTheLightWithNinetyFivePercent) {
  const SolvedSurface wall = slanted_wall();
  const auto& plane = std::get<PlacedPlane>(wall.placement);
  const Pose world_from_projector = twisted(Vec3(-1.2, 0.4, 0.8), Vec3(3, -1, 0.5));
  Mat6 root = Mat6::Zero();
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k <= i; ++k) root(i, k) = 1e-3 * (1 + i) + 4e-4 * k * (i - 3);
  const std::vector<dds::GraphMarker> markers =
      error_markers(wall, "procam/surfaces/wall", world_from_projector, root * root.transpose());
  ASSERT_EQ(markers.size(), 2u);
  EXPECT_EQ(markers[0].frame, "procam/surfaces/wall");
  ASSERT_EQ(markers[0].lines.size(), 64u);
  // The ellipse by its points: q^T M q = 1.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : markers[0].lines) middle += p / 64;
  const Vec3 expected = plane.plane_from_content * Vec3(0.5, 0.5, 1);
  EXPECT_NEAR(middle.x(), expected.x() / expected.z(), 1e-9);
  EXPECT_NEAR(middle.y(), expected.y() / expected.z(), 1e-9);
  Eigen::Matrix<double, 64, 3> rows;
  for (int i = 0; i < 64; ++i) {
    const Vec3 q = markers[0].lines[std::size_t(i)] - middle;
    EXPECT_EQ(q.z(), 0);
    rows.row(i) << q.x() * q.x(), 2 * q.x() * q.y(), q.y() * q.y();
  }
  const Vec3 m =
      (rows.transpose() * rows).ldlt().solve(rows.transpose() * Eigen::Matrix<double, 64, 1>::Ones());
  // Light for the estimated pose lands where the true projector throws it: by rays and the plane, nothing linear.
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Pose world_from_plane = world_from_projector * plane.projector_from_surface;
  const Vec3 in_projector = plane.projector_from_surface * middle;
  int inside = 0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    Vec6 z;
    for (int k = 0; k < 6; ++k) z[k] = normal(random);
    const Pose plane_from_true = world_from_plane.inverse() * se3_exp(Vec6(root * z)) * world_from_projector;
    const Vec3 from = plane_from_true.translation, to = plane_from_true * in_projector;
    const Vec3 hit = from + (to - from) * (from.z() / (from.z() - to.z()));
    const Vec3 q = hit - middle;
    inside += m[0] * q.x() * q.x() + 2 * m[1] * q.x() * q.y() + m[2] * q.y() * q.y() < 1 ? 1 : 0;
  }
  // 95 % of 4000 with 4 standard deviations of 0.34 %.
  EXPECT_NEAR(double(inside) / kSamples, 0.95, 0.014);
  double longest = 0;
  for (const Vec3& p : markers[0].lines) longest = std::max(longest, (p - middle).norm());
  EXPECT_NEAR(1e3 * longest, std::stod(markers[1].text.substr(6)), 0.01 * 1e3 * longest) << markers[1].text;
  EXPECT_TRUE(error_markers(wall, "", world_from_projector, Mat6::Zero()).empty()) << "unknown";
  SolvedSurface behind = wall;
  std::get<PlacedPlane>(behind.placement).projector_from_surface.translation.z() = -2.3;
  EXPECT_TRUE(error_markers(behind, "", world_from_projector, Mat6::Identity()).empty());
}

TEST(GraphMarkers, TheFrustumEndsOnTheBorderOfTheImage) {
  Camera lens;
  lens.size = {320, 200};
  lens.intrinsics = {410.0, 396.0, 171.3, 148.9, 1.7};
  lens.distortion = BrownConrady{{-0.1, 0.02, 0.003, -0.004, 0.0005}};
  const dds::GraphMarker marker = frustum_marker(lens, "procam/lamp", 2.5);
  EXPECT_EQ(marker.lines.size(), 2u * (4 + 32));
  int from_lens = 0;
  for (const Vec3& p : marker.lines) {
    if (p == Vec3::Zero()) {
      ++from_lens;
      continue;
    }
    EXPECT_NEAR(p.z(), 2.5, 1e-12);
    const Vec2 pixel = *lens.project(p);
    const double beside = std::min(std::min(std::abs(pixel.x() + 0.5), std::abs(pixel.x() - 319.5)),
                                   std::min(std::abs(pixel.y() + 0.5), std::abs(pixel.y() - 199.5)));
    EXPECT_LT(beside, 1e-6);
  }
  EXPECT_EQ(from_lens, 4);
}

TEST(GraphMarkers, OutlinesOfPlanesAndMeshes) {
  const dds::GraphMarker plane = outline_marker(slanted_wall(), "f");
  ASSERT_EQ(plane.lines.size(), 8u);
  EXPECT_EQ(plane.name, "surface wall");
  EXPECT_NEAR(plane.lines[0].x(), -0.6, 1e-12);
  EXPECT_NEAR(plane.lines[1].x(), 0.8 / 1.02, 1e-12);
  EXPECT_EQ(plane.lines[7], plane.lines[0]);
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0.5}, {0, 2, 0.5}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  SolvedSurface folded;
  folded.placement = PlacedMesh{mesh, Pose()};
  EXPECT_EQ(outline_marker(folded, "f").lines.size(), 8u) << "the diagonal is no border";
  folded.placement = PlacedPixels{};
  EXPECT_TRUE(outline_marker(folded, "f").lines.empty());
}

}  // namespace
}  // namespace procam::show
