#include "sampling.hpp"

#include <cmath>

#include "defocus.hpp"
#include "paper.hpp"
#include "procam/core/base/parallel.hpp"
#include "ray_grid.hpp"
#include "scene.hpp"

namespace procam::simulate::internal {
namespace {

/// A row of rays and where each meets the board's sheet.
struct BoardRow {
  std::vector<RayNode> rays;
  std::vector<std::optional<Vec2>> on_sheet;
};

BoardRow make_board_row(const Scene& scene, int row) {
  BoardRow made{ray_node_row(scene.camera(), scene.camera_deviation(), row), {}};
  for (const RayNode& ray : made.rays)
    made.on_sheet.push_back(ray.valid ? scene.meet_sheet(ray.direction_in_camera) : std::nullopt);
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

/// Discs of confusion on the board in one row of the image.
struct Radii {
  double low = 1e300, high = 0;
};

/// Casts the rays of all pixels, row by row of the grid in which directions are linear.
class ViewSampler {
 public:
  ViewSampler(const World& world, const CaptureOptions& options)
      : options_(options),
        scene_(world),
        paper_(world.board),
        size_(scene_.camera().size),
        rays_(options.samples_per_axis),
        share_(1.f / float(rays_ * rays_)),
        defocused_(options.projector_lens.aperture > 0),
        radius_on_board_(defocused_ ? std::size_t(size_.height) : 0) {
    view_.samples_per_pixel = rays_ * rays_;
    view_.ambient_level = ImageF(size_);
    view_.of_light.emplace_back(
        std::size_t(size_.width) * std::size_t(size_.height) * std::size_t(rays_ * rays_),
        LightSample{0, 0, 0});
    view_.discs.emplace_back(defocused_ ? view_.of_light.front().size() : 0);
    if (options.indirect > 0) view_.albedo = ImageF(size_);
    if (options.vignetting > 0) view_.falloff = ImageF(size_);
  }

  SampledView sample() {
    parallel_for(ray_cells(size_.height), options_.threads,
                 [&](int begin, int end) { trace_rows(begin, end); });
    if (defocused_) choose_radii();
    return std::move(view_);
  }

 private:
  void trace_rows(int begin, int end) {
    const int cells_x = ray_cells(size_.width);
    BoardRow above = make_board_row(scene_, begin);
    for (int cell_y = begin; cell_y < end; ++cell_y) {
      BoardRow below = make_board_row(scene_, cell_y + 1);
      for (int cell_x = 0; cell_x < cells_x; ++cell_x) {
        const std::size_t i = std::size_t(cell_x);
        const RayCell rays{above.rays[i], above.rays[i + 1], below.rays[i], below.rays[i + 1]};
        if (!rays.valid()) continue;  // beyond the lens: black
        const Vec2 width =
            footprint(above.on_sheet[i], above.on_sheet[i + 1], below.on_sheet[i], 1.0 / rays_);
        for (int y = cell_y * kRayCell; y < std::min((cell_y + 1) * kRayCell, size_.height); ++y)
          for (int x = cell_x * kRayCell; x < std::min((cell_x + 1) * kRayCell, size_.width); ++x)
            trace_pixel(x, y, rays, width);
      }
      std::swap(above, below);
    }
  }

  void trace_pixel(int x, int y, const RayCell& rays, const Vec2& width) {
    std::size_t ray = view_.first_ray_of(x, y);
    for (int j = 0; j < rays_; ++j)
      for (int i = 0; i < rays_; ++i, ++ray) {
        const double s = (x % kRayCell + (i + 0.5) / rays_) / kRayCell;
        const double t = (y % kRayCell + (j + 0.5) / rays_) / kRayCell;
        if (const std::optional<Hit> hit = scene_.hit(rays.direction(s, t))) add(x, y, ray, *hit, width);
      }
    if (view_.falloff.empty()) return;
    const double s = (x % kRayCell + 0.5) / kRayCell, t = (y % kRayCell + 0.5) / kRayCell;
    view_.falloff.at(x, y) =
        float(std::pow(std::max(rays.direction(s, t).normalized().z(), 0.0), options_.vignetting));
  }

  void add(int x, int y, std::size_t ray, const Hit& hit, const Vec2& width) {
    const double albedo = !hit.on_board      ? scene_.wall_albedo()
                          : hit.printed_side ? paper_.albedo(hit.point_on_board, width)
                                             : scene_.white_albedo();
    view_.ambient_level.at(x, y) += share_ * float(albedo * scene_.ambient());
    if (!view_.albedo.empty()) view_.albedo.at(x, y) += share_ * float(albedo);
    const std::optional<Lighting> light = scene_.lighting(hit);
    if (!light) return;
    view_.of_light.front()[ray] = {float(light->projector_pixel.x()), float(light->projector_pixel.y()),
                                   share_ * float(albedo * light->irradiance)};
    if (!defocused_) return;
    const double radius =
        std::abs(disc_radius(options_.projector_lens, scene_.projector().inverse_camera, light->depth));
    view_.discs.front()[ray] = float(radius);
    if (!hit.on_board) return;
    Radii& on_board = radius_on_board_[std::size_t(y)];
    on_board = {std::min(on_board.low, radius), std::max(on_board.high, radius)};
  }

  void choose_radii() {
    double smallest = radius_on_board_.front().low, largest = radius_on_board_.front().high;
    for (const Radii& row : radius_on_board_) {
      smallest = std::min(smallest, row.low);
      largest = std::max(largest, row.high);
    }
    if (smallest <= largest) view_.disc_radii = radii_between(smallest, largest);
  }

  const CaptureOptions& options_;
  const Scene scene_;
  const Paper paper_;
  const ImageSize size_;
  const int rays_;  ///< a pixel, along each axis
  const float share_;
  const bool defocused_;
  std::vector<Radii> radius_on_board_;  ///< by row of the image, so that threads do not meet
  SampledView view_;
};

}  // namespace

SampledView sample_view(const World& world, const CaptureOptions& options) {
  return ViewSampler(world, options).sample();
}

}  // namespace procam::simulate::internal
