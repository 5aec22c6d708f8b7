#include "procam/render/preview.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

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

/// The plane of the nearest facet that the ray meets; of a plane's margin where there is nothing else: the
/// grey round one content must not hide another.
struct Met {
  Plane plane;
  int layer;  ///< margins are counted after the surfaces
};
std::optional<Met> nearest_plane(const std::vector<RoomLayer>& surfaces,
                                 const std::vector<RoomLayer>& margins, int x, int y, const Vec3& ray) {
  const Facet* found = nullptr;
  int of = 0, count = 0;
  for (const auto* layers : {&surfaces, &margins}) {
    if (found) break;
    for (const RoomLayer& layer : *layers) {
      const Facet* facet = layer.nearest(x, y, ray);
      if (facet && (!found || along(facet->nearness, ray) > along(found->nearness, ray))) {
        found = facet;
        of = count;
      }
      ++count;
    }
  }
  if (!found) return std::nullopt;
  const Vec3 nearness(double(found->nearness[0]), double(found->nearness[1]), double(found->nearness[2]));
  return Met{Plane{nearness.normalized(), -1 / nearness.norm()}, of};  // nearness . x = 1 on it
}

/// What full light makes of a place: its cosine over the squared distance, as in simulate.
double irradiance(const Vec3& point_in_projector, const Vec3& unit_normal_in_projector) {
  const double range = point_in_projector.norm();
  return std::abs(point_in_projector.dot(unit_normal_in_projector)) / (range * range * range);
}

/// The irradiance that the picture is exposed for: a tenth of what the projector lights is brighter.
double exposed_for(const std::vector<RoomLayer>& lit, const Projector& projector) {
  constexpr int kSteps = 48;
  std::vector<double> found;
  const ImageSize size = projector.size();
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i) {
      const int x = size.width * (2 * i + 1) / (2 * kSteps), y = size.height * (2 * j + 1) / (2 * kSteps);
      const auto ray = projector.emit(Vec2(x, y));
      const auto met = ray ? nearest_plane(lit, {}, x, y, ray->direction) : std::nullopt;
      const auto point = met ? intersect(*ray, met->plane) : std::nullopt;
      if (point) found.push_back(irradiance(*point, met->plane.normal));
    }
  if (found.empty()) return 1;
  const auto at = found.begin() + std::ptrdiff_t(found.size() * 9 / 10);
  std::nth_element(found.begin(), at, found.end());
  return *at;
}

}  // namespace

ImageU8 preview(const Scene& scene, const Projector& projector, ViewU8 frame, const Viewpoint& viewpoint,
                const RenderOptions& options) {
  require(frame.channels == 3 && frame.size() == projector.size() && !frame.empty(),
          "preview: the frame must have 3 channels and the projector's size");
  const LightCurve curve(true);
  const Kernels& kernels = kernels_for(options.vector_bits);
  Workers workers(options.threads);
  LightTexture light;
  light.prepare(frame, curve, levels_of(frame.size()), workers);
  const Pose projector_from_camera = viewpoint.camera_from_projector.inverse();
  const Camera& camera = viewpoint.camera;
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

  const double full = exposed_for(lit, projector);
  const ImageSize size = camera.size;
  /// What a place of the view shows, and what tells it from its neighbours.
  struct Shown {
    Rgba colour;
    int layer;  ///< -1: nothing
    bool is_lit;
    double depth;
  };
  const auto look = [&](const Vec2& at, int x, int y) {
    Shown shown{Rgba::Constant(kRoom), -1, false, 0};
    const std::optional<Vec3> bearing = camera.unproject(at);
    const auto met = bearing ? nearest_plane(seen, margins, x, y, *bearing) : std::nullopt;
    const auto point = met ? intersect(Ray{Vec3::Zero(), *bearing}, met->plane) : std::nullopt;
    if (!point) return shown;
    shown.layer = met->layer;
    shown.depth = point->z();
    // The room's own light comes from all sides, a little more of it from behind the person.
    const double facing = std::abs(bearing->normalized().dot(met->plane.normal));
    shown.colour = Rgba::Constant(kSurface * float(0.6 + 0.4 * facing));
    const auto footprint = frame_footprint(at, met->plane);
    if (!footprint) return shown;
    const Coverage reached = coverage(*footprint);
    shown.is_lit = reached.area > 0;
    const double bright =
        irradiance(projector_from_camera * *point, projector_from_camera.rotate(met->plane.normal)) / full;
    if (shown.is_lit)
      shown.colour +=
          float(reached.area * bright) *
          (kBlackLevel + (1 - kSurface - kBlackLevel) * mean_content(light, kernels, *footprint, true));
    return shown;
  };

  std::vector<Shown> middles(std::size_t(size.width) * std::size_t(size.height));
  workers.run(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x)
      middles[std::size_t(y) * std::size_t(size.width) + std::size_t(x)] = look(Vec2(x, y), x, y);
  });
  const auto is_edge = [&](int x, int y) {
    constexpr double kStep = 0.03;  // share of the depth
    const auto at = [&](int i, int j) -> const Shown& {
      return middles[std::size_t(j) * std::size_t(size.width) + std::size_t(i)];
    };
    const Shown& here = at(x, y);
    for (int j = std::max(0, y - 1); j <= std::min(size.height - 1, y + 1); ++j)
      for (int i = std::max(0, x - 1); i <= std::min(size.width - 1, x + 1); ++i) {
        const Shown& there = at(i, j);
        if (there.layer != here.layer || there.is_lit != here.is_lit ||
            std::abs(there.depth - here.depth) > kStep * here.depth)
          return true;
      }
    return false;
  };
  ImageU8 view(size, 3);
  workers.run(size.height, [&](int y) {
    constexpr int kSide = 4;  // looks across and down in a pixel that holds an edge
    for (int x = 0; x < size.width; ++x) {
      Rgba shown = middles[std::size_t(y) * std::size_t(size.width) + std::size_t(x)].colour.min(1.0f);
      if (is_edge(x, y)) {
        shown.setZero();
        for (int j = 0; j < kSide; ++j)
          for (int i = 0; i < kSide; ++i)
            shown +=
                look(Vec2(x + (i + 0.5) / kSide - 0.5, y + (j + 0.5) / kSide - 0.5), x, y).colour.min(1.0f) /
                float(kSide * kSide);
      }
      for (int k = 0; k < 3; ++k)
        view.at(x, y, k) = curve.value(Light(std::lround(kFull * std::min(1.0f, shown[k]))));
    }
  });
  return view;
}

}  // namespace procam::render
