/// Laws for every surface that is drawn as triangles; the list comes from the variant.
#include "procam/core/surface/surface.hpp"
#include "procam/core/surface/tessellate.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

template <typename Shape>
Shape example();

template <>
GridSurface example<GridSurface>() {
  GridSurface grid;
  grid.columns = 4;
  grid.rows = 3;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i)
      grid.points.emplace_back(0.31 * i + 0.02 * j, 0.27 * j - 0.03 * i,
                               0.05 * i * j - 0.04 * i + 0.02 * j * j);
  return grid;
}

template <>
BezierSurface example<BezierSurface>() {
  BezierSurface patch;
  patch.columns = 4;
  patch.rows = 3;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i)
      patch.control_points.emplace_back(0.4 * i, 0.35 * j + 0.06 * i,
                                        (i % 2 ? 0.31 : -0.12) + 0.2 * j * (2 - j));
  return patch;
}

template <>
CylinderSurface example<CylinderSurface>() {
  CylinderSurface column;
  column.radius = 0.43;
  column.left = -50 * kDegree;
  column.right = 71 * kDegree;
  column.top = -0.2;
  column.bottom = 0.9;
  return column;
}

template <>
SphereSurface example<SphereSurface>() {
  SphereSurface dome;
  dome.radius = 1.3;
  dome.left = -80 * kDegree;
  dome.right = 62 * kDegree;
  dome.top = 41 * kDegree;
  dome.bottom = -67 * kDegree;
  dome.seen_from = SeenFrom::kInside;
  return dome;
}

template <>
MeshSurface example<MeshSurface>() {
  MeshSurface roof;
  roof.file = "roof.obj";
  Mesh mesh;
  mesh.vertices = {{0, 0, 0.2},     {0.7, 0.03, 0}, {1.5, 0, 0.31},
                   {0.1, 0.9, 0.2}, {0.8, 1, 0.05}, {1.4, 1.1, 0.3}};
  mesh.uv = {{0, 0}, {0.4, 0}, {1, 0}, {0, 1}, {0.4, 1}, {1, 1}};
  mesh.triangles = {{0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}};
  roof.mesh = std::make_shared<const Mesh>(mesh);
  return roof;
}

/// What the variant holds beyond planes and pixels, as googletest wants it.
template <typename Variant>
struct Drawn;
template <typename Plane, typename Pixels, typename... Shapes>
struct Drawn<std::variant<Plane, Pixels, Shapes...>> {
  using Types = ::testing::Types<Shapes...>;
};

template <typename Shape>
class SurfaceOfTriangles : public ::testing::Test {};
TYPED_TEST_SUITE(SurfaceOfTriangles, Drawn<SurfaceGeometry>::Types);

TYPED_TEST(SurfaceOfTriangles, IsDrawnAsAMeshWithoutAFaultThatReadsTheRightWayRound) {
  const auto mesh = mesh_of(Surface{"wall", example<TypeParam>(), {}, ""});
  ASSERT_TRUE(mesh);
  EXPECT_EQ(fault_of(*mesh), std::nullopt);
  for (const auto& triangle : mesh->triangles) {
    const auto uv = [&](std::size_t i) { return mesh->uv[std::size_t(triangle[i])]; };
    const Vec2 du = uv(1) - uv(0), dv = uv(2) - uv(0);
    const double sense = du.x() * dv.y() - du.y() * dv.x();
    EXPECT_GT(sense * area_vector(*mesh, triangle).z(), 0) << "a reader on the -z side sees content mirrored";
  }
}

TYPED_TEST(SurfaceOfTriangles, KeepsWithinTheToleranceEverywhere) {
  const TypeParam shape = example<TypeParam>();
  if constexpr (!std::is_same_v<TypeParam, MeshSurface>) {
    std::mt19937_64 random(7);
    for (const double tolerance : {1e-4, 3e-3}) {
      const Mesh mesh = tessellate(shape, tolerance);
      double worst = 0;
      for (int draw = 0; draw < 20000; ++draw) {
        const auto& triangle = mesh.triangles[random() % mesh.triangles.size()];
        const double root = std::sqrt(test::uniform(random, 0, 1)), along = test::uniform(random, 0, 1);
        const double b[3] = {1 - root, root * (1 - along), root * along};
        Vec3 point = Vec3::Zero();
        Vec2 uv = Vec2::Zero();
        for (std::size_t i = 0; i < 3; ++i) {
          point += b[i] * mesh.vertices[std::size_t(triangle[i])];
          uv += b[i] * mesh.uv[std::size_t(triangle[i])];
        }
        worst = std::max(worst, (point - shape.point(uv)).norm());
      }
      EXPECT_LT(worst, tolerance);
      if (tolerance == 1e-4 && !std::is_same_v<TypeParam, GridSurface>)
        EXPECT_GT(worst, 0.1 * tolerance) << "far finer than asked";
    }
  } else {
    EXPECT_EQ(mesh_of(Surface{"wall", shape, {}, ""}), shape.mesh);
  }
}

TEST(Surface, CurvedShapesHoldTheirCornersAndRadii) {
  const auto column = example<CylinderSurface>();
  EXPECT_NEAR(std::hypot(column.point({0.3, 0.7}).x(), column.point({0.3, 0.7}).z()), 0.43, 1e-12);
  EXPECT_LT((column.point({0, 1}) - Vec3(-0.43 * std::sin(50 * kDegree), 0.9, -0.43 * std::cos(50 * kDegree)))
                .norm(),
            1e-12);
  const auto dome = example<SphereSurface>();
  EXPECT_NEAR(dome.point({0.9, 0.2}).norm(), 1.3, 1e-12);
  EXPECT_LT((dome.point({0.5, 0}) - 1.3 * Vec3(std::cos(41 * kDegree) * std::sin(-9 * kDegree),
                                               -std::sin(41 * kDegree),
                                               std::cos(41 * kDegree) * std::cos(-9 * kDegree)))
                .norm(),
            1e-12);
  const auto grid = example<GridSurface>();
  EXPECT_LT((grid.point({1.0 / 3, 0.5}) - grid.points[5]).norm(), 1e-12);
  EXPECT_LT((grid.point({1, 1}) - grid.points.back()).norm(), 1e-12);
}

TEST(Surface, BezierPatchIsItsBernsteinSum) {
  const auto patch = example<BezierSurface>();
  const double u = 0.37, v = 0.81;
  const double bu[4] = {(1 - u) * (1 - u) * (1 - u), 3 * u * (1 - u) * (1 - u), 3 * u * u * (1 - u),
                        u * u * u};
  const double bv[3] = {(1 - v) * (1 - v), 2 * v * (1 - v), v * v};
  Vec3 sum = Vec3::Zero();
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 4; ++i) sum += bu[i] * bv[j] * patch.control_points[4 * j + i];
  EXPECT_LT((patch.point({u, v}) - sum).norm(), 1e-14);
}

TEST(Surface, AWholeSphereHasNoTriangleWithoutArea) {
  SphereSurface globe;
  globe.left = -kPi;
  globe.right = kPi;
  globe.top = kPi / 2;
  globe.bottom = -kPi / 2;
  const Mesh mesh = tessellate(globe, 1e-3);
  EXPECT_EQ(fault_of(mesh), std::nullopt);
  double area = 0;
  for (const auto& triangle : mesh.triangles) area += 0.5 * area_vector(mesh, triangle).norm();
  EXPECT_NEAR(area, 4 * kPi, 0.02);
}

TEST(Surface, RefusesAShapeThatCannotBeByNameAndReason) {
  const auto refused = [](SurfaceGeometry geometry) -> std::string {
    try {
      mesh_of(Surface{"niche", std::move(geometry), {}, ""});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return error.what();
    }
    return "";
  };
  auto column = example<CylinderSurface>();
  column.radius = -1;
  EXPECT_NE(refused(column).find("surface 'niche': its radius"), std::string::npos);
  column = example<CylinderSurface>();
  std::swap(column.left, column.right);
  EXPECT_NE(refused(column), "");
  auto dome = example<SphereSurface>();
  dome.top = 100 * kDegree;
  EXPECT_NE(refused(dome), "");
  auto grid = example<GridSurface>();
  grid.points.pop_back();
  EXPECT_NE(refused(grid), "");
  grid = example<GridSurface>();
  grid.points[3].y() = std::nan("");
  EXPECT_NE(refused(grid), "");
  auto patch = example<BezierSurface>();
  patch.columns = 17;
  EXPECT_NE(refused(patch), "");
  EXPECT_NE(refused(MeshSurface{}), "");
}

TEST(Mesh, NamesItsFault) {
  const Mesh good = *example<MeshSurface>().mesh;
  ASSERT_EQ(fault_of(good), std::nullopt);
  Mesh bad = good;
  bad.uv.pop_back();
  EXPECT_NE(fault_of(bad).value_or("").find("content coordinates"), std::string::npos);
  bad = good;
  bad.vertices[4].z() = std::nan("");
  EXPECT_NE(fault_of(bad).value_or("").find("vertex 4"), std::string::npos);
  bad = good;
  bad.triangles[2][1] = 6;
  EXPECT_NE(fault_of(bad).value_or("").find("triangle 2 has a corner 6"), std::string::npos);
  bad = good;
  bad.triangles[1] = {1, 4, 1};
  EXPECT_NE(fault_of(bad).value_or("").find("triangle 1 has no area"), std::string::npos);
  EXPECT_NE(fault_of(Mesh{}), std::nullopt);
}

}  // namespace
}  // namespace procam
