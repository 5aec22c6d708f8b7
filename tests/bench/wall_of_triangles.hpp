#pragma once
/// The mesh that the renderers are timed with.
#include <cmath>
#include <memory>

#include "procam/core/surface/scene.hpp"
#include "render/rooms.hpp"

namespace procam {

/// A sheet as a little over 100 000 triangles, with a bump in it.
inline Scene wall_of_triangles(const Sheet& sheet, ViewU8 content) {
  constexpr int kAcross = 260, kDown = 195;
  Mesh mesh;
  for (int j = 0; j <= kDown; ++j)
    for (int i = 0; i <= kAcross; ++i) {
      const Vec2 uv(double(i) / kAcross, double(j) / kDown), at = sheet.plane_point(uv.x(), uv.y());
      mesh.vertices.emplace_back(at.x(), at.y(), -0.05 * std::exp(-20 * (uv - Vec2(0.4, 0.5)).squaredNorm()));
      mesh.uv.push_back(uv);
    }
  for (int j = 0; j < kDown; ++j)
    for (int i = 0; i < kAcross; ++i) {
      const int a = j * (kAcross + 1) + i, b = a + 1, c = a + kAcross + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, c + 1, c});
    }
  Scene scene;
  scene.items.push_back(
      {PlacedMesh{std::make_shared<const Mesh>(std::move(mesh)), sheet.placement.projector_from_surface},
       content});
  return scene;
}

}  // namespace procam
