#include "procam/render/preview.hpp"

#include <Eigen/LU>

#include "mean_content.hpp"

namespace procam::render {

namespace {

constexpr double kMargin = 0.2;                    ///< of the content's size, shown round it on each side
constexpr float kRoom = 0.012f, kSurface = 0.06f;  ///< light of what the projector does not reach
constexpr float kBlackLevel = 0.03f;               ///< what a projector's black adds

struct PlanarItem {
  PlacedPlane placement;
  Plane plane_in_projector;
  Mat3 content_from_plane;

  explicit PlanarItem(const PlacedPlane& placed)
      : placement(placed),
        plane_in_projector(Plane::of_xy(placed.projector_from_surface)),
        content_from_plane(placed.plane_from_content.inverse()) {}

  Vec3 in_projector(double u, double v) const {
    const Vec2 point = (placement.plane_from_content * Vec3(u, v, 1)).hnormalized();
    return placement.projector_from_surface * Vec3(point.x(), point.y(), 0);
  }
  /// Is the point on the content, or within `margin` of its size round it?
  bool holds(const Vec3& point_in_projector, double margin) const {
    const Vec3 point = placement.projector_from_surface.inverse() * point_in_projector;
    const Vec3 q = content_from_plane * Vec3(point.x(), point.y(), 1);
    if (!(q.z() > 0)) return false;
    const Vec2 uv = q.hnormalized();
    return (uv.array() >= -margin).all() && (uv.array() <= 1 + margin).all();
  }
};

std::vector<PlanarItem> planar_items(const Scene& scene) {
  std::vector<PlanarItem> items;
  for (const SceneItem& item : scene.items)
    if (const auto* plane = std::get_if<PlacedPlane>(&item.placement)) items.emplace_back(*plane);
  return items;
}

/// The projector's pixel whose light falls on the surface point that the view's ray meets.
std::optional<Vec2> lighting_pixel(const Projector& projector, const Camera& camera, const Vec2& view_pixel,
                                   const Pose& projector_from_camera, const Plane& plane_in_projector) {
  const std::optional<Vec3> bearing = camera.unproject(view_pixel);
  if (!bearing) return std::nullopt;
  const auto point = intersect(projector_from_camera * Ray{Vec3::Zero(), *bearing}, plane_in_projector);
  if (!point) return std::nullopt;
  return projector.pixel_lighting(*point);
}

}  // namespace

std::optional<Viewpoint> facing_viewpoint(const Scene& scene, ImageSize size) {
  const std::vector<PlanarItem> items = planar_items(scene);
  if (items.empty()) return std::nullopt;
  Vec3 centre = Vec3::Zero(), forward = Vec3::Zero(), down = Vec3::Zero();
  for (const PlanarItem& item : items) {
    centre += item.in_projector(0.5, 0.5) / double(items.size());
    forward += item.plane_in_projector.normal;  // surface frames have z into the wall
    down += (item.in_projector(0.5, 1) - item.in_projector(0.5, 0)).normalized();
  }
  if (forward.norm() < 1e-3) forward = items.front().plane_in_projector.normal;  // they face each other
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
  for (const PlanarItem& item : items)
    for (const double u : {-kMargin, 1 + kMargin})
      for (const double v : {-kMargin, 1 + kMargin}) {
        const Vec3 corner = camera_from_projector_rotation * (item.in_projector(u, v) - centre);
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
  const std::vector<PlanarItem> items = planar_items(scene);
  const Pose projector_from_camera = viewpoint.camera_from_projector.inverse();
  const Camera& camera = viewpoint.camera;

  const auto nearest = [&](const Vec2& pixel) -> const PlanarItem* {
    const std::optional<Vec3> bearing = camera.unproject(pixel);
    if (!bearing) return nullptr;
    const Ray ray = projector_from_camera * Ray{Vec3::Zero(), *bearing};
    const PlanarItem* found = nullptr;
    double found_distance = 0;
    for (const double margin : {0.0, kMargin}) {  // the grey round one content must not hide another
      for (const PlanarItem& item : items) {
        const std::optional<Vec3> point = intersect(ray, item.plane_in_projector);
        if (!point || !item.holds(*point, margin)) continue;
        const double distance = (*point - ray.origin).norm();
        if (!found || distance < found_distance) {
          found = &item;
          found_distance = distance;
        }
      }
      if (found) break;
    }
    return found;
  };
  // The frame's coordinates over one pixel of the view, linear; nullopt where no light of the projector goes.
  const auto frame_footprint = [&](const Vec2& pixel, const Plane& plane) -> std::optional<Footprint> {
    const auto uv = [&](double dx, double dy) -> std::optional<Vec3> {
      const auto lit = lighting_pixel(projector, camera, pixel + Vec2(dx, dy), projector_from_camera, plane);
      if (!lit) return std::nullopt;
      return Vec3((lit->x() + 0.5) / frame.width, (lit->y() + 0.5) / frame.height, 1);
    };
    const auto centre = uv(0, 0), left = uv(-0.5, 0), right = uv(0.5, 0), top = uv(0, -0.5),
               bottom = uv(0, 0.5);
    if (!centre || !left || !right || !top || !bottom) return std::nullopt;
    return Footprint{*centre, *right - *left, *bottom - *top};
  };

  ImageU8 view(camera.size, 3);
  workers.run(view.height(), [&](int y) {
    for (int x = 0; x < view.width(); ++x) {
      Rgba seen = Rgba::Constant(kRoom);
      if (const PlanarItem* item = nearest(Vec2(x, y))) {
        seen = Rgba::Constant(kSurface);
        if (const auto footprint = frame_footprint(Vec2(x, y), item->plane_in_projector)) {
          const Coverage lit = coverage(*footprint);
          if (lit.area > 0)
            seen += float(lit.area) * (kBlackLevel + (1 - kSurface - kBlackLevel) *
                                                         mean_content(light, kernels, *footprint, true));
        }
      }
      for (int k = 0; k < 3; ++k)
        view.at(x, y, k) = curve.value(Light(std::lround(kFull * std::min(1.0f, seen[k]))));
    }
  });
  return view;
}

}  // namespace procam::render
