#include "room_sampling.hpp"

#include <array>

#include "defocus.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/geometry/se3.hpp"
#include "room_lights.hpp"

namespace procam::simulate::internal {
namespace {

constexpr int kCameraTile = 16;  ///< pixels, a multiple of kRayCell; a row of tiles is one piece of work

/// Columns [x, x_end), rows [y, y_end).
struct PixelBox {
  int x, x_end, y, y_end;
};

/// What a pixel's centre meets, for the plane that stands for all of the pixel.
struct CentrePlane {
  Eigen::Vector3f normal_in_room, smooth_normal_in_room;  ///< against the ray
  std::int32_t facet = -1;
  bool front = true;
  bool waits = false;  ///< for the second pass
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
        room_lights_(lights, light_reach),
        options_(options),
        camera_tiles_(camera, Vec2(-0.5, -0.5), Vec2(camera.size.width - 0.5, camera.size.height - 0.5),
                      kCameraTile) {
    still_ = room_from_camera.is_still();
    for (const RoomLight& light : lights) still_ = still_ && light.room_from_projector.is_still();
    still_ = still_ || options.row_time == 0;
    if (still_) {
      eyes_.push_back(eyes_at(0));
      light_candidates_ = room_lights_.candidates(room_, eyes_.front(), std::vector<Slack>(lights.size()));
    }
    make_room(camera.size);
  }

  int bands() const { return camera_tiles_.rows(); }

  /// All rays of a band; where `options.adaptive` and not all is flat, its centres alone.
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
      moving_lights = room_lights_.candidates(room_, middle, light_slack);
    }
    const Eyes& middle = still_ ? eyes_.front() : moving[moving.size() / 2];
    const std::vector<std::vector<Candidates>>& in_light = still_ ? light_candidates_ : moving_lights;
    for_cells(band, middle, camera_slack,
              [&](const PixelBox& box, const RayCell& cell, const Candidates& candidates) {
                if (still_ && trace_flat(box, cell, eyes_.front(), candidates, in_light)) return;
                for (int row = box.y; row < box.y_end; ++row)
                  for (int column = box.x; column < box.x_end; ++column) {
                    const Eyes& eyes = still_ ? eyes_.front() : moving[std::size_t(row - first)];
                    note_truth(column, row, cell, eyes, candidates, in_light);
                    if (centres_.empty()) trace_pixel(column, row, cell, eyes, candidates, in_light);
                  }
              });
  }

  bool is_adaptive() const { return !centres_.empty(); }
  /// After trace_band() of all bands: the rays that wait.
  void refine_band(int band) {
    const Eyes& eyes = eyes_.front();
    for_cells(band, eyes, {}, [&](const PixelBox& box, const RayCell& cell, const Candidates& candidates) {
      for (int y = box.y; y < box.y_end; ++y)
        for (int x = box.x; x < box.x_end; ++x) {
          if (!centre_at(x, y).waits) continue;
          if (is_edge(x, y, eyes, cell))
            trace_pixel(x, y, cell, eyes, candidates, light_candidates_);
          else if (samples_.truth.body.at(x, y) >= 0)
            trace_plane(x, y, cell, eyes);
        }
    });
  }

  RoomSamples take() { return std::move(samples_); }

 private:
  PreparedRoom room_;
  const Camera& camera_;
  const Motion& room_from_camera_;
  const std::vector<RoomLight>& lights_;
  RoomLights room_lights_;
  const RoomViewOptions& options_;
  TileIndex camera_tiles_;
  bool still_ = true;
  std::vector<Eyes> eyes_;                                 ///< one, when nothing moves
  std::vector<std::vector<Candidates>> light_candidates_;  ///< by light and tile, likewise
  RoomSamples samples_;
  std::vector<CentrePlane> centres_;  ///< of all pixels; empty: all rays are cast
  std::vector<ImageU8> reached_;      ///< by light, then too: 1 where it reaches the pixel's centre

  CentrePlane& centre_at(int x, int y) {
    return centres_[std::size_t(y) * std::size_t(camera_.size.width) + std::size_t(x)];
  }

  /// Calls visit(box, cell, candidates) for the cells of a band in which something may be met.
  template <typename Visit>
  void for_cells(int band, const Eyes& eyes, const Slack& slack, const Visit& visit) {
    const int first = band * kCameraTile, end = std::min(first + kCameraTile, camera_.size.height);
    const std::vector<Candidates> tiles =
        camera_tiles_.candidates(room_, eyes.camera.room_from_eye(), band, band + 1, slack);
    const int cells_x = ray_cells(camera_.size.width);
    std::vector<RayNode> above = ray_node_row(camera_, {}, first / kRayCell);
    std::vector<double> falloff_above = falloff_of(above);
    for (int cell_y = first / kRayCell; cell_y * kRayCell < end; ++cell_y) {
      std::vector<RayNode> below = ray_node_row(camera_, {}, cell_y + 1);
      std::vector<double> falloff_below = falloff_of(below);
      const int y_end = std::min((cell_y + 1) * kRayCell, end);
      for (int cell_x = 0; cell_x < cells_x; ++cell_x) {
        const std::size_t i = std::size_t(cell_x);
        const RayCell cell{above[i], above[i + 1], below[i], below[i + 1]};
        if (!cell.valid()) continue;  // beyond the lens: black
        const int x = cell_x * kRayCell, x_end = std::min(x + kRayCell, camera_.size.width);
        const PixelBox box{x, x_end, cell_y * kRayCell, y_end};
        if (!samples_.falloff.empty())
          note_falloff(box, falloff_above[i], falloff_above[i + 1], falloff_below[i], falloff_below[i + 1]);
        const Candidates& candidates = tiles[std::size_t(x / kCameraTile)];
        if (!candidates.empty()) visit(box, cell, candidates);
      }
      above.swap(below);
      falloff_above.swap(falloff_below);
    }
  }

  void make_room(ImageSize size) {
    const std::size_t rays = std::size_t(options_.samples_per_axis) * std::size_t(options_.samples_per_axis);
    const std::size_t pixels = std::size_t(size.width) * std::size_t(size.height);
    samples_.view.samples_per_pixel = int(rays);
    samples_.view.bands = bands_of(room_);
    samples_.view.ambient_level = ImageF(size, samples_.view.bands);
    if (samples_.view.bands > 1) samples_.view.tints.resize(pixels * rays);
    if (room_.room->indirect) samples_.view.albedo = ImageF(size);
    for (const RoomLight& light : lights_)
      samples_.view.discs.emplace_back(light.lens.aperture > 0 ? pixels * rays : 0);
    samples_.view.of_light.assign(lights_.size(), std::vector<LightSample>(pixels * rays, {0, 0, 0}));
    if (options_.vignetting > 0) samples_.falloff = ImageF(size);
    samples_.truth.body = Image<std::int16_t>(size, 1, std::int16_t(-1));
    samples_.truth.depth = ImageF(size);
    samples_.truth.point_in_room = ImageF(size, 3);
    samples_.truth.light.assign(lights_.size(), {ImageF(size, 2), ImageU8(size)});
    if (options_.adaptive && still_) {
      centres_.resize(pixels);
      reached_.assign(lights_.size(), ImageU8(size));
    }
  }

  static int bands_of(const PreparedRoom& room) {
    for (const PreparedPaint& paint : room.paints)
      if (paint.is_coloured()) return 3;
    return 1;
  }
  Eyes eyes_at(int row) const {
    const double time = options_.time + row * options_.row_time;
    const Pose room_from_camera = room_from_camera_(time);
    Eyes eyes{Caster(room_, room_from_camera), {}};
    for (const RoomLight& light : lights_) {
      const Pose room_from_light = light.room_from_projector(time);
      const Pose light_from_camera = room_from_light.inverse() * room_from_camera;
      eyes.lights.push_back(
          {Caster(room_, room_from_light), light_from_camera, light_from_camera.rotation_matrix()});
    }
    return eyes;
  }
  static void widen(Slack& slack, const Caster& middle, const Caster& other) {
    const Pose between = middle.room_from_eye().inverse() * other.room_from_eye();
    slack.angle = std::max(slack.angle, so3_log(between.rotation).norm());
    slack.shift = std::max(slack.shift, between.translation.norm());
  }
  /// The side of a body that a ray meets, in the body's frame.
  struct Facing {
    bool front;
    Vec3 normal, smooth_normal;  ///< against the ray: of the shape, and of what light falls on
  };
  Facing facing_of(const BodyHit& hit, const Vec3& direction_in_body) const {
    const Shape& shape = room_.room->bodies[std::size_t(hit.body)].shape;
    const Vec3 normal = outward(shape, hit.spot_in_body);
    const bool front = normal.dot(direction_in_body) < 0;
    const double side = front ? 1 : -1;
    if (hit.spot_in_body.facet < 0) return {front, side * normal, side * normal};
    return {front, side * normal, side * smooth_outward(shape, hit.spot_in_body)};
  }

  double share_of_ray() const { return 1.0 / samples_.view.samples_per_pixel; }

  /// A ray's albedo, for the ambient light and for all that `light` puts there.
  double note_albedo(int x, int y, std::size_t ray, const Bands& albedo) {
    SampledView& view = samples_.view;
    if (room_.room->indirect) view.albedo.at(x, y) += float(share_of_ray() * albedo[0]);
    for (int band = 0; band < view.bands; ++band)
      view.ambient_level.at(x, y, band) +=
          float(share_of_ray() * albedo[std::size_t(band)] * room_.room->ambient);
    if (view.bands == 1) return share_of_ray() * albedo[0];
    view.tints[ray] = {float(albedo[0]), float(albedo[1]), float(albedo[2])};
    return share_of_ray();
  }
  void note_light(std::size_t l, std::size_t ray, double level, const Arriving& light) {
    samples_.view.of_light[l][ray] = {float(light.projector_pixel.x()), float(light.projector_pixel.y()),
                                      float(level * light.irradiance)};
    if (samples_.view.discs[l].empty()) return;
    const RoomLight& source = lights_[l];
    samples_.view.discs[l][ray] =
        float(std::abs(disc_radius(source.lens, source.projector.inverse_camera, light.depth)));
  }

  void trace_pixel(int x, int y, const RayCell& cell, const Eyes& eyes, const Candidates& candidates,
                   const std::vector<std::vector<Candidates>>& in_light) {
    const int n = options_.samples_per_axis;
    const std::size_t first = samples_.view.first_ray_of(x, y);
    for (int k = 0; k < n * n; ++k) {
      const double s = (x % kRayCell + (k % n + 0.5) / n) / kRayCell;
      const double t = (y % kRayCell + (k / n + 0.5) / n) / kRayCell;
      const Vec3 direction = cell.direction(s, t);
      const BodyHit hit = eyes.camera.nearest(direction, candidates);
      if (hit.body < 0) continue;
      const Vec3 in_body = eyes.camera.in_body(hit.body, direction);
      const Facing facing = facing_of(hit, in_body);
      const bool front = facing.front;
      const PreparedPaint& paint = room_.paints[std::size_t(hit.body)];
      const Footprint share = paint.is_plain(front)
                                  ? Footprint{}
                                  : footprint(hit, facing.normal, in_body, eyes.camera, cell, 1.0 / n);
      const double level =
          note_albedo(x, y, first + std::size_t(k), paint.albedo(front, hit.spot_in_body, share));
      for (std::size_t l = 0; l < lights_.size(); ++l)
        if (const auto light =
                room_lights_.arriving(l, eyes, hit, facing.smooth_normal, hit.s * direction, in_light[l]))
          note_light(l, first + std::size_t(k), level, *light);
    }
  }

  /// Does a pixel beside this one see another body, another bend of it, or another light?
  bool is_edge(int x, int y, const Eyes& eyes, const RayCell& cell) {
    constexpr float kBend = 0.1f;     // of the step to the next pixel, off the plane
    constexpr double kGrazing = 0.1;  // cosine
    const RoomTruth& truth = samples_.truth;
    const int body = truth.body.at(x, y);
    const Eigen::Vector3f normal = centre_at(x, y).normal_in_room;
    const auto point = [&](int i, int j) {
      return Eigen::Map<const Eigen::Vector3f>(&truth.point_in_room.at(i, j));
    };
    if (body >= 0) {
      const Vec3 direction = centre_of(x, y, cell);
      const Vec3 in_room = eyes.camera.room_from_eye().rotate(direction);
      if (std::abs(normal.cast<double>().dot(in_room)) < kGrazing * direction.norm()) return true;
    }
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, camera_.size.height - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, camera_.size.width - 1); ++i) {
        if (truth.body.at(i, j) != body) return true;
        for (const ImageU8& reached : reached_)
          if (reached.at(i, j) != reached.at(x, y)) return true;
        if (body < 0) continue;
        const Eigen::Vector3f step = point(i, j) - point(x, y);
        if (std::abs(normal.dot(step)) > kBend * step.norm()) return true;
      }
    return false;
  }
  /// All rays of a pixel on the plane that its centre meets, with the light that reaches the centre.
  void trace_plane(int x, int y, const RayCell& cell, const Eyes& eyes) {
    const CentrePlane& plane = centre_at(x, y);
    const int body = samples_.truth.body.at(x, y), n = options_.samples_per_axis;
    const std::size_t pixel = std::size_t(y) * std::size_t(camera_.size.width) + std::size_t(x);
    const std::size_t first = samples_.view.first_ray_of(x, y);
    const Eigen::Quaterniond eye_from_room = eyes.camera.room_from_eye().rotation.conjugate();
    const Vec3 normal = eye_from_room * plane.normal_in_room.cast<double>();
    const auto direction_at = [&](double across, double down) {  // of the pixel, 0..1
      return cell.direction((x % kRayCell + across) / kRayCell, (y % kRayCell + down) / kRayCell);
    };
    const Vec3 middle = direction_at(0.5, 0.5);
    const double height = double(samples_.truth.depth.at(x, y)) / middle.z() * normal.dot(middle);
    const auto length_of = [&](const Vec3& direction) { return height / normal.dot(direction); };

    const PreparedPaint& paint = room_.paints[std::size_t(body)];
    const bool plain = paint.is_plain(plane.front);
    Footprint share;
    if (!plain)
      share = footprint({body, length_of(middle), {}}, eyes.camera.in_body(body, normal),
                        eyes.camera.in_body(body, middle), eyes.camera, cell, 1.0 / n);
    std::array<double, kMaxPerAxis * kMaxPerAxis> levels;
    for (int k = 0; k < n * n; ++k) {
      Spot spot;
      if (!plain) {
        const Vec3 direction = direction_at((k % n + 0.5) / n, (k / n + 0.5) / n);
        spot = {eyes.camera.eye_in_body(body) + eyes.camera.in_body(body, length_of(direction) * direction),
                plane.facet};
      }
      levels[std::size_t(k)] =
          note_albedo(x, y, first + std::size_t(k), paint.albedo(plane.front, spot, share));
    }
    // The light's pixel and strength at the middle and half a pixel beside it; linear between.
    for (std::size_t l = 0; l < lights_.size(); ++l) {
      if (reached_[l].data()[pixel] == 0) continue;
      const LightEye& light = eyes.lights[l];
      const Vec3 smooth_normal =
          light.light_rotation * (eye_from_room * plane.smooth_normal_in_room.cast<double>());
      const auto arrives = [&](double across, double down) -> std::optional<Arriving> {
        const Vec3 direction = direction_at(across, down);
        const Vec3 point = light.light_from_camera * Vec3(length_of(direction) * direction);
        const std::optional<Vec2> lit = lights_[l].projector.project(point);
        if (!lit) return std::nullopt;
        const double distance2 = point.squaredNorm();
        const double closing = std::max(-smooth_normal.dot(point), 0.0);
        return Arriving{*lit, lights_[l].intensity * closing / (distance2 * std::sqrt(distance2)), point.z()};
      };
      const auto at = arrives(0.5, 0.5), right = arrives(1, 0.5), below = arrives(0.5, 1);
      if (!at || !right || !below) continue;
      for (int k = 0; k < n * n; ++k) {
        const double across = 2 * ((k % n + 0.5) / n - 0.5), down = 2 * ((k / n + 0.5) / n - 0.5);
        const auto between = [&](const auto& a, const auto& b, const auto& c) {
          return a + across * (b - a) + down * (c - a);
        };
        note_light(l, first + std::size_t(k), levels[std::size_t(k)],
                   {between(at->projector_pixel, right->projector_pixel, below->projector_pixel),
                    between(at->irradiance, right->irradiance, below->irradiance), at->depth});
      }
    }
  }

  /// The pixel's sides, laid along the surface: dp = s (dd - d (n dd) / (n d)).
  static Footprint footprint(const BodyHit& hit, const Vec3& normal, const Vec3& direction_in_body,
                             const Caster& eye, const RayCell& cell, double width) {
    const auto on_surface = [&](const RayNode& next) {
      const Vec3 change = eye.in_body(hit.body, next.direction_in_camera - cell.a.direction_in_camera);
      return Vec3((hit.s * width / kRayCell) *
                  (change - direction_in_body * (normal.dot(change) / normal.dot(direction_in_body))));
    };
    return {on_surface(cell.b), on_surface(cell.c)};
  }

  /// A cell of which all rays meet one flat body, or none: true where that is certain and done.
  bool trace_flat(const PixelBox& box, const RayCell& cell, const Eyes& eyes, const Candidates& candidates,
                  const std::vector<std::vector<Candidates>>& in_light) {
    const CellRays corners = {cell.a.direction_in_camera, cell.b.direction_in_camera,
                              cell.c.direction_in_camera, cell.d.direction_in_camera};
    const std::optional<int> first = eyes.camera.first_of(corners, candidates);
    if (!first) return false;
    if (*first < 0) return true;
    const int body = *first, n = options_.samples_per_axis;
    const Vec3& eye = eyes.camera.eye_in_body(body);
    const bool front = eye.z() < 0;
    const Vec3 normal(0, 0, front ? -1 : 1);

    const PreparedPaint& paint = room_.paints[std::size_t(body)];
    Footprint share;
    Bands albedo;
    if (paint.is_plain(front)) {
      albedo = paint.albedo(front, {}, share);
    } else {
      const Vec3 middle = cell.direction(0.5, 0.5);
      const double s = eyes.camera.lengths_to_plane(body, middle);
      share = footprint({body, s, {}}, normal, eyes.camera.in_body(body, middle), eyes.camera, cell, 1.0 / n);
    }
    // n x n rays a pixel over the cell, use(x, y, number within the pixel, point in the camera's frame).
    const auto each_point = [&](int n_of_pixel, const auto& use) {
      const double step = 1.0 / (kRayCell * n_of_pixel);
      for (int y = box.y; y < box.y_end; ++y)
        for (int j = 0; j < n_of_pixel; ++j) {
          const double t = double(y - box.y) / kRayCell + (j + 0.5) * step;
          const Vec3 left = cell.direction(0, t), across = cell.direction(1, t) - left;
          for (int x = box.x; x < box.x_end; ++x)
            for (int i = 0; i < n_of_pixel; ++i) {
              const Vec3 direction = left + (double(x - box.x) / kRayCell + (i + 0.5) * step) * across;
              use(x, y, std::size_t(j * n_of_pixel + i),
                  Vec3(eyes.camera.lengths_to_plane(body, direction) * direction));
            }
        }
    };
    FlatPoints rays, centres;
    rays.body = centres.body = body;
    rays.normal = centres.normal = normal;
    each_point(n, [&](int x, int y, std::size_t k, const Vec3& point) {
      if (!paint.is_plain(front))
        albedo = paint.albedo(front, {eye + eyes.camera.in_body(body, point)}, share);
      const std::size_t ray = samples_.view.first_ray_of(x, y) + k;
      rays.points[rays.count++] = {point, ray, note_albedo(x, y, ray, albedo)};
    });
    each_point(1, [&](int x, int y, std::size_t, const Vec3& point) {
      note_seen(x, y, body, point, eyes);
      centres.points[centres.count++] = {
          point, std::size_t(y) * std::size_t(camera_.size.width) + std::size_t(x), 0};
    });
    for (std::size_t l = 0; l < lights_.size(); ++l) {
      const FlatLight light = room_lights_.flat_light(l, eyes, body, normal, corners, in_light[l]);
      if (light.hidden == Share::kAll) continue;
      room_lights_.each_lit(l, light, eyes, rays, in_light[l],
                            [&](const FlatPoints::Point& point, const Arriving& arriving) {
                              note_light(l, point.ray, point.level, arriving);
                            });
      room_lights_.each_lit(l, light, eyes, centres, in_light[l],
                            [&](const FlatPoints::Point& point, const Arriving& arriving) {
                              note_truth_light(point.ray, l, arriving);
                            });
    }
    return true;
  }

  static Vec3 centre_of(int x, int y, const RayCell& cell) {
    return cell.direction((x % kRayCell + 0.5) / kRayCell, (y % kRayCell + 0.5) / kRayCell);
  }

  /// cos(field angle)^vignetting; empty without vignetting.
  std::vector<double> falloff_of(const std::vector<RayNode>& nodes) const {
    std::vector<double> falloff;
    if (samples_.falloff.empty()) return falloff;
    falloff.reserve(nodes.size());
    for (const RayNode& node : nodes)
      falloff.push_back(
          node.valid ? std::pow(std::max(node.direction_in_camera.normalized().z(), 0.0), options_.vignetting)
                     : 0);
    return falloff;
  }
  /// Linear between the corners.
  void note_falloff(const PixelBox& box, double a, double b, double c, double d) {
    for (int y = box.y; y < box.y_end; ++y)
      for (int x = box.x; x < box.x_end; ++x) {
        const double s = (x - box.x + 0.5) / kRayCell, t = (y - box.y + 0.5) / kRayCell;
        samples_.falloff.at(x, y) = float((1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d));
      }
  }

  void note_truth(int x, int y, const RayCell& cell, const Eyes& eyes, const Candidates& candidates,
                  const std::vector<std::vector<Candidates>>& in_light) {
    const Vec3 direction = centre_of(x, y, cell);
    const BodyHit hit = eyes.camera.nearest(direction, candidates);
    if (is_adaptive()) centre_at(x, y).waits = true;
    if (hit.body < 0) return;
    const Vec3 point = hit.s * direction;
    note_seen(x, y, hit.body, point, eyes);
    const Facing facing = facing_of(hit, eyes.camera.in_body(hit.body, direction));
    if (is_adaptive()) {
      const Pose& room_from_body = room_.room->bodies[std::size_t(hit.body)].room_from_body;
      centre_at(x, y) = {room_from_body.rotate(facing.normal).cast<float>(),
                         room_from_body.rotate(facing.smooth_normal).cast<float>(), hit.spot_in_body.facet,
                         facing.front, true};
    }
    for (std::size_t l = 0; l < lights_.size(); ++l)
      if (const auto light = room_lights_.arriving(l, eyes, hit, facing.smooth_normal, point, in_light[l]))
        note_truth_light(std::size_t(y) * std::size_t(camera_.size.width) + std::size_t(x), l, *light);
  }
  void note_seen(int x, int y, int body, const Vec3& point_in_camera, const Eyes& eyes) {
    RoomTruth& truth = samples_.truth;
    const Vec3 in_room = eyes.camera.room_from_eye() * point_in_camera;
    truth.body.at(x, y) = std::int16_t(body);
    truth.depth.at(x, y) = float(point_in_camera.z());
    for (int c = 0; c < 3; ++c) truth.point_in_room.at(x, y, c) = float(in_room[c]);
  }
  void note_truth_light(std::size_t pixel, std::size_t l, const Arriving& light) {
    if (is_adaptive()) reached_[l].data()[pixel] = 1;
    if (!lights_[l].projector.size().contains(light.projector_pixel)) return;
    ProjectorMap& map = samples_.truth.light[l];
    map.lit.data()[pixel] = 1;
    map.pixel.data()[2 * pixel] = float(light.projector_pixel.x());
    map.pixel.data()[2 * pixel + 1] = float(light.projector_pixel.y());
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
  if (tracer.is_adaptive())
    parallel_for(tracer.bands(), options.threads, [&](int begin, int end) {
      for (int band = begin; band < end; ++band) tracer.refine_band(band);
    });
  return tracer.take();
}

}  // namespace procam::simulate::internal
