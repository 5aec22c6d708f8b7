#include "room_sampling.hpp"

#include "caster.hpp"
#include "parallel.hpp"
#include "procam/core/se3.hpp"
#include "ray_grid.hpp"

namespace procam::simulate::internal {
namespace {

constexpr int kCameraTile = 16;  ///< pixels, a multiple of kRayCell; a row of tiles is one piece of work
constexpr int kLightTile = 32;   ///< projector pixels

/// One light before the room, at one moment.
struct LightEye {
  Caster caster;
  Pose light_from_camera;
};

/// Camera and lights at the moment of one row.
struct Eyes {
  Caster camera;
  std::vector<LightEye> lights;
};

/// The projector pixel that lights a point, and with how much at full light.
struct Arriving {
  Vec2 projector_pixel;
  double irradiance;
};

class RoomTracer {
 public:
  RoomTracer(const Room& room, const Camera& camera, const Motion& room_from_camera,
             const std::vector<RoomLight>& lights, const std::vector<double>& light_reach,
             const RoomViewOptions& options)
      : room_(room),
        camera_(camera),
        room_from_camera_(room_from_camera),
        lights_(lights),
        options_(options),
        camera_tiles_(camera, Vec2(-0.5, -0.5), Vec2(camera.size.width - 0.5, camera.size.height - 0.5),
                      kCameraTile) {
    for (std::size_t l = 0; l < lights.size(); ++l) {
      const Vec2 reach = Vec2::Constant(light_reach[l] + 0.5);
      const ImageSize size = lights[l].projector.size();
      light_tiles_.emplace_back(lights[l].projector.inverse_camera, -reach,
                                Vec2(size.width - 1, size.height - 1) + reach, kLightTile);
    }
    still_ = room_from_camera.is_still();
    for (const RoomLight& light : lights) still_ = still_ && light.room_from_projector.is_still();
    still_ = still_ || options.row_time == 0;
    if (still_) {
      eyes_.push_back(eyes_at(0));
      light_candidates_ = light_candidates(eyes_.front(), std::vector<Slack>(lights.size()));
    }
    make_room(camera.size);
  }

  int bands() const { return camera_tiles_.rows(); }

  void trace_band(int band) {
    const int first = band * kCameraTile, end = std::min(first + kCameraTile, camera_.size.height);
    // With a rolling shutter, tiles belong to the moment of the band's middle.
    std::vector<Eyes> moving;
    std::vector<std::vector<Candidates>> moving_lights;
    Slack camera_slack;
    if (!still_) {
      for (int y = first; y < end; ++y) moving.push_back(eyes_at(y));
      const Eyes& middle = moving[moving.size() / 2];
      std::vector<Slack> light_slack(lights_.size());
      for (const Eyes& eyes : moving) {
        widen(camera_slack, middle.camera, eyes.camera);
        for (std::size_t l = 0; l < lights_.size(); ++l)
          widen(light_slack[l], middle.lights[l].caster, eyes.lights[l].caster);
      }
      moving_lights = light_candidates(middle, light_slack);
    }
    const Eyes& middle = still_ ? eyes_.front() : moving[moving.size() / 2];
    const std::vector<Candidates> tiles =
        camera_tiles_.candidates(room_, middle.camera.room_from_eye(), band, band + 1, camera_slack);
    const std::vector<std::vector<Candidates>>& in_light = still_ ? light_candidates_ : moving_lights;

    const int cells_x = ray_cells(camera_.size.width);
    std::vector<RayNode> above = ray_node_row(camera_, first / kRayCell);
    for (int cell_y = first / kRayCell; cell_y * kRayCell < end; ++cell_y) {
      std::vector<RayNode> below = ray_node_row(camera_, cell_y + 1);
      for (int y = cell_y * kRayCell; y < std::min((cell_y + 1) * kRayCell, end); ++y) {
        const Eyes& eyes = still_ ? eyes_.front() : moving[std::size_t(y - first)];
        for (int cell_x = 0; cell_x < cells_x; ++cell_x) {
          const std::size_t i = std::size_t(cell_x);
          const RayCell cell{above[i], above[i + 1], below[i], below[i + 1]};
          if (!cell.valid()) continue;  // beyond the lens: black
          for (int x = cell_x * kRayCell; x < std::min((cell_x + 1) * kRayCell, camera_.size.width); ++x)
            trace_pixel(x, y, cell, eyes, tiles[std::size_t(x / kCameraTile)], in_light);
        }
      }
      above.swap(below);
    }
  }

  RoomSamples take() { return std::move(samples_); }

 private:
  PreparedRoom room_;
  const Camera& camera_;
  const Motion& room_from_camera_;
  const std::vector<RoomLight>& lights_;
  const RoomViewOptions& options_;
  TileIndex camera_tiles_;
  std::vector<TileIndex> light_tiles_;
  bool still_ = true;
  std::vector<Eyes> eyes_;                                 ///< one, when nothing moves
  std::vector<std::vector<Candidates>> light_candidates_;  ///< by light and tile, likewise
  RoomSamples samples_;

  void make_room(ImageSize size) {
    const std::size_t rays = std::size_t(options_.samples_per_axis) * std::size_t(options_.samples_per_axis);
    const std::size_t pixels = std::size_t(size.width) * std::size_t(size.height);
    samples_.view.samples_per_pixel = int(rays);
    samples_.view.ambient_level = ImageF(size);
    samples_.view.of_light.assign(lights_.size(), std::vector<LightSample>(pixels * rays, {0, 0, 0}));
    if (options_.vignetting > 0) samples_.falloff = ImageF(size);
    samples_.truth.body = Image<std::int16_t>(size, 1, std::int16_t(-1));
    samples_.truth.depth = ImageF(size);
    samples_.truth.point_in_room = ImageF(size, 3);
    samples_.truth.light.assign(lights_.size(), {ImageF(size, 2), ImageU8(size)});
  }

  Eyes eyes_at(int row) const {
    const double time = options_.time + row * options_.row_time;
    const Pose room_from_camera = room_from_camera_(time);
    Eyes eyes{Caster(room_, room_from_camera), {}};
    for (const RoomLight& light : lights_) {
      const Pose room_from_light = light.room_from_projector(time);
      eyes.lights.push_back({Caster(room_, room_from_light), room_from_light.inverse() * room_from_camera});
    }
    return eyes;
  }
  static void widen(Slack& slack, const Caster& middle, const Caster& other) {
    const Pose between = middle.room_from_eye().inverse() * other.room_from_eye();
    slack.angle = std::max(slack.angle, so3_log(between.rotation).norm());
    slack.shift = std::max(slack.shift, between.translation.norm());
  }
  std::vector<std::vector<Candidates>> light_candidates(const Eyes& eyes,
                                                        const std::vector<Slack>& slack) const {
    std::vector<std::vector<Candidates>> found;
    for (std::size_t l = 0; l < lights_.size(); ++l)
      found.push_back(light_tiles_[l].candidates(room_, eyes.lights[l].caster.room_from_eye(), 0,
                                                 light_tiles_[l].rows(), slack[l]));
    return found;
  }

  /// What arrives of light l at a point, on the side of `normal`.
  std::optional<Arriving> arriving(std::size_t l, const Eyes& eyes, const BodyHit& hit, const Vec3& normal,
                                   const Vec3& point_in_camera,
                                   const std::vector<Candidates>& in_light) const {
    const LightEye& eye = eyes.lights[l];
    const Vec3 to_light = eye.caster.eye_in_body(hit.body) - hit.point_in_body;
    const double closing = normal.dot(to_light);
    if (!(closing > 0)) return std::nullopt;
    const Vec3 point_in_light = eye.light_from_camera * point_in_camera;
    const std::optional<Vec2> pixel = lights_[l].projector.pixel_lighting(point_in_light);
    if (!pixel || !light_tiles_[l].contains(*pixel)) return std::nullopt;
    if (eye.caster.is_hidden(point_in_light, in_light[std::size_t(light_tiles_[l].at(*pixel))]))
      return std::nullopt;
    const double distance2 = to_light.squaredNorm();
    return Arriving{*pixel, lights_[l].intensity * closing / (distance2 * std::sqrt(distance2))};
  }

  void trace_pixel(int x, int y, const RayCell& cell, const Eyes& eyes, const Candidates& candidates,
                   const std::vector<std::vector<Candidates>>& in_light) {
    if (!samples_.falloff.empty())
      samples_.falloff.at(x, y) =
          float(std::pow(std::max(centre_of(x, y, cell).normalized().z(), 0.0), options_.vignetting));
    if (candidates.empty()) return;
    const int n = options_.samples_per_axis;
    const double share = 1.0 / (n * n);
    const std::size_t first = (std::size_t(y) * std::size_t(camera_.size.width) + std::size_t(x)) *
                              std::size_t(samples_.view.samples_per_pixel);
    double ambient = 0;
    for (int k = 0; k < n * n; ++k) {
      const double s = (x % kRayCell + (k % n + 0.5) / n) / kRayCell;
      const double t = (y % kRayCell + (k / n + 0.5) / n) / kRayCell;
      const Vec3 direction = cell.direction(s, t);
      const BodyHit hit = eyes.camera.nearest(direction, candidates);
      if (hit.body < 0) continue;
      const Vec3 in_body = eyes.camera.in_body(hit.body, direction);
      Vec3 normal = outward(room_.room->bodies[std::size_t(hit.body)].shape, hit.point_in_body);
      const bool front = normal.dot(in_body) < 0;
      if (!front) normal = -normal;
      const double albedo = albedo_at(hit, front, normal, in_body, eyes.camera, cell, 1.0 / n);
      ambient += albedo;
      for (std::size_t l = 0; l < lights_.size(); ++l)
        if (const auto light = arriving(l, eyes, hit, normal, hit.s * direction, in_light[l]))
          samples_.view.of_light[l][first + std::size_t(k)] = {float(light->projector_pixel.x()),
                                                               float(light->projector_pixel.y()),
                                                               float(share * albedo * light->irradiance)};
    }
    samples_.view.ambient_level.at(x, y) = float(share * ambient * room_.room->ambient);
    note_truth(x, y, cell, eyes, candidates, in_light);
  }

  double albedo_at(const BodyHit& hit, bool front, const Vec3& normal, const Vec3& in_body, const Caster& eye,
                   const RayCell& cell, double width) const {
    const PreparedPaint& paint = room_.paints[std::size_t(hit.body)];
    if (paint.is_plain(front)) return paint.plain_albedo(front);
    // The pixel's sides, laid along the surface: dp = s (dd - d (n dd) / (n d)).
    const auto on_surface = [&](const RayNode& next) {
      const Vec3 change = eye.in_body(hit.body, next.direction_in_camera - cell.a.direction_in_camera);
      return Vec3((hit.s * width / kRayCell) *
                  (change - in_body * (normal.dot(change) / normal.dot(in_body))));
    };
    return paint.albedo(front, hit.point_in_body, on_surface(cell.b), on_surface(cell.c));
  }

  static Vec3 centre_of(int x, int y, const RayCell& cell) {
    return cell.direction((x % kRayCell + 0.5) / kRayCell, (y % kRayCell + 0.5) / kRayCell);
  }

  void note_truth(int x, int y, const RayCell& cell, const Eyes& eyes, const Candidates& candidates,
                  const std::vector<std::vector<Candidates>>& in_light) {
    const Vec3 direction = centre_of(x, y, cell);
    const BodyHit hit = eyes.camera.nearest(direction, candidates);
    if (hit.body < 0) return;
    const Vec3 point = hit.s * direction, in_room = eyes.camera.room_from_eye() * point;
    RoomTruth& truth = samples_.truth;
    truth.body.at(x, y) = std::int16_t(hit.body);
    truth.depth.at(x, y) = float(point.z());
    for (int c = 0; c < 3; ++c) truth.point_in_room.at(x, y, c) = float(in_room[c]);
    Vec3 normal = outward(room_.room->bodies[std::size_t(hit.body)].shape, hit.point_in_body);
    if (normal.dot(eyes.camera.in_body(hit.body, direction)) > 0) normal = -normal;
    for (std::size_t l = 0; l < lights_.size(); ++l) {
      const auto light = arriving(l, eyes, hit, normal, point, in_light[l]);
      if (!light || !lights_[l].projector.size().contains(light->projector_pixel)) continue;
      truth.light[l].lit.at(x, y) = 1;
      truth.light[l].pixel.at(x, y, 0) = float(light->projector_pixel.x());
      truth.light[l].pixel.at(x, y, 1) = float(light->projector_pixel.y());
    }
  }
};

}  // namespace

RoomSamples sample_room(const Room& room, const Camera& camera, const Motion& room_from_camera,
                        const std::vector<RoomLight>& lights, const std::vector<double>& light_reach,
                        const RoomViewOptions& options) {
  RoomTracer tracer(room, camera, room_from_camera, lights, light_reach, options);
  parallel_for(tracer.bands(), options.threads, [&](int begin, int end) {
    for (int band = begin; band < end; ++band) tracer.trace_band(band);
  });
  return tracer.take();
}

}  // namespace procam::simulate::internal
