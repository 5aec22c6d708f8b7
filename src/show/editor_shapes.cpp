#include "editor_shapes.hpp"

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "procam/core/geometry/homography.hpp"

namespace procam::show {
namespace {

Vec2 clamped(const Vec2& uv) {
  return uv.cwiseMax(Vec2(0, 0)).cwiseMin(Vec2(1, 1));
}

std::optional<Vec2> clamped_inverse(const Mat3& matrix, const Vec2& point) {
  const std::optional<Vec2> uv = Homography(matrix).inverse().apply(point);
  return uv ? std::optional(clamped(*uv)) : std::nullopt;
}

/// The triangle that the ray meets first. A mesh on the rays of its pixels has each of them at a distance of one.
std::optional<Vec2> content_of_mesh(const PlacedMesh& placed, const Vec3& direction) {
  std::optional<Vec2> found;
  double nearest = 0;
  if (!placed.mesh) return found;
  const Mesh& mesh = *placed.mesh;
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    Mat3 corners;
    Eigen::Matrix<double, 2, 3> content;
    for (int i = 0; i < 3; ++i) {
      const auto corner = std::size_t(triangle[std::size_t(i)]);
      corners.col(i) = placed.projector_from_surface * mesh.vertices[corner];
      content.col(i) = mesh.uv[corner];
    }
    const Vec3 b = corners.inverse() * direction;
    if (!(b.minCoeff() >= -1e-12 && b.sum() > nearest)) continue;
    nearest = b.sum();
    found = content * b / b.sum();
  }
  return found;
}

/// Beside it, the vertex whose pixel is nearest.
Vec2 content_beside(const Mesh& in_pixels, const Vec2& pixel) {
  double least = std::numeric_limits<double>::infinity();
  Vec2 found(0, 0);
  for (std::size_t i = 0; i < in_pixels.vertices.size(); ++i) {
    const double distance = (in_pixels.vertices[i].head<2>() - pixel).squaredNorm();
    if (distance < least) least = distance, found = in_pixels.uv[i];
  }
  return found;
}

double bernstein(int n, int i, double t) {
  double value = 1;  // binomial(n, i) t^i (1 - t)^(n - i)
  for (int k = 1; k <= i; ++k) value *= t * double(n - i + k) / k;
  return value * std::pow(1 - t, n - i);
}

/// Rows: positions k / (count - 1); columns: control points.
Eigen::MatrixXd bernstein_matrix(int count) {
  Eigen::MatrixXd matrix(count, count);
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < count; ++i) matrix(k, i) = bernstein(count - 1, i, double(k) / (count - 1));
  return matrix;
}

/// Control points of the patch that passes through points at regular content positions.
Points2 control_points_through(const Points2& points, int columns, int rows) {
  Points2 result(points.size());
  const auto across = bernstein_matrix(columns).partialPivLu();
  const auto down = bernstein_matrix(rows).partialPivLu();
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::MatrixXd values(rows, columns);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) values(j, i) = points[std::size_t(j * columns + i)][axis];
    const Eigen::MatrixXd half = down.solve(values);
    const Eigen::MatrixXd control = across.solve(half.transpose()).transpose();
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) result[std::size_t(j * columns + i)][axis] = control(j, i);
  }
  return result;
}

}  // namespace

std::optional<Vec2> frame_at(const SolvedSurface& surface, const Projector& projector, const Vec2& uv) {
  if (const auto* pixels = std::get_if<PixelSurface>(&surface.surface.geometry);
      pixels != nullptr && pixels->is_curved())
    return pixels->point(uv);
  if (const auto* pixels = std::get_if<PlacedPixels>(&surface.placement)) return pixel_at(*pixels, uv);
  const auto* plane = std::get_if<PlacedPlane>(&surface.placement);
  if (plane == nullptr) return std::nullopt;
  const std::optional<Vec2> at = Homography(plane->plane_from_content).apply(uv);
  if (!at) return std::nullopt;
  return projector.project(plane->projector_from_surface * Vec3(at->x(), at->y(), 0));
}

std::optional<Vec2> content_at(const SolvedSurface& surface, const Projector& projector, const Vec2& pixel) {
  const auto* pixels = std::get_if<PlacedPixels>(&surface.placement);
  if (pixels != nullptr && !pixels->mesh) return clamped_inverse(pixels->pixel_from_content, pixel);
  const std::optional<Ray> ray = projector.emit(pixel);
  if (pixels != nullptr) {
    const auto uv = ray ? content_of_mesh(mesh_on_rays(*pixels, projector), ray->direction) : std::nullopt;
    return clamped(uv ? *uv : content_beside(*pixels->mesh, pixel));
  }
  if (!ray) return std::nullopt;
  if (const auto* mesh = std::get_if<PlacedMesh>(&surface.placement)) {
    const auto uv = content_of_mesh(*mesh, ray->direction);
    return uv ? std::optional(clamped(*uv)) : std::nullopt;
  }
  const auto& plane = std::get<PlacedPlane>(surface.placement);
  const Pose surface_from_projector = plane.projector_from_surface.inverse();
  const Vec3 origin = surface_from_projector.translation,
             direction = surface_from_projector.rotate(ray->direction);
  const double along = -origin.z() / direction.z();
  if (!(along > 0 && std::isfinite(along))) return std::nullopt;
  return clamped_inverse(plane.plane_from_content, (origin + along * direction).head<2>());
}

std::string shape_name(const SurfaceGeometry& geometry) {
  const auto* pixels = std::get_if<PixelSurface>(&geometry);
  if (pixels == nullptr) return "";
  if (!pixels->is_curved()) return "flat";
  return std::string(pixels->shape == PixelShape::kGrid ? "grid " : "bezier ") +
         std::to_string(pixels->columns) + "x" + std::to_string(pixels->rows);
}

PixelSurface reshaped(const PixelSurface& surface, const PlacedPixels& placed, const std::string& name) {
  PixelSurface made;
  char kind[8] = "", rest = 0;
  const int read = std::sscanf(name.c_str(), "%7[a-z] %2dx%2d%c", kind, &made.columns, &made.rows, &rest);
  if (name != "flat") {
    made.shape = std::string(kind) == "grid" ? PixelShape::kGrid : PixelShape::kBezier;
    if (read != 3 || (std::string(kind) != "grid" && std::string(kind) != "bezier"))
      throw std::invalid_argument("'" + name + "' is none of: flat, grid 5x4, bezier 4x4");
    if (std::min(made.columns, made.rows) < 2 || std::max(made.columns, made.rows) > BezierSurface::kMax)
      throw std::invalid_argument("it has " + std::to_string(made.columns) + " x " +
                                  std::to_string(made.rows) + " points, and 2 x 2 to 16 x 16 are possible");
  }
  const auto pixel = [&](const Vec2& uv) {
    const auto at = surface.is_curved() ? std::optional(surface.point(uv)) : pixel_at(placed, uv);
    if (!at) throw std::invalid_argument("part of its content is beyond its horizon");
    return *at;
  };
  if (name == "flat") {
    made.columns = made.rows = 0;
    made.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (const Vec2& uv : made.content) made.pixels.push_back(pixel(uv));
    return made;
  }
  for (int j = 0; j < made.rows; ++j)
    for (int i = 0; i < made.columns; ++i)
      made.pixels.push_back(pixel(Vec2(double(i) / (made.columns - 1), double(j) / (made.rows - 1))));
  if (made.shape == PixelShape::kBezier)
    made.pixels = control_points_through(made.pixels, made.columns, made.rows);
  return made;
}

void add_hole(ContentShape& shape, Points2 ring) {
  ContentShape changed = shape;
  changed.holes.push_back(std::move(ring));
  if (const auto fault = fault_of(changed)) throw std::invalid_argument(*fault);
  shape = std::move(changed);
}

}  // namespace procam::show
