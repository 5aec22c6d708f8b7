#include "graph_markers.hpp"

#include <cmath>
#include <cstdio>
#include <map>

#include "light_shift.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/detail/chi_square.hpp"

namespace procam::show {
namespace {

constexpr int kPiecesOfSide = 8, kPiecesOfEllipse = 32;
constexpr std::size_t kMaxEdges = 5000;  ///< of a mesh's border
constexpr double kLine_m = 0.01, kThinLine_m = 0.002, kText_m = 0.1;

/// The area's corners on its plane, in order; empty where it reaches infinity.
std::vector<Vec3> corners_of(const PlacedPlane& plane) {
  std::vector<Vec3> corners;
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    const Vec3 h = plane.plane_from_content * uv.homogeneous();
    if (!(std::abs(h.z()) > 1e-12)) return {};
    corners.emplace_back(h.x() / h.z(), h.y() / h.z(), 0);
  }
  return corners;
}

/// Edges that belong to one triangle.
std::vector<Vec3> border_of(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& triangle : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = triangle[std::size_t(k)], b = triangle[std::size_t((k + 1) % 3)];
      ++uses[{std::min(a, b), std::max(a, b)}];
    }
  std::vector<Vec3> lines;
  for (const auto& [edge, count] : uses) {
    if (count != 1 || lines.size() >= 2 * kMaxEdges) continue;
    lines.push_back(mesh.vertices[std::size_t(edge.first)]);
    lines.push_back(mesh.vertices[std::size_t(edge.second)]);
  }
  return lines;
}

}  // namespace

dds::GraphMarker frustum_marker(const Camera& inverse_camera, const std::string& frame, double length) {
  dds::GraphMarker marker;
  marker.frame = frame;
  marker.name = "frustum";
  marker.size = kLine_m;
  marker.color = {1.0f, 0.8f, 0.1f, 1.0f};
  const double right = inverse_camera.size.width - 0.5, bottom = inverse_camera.size.height - 0.5;
  const Vec2 corners[4] = {{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}};
  const auto at = [&](const Vec2& pixel) -> std::optional<Vec3> {
    const std::optional<Vec3> ray = inverse_camera.unproject(pixel);
    if (!ray || !(ray->z() > 1e-3)) return std::nullopt;
    return Vec3(*ray * (length / ray->z()));
  };
  for (int side = 0; side < 4; ++side) {
    const Vec2 from = corners[side], to = corners[(side + 1) % 4];
    std::optional<Vec3> last = at(from);
    if (last) marker.lines.insert(marker.lines.end(), {Vec3::Zero(), *last});
    for (int i = 1; i <= kPiecesOfSide; ++i) {
      const std::optional<Vec3> next = at(from + (to - from) * (double(i) / kPiecesOfSide));
      if (last && next) marker.lines.insert(marker.lines.end(), {*last, *next});
      last = next;
    }
  }
  return marker;
}

dds::GraphMarker outline_marker(const SolvedSurface& surface, const std::string& frame) {
  dds::GraphMarker marker;
  marker.frame = frame;
  marker.name = "surface " + surface.surface.name;
  marker.size = kLine_m;
  marker.color = {0.2f, 0.6f, 1.0f, 1.0f};
  if (const auto* plane = std::get_if<PlacedPlane>(&surface.placement)) {
    const std::vector<Vec3> corners = corners_of(*plane);
    for (std::size_t i = 0; i < corners.size(); ++i)
      marker.lines.insert(marker.lines.end(), {corners[i], corners[(i + 1) % corners.size()]});
  }
  if (const auto* mesh = std::get_if<PlacedMesh>(&surface.placement); mesh != nullptr && mesh->mesh)
    marker.lines = border_of(*mesh->mesh);
  return marker;
}

std::vector<dds::GraphMarker> error_markers(const SolvedSurface& surface, const std::string& frame,
                                            const Pose& world_from_projector, const Mat6& covariance) {
  const auto* plane = std::get_if<PlacedPlane>(&surface.placement);
  if (plane == nullptr || covariance.isZero(0)) return {};
  const std::optional<Mat3> shift = light_shift(*plane, world_from_projector, covariance);
  const std::optional<Vec2> centre = content_centre(*plane);
  if (!shift || !centre) return {};
  if (!((plane->projector_from_surface * Vec3(centre->x(), centre->y(), 0)).z() > 0)) return {};
  const Mat3 world_axes = (world_from_projector * plane->projector_from_surface).rotation.toRotationMatrix();
  const Eigen::Matrix<double, 3, 2> axes = world_axes.leftCols<2>();
  const SymmetricEigen2 own = symmetric_eigen(axes.transpose() * *shift * axes);
  const double limit = internal::chi_square_limit(0.05, 2);
  const Vec2 radii = (limit * own.values.cwiseMax(0)).cwiseSqrt();
  if (!radii.allFinite()) return {};
  dds::GraphMarker ellipse;
  ellipse.frame = frame;
  ellipse.name = "error " + surface.surface.name;
  ellipse.size = kThinLine_m;
  ellipse.color = {1.0f, 0.2f, 0.2f, 1.0f};
  const auto at = [&](int i) {
    const double angle = 2 * kPi * i / kPiecesOfEllipse;
    const Vec2 p = *centre + own.vectors * radii.cwiseProduct(Vec2(std::cos(angle), std::sin(angle)));
    return Vec3(p.x(), p.y(), 0);
  };
  for (int i = 0; i < kPiecesOfEllipse; ++i) ellipse.lines.insert(ellipse.lines.end(), {at(i), at(i + 1)});
  dds::GraphMarker text;
  text.frame = frame;
  text.name = "error in mm " + surface.surface.name;
  text.size = kText_m;
  text.color = ellipse.color;
  text.lines = {Vec3(centre->x(), centre->y(), 0)};
  char words[64];
  std::snprintf(words, sizeof words, "95 %%: %.1f x %.1f mm", 1e3 * radii.maxCoeff(), 1e3 * radii.minCoeff());
  text.text = words;
  return {ellipse, text};
}

}  // namespace procam::show
