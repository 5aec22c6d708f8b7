#pragma once
/// From a curved surface to triangles that are nowhere farther from it than told.
#include <algorithm>
#include <array>
#include <string>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/mesh.hpp"

namespace procam {

/// A regular grid of triangles over (u, v): `shape.cells()` cells a side to begin with, doubled along u or v
/// until the middle of every cell's side and diagonal lies within 3/4 of `tolerance` (metres) of
/// shape.point() there. That bounds both the distance from the surface and how far content slides along it:
/// over a cell a smooth surface is a quadratic, whose error inside a triangle is at most 4/3 of that at its
/// sides' middles. Throws Error(kInput) where 1024 cells a side do not suffice: the shape is not smooth.
template <typename Shape>
Mesh tessellate(const Shape& shape, double tolerance) {
  constexpr int kMaxCells = 1024;
  require(tolerance > 0, "tessellate: the tolerance must be positive");
  const double at_middles = 0.75 * tolerance;
  int across = std::max(1, shape.cells()[0]), down = std::max(1, shape.cells()[1]);
  int across_doubled = 0, down_doubled = 0;
  Points3 points;
  for (;;) {
    points.clear();
    for (int j = 0; j <= down; ++j)
      for (int i = 0; i <= across; ++i)
        points.push_back(shape.point(Vec2(double(i) / across, double(j) / down)));
    const auto at = [&](int i, int j) -> const Vec3& {
      return points[std::size_t(j) * std::size_t(across + 1) + std::size_t(i)];
    };
    const auto away = [&](double i, double j, const Vec3& a, const Vec3& b) {
      return (shape.point(Vec2(i / across, j / down)) - 0.5 * (a + b)).norm();
    };
    double along_u = 0, along_v = 0, along_diagonal = 0;
    for (int j = 0; j <= down; ++j)
      for (int i = 0; i <= across; ++i) {
        if (i < across) along_u = std::max(along_u, away(i + 0.5, j, at(i, j), at(i + 1, j)));
        if (j < down) along_v = std::max(along_v, away(i, j + 0.5, at(i, j), at(i, j + 1)));
        if (i < across && j < down)
          along_diagonal = std::max(along_diagonal, away(i + 0.5, j + 0.5, at(i + 1, j), at(i, j + 1)));
      }
    // A twist, u v K, shrinks with either side: both in turn.
    const bool twisted = along_diagonal > at_middles && !(along_u > at_middles) && !(along_v > at_middles);
    if (!(along_u > at_middles) && !(along_v > at_middles) && !twisted) break;
    const bool split_u = along_u > at_middles || (twisted && across_doubled <= down_doubled);
    const bool split_v = along_v > at_middles || (twisted && !split_u);
    across_doubled += split_u;
    down_doubled += split_v;
    across *= split_u ? 2 : 1;
    down *= split_v ? 2 : 1;
    if (across > kMaxCells || down > kMaxCells)
      throw Error(
          ErrorKind::kInput, "tessellate",
          "1024 triangles a side do not follow the surface to " + std::to_string(1e3 * tolerance) + " mm",
          "check its points and units, or ask for a coarser tolerance");
  }
  Mesh mesh;
  for (int j = 0; j <= down; ++j)
    for (int i = 0; i <= across; ++i) {
      mesh.vertices.push_back(points[std::size_t(j) * std::size_t(across + 1) + std::size_t(i)]);
      mesh.uv.emplace_back(double(i) / across, double(j) / down);
    }
  const auto add = [&](int a, int b, int c) {
    // A cell side may have shrunk to a point, as at a sphere's pole.
    const std::array<int, 3> triangle{a, b, c};
    const double side = (mesh.vertices[std::size_t(a)] - mesh.vertices[std::size_t(b)]).squaredNorm() +
                        (mesh.vertices[std::size_t(a)] - mesh.vertices[std::size_t(c)]).squaredNorm();
    if (area_vector(mesh, triangle).norm() > 1e-9 * side) mesh.triangles.push_back(triangle);
  };
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i) {
      const int a = j * (across + 1) + i, b = a + 1, c = a + across + 1, d = c + 1;
      add(a, b, c);
      add(b, d, c);
    }
  return mesh;
}

}  // namespace procam
