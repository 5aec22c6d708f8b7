#include "procam/render/preview.hpp"

#include <Eigen/LU>

#include "mean_content.hpp"
#include "room_layer.hpp"

namespace procam::render {

namespace {

constexpr double kMargin = 0.2;                    ///< of the content's size, shown round it on each side
constexpr float kRoom = 0.012f, kSurface = 0.06f;  ///< light of what the projector does not reach
constexpr float kBlackLevel = 0.03f;               ///< what a projector's black adds

/// The content's area and kMargin of its size round it.
PlacedPlane with_margin(PlacedPlane placed) {
  Mat3 wider;
  wider << 1 + 2 * kMargin, 0, -kMargin, 0, 1 + 2 * kMargin, -kMargin, 0, 0, 1;
  placed.plane_from_content *= wider;
  return placed;
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
