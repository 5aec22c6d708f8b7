#include "sampling.hpp"

#include <cmath>

#include "paper.hpp"
#include "parallel.hpp"
#include "scene.hpp"

namespace procam::simulate::internal {
namespace {

/// Directions are exact on every second pixel border and linear between: right to 1e-3 px for the strongest
/// lenses, as the second derivative of the undistortion is below 1e-3 px per px^2.
constexpr int kCell = 2;

struct Node {
  bool valid = false;
  Vec3 direction_in_camera =
      Vec3::Zero();  ///< z = 1 where possible, so that linear interpolation stays on the plane
  std::optional<Vec2> on_board_plane;
};

Node make_node(const Scene& scene, const Vec2& pixel) {
  Node node;
  std::optional<Vec3> direction = scene.camera().unproject(pixel);
  if (!direction) return node;
  node.valid = true;
  if (direction->z() > 0.1) *direction /= direction->z();
  node.direction_in_camera = *direction;
  node.on_board_plane = scene.meet_board_plane(*direction);
  return node;
}

/// Borders of cells: -0.5, 1.5, 3.5, ...
std::vector<Node> make_node_row(const Scene& scene, int cells, int row) {
  std::vector<Node> nodes;
  nodes.reserve(std::size_t(cells) + 1);
  for (int i = 0; i <= cells; ++i)
    nodes.push_back(make_node(scene, Vec2(kCell * i - 0.5, kCell * row - 0.5)));
  return nodes;
}

/// Width of a ray's share of the camera pixel on the board, as the box of the same variance along each axis.
Vec2 footprint(const Node& a, const Node& right, const Node& below, double share) {
  if (!a.on_board_plane || !right.on_board_plane || !below.on_board_plane) return Vec2::Zero();
  const Vec2 along_x = (*right.on_board_plane - *a.on_board_plane) / kCell;
  const Vec2 along_y = (*below.on_board_plane - *a.on_board_plane) / kCell;
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
  view.samples.resize(std::size_t(size.width) * std::size_t(size.height) * std::size_t(n * n), {0, 0, 0});

  const int cells_x = (size.width + kCell - 1) / kCell, cells_y = (size.height + kCell - 1) / kCell;
  const float share = 1.f / float(n * n);

  const auto trace_pixel = [&](int x, int y, const Node& a, const Node& b, const Node& c, const Node& d) {
    const Vec2 width = footprint(a, b, c, 1.0 / n);
    LightSample* sample = view.samples.data() +
                          (std::size_t(y) * std::size_t(size.width) + std::size_t(x)) * std::size_t(n * n);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++sample) {
        const double s = (x % kCell + (i + 0.5) / n) / kCell, t = (y % kCell + (j + 0.5) / n) / kCell;
        const Vec3 direction = (1 - t) * ((1 - s) * a.direction_in_camera + s * b.direction_in_camera) +
                               t * ((1 - s) * c.direction_in_camera + s * d.direction_in_camera);
        const std::optional<Hit> hit = scene.hit(direction);
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
    std::vector<Node> above = make_node_row(scene, cells_x, begin);
    for (int cell_y = begin; cell_y < end; ++cell_y) {
      std::vector<Node> below = make_node_row(scene, cells_x, cell_y + 1);
      for (int cell_x = 0; cell_x < cells_x; ++cell_x) {
        const std::size_t i = std::size_t(cell_x);
        const Node &a = above[i], &b = above[i + 1], &c = below[i], &d = below[i + 1];
        if (!a.valid || !b.valid || !c.valid || !d.valid) continue;  // beyond the lens: black
        for (int y = cell_y * kCell; y < std::min((cell_y + 1) * kCell, size.height); ++y)
          for (int x = cell_x * kCell; x < std::min((cell_x + 1) * kCell, size.width); ++x)
            trace_pixel(x, y, a, b, c, d);
      }
      above.swap(below);
    }
  });
  return view;
}

}  // namespace procam::simulate::internal
