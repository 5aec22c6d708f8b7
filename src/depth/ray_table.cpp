#include "procam/depth/ray_table.hpp"

#include <algorithm>
#include <limits>

namespace procam::depth {
namespace {

constexpr double kLattice = 8;  ///< pixels between its points
constexpr double kMargin = 64;  ///< pixels that it reaches beyond the image

/// The rays of one cell of the table's image, added up; `focal` in pixels.
RayTable::CellRays sum_cell(const RayTable& rays, int column, int row, double focal) {
  constexpr int kSide = RayTable::kCell;
  RayTable::CellRays cell;
  const int x0 = column * kSide, y0 = row * kSide;
  const int x1 = std::min(x0 + kSide, rays.size().width), y1 = std::min(y0 + kSide, rays.size().height);
  int count = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      if (std::isnan(rays.u(x, y))) continue;
      cell.u += rays.u(x, y);
      cell.v += rays.v(x, y);
      ++count;
    }
  if (count > 0) {
    cell.u /= count;
    cell.v /= count;
  }
  cell.whole = count == kSide * kSide;
  if (cell.whole)
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const double dx = focal * (rays.u(x, y) - cell.u), dy = focal * (rays.v(x, y) - cell.v);
        cell.sx += dx;
        cell.sy += dy;
        cell.sxx += dx * dx;
        cell.sxy += dx * dy;
        cell.syy += dy * dy;
      }
  return cell;
}

}  // namespace

RayTable::RayTable(const Camera& camera) : camera_(camera) {
  const auto [width, height] = camera.size;
  require(width > 0 && height > 0, "RayTable: the camera has no pixels");
  const Intrinsics& k = camera.intrinsics;
  require(k.fx > 0 && k.fy > 0, "RayTable: the focal lengths must be positive");
  u_ = ImageF(camera.size);
  v_ = ImageF(camera.size);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::optional<Vec3> ray = camera.unproject(Vec2(x, y));
      const bool ahead = ray && ray->z() > 1e-3;
      u_.at(x, y) = ahead ? float(ray->x() / ray->z()) : std::numeric_limits<float>::quiet_NaN();
      v_.at(x, y) = ahead ? float(ray->y() / ray->z()) : std::numeric_limits<float>::quiet_NaN();
    }

  separable_ = std::holds_alternative<NoDistortion>(camera.distortion) && k.skew == 0 && width >= kCell;
  columns_ = (width + kCell - 1) / kCell;
  rows_ = (height + kCell - 1) / kCell;
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) cells_.push_back(sum_cell(*this, column, row, k.fx));

  if (std::holds_alternative<NoDistortion>(camera.distortion)) return;
  lattice_columns_ = int((width + 2 * kMargin) / kLattice) + 2;
  lattice_rows_ = int((height + 2 * kMargin) / kLattice) + 2;
  for (int j = 0; j < lattice_rows_; ++j)
    for (int i = 0; i < lattice_columns_; ++i) {
      const Vec2 pinhole(i * kLattice - kMargin, j * kLattice - kMargin);
      const Vec2 n = k.normalized_from_pixel(pinhole);
      const std::optional<Vec2> seen = camera.project(Vec3(n.x(), n.y(), 1));
      // Beyond the lens' fold nothing is seen: a place outside the picture.
      shift_.push_back(seen ? Vec2(*seen - pinhole) : Vec2(-1e6, -1e6));
    }
}

Vec2 RayTable::pixel_of(double u, double v) const {
  const Vec2 pinhole = camera_.intrinsics.pixel_from_normalized(Vec2(u, v));
  if (shift_.empty()) return pinhole;
  const double x = std::clamp((pinhole.x() + kMargin) / kLattice, 0.0, lattice_columns_ - 1.001);
  const double y = std::clamp((pinhole.y() + kMargin) / kLattice, 0.0, lattice_rows_ - 1.001);
  const int i = int(x), j = int(y);
  const double s = x - i, t = y - j;
  const Vec2* at = &shift_[std::size_t(j) * std::size_t(lattice_columns_) + std::size_t(i)];
  return pinhole + (1 - t) * ((1 - s) * at[0] + s * at[1]) +
         t * ((1 - s) * at[lattice_columns_] + s * at[lattice_columns_ + 1]);
}

}  // namespace procam::depth
