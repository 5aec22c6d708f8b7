#include "sampling.hpp"

#include <cmath>

#include "defocus.hpp"
#include "paper.hpp"
#include "procam/core/base/parallel.hpp"
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

/// Few radii over a flat board; the wall behind it takes the nearest of them.
std::vector<double> radii_between(double smallest, double largest) {
  constexpr double kStep = 1;
  const int steps = int(std::ceil((largest - smallest) / kStep));
  std::vector<double> radii{smallest};
  for (int i = 1; i <= steps; ++i) radii.push_back(smallest + (largest - smallest) * i / steps);
  return radii;
}

}  // namespace

SampledView sample_view(const World& world, const CaptureOptions& options) {
  const Scene scene(world);
  const Paper paper(world.board);
  const ImageSize size = scene.camera().size;
  const int n = options.samples_per_axis;
  const bool defocused = options.projector_lens.aperture > 0;
  SampledView view;
  view.samples_per_pixel = n * n;
  view.ambient_level = ImageF(size);
  view.of_light.emplace_back(std::size_t(size.width) * std::size_t(size.height) * std::size_t(n * n),
                             LightSample{0, 0, 0});
  view.discs.emplace_back(defocused ? view.of_light.front().size() : 0);
  if (options.indirect > 0) view.albedo = ImageF(size);
  if (options.vignetting > 0) view.falloff = ImageF(size);

  const int cells_x = ray_cells(size.width), cells_y = ray_cells(size.height);
  const float share = 1.f / float(n * n);

  struct Radii {
    double low = 1e300, high = 0;
  };
  std::vector<Radii> radius_on_board(defocused ? std::size_t(size.height) : 0);

  const auto trace_pixel = [&](int x, int y, const RayCell& rays, const Vec2& width) {
    std::size_t ray = view.first_ray_of(x, y);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++ray) {
        const double s = (x % kRayCell + (i + 0.5) / n) / kRayCell;
        const double t = (y % kRayCell + (j + 0.5) / n) / kRayCell;
        const std::optional<Hit> hit = scene.hit(rays.direction(s, t));
        if (!hit) continue;
        const double albedo = !hit->on_board      ? scene.wall_albedo()
                              : hit->printed_side ? paper.albedo(hit->point_on_board, width)
                                                  : scene.white_albedo();
        view.ambient_level.at(x, y) += share * float(albedo * scene.ambient());
        if (!view.albedo.empty()) view.albedo.at(x, y) += share * float(albedo);
        const std::optional<Lighting> light = scene.lighting(*hit);
        if (!light) continue;
        view.of_light.front()[ray] = {float(light->projector_pixel.x()), float(light->projector_pixel.y()),
                                      share * float(albedo * light->irradiance)};
        if (!defocused) continue;
        const double radius =
            std::abs(disc_radius(options.projector_lens, scene.projector().inverse_camera, light->depth));
        view.discs.front()[ray] = float(radius);
        if (!hit->on_board) continue;
        Radii& on_board = radius_on_board[std::size_t(y)];
        on_board = {std::min(on_board.low, radius), std::max(on_board.high, radius)};
      }
    if (view.falloff.empty()) return;
    const double s = (x % kRayCell + 0.5) / kRayCell, t = (y % kRayCell + 0.5) / kRayCell;
    view.falloff.at(x, y) =
        float(std::pow(std::max(rays.direction(s, t).normalized().z(), 0.0), options.vignetting));
  };

  parallel_for(cells_y, options.threads, [&](int begin, int end) {
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
  if (defocused) {
    double smallest = radius_on_board.front().low, largest = radius_on_board.front().high;
    for (const Radii& row : radius_on_board) {
      smallest = std::min(smallest, row.low);
      largest = std::max(largest, row.high);
    }
    if (smallest <= largest) view.disc_radii = radii_between(smallest, largest);
  }
  return view;
}

}  // namespace procam::simulate::internal
