#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "caster.hpp"
#include "defocus.hpp"
#include "indirect.hpp"
#include "procam/core/base/parallel.hpp"
#include "room_hit.hpp"

namespace procam::simulate::internal {
namespace {

/// The plane of a flat body that mirrors; its front is the side of z < 0.
struct Mirror {
  int body = 0;
  const Body* flat = nullptr;
  Vec3 normal, point;  ///< in the room; normal of the front

  explicit Mirror(const Room& room, int number)
      : body(number),
        flat(&room.bodies[std::size_t(number)]),
        normal(-flat->room_from_body.rotate(Vec3::UnitZ())),
        point(flat->room_from_body.translation) {}

  double height(const Vec3& p) const { return normal.dot(p - point); }
  Vec3 image(const Vec3& p) const { return p - 2 * height(p) * normal; }
  Vec3 mirrored(const Vec3& direction) const { return direction - 2 * normal.dot(direction) * normal; }
  /// Where the line from a to b meets the body itself.
  std::optional<Vec3> between(const Vec3& a, const Vec3& b) const {
    const Pose body_from_room = flat->room_from_body.inverse();
    const Meeting met = meet(*flat, body_from_room * a, body_from_room.rotate(b - a), 0, 1);
    if (!met.met()) return std::nullopt;
    return Vec3(flat->room_from_body * met.spot.point);
  }
};

/// One pixel's point of the room.
struct SeenPoint {
  Vec3 point, normal;  ///< normal towards the camera
  int body = 0;
  double albedo = 0;
};

/// What one light sends to a pixel by one path.
struct MirroredSample {
  Vec2 projector_pixel;
  double level, depth;
};

class MirrorTracer {
 public:
  MirrorTracer(const Room& room, const Pose& room_from_camera, const std::vector<RoomLight>& lights)
      : room_(room), prepared_(room), camera_centre_(room_from_camera.translation), lights_(lights) {
    for (std::size_t i = 0; i < room.bodies.size(); ++i)
      if (room.bodies[i].gloss.share > 0) mirrors_.emplace_back(room, int(i));
    for (const RoomLight& light : lights) {
      room_from_light_.push_back(light.room_from_projector(0));
      eyes_.emplace_back(prepared_, room_from_light_.back());
    }
  }

  bool has_mirrors() const { return !mirrors_.empty(); }

  /// The mirror image that the pixel sees, the highlight, and what each mirror throws.
  std::size_t paths() const { return 2 + mirrors_.size(); }
  std::optional<MirroredSample> along(std::size_t path, const SeenPoint& seen, std::size_t l) const {
    if (path == 0) return seen_in_mirror(seen, l);
    if (path == 1) return highlight(seen, l);
    return thrown_by(mirrors_[path - 2], seen, l);
  }

 private:
  /// A mirrored image of the room, seen in the body that the pixel sees.
  std::optional<MirroredSample> seen_in_mirror(const SeenPoint& seen, std::size_t l) const {
    const Mirror* mirror = mirror_at(seen);
    if (mirror == nullptr) return std::nullopt;
    const Vec3 direction = mirror->mirrored(Vec3(seen.point - camera_centre_)).normalized();
    const Caster eye(prepared_,
                     Pose(Eigen::Quaterniond::Identity(), seen.point + kBeforeSurface * mirror->normal));
    const BodyHit hit = eye.nearest(direction, prepared_.all);
    if (hit.body < 0) return std::nullopt;
    const Body& body = room_.bodies[std::size_t(hit.body)];
    const Vec3 outwards = body.room_from_body.rotate(smooth_outward(body.shape, hit.spot_in_body));
    const bool front = outwards.dot(direction) < 0;
    const double albedo =
        prepared_.paints[std::size_t(hit.body)].albedo(front, hit.spot_in_body, Footprint{})[0];
    const SeenPoint lit{body.room_from_body * hit.spot_in_body.point, front ? outwards : Vec3(-outwards),
                        hit.body, albedo};
    if (!reaches(l, lit)) return std::nullopt;
    return sample(l, lit, lit.point, room_from_light_[l].translation, mirror->flat->gloss.share * albedo);
  }

  /// The light that a mirror throws on the point.
  std::optional<MirroredSample> thrown_by(const Mirror& mirror, const SeenPoint& seen, std::size_t l) const {
    const Vec3 light = room_from_light_[l].translation;
    if (mirror.body == seen.body || mirror.height(light) <= 0 || mirror.height(seen.point) <= 0)
      return std::nullopt;
    const Vec3 image = mirror.image(seen.point);
    const std::optional<Vec3> by = mirror.between(light, image);
    if (!by) return std::nullopt;
    if (!reaches(l, {*by, mirror.normal, mirror.body, 0})) return std::nullopt;
    const Vec3 start = *by + kBeforeSurface * mirror.normal;
    const Caster eye(prepared_, Pose(Eigen::Quaterniond::Identity(), start));
    if (eye.is_hidden(seen.point - start, seen.body, prepared_.all)) return std::nullopt;
    return sample(l, seen, image, mirror.image(light), mirror.flat->gloss.share * seen.albedo);
  }

  /// The projector's lens, as a lobe of mirrored directions shows it: Gaussian, of integral 1 over the solid angle.
  std::optional<MirroredSample> highlight(const SeenPoint& seen, std::size_t l) const {
    const Mirror* mirror = mirror_at(seen);
    if (mirror == nullptr) return std::nullopt;
    const Gloss& gloss = mirror->flat->gloss;
    const Vec3 to_light = room_from_light_[l].translation - seen.point;
    const Vec3 direction = mirror->mirrored(Vec3(seen.point - camera_centre_)).normalized();
    const double angle = std::acos(std::clamp(direction.dot(to_light.normalized()), -1.0, 1.0));
    if (angle > 5 * gloss.spread || !reaches(l, seen)) return std::nullopt;
    std::optional<MirroredSample> direct = sample(l, seen, seen.point, seen.point + to_light, gloss.share);
    const double lobe = std::exp(-0.5 * angle * angle / (gloss.spread * gloss.spread)) /
                        (2 * kPi * gloss.spread * gloss.spread);
    if (direct) direct->level *= kPi * lobe;  // levels are pi times a radiance
    return direct;
  }

  const Mirror* mirror_at(const SeenPoint& seen) const {
    for (const Mirror& mirror : mirrors_)
      if (mirror.body == seen.body && mirror.normal.dot(seen.normal) > 0) return &mirror;
    return nullptr;
  }

  bool reaches(std::size_t l, const SeenPoint& point) const {
    const Vec3 to_light = room_from_light_[l].translation - point.point;
    if (to_light.dot(point.normal) <= 0) return false;
    return !eyes_[l].is_hidden(room_from_light_[l].inverse() * point.point, point.body, prepared_.all);
  }

  /// What the light at `light` (itself, or its mirror image) puts on `lit`; it leaves the projector towards `through`.
  std::optional<MirroredSample> sample(std::size_t l, const SeenPoint& lit, const Vec3& through,
                                       const Vec3& light, double share) const {
    const Vec3 in_light = room_from_light_[l].inverse() * through;
    const std::optional<Vec2> pixel = lights_[l].projector.project(in_light);
    if (!pixel || !lights_[l].projector.size().contains(*pixel)) return std::nullopt;
    const Vec3 to_light = light - lit.point;
    const double closing = lit.normal.dot(to_light), distance = to_light.norm();
    if (!(closing > 0)) return std::nullopt;
    return MirroredSample{*pixel, share * lights_[l].intensity * closing / (distance * distance * distance),
                          in_light.z()};
  }

  const Room& room_;
  PreparedRoom prepared_;
  Vec3 camera_centre_;
  const std::vector<RoomLight>& lights_;
  std::vector<Pose> room_from_light_;
  std::vector<Caster> eyes_;  ///< of the lights
  std::vector<Mirror> mirrors_;
};

std::optional<SeenPoint> seen_at(const Room& room, const Camera& camera, const Pose& room_from_camera,
                                 const RoomSamples& samples, int x, int y) {
  const std::optional<Vec3> bearing = camera.unproject(Vec2(x, y));
  if (samples.truth.body.at(x, y) < 0 || !bearing) return std::nullopt;
  const auto hit = nearest_hit(room, {room_from_camera.translation, room_from_camera.rotate(*bearing)});
  if (!hit) return std::nullopt;
  return SeenPoint{hit->point_in_room, hit->normal_in_room, hit->body, double(samples.view.albedo.at(x, y))};
}

}  // namespace

void add_mirrored_light(const Room& room, const Camera& camera, const Pose& room_from_camera,
                        const std::vector<RoomLight>& lights, int threads, RoomSamples& samples,
                        std::vector<ShownFrames>& shown) {
  const MirrorTracer tracer(room, room_from_camera, lights);
  if (!tracer.has_mirrors()) return;
  SampledView& view = samples.view;
  const ImageSize size = camera.size;
  const std::size_t rays = std::size_t(view.samples_per_pixel);
  const std::size_t all_rays = std::size_t(size.width) * std::size_t(size.height) * rays;
  // One path after the other takes the place of a ray.
  const std::size_t paths = tracer.paths(), layers = (paths + rays - 1) / rays;
  for (std::size_t l = 0; l < lights.size(); ++l) {
    const RoomLight& light = lights[l];
    const std::size_t first_layer = view.of_light.size();
    for (std::size_t layer = 0; layer < layers; ++layer) {
      view.of_light.emplace_back(all_rays, LightSample{0, 0, 0});
      view.discs.emplace_back(light.lens.aperture > 0 ? all_rays : 0);
      shown.push_back(shown[l]);
    }
    parallel_each(size.height, threads, [&](int y) {
      for (int x = 0; x < size.width; ++x) {
        const std::optional<SeenPoint> seen = seen_at(room, camera, room_from_camera, samples, x, y);
        for (std::size_t path = 0; seen && path < paths; ++path) {
          const std::optional<MirroredSample> mirrored = tracer.along(path, *seen, l);
          if (!mirrored) continue;
          const std::size_t layer = first_layer + path / rays, ray = view.first_ray_of(x, y) + path % rays;
          view.of_light[layer][ray] = {float(mirrored->projector_pixel.x()),
                                       float(mirrored->projector_pixel.y()), float(mirrored->level)};
          if (!view.discs[layer].empty())
            view.discs[layer][ray] =
                float(std::abs(disc_radius(light.lens, light.projector.inverse_camera, mirrored->depth)));
        }
      }
    });
  }
}

}  // namespace procam::simulate::internal
