#include "procam/depth/areas.hpp"

#include <algorithm>
#include <array>

#include "procam/core/surface/content_layout.hpp"
#include "upright_frame.hpp"

namespace procam::depth {
namespace {

constexpr int kMaxCells = 1 << 18;
/// Cells of a plane seen at the horizon are kilometres away; nothing is projected there.
constexpr double kLargestExtent = 40;

/// Where the plane's pixels lie in its own frame.
struct Extent {
  Vec2 low = Vec2::Constant(1e9), high = Vec2::Constant(-1e9);
};

Extent extent_of(const Planes& planes, std::size_t plane, const RayTable& rays,
                 const Pose& plane_from_camera) {
  const Plane& p = planes.planes[plane].estimate.plane;
  const Vec3 t = -p.normal / p.offset;
  const Mat3 r = plane_from_camera.rotation_matrix();
  Extent extent;
  for (int y = 0; y < planes.labels.height(); y += 2) {
    const std::int16_t* const row = planes.labels.row(y);
    for (int x = 0; x < planes.labels.width(); x += 2) {
      if (row[x] != std::int16_t(plane)) continue;
      const Vec3 ray(double(rays.u(x, y)), double(rays.v(x, y)), 1);
      const double q = t.dot(ray);
      if (!(q > 1 / kLargestExtent)) continue;
      const Vec2 at = (r * (ray / q) + plane_from_camera.translation).head<2>();
      extent.low = extent.low.cwiseMin(at);
      extent.high = extent.high.cwiseMax(at);
    }
  }
  return extent;
}

/// A cell is free where most of the pixel it falls on and its four neighbours bear the plane's label (at the
/// image's rim: that pixel).
void fill(const Planes& planes, std::int16_t plane, const RayTable& rays, const Pose& camera_from_plane,
          PlaneRaster& raster) {
  const Mat3 r = camera_from_plane.rotation_matrix();
  const Image<std::int16_t>& labels = planes.labels;
  const int width = labels.width(), height = labels.height();
  const Mat3 k = rays.camera().intrinsics.matrix();
  const bool pinhole = rays.is_pinhole();
  const auto own = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < width && y < height && labels.at(x, y) == plane;
  };
  for (int j = 0; j < raster.free.height(); ++j) {
    // Along a row the point, and K times it, move in equal steps.
    const Vec2 first = raster.corner(0, j) + Vec2::Constant(0.5 * raster.cell);
    const Vec3 point = r.leftCols<2>() * first + camera_from_plane.translation, step = raster.cell * r.col(0);
    const Vec3 start = pinhole ? Vec3(k * point) : point, along = pinhole ? Vec3(k * step) : step;
    std::uint8_t* const row = raster.free.row(j);
    for (int i = 0; i < raster.free.width(); ++i) {
      const double z = start.z() + i * along.z();
      if (!(z > 1e-3)) continue;
      double px = (start.x() + i * along.x()) / z, py = (start.y() + i * along.y()) / z;
      if (!pinhole) {
        const Vec2 pixel = rays.pixel_of(px, py);
        px = pixel.x();
        py = pixel.y();
      }
      if (!(px > -0.5 && py > -0.5 && px < width - 0.5 && py < height - 0.5)) continue;
      const int x = int(px + 0.5), y = int(py + 0.5);
      if (x > 0 && y > 0 && x + 1 < width && y + 1 < height) {
        const std::int16_t* const at = labels.row(y) + x;
        row[i] = (at[0] == plane) + (at[-1] == plane) + (at[1] == plane) + (at[-width] == plane) +
                     (at[width] == plane) >=
                 3;
      } else {
        row[i] = own(x, y);
      }
    }
  }
}

/// A cell whose neighbours all but two are free is a flaw of the depth image.
void heal(ImageU8& free) {
  const ImageU8 before = free;
  for (int j = 1; j + 1 < free.height(); ++j) {
    const std::uint8_t *const above = before.row(j - 1), *const here = before.row(j),
                              *const below = before.row(j + 1);
    std::uint8_t* const out = free.row(j);
    for (int i = 1; i + 1 < free.width(); ++i) {
      const int count = above[i - 1] + above[i] + above[i + 1] + here[i - 1] + here[i + 1] + below[i - 1] +
                        below[i] + below[i + 1];
      out[i] = std::uint8_t(here[i] | (count >= 6));
    }
  }
}

/// Douglas-Peucker between two places of the loop, without the last.
void straighten(const Points2& loop, std::size_t from, std::size_t to, double tolerance, Points2& out) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{from, to}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const Vec2 p = loop[a], d = loop[b % loop.size()] - p;
    const double length = d.norm();
    double farthest = tolerance;
    std::size_t split = 0;
    for (std::size_t i = a + 1; i < b; ++i) {
      const Vec2 e = loop[i] - p;
      const double off = length > 0 ? std::abs(d.x() * e.y() - d.y() * e.x()) / length : e.norm();
      if (off > farthest) farthest = off, split = i;
    }
    if (split == 0) {
      out.push_back(p);
      continue;
    }
    open.emplace_back(split, b);
    open.emplace_back(a, split);
  }
}

Points2 straightened(const Points2& loop, double tolerance) {
  // Two places far apart stay: the first and the farthest from it.
  std::size_t far = 0;
  for (std::size_t i = 1; i < loop.size(); ++i)
    if ((loop[i] - loop[0]).squaredNorm() > (loop[far] - loop[0]).squaredNorm()) far = i;
  if (far == 0) return loop;
  Points2 out;
  straighten(loop, 0, far, tolerance, out);
  straighten(loop, far, loop.size(), tolerance, out);
  return out;
}

/// Directed edges about free cells, free on their right: bits for east, south, west, north of each lattice point.
ImageU8 edges_of(const PlaneRaster& raster) {
  const int width = raster.free.width(), height = raster.free.height();
  ImageU8 edges(width + 1, height + 1);
  const auto free = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < width && j < height && raster.free.at(i, j) != 0;
  };
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      if (!free(i, j)) continue;
      if (!free(i, j - 1)) edges.at(i, j) |= 1;
      if (!free(i + 1, j)) edges.at(i + 1, j) |= 2;
      if (!free(i, j + 1)) edges.at(i + 1, j + 1) |= 4;
      if (!free(i - 1, j)) edges.at(i, j + 1) |= 8;
    }
  return edges;
}

/// The corners of the loop of edges from lattice point i, j on, which are taken away.
Points2 take_loop(const PlaneRaster& raster, int i, int j, ImageU8& edges) {
  constexpr std::array<int, 4> kX{1, 0, -1, 0}, kY{0, 1, 0, -1};
  Points2 loop;
  int x = i, y = j, direction = -1;
  do {
    // Turn right first: cells that touch at a corner only are two parts.
    int next = -1;
    for (const int turn : {1, 0, 3, 2}) {
      const int d = direction < 0 ? (turn + 3) % 4 : (direction + turn) % 4;
      if (edges.at(x, y) >> d & 1) {
        next = d;
        break;
      }
    }
    if (next < 0) break;
    edges.at(x, y) = std::uint8_t(edges.at(x, y) & ~(1 << next));
    if (next != direction) loop.push_back(raster.corner(x, y));
    direction = next;
    x += kX[std::size_t(next)];
    y += kY[std::size_t(next)];
  } while (x != i || y != j);
  return loop;
}

}  // namespace

Pose upright_frame(const Plane& plane, const Vec3& origin, const Vec3& up, const Vec3& forward) {
  const Vec3 z = -plane.normal;
  const auto across = [&](const Vec3& direction) { return Vec3(direction - z * z.dot(direction)); };
  Vec3 y = -across(up.normalized());
  // Within 20 degrees of level, up does not determine the reading direction.
  if (y.norm() < 0.34) y = (plane.normal.dot(up) > 0 ? -1.0 : 1.0) * across(forward);
  if (y.norm() < 1e-6) y = z.unitOrthogonal();
  y.normalize();
  Mat3 axes;
  axes << y.cross(z), y, z;
  return Pose(axes, Vec3(origin - plane.normal * plane.signed_distance(origin)));
}

std::optional<FreeRectangle> largest_rectangle(const PlaneRaster& raster, double min_side, double margin) {
  const int width = raster.free.width(), height = raster.free.height();
  std::vector<int> tall(std::size_t(width) + 1);  // free cells upwards from this row; a 0 at the end
  struct Step {
    int from, tall;
  };
  std::vector<Step> stack;
  const int least = int(std::ceil((min_side + 2 * margin) / raster.cell - 1e-9));
  long best = 0;
  FreeRectangle out;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      int& t = tall[std::size_t(i)];
      t = raster.free.at(i, j) ? t + 1 : 0;
    }
    stack.clear();
    for (int i = 0; i <= width; ++i) {
      const int t = tall[std::size_t(i)];
      int from = i;
      while (!stack.empty() && stack.back().tall >= t) {
        from = stack.back().from;
        const long area = long(stack.back().tall) * (i - from);
        if (area > best && stack.back().tall >= least && i - from >= least) {
          best = area;
          out = {raster.corner(from, j + 1 - stack.back().tall), raster.corner(i, j + 1)};
        }
        stack.pop_back();
      }
      if (t > 0) stack.push_back({from, t});
    }
  }
  out.low += Vec2::Constant(margin);
  out.high -= Vec2::Constant(margin);
  if (best == 0 || !(out.size().minCoeff() > 0)) return std::nullopt;
  return out;
}

std::vector<PlaneOutline> outlines_of(const PlaneRaster& raster, double min_part) {
  ImageU8 edges = edges_of(raster);
  const double least = 2 * min_part;
  std::vector<PlaneOutline> out;
  std::vector<Points2> holes;
  for (int j = 0; j < edges.height(); ++j)
    for (int i = 0; i < edges.width(); ++i)
      while (edges.at(i, j)) {
        const Points2 loop = take_loop(raster, i, j, edges);
        const double area = twice_area(loop);
        if (std::abs(area) < least || loop.size() < 4) continue;
        Points2 straight = straightened(loop, 1.5 * raster.cell);
        if (straight.size() < 3) continue;
        if (area > 0)
          out.push_back({std::move(straight), {}});
        else
          holes.push_back(std::move(straight));
      }
  for (Points2& hole : holes)
    for (PlaneOutline& part : out)
      if (contains(part.outer, hole.front())) {
        part.holes.push_back(std::move(hole));
        break;
      }
  std::stable_sort(out.begin(), out.end(), [](const PlaneOutline& a, const PlaneOutline& b) {
    return twice_area(a.outer) > twice_area(b.outer);
  });
  return out;
}

PlaneArea area_of(const Planes& planes, std::size_t plane, const RayTable& rays, const Vec3& up,
                  const AreaOptions& options) {
  require(plane < planes.planes.size(), "area_of: there is no such plane");
  require(planes.labels.size() == rays.size(), "area_of: the labels are not of the camera's size");
  require(options.cell > 0 && options.margin >= 0 && options.min_part >= 0 && up.norm() > 0,
          "area_of: the cell must be positive, up a direction");
  const DetectedPlane& detected = planes.planes[plane];
  PlaneArea out;
  out.camera_from_plane = upright_frame(detected.estimate.plane, detected.middle, up);
  const Extent extent = extent_of(planes, plane, rays, out.camera_from_plane.inverse());
  const Vec2 size = extent.high - extent.low;
  if (!(size.x() > 0 && size.y() > 0)) return out;
  out.raster.cell = std::max(options.cell, std::sqrt(size.x() * size.y() / kMaxCells));
  out.raster.low = extent.low;
  out.raster.free = ImageU8(int(size.x() / out.raster.cell) + 2, int(size.y() / out.raster.cell) + 2);
  fill(planes, std::int16_t(plane), rays, out.camera_from_plane, out.raster);
  heal(out.raster.free);
  heal(out.raster.free);
  int count = 0;
  for (int j = 0; j < out.raster.free.height(); ++j)
    for (int i = 0; i < out.raster.free.width(); ++i) count += out.raster.free.at(i, j);
  out.area = count * out.raster.cell * out.raster.cell;
  out.outlines = outlines_of(out.raster, options.min_part);
  out.rectangle = largest_rectangle(out.raster, options.min_side, options.margin);
  return out;
}

}  // namespace procam::depth
