#include "sampling.hpp"

#include <cmath>

#include "paper.hpp"
#include "parallel.hpp"
#include "ray_grid.hpp"
#include "scene.hpp"

namespace procam::simulate::internal {
namespace {

/// A row of rays and where each meets the board's plane.
struct BoardRow {
  std::vector<RayNode> rays;
  std::vector<std::optional<Vec2>> on_board_plane;
};

BoardRow make_board_row(const Scene& scene, int row) {
  BoardRow made{ray_node_row(scene.camera(), row), {}};
  for (const RayNode& ray : made.rays)
    made.on_board_plane.push_back(ray.valid ? scene.meet_board_plane(ray.direction_in_camera) : std::nullopt);
  return made;
}

/// Width of a ray's share of the camera pixel on the board, as the box of the same variance along each axis.
Vec2 footprint(const std::optional<Vec2>& a, const std::optional<Vec2>& right,
               const std::optional<Vec2>& below, double share) {
  if (!a || !right || !below) return Vec2::Zero();
  const Vec2 along_x = (*right - *a) / kRayCell, along_y = (*below - *a) / kRayCell;
  return share * Vec2(std::hypot(along_x.x(), along_y.x()), std::hypot(along_x.y(), along_y.y()));
}

}  // namespace

SampledView sample_view(const World& world, int samples_per_axis, int threads) {
  const Scene scene(world);
  const Paper paper(world.board);
  const ImageSize size = scene.camera().size;
  const int n = samples_per_axis;
  SampledView view;
  view.samples_per_pixel = n * n;
  view.ambient_level = ImageF(size);
  view.of_light.emplace_back(std::size_t(size.width) * std::size_t(size.height) * std::size_t(n * n),
                             LightSample{0, 0, 0});
  view.discs.emplace_back();

  const int cells_x = ray_cells(size.width), cells_y = ray_cells(size.height);
  const float share = 1.f / float(n * n);

  const auto trace_pixel = [&](int x, int y, const RayCell& rays, const Vec2& width) {
    LightSample* sample = view.of_light.front().data() +
                          (std::size_t(y) * std::size_t(size.width) + std::size_t(x)) * std::size_t(n * n);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++sample) {
        const double s = (x % kRayCell + (i + 0.5) / n) / kRayCell;
        const double t = (y % kRayCell + (j + 0.5) / n) / kRayCell;
        const std::optional<Hit> hit = scene.hit(rays.direction(s, t));
        if (!hit) continue;
        const double albedo = !hit->on_board      ? scene.wall_albedo()
                              : hit->printed_side ? paper.albedo(hit->point_on_board, width)
                                                  : scene.white_albedo();
        view.ambient_level.at(x, y) += share * float(albedo * scene.ambient());
        if (const std::optional<Lighting> light = scene.lighting(*hit))
          *sample = {float(light->projector_pixel.x()), float(light->projector_pixel.y()),
                     share * float(albedo * light->irradiance)};
      }
  };

  parallel_for(cells_y, threads, [&](int begin, int end) {
    BoardRow above = make_board_row(scene, begin);
    for (int cell_y = begin; cell_y < end; ++cell_y) {
      BoardRow below = make_board_row(scene, cell_y + 1);
      for (int cell_x = 0; cell_x < cells_x; ++cell_x) {
        const std::size_t i = std::size_t(cell_x);
        const RayCell rays{above.rays[i], above.rays[i + 1], below.rays[i], below.rays[i + 1]};
        if (!rays.valid()) continue;  // beyond the lens: black
        const Vec2 width =
            footprint(above.on_board_plane[i], above.on_board_plane[i + 1], below.on_board_plane[i], 1.0 / n);
        for (int y = cell_y * kRayCell; y < std::min((cell_y + 1) * kRayCell, size.height); ++y)
          for (int x = cell_x * kRayCell; x < std::min((cell_x + 1) * kRayCell, size.width); ++x)
            trace_pixel(x, y, rays, width);
      }
      std::swap(above, below);
    }
  });
  return view;
}

}  // namespace procam::simulate::internal
