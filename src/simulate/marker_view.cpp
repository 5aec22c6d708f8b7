#include "procam/simulate/marker_view.hpp"

#include <algorithm>
#include <cmath>

#include "blur.hpp"
#include "marker_print.hpp"
#include "noise.hpp"
#include "procam/core/geometry/se3.hpp"
#include "summed_picture.hpp"

namespace procam::simulate {
namespace {

/// The lens blurs before the sensor gathers the light in its pixels: blur works on this many cells a pixel
/// and axis. (On whole pixels it would make a staircase of every edge.)
constexpr int kFine = 2;
constexpr int kRays = 2;  ///< an axis and cell

/// One sheet before the camera: the share of white over boxes of it.
class Sheet {
 public:
  Sheet(const PlacedMarker& marker, const Pose& camera_from_world, const MarkerCells& codes, double rim)
      : marker_from_camera_((camera_from_world * marker.world_from_marker).inverse()),
        white_(internal::marker_print(marker.id, codes, 0)),
        cells_(white_.width()),
        unit_(marker.size / cells_),
        rim_(rim) {}

  /// Where a ray meets the print, in cells from the black square's corner; nullopt from behind.
  std::optional<Vec2> meet(const Vec3& direction_in_camera) const {
    const Vec3& eye = marker_from_camera_.translation;
    const Vec3 direction = marker_from_camera_.rotate(direction_in_camera);
    const double s = -eye.z() / direction.z();
    if (!(s > 0) || !(eye.z() < 0)) return std::nullopt;
    return Vec2(Vec2(eye.x() + s * direction.x(), eye.y() + s * direction.y()) / unit_ +
                Vec2::Constant(0.5 * cells_));
  }
  /// Share of the box that the sheet covers.
  double cover(const Vec2& low, const Vec2& high) const {
    return overlap(low, high, -rim_, cells_ + rim_) / (high - low).prod();
  }
  /// Share of the box that is black.
  double black(const Vec2& low, const Vec2& high) const {
    const double inside = overlap(low, high, 0, cells_);
    if (inside <= 0) return 0;
    const double white = white_.sum(low.cwiseMax(0.0), high.cwiseMin(double(cells_)));
    return (inside - white) / (high - low).prod();
  }

 private:
  Pose marker_from_camera_;
  internal::SummedPicture white_;
  int cells_;
  double unit_, rim_;

  static double overlap(const Vec2& low, const Vec2& high, double from, double to) {
    const Vec2 size = (high.cwiseMin(to) - low.cwiseMax(from)).cwiseMax(0.0);
    return size.prod();
  }
};

/// Direction of a pixel with z = 1, so that it may be interpolated; nullopt beyond the lens or 84 degrees
/// off.
std::optional<Vec3> direction_of(const Camera& camera, const Vec2& pixel) {
  const std::optional<Vec3> bearing = camera.unproject(pixel);
  if (!bearing || !(bearing->z() > 0.1)) return std::nullopt;
  return Vec3(*bearing / bearing->z());
}

/// What the cells of one pixel collect of the sheets, given the directions of the pixel's four corners.
std::array<double, kFine * kFine> collect(const std::vector<Sheet>& sheets, const std::array<Vec3, 4>& corner,
                                          const MarkerViewOptions& options) {
  std::array<double, kFine * kFine> levels;
  levels.fill(options.wall_grey);
  constexpr int kAxis = kFine * kRays;
  const auto direction = [&](double u, double v) {
    return Vec3((1 - v) * ((1 - u) * corner[0] + u * corner[1]) + v * ((1 - u) * corner[2] + u * corner[3]));
  };
  for (const Sheet& sheet : sheets) {
    const auto a = sheet.meet(corner[0]), b = sheet.meet(corner[1]), c = sheet.meet(corner[2]);
    if (!a || !b || !c) continue;
    // The box of the same variance as the ray's share of the pixel.
    const Vec2 along_x = *b - *a, along_y = *c - *a;
    const Vec2 half =
        Vec2(std::hypot(along_x.x(), along_y.x()), std::hypot(along_x.y(), along_y.y())) * (0.5 / kAxis);
    const Vec2 reach = 4 * kAxis * half;
    if (!(sheet.cover(*a - reach, *a + reach) > 0)) continue;
    levels.fill(0);
    for (int j = 0; j < kAxis; ++j)
      for (int i = 0; i < kAxis; ++i) {
        double grey = options.wall_grey;
        if (const auto p = sheet.meet(direction((i + 0.5) / kAxis, (j + 0.5) / kAxis)))
          grey += sheet.cover(*p - half, *p + half) * (options.white_grey - options.wall_grey) -
                  sheet.black(*p - half, *p + half) * (options.white_grey - options.black_grey);
        levels[std::size_t(j / kRays * kFine + i / kRays)] += grey / (kRays * kRays);
      }
    return levels;
  }
  return levels;
}

/// Mean of each pixel's cells.
ImageF gather(const ImageF& cells, ImageSize size) {
  ImageF pixels(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      for (int j = 0; j < kFine; ++j)
        for (int i = 0; i < kFine; ++i)
          pixels.at(x, y) += cells.at(kFine * x + i, kFine * y + j) / float(kFine * kFine);
  return pixels;
}

}  // namespace

ImageU8 marker_view(const Camera& camera, const Pose& camera_from_world,
                    const std::vector<PlacedMarker>& markers, const MarkerCells& codes,
                    const MarkerViewOptions& options) {
  require(options.blur_px >= 0 && options.rim_cells >= 0 && options.noise.at_black >= 0 &&
              options.noise.per_level >= 0 && options.gamma > 0 && options.glare >= 0,
          "marker_view: negative blur, rim, noise, gamma or glare");
  std::vector<Sheet> sheets;
  for (const PlacedMarker& marker : markers) {
    require(marker.size > 0, "marker_view: the size of a marker is not positive");
    require(marker.id >= 0 && std::size_t(marker.id) < codes.white.size(),
            "marker_view: there is no marker " + std::to_string(marker.id));
    sheets.emplace_back(marker, camera_from_world, codes, options.rim_cells);
  }

  const ImageSize size = camera.size;
  ImageF cells(kFine * size.width, kFine * size.height);
  const auto directions_of_row = [&](int row) {
    std::vector<std::optional<Vec3>> row_of;
    for (int x = 0; x <= size.width; ++x) row_of.push_back(direction_of(camera, Vec2(x - 0.5, row - 0.5)));
    return row_of;
  };
  std::vector<std::optional<Vec3>> above = directions_of_row(0);
  for (int y = 0; y < size.height; ++y) {
    std::vector<std::optional<Vec3>> below = directions_of_row(y + 1);
    for (int x = 0; x < size.width; ++x) {
      const std::size_t i = std::size_t(x);
      if (!above[i] || !above[i + 1] || !below[i] || !below[i + 1]) continue;  // beyond the lens: black
      const double lamp =
          1 + options.falloff * (0.5 - 0.6 * (x + 0.5) / size.width - 0.4 * (y + 0.5) / size.height);
      const auto levels = collect(sheets, {*above[i], *above[i + 1], *below[i], *below[i + 1]}, options);
      for (int k = 0; k < kFine * kFine; ++k)
        cells.at(kFine * x + k % kFine, kFine * y + k / kFine) = float(lamp * levels[std::size_t(k)]);
    }
    above.swap(below);
  }

  const ImageF levels =
      gather(internal::convolve(cells, internal::gaussian_kernel(kFine * options.blur_px)), size);
  double mean = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) mean += levels.at(x, y) / (double(size.width) * size.height);
  const std::vector<float>& normal = internal::normal_table();
  ImageU8 grey(size);
  for (int y = 0; y < size.height; ++y) {
    internal::Random random(options.seed, 0, std::uint64_t(y));
    for (int x = 0; x < size.width; ++x) {
      const double level = (1 - options.glare) * levels.at(x, y) + options.glare * mean;
      const double noisy = level + std::sqrt(options.noise.variance(level)) * normal[random.next() & 0xffff];
      const double linear = std::clamp(noisy, 0.0, 255.0);
      grey.at(x, y) =
          std::uint8_t((options.gamma == 1 ? linear : 255 * std::pow(linear / 255, 1 / options.gamma)) + 0.5);
    }
  }
  return grey;
}

HungMarkers hang_markers(const World& world) {
  const Pose rig_from_wall = simulate::rig_from_wall(world);
  const double distance = (rig_from_wall.translation - world.rig.camera().rig_from_camera.translation).norm();

  struct Place {
    int id;
    double size, x, y, turn;  ///< shares of the distance; radians
  };
  constexpr Place kPlaces[] = {{3, 0.1, -0.14, -0.09, 0.08},
                               {7, 0.09, 0.17, -0.12, -0.3},
                               {11, 0.09, 0.15, 0.13, 0.2},
                               {20, 0.08, -0.15, 0.12, 1.7}};
  HungMarkers hung;
  hung.map.dictionary = MarkerDictionary::kAprilTag36h11;
  Pose world_from_wall;
  for (const Place& place : kPlaces) {
    const Pose wall_from_marker(so3_exp(Vec3(0, 0, place.turn)), Vec3(place.x, place.y, 0) * distance);
    if (hung.map.markers.empty()) {
      world_from_wall = wall_from_marker.inverse();
      hung.rig_from_world = rig_from_wall * wall_from_marker;
    }
    hung.map.markers.push_back({place.id, place.size * distance, world_from_wall * wall_from_marker});
  }
  hung.map.markers.front().world_from_marker = Pose();
  return hung;
}

}  // namespace procam::simulate
