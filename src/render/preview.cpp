#include "procam/render/preview.hpp"

#include <Eigen/LU>

#include "mean_content.hpp"
#include "room_layer.hpp"

namespace procam::render {

namespace {

constexpr double kMargin = 0.2;                    ///< of the content's size, shown round it on each side
constexpr float kRoom = 0.012f, kSurface = 0.06f;  ///< light of what the projector does not reach
constexpr float kBlackLevel = 0.03f;               ///< what a projector's black adds

/// A surface as somebody who looks for a place to stand sees it, in the projector's frame.
struct Looked {
  Vec3 centre = Vec3::Zero(), into_wall = Vec3::Zero(), down = Vec3::Zero();
  Points3 outline;  ///< what must be in the picture
};

/// The content's area and kMargin of its size round it.
PlacedPlane with_margin(PlacedPlane placed) {
  Mat3 wider;
  wider << 1 + 2 * kMargin, 0, -kMargin, 0, 1 + 2 * kMargin, -kMargin, 0, 0, 1;
  placed.plane_from_content *= wider;
  return placed;
}

Looked look_at(const PlacedPlane& placed) {
  const auto at = [](const PlacedPlane& plane, double u, double v) {
    const Vec2 point = (plane.plane_from_content * Vec3(u, v, 1)).hnormalized();
    return plane.projector_from_surface * Vec3(point.x(), point.y(), 0);
  };
  Looked looked;
  looked.centre = at(placed, 0.5, 0.5);
  looked.into_wall = placed.projector_from_surface.rotate(Vec3::UnitZ());
  looked.down = (at(placed, 0.5, 1) - at(placed, 0.5, 0)).normalized();
  const PlacedPlane shown = with_margin(placed);
  for (const double u : {0.0, 1.0})
    for (const double v : {0.0, 1.0}) looked.outline.push_back(at(shown, u, v));
  return looked;
}

/// Means over its area.
Looked look_at(const PlacedMesh& placed) {
  const Mesh& mesh = *placed.mesh;
  Looked looked;
  double whole = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[std::size_t(triangle[i])]; };
    const auto uv = [&](std::size_t i) { return mesh.uv[std::size_t(triangle[i])]; };
    const Vec3 area = area_vector(mesh, triangle);
    const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
    const double sense = a.x() * b.y() - a.y() * b.x();
    if (sense == 0) continue;  // shows one line of the content
    whole += area.norm();
    looked.centre += area.norm() / 3 * (corner(0) + corner(1) + corner(2));
    looked.into_wall += (sense < 0 ? -1 : 1) * area;
    // The step in space for a step in v: point = corner + (a, b)^-1 (u, v).
    const Vec3 along_v = (a.x() * (corner(2) - corner(0)) - b.x() * (corner(1) - corner(0))) / sense;
    looked.down += area.norm() * along_v.normalized();
  }
  const Pose& pose = placed.projector_from_surface;
  looked.centre = pose * Vec3(looked.centre / std::max(whole, 1e-300));
  looked.into_wall = pose.rotate(looked.into_wall) / std::max(whole, 1e-300);
  looked.down = pose.rotate(looked.down) / std::max(whole, 1e-300);
  for (const Vec3& vertex : mesh.vertices) looked.outline.push_back(pose * vertex);
  return looked;
}

std::vector<Looked> look_at(const Scene& scene) {
  std::vector<Looked> result;
  for (const SceneItem& item : scene.items) {
    if (const auto* plane = std::get_if<PlacedPlane>(&item.placement)) result.push_back(look_at(*plane));
    if (const auto* mesh = std::get_if<PlacedMesh>(&item.placement)) result.push_back(look_at(*mesh));
  }
  return result;
}

/// The surfaces of the scene as somebody at `viewer_from_projector` sees them, whose picture is that of a
/// projector standing there.
std::vector<RoomLayer> layers_seen(const Scene& scene, const Projector& viewer,
                                   const Pose& viewer_from_projector, bool planes_with_margin,
                                   Workers& workers) {
  std::vector<RoomLayer> layers;
  for (const SceneItem& item : scene.items) {
    if (const auto* plane = std::get_if<PlacedPlane>(&item.placement)) {
      PlacedPlane seen = planes_with_margin ? with_margin(*plane) : *plane;
      seen.projector_from_surface = viewer_from_projector * seen.projector_from_surface;
      layers.emplace_back(seen, TileGrid{viewer.size()});
    }
    if (const auto* mesh = std::get_if<PlacedMesh>(&item.placement)) {
      const PlacedMesh seen{mesh->mesh, viewer_from_projector * mesh->projector_from_surface};
      layers.emplace_back(seen, viewer, TileGrid{viewer.size()}, workers);
    }
  }
  return layers;
}

/// The plane of the nearest facet that the ray meets.
std::optional<Plane> nearest_plane(const std::vector<RoomLayer>& layers, int x, int y, const Vec3& ray) {
  const Facet* found = nullptr;
  for (const RoomLayer& layer : layers) {
    const Facet* facet = layer.nearest(x, y, ray);
    if (facet && (!found || along(facet->nearness, ray) > along(found->nearness, ray))) found = facet;
  }
  if (!found) return std::nullopt;
  const Vec3 nearness(double(found->nearness[0]), double(found->nearness[1]), double(found->nearness[2]));
  return Plane{nearness.normalized(), -1 / nearness.norm()};  // nearness . x = 1 on it
}

}  // namespace

std::optional<Viewpoint> facing_viewpoint(const Scene& scene, ImageSize size) {
  const std::vector<Looked> items = look_at(scene);
  if (items.empty()) return std::nullopt;
  Vec3 centre = Vec3::Zero(), forward = Vec3::Zero(), down = Vec3::Zero();
  for (const Looked& item : items) {
    centre += item.centre / double(items.size());
    forward += item.into_wall;
    down += item.down;
  }
  if (forward.norm() < 1e-3) forward = items.front().into_wall;  // they face each other
  if (forward.norm() < 1e-3) forward = centre;                   // it faces all ways, as a globe does
  forward.normalize();
  down -= down.dot(forward) * forward;
  if (down.norm() < 1e-3) down = forward.unitOrthogonal();
  down.normalize();
  Mat3 camera_from_projector_rotation;
  camera_from_projector_rotation << down.cross(forward).transpose(), down.transpose(), forward.transpose();

  Viewpoint viewpoint;
  viewpoint.camera.size = size;
  Intrinsics& k = viewpoint.camera.intrinsics;
  k.fx = k.fy = 1.2 * size.width;
  k.cx = 0.5 * (size.width - 1);
  k.cy = 0.5 * (size.height - 1);
  double distance = 0.1;
  for (const Looked& item : items)
    for (const Vec3& point : item.outline) {
      const Vec3 corner = camera_from_projector_rotation * (point - centre);
      distance = std::max({distance, k.fx * std::abs(corner.x()) / (0.5 * size.width) - corner.z(),
                           k.fy * std::abs(corner.y()) / (0.5 * size.height) - corner.z()});
    }
  viewpoint.camera_from_projector =
      Pose(camera_from_projector_rotation, Vec3(0, 0, distance) - camera_from_projector_rotation * centre);
  return viewpoint;
}

ImageU8 preview(const Scene& scene, const Projector& projector, ViewU8 frame, const Viewpoint& viewpoint,
                const RenderOptions& options) {
  require(frame.channels == 3 && frame.size() == projector.size() && !frame.empty(),
          "preview: the frame must have 3 channels and the projector's size");
  const LightCurve curve(true);
  const Kernels& kernels = options.wide_vectors ? best_kernels() : kPlainKernels;
  Workers workers(options.threads);
  LightTexture light;
  light.prepare(frame, curve, levels_of(frame.size()), workers);
  const Pose projector_from_camera = viewpoint.camera_from_projector.inverse();
  const Camera& camera = viewpoint.camera;
  // The grey round one content must not hide another: it is looked for where there is nothing else.
  const std::vector<RoomLayer> seen = layers_seen(scene, {camera}, viewpoint.camera_from_projector, false,
                                                  workers),
                               margins = layers_seen(scene, {camera}, viewpoint.camera_from_projector, true,
                                                     workers),
                               lit = layers_seen(scene, projector, Pose::identity(), false, workers);

  /// Where the light that falls on the plane at this place of the view comes from.
  struct Source {
    Vec2 pixel;
    Vec3 point_in_projector;
  };
  const auto source = [&](const Vec2& view_pixel, const Plane& plane) -> std::optional<Source> {
    const std::optional<Vec3> bearing = camera.unproject(view_pixel);
    const auto point = bearing ? intersect(Ray{Vec3::Zero(), *bearing}, plane) : std::nullopt;
    if (!point) return std::nullopt;
    const Vec3 in_projector = projector_from_camera * *point;
    const auto pixel = projector.pixel_lighting(in_projector);
    if (!pixel) return std::nullopt;
    return Source{*pixel, in_projector};
  };
  const auto in_shadow = [&](const Source& light_source) {
    constexpr float kBefore = 1.01f;  // 1: the surface itself
    const int x = int(std::lround(light_source.pixel.x())), y = int(std::lround(light_source.pixel.y()));
    if (x < 0 || y < 0 || x >= frame.width || y >= frame.height) return false;
    for (const RoomLayer& layer : lit) {
      const Facet* facet = layer.nearest(x, y, light_source.point_in_projector);
      if (facet && along(facet->nearness, light_source.point_in_projector) > kBefore) return true;
    }
    return false;
  };
  // The frame's coordinates over one pixel of the view, linear; nullopt where no light of the projector goes.
  const auto frame_footprint = [&](const Vec2& pixel, const Plane& plane) -> std::optional<Footprint> {
    const auto uv = [&](const std::optional<Source>& from) {
      return Vec3((from->pixel.x() + 0.5) / frame.width, (from->pixel.y() + 0.5) / frame.height, 1);
    };
    const auto centre = source(pixel, plane), left = source(pixel - Vec2(0.5, 0), plane),
               right = source(pixel + Vec2(0.5, 0), plane), top = source(pixel - Vec2(0, 0.5), plane),
               bottom = source(pixel + Vec2(0, 0.5), plane);
    if (!centre || !left || !right || !top || !bottom || in_shadow(*centre)) return std::nullopt;
    return Footprint{uv(centre), uv(right) - uv(left), uv(bottom) - uv(top)};
  };

  ImageU8 view(camera.size, 3);
  workers.run(view.height(), [&](int y) {
    for (int x = 0; x < view.width(); ++x) {
      Rgba shown = Rgba::Constant(kRoom);
      const std::optional<Vec3> bearing = camera.unproject(Vec2(x, y));
      std::optional<Plane> plane = bearing ? nearest_plane(seen, x, y, *bearing) : std::nullopt;
      if (!plane && bearing) plane = nearest_plane(margins, x, y, *bearing);
      if (plane) {
        shown = Rgba::Constant(kSurface);
        if (const auto footprint = frame_footprint(Vec2(x, y), *plane)) {
          const Coverage reached = coverage(*footprint);
          if (reached.area > 0)
            shown += float(reached.area) * (kBlackLevel + (1 - kSurface - kBlackLevel) *
                                                              mean_content(light, kernels, *footprint, true));
        }
      }
      for (int k = 0; k < 3; ++k)
        view.at(x, y, k) = curve.value(Light(std::lround(kFull * std::min(1.0f, shown[k]))));
    }
  });
  return view;
}

}  // namespace procam::render
