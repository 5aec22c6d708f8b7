#include "procam/simulate/preview.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "caster.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::simulate {
namespace {

constexpr double kAlbedo = 0.8;
constexpr double kMargin = 0.2;  ///< of a plane's size, on each side

/// Corners of the content's area and `margin` of it round it; nullopt where they are beyond a horizon.
std::optional<Polygon> area_of(const PlacedPlane& placed, double margin) {
  Polygon area;
  for (const Vec2& uv : {Vec2(-margin, -margin), Vec2(1 + margin, -margin), Vec2(1 + margin, 1 + margin),
                         Vec2(-margin, 1 + margin)}) {
    const Vec3 q = placed.plane_from_content * uv.homogeneous();
    const Vec3 middle = placed.plane_from_content * Vec3(0.5, 0.5, 1);
    if (!(q.z() * middle.z() > 0)) return std::nullopt;
    area.corners.emplace_back(q.hnormalized());
  }
  return area;
}

std::optional<Cutout> cutout_of(ViewU8 mask) {
  if (mask.empty()) return std::nullopt;
  Cutout cutout{ImageU8(mask.size()), Mat3::Identity()};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) cutout.mask.at(x, y) = mask.at(x, y);
  return cutout;
}

void add(const PlacedPlane& placed, const SceneItem& item, const std::string& name, Room& room) {
  const std::optional<Polygon> area = area_of(placed, 0), wall = area_of(placed, kMargin);
  if (wall) {
    Body backdrop{"round " + name, *wall, placed.projector_from_surface, kAlbedo};
    backdrop.backdrop = true;
    room.bodies.push_back(std::move(backdrop));
  }
  if (!area) return;
  Body body{name, *area, placed.projector_from_surface, kAlbedo};
  body.cutout = cutout_of(item.mask);
  if (body.cutout) {  // the polygon's u, v are those of its bounds
    const Rectangle bounds = *internal::flat_bounds(body.shape);
    Mat3 plane_from_uv = Mat3::Identity();
    plane_from_uv.topLeftCorner<2, 2>() = Mat2((bounds.high - bounds.low).asDiagonal());
    plane_from_uv.topRightCorner<2, 1>() = bounds.low;
    Mat3 content_from_plane = placed.plane_from_content.inverse();
    const Vec3 middle = placed.plane_from_content * Vec3(0.5, 0.5, 1);
    body.cutout->mask_from_uv = middle.z() * content_from_plane * plane_from_uv;
  }
  room.bodies.push_back(std::move(body));
}
void add(const PlacedMesh& placed, const SceneItem& item, const std::string& name, Room& room) {
  Body body{name, TriangleMesh(placed.mesh), placed.projector_from_surface, kAlbedo};
  body.cutout = cutout_of(item.mask);
  room.bodies.push_back(std::move(body));
}
void add(const PlacedPixels&, const SceneItem&, const std::string&, Room&) {}

/// A tenth of what the lights' pictures fall on sends back more than this, at full light.
double bright_level(const Room& room, const std::vector<RoomLight>& lights, double time) {
  constexpr int kSteps = 48;
  const internal::PreparedRoom prepared(room);
  std::vector<double> levels;
  for (const RoomLight& light : lights) {
    const internal::Caster caster(prepared, light.room_from_projector(time));
    const ImageSize size = light.projector.size();
    for (int j = 0; j < kSteps; ++j)
      for (int i = 0; i < kSteps; ++i) {
        const auto ray = light.projector.emit(
            Vec2(size.width * (i + 0.5) / kSteps - 0.5, size.height * (j + 0.5) / kSteps - 0.5));
        if (!ray) continue;
        const internal::BodyHit hit = caster.nearest(ray->direction, prepared.all);
        if (hit.body < 0) continue;
        const Vec3 normal =
            internal::smooth_outward(room.bodies[std::size_t(hit.body)].shape, hit.spot_in_body);
        const Vec3 way = caster.in_body(hit.body, hit.s * ray->direction);
        const double closing = std::abs(normal.dot(way)), distance2 = way.squaredNorm();
        const internal::Bands albedo =
            prepared.paints[std::size_t(hit.body)].albedo(normal.dot(way) < 0, hit.spot_in_body, {});
        levels.push_back(light.intensity * *std::max_element(albedo.begin(), albedo.end()) * closing /
                         (distance2 * std::sqrt(distance2)));
      }
  }
  if (levels.empty()) return 0;
  return at_rank(levels, levels.size() * 9 / 10);
}

}  // namespace

Room room_of(const Scene& scene) {
  Room room;
  for (std::size_t i = 0; i < scene.items.size(); ++i)
    std::visit([&](const auto& placed) { add(placed, scene.items[i], std::to_string(i), room); },
               scene.items[i].placement);
  return room;
}

ImageU8 preview(const Room& room, const std::vector<RoomLight>& lights, const Camera& eye,
                const Pose& room_from_eye, const PreviewOptions& options) {
  require(options.ambient >= 0, "preview: the ambient light is negative");
  RoomViewOptions view;
  const double bright = bright_level(room, lights, view.time);
  // Without light, what white paper makes of the room's own.
  const double white = bright > 0 ? bright : kAlbedo * std::max(room.ambient, 1.0);
  Room lit = room;
  if (options.ambient > 0) lit.ambient = options.ambient * white / kAlbedo;
  std::vector<RoomLight> shown = lights;
  for (RoomLight& light : shown)
    if (light.frames.size() > 1) light.frames.resize(1);
  view.exposure = 255 / (white * (1 + options.ambient));
  view.colour = true;
  view.crosstalk = 0;
  view.gamma = kSrgb;
  view.samples_per_axis = 3;
  view.adaptive = true;
  view.threads = options.threads;
  return std::move(room_view(lit, eye, room_from_eye, shown, view).captures.front());
}

}  // namespace procam::simulate
