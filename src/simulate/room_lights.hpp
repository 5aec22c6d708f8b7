#pragma once
/// The lights before a room: what arrives of them at a point, and at all points that a cell of rays sees of a flat body.
#include <array>
#include <limits>

#include "caster.hpp"
#include "procam/simulate/room_view.hpp"
#include "ray_grid.hpp"
#include "sampling.hpp"

namespace procam::simulate::internal {

/// One light before the room, at one moment.
struct LightEye {
  Caster caster;
  Pose light_from_camera;
  Mat3 light_rotation;  ///< of that pose
};

/// Camera and lights at the moment of one row.
struct Eyes {
  Caster camera;
  std::vector<LightEye> lights;
};

/// The projector pixel that lights a point, with how much at full light, and its depth before the projector.
struct Arriving {
  Vec2 projector_pixel;
  double irradiance, depth;
};

/// Points that one flat body shows to a cell's rays.
struct FlatPoints {
  static constexpr std::size_t kMax = kRayCell * kRayCell * kMaxPerAxis * kMaxPerAxis;
  struct Point {
    Vec3 in_camera;
    std::size_t ray;  ///< number of the ray, or of the pixel for its centre
    double level;
  };
  int body;
  Vec3 normal;  ///< of the body, against the rays
  std::size_t count = 0;
  std::array<Point, kMax> points;
};

/// How one light falls on a flat body within a cell.
struct FlatLight {
  Share hidden;       ///< all: dark
  bool one_by_one;    ///< every point has to be asked by itself: a border of the light is near
  double height = 0;  ///< of the light above the body's plane
  const Candidates* shade = nullptr;
};

class RoomLights {
 public:
  /// `reach`: how far light reaches beyond each projector's picture by its blur, projector pixels. Keeps `lights`.
  RoomLights(const std::vector<RoomLight>& lights, const std::vector<double>& reach) : lights_(lights) {
    constexpr int kTile = 32;  // projector pixels
    for (std::size_t l = 0; l < lights.size(); ++l) {
      const Vec2 beyond = Vec2::Constant(reach[l] + 0.5);
      const ImageSize size = lights[l].projector.size();
      tiles_.emplace_back(lights[l].projector.inverse_camera, -beyond,
                          Vec2(size.width - 1, size.height - 1) + beyond, kTile);
    }
  }

  /// By light and tile: what may stand in its way.
  std::vector<std::vector<Candidates>> candidates(const PreparedRoom& room, const Eyes& eyes,
                                                  const std::vector<Slack>& slack) const {
    std::vector<std::vector<Candidates>> found;
    for (std::size_t l = 0; l < lights_.size(); ++l)
      found.push_back(
          tiles_[l].candidates(room, eyes.lights[l].caster.room_from_eye(), 0, tiles_[l].rows(), slack[l]));
    return found;
  }

  /// What arrives of light l at a point, on the side of `normal`.
  std::optional<Arriving> arriving(std::size_t l, const Eyes& eyes, const BodyHit& hit, const Vec3& normal,
                                   const Vec3& point_in_camera,
                                   const std::vector<Candidates>& in_light) const {
    const LightEye& eye = eyes.lights[l];
    const Vec3 to_light = eye.caster.eye_in_body(hit.body) - hit.spot_in_body.point;
    const double closing = normal.dot(to_light);
    if (!(closing > 0)) return std::nullopt;
    const Vec3 point_in_light = eye.light_from_camera * point_in_camera;
    const std::optional<Vec2> pixel = lights_[l].projector.project(point_in_light);
    if (!pixel || !tiles_[l].contains(*pixel)) return std::nullopt;
    if (eye.caster.is_hidden(point_in_light, hit.body, in_light[std::size_t(tiles_[l].at(*pixel))]))
      return std::nullopt;
    const double distance2 = to_light.squaredNorm();
    return Arriving{*pixel, lights_[l].intensity * closing / (distance2 * std::sqrt(distance2)),
                    point_in_light.z()};
  }

  FlatLight flat_light(std::size_t l, const Eyes& eyes, int body, const Vec3& normal, const CellRays& corners,
                       const std::vector<Candidates>& in_light) const {
    const LightEye& eye = eyes.lights[l];
    const double height = normal.dot(eye.caster.eye_in_body(body));
    if (!(height > 0)) return {Share::kAll, false};
    const TileIndex& tiles = tiles_[l];
    CellRays in_this_light;
    int beyond_lens = 0;
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3 point = eyes.camera.lengths_to_plane(body, corners[k]) * corners[k];
      in_this_light[k] = eye.light_rotation * point + eye.light_from_camera.translation;
      const std::optional<Vec2> pixel = lights_[l].projector.project(in_this_light[k]);
      beyond_lens += !pixel;
      if (!pixel) continue;
      low = low.cwiseMin(*pixel);
      high = high.cwiseMax(*pixel);
    }
    if (beyond_lens == 4 || tiles.is_beside(low, high)) return {Share::kAll, false};
    if (beyond_lens > 0 || !tiles.contains(low) || !tiles.contains(high) || tiles.at(low) != tiles.at(high))
      return {Share::kSome, true};
    const Candidates& shade = in_light[std::size_t(tiles.at(low))];
    return {eye.caster.hidden(in_this_light, body, shade), false, height, &shade};
  }

  /// use(point, what arrives there) for the points that the light reaches.
  template <typename Use>
  void each_lit(std::size_t l, const FlatLight& light, const Eyes& eyes, const FlatPoints& seen,
                const std::vector<Candidates>& in_light, const Use& use) const {
    const int body = seen.body;
    const Camera& lens = lights_[l].projector.inverse_camera;
    const LightEye& eye = eyes.lights[l];
    const double strength = lights_[l].intensity * light.height;
    std::visit(
        [&](const auto& model) {
          using Model = std::decay_t<decltype(model)>;
          for (std::size_t i = 0; i < seen.count; ++i) {
            const Vec3& point = seen.points[i].in_camera;
            if constexpr (procam::internal::HasFormula<Model>::value) {
              if (!light.one_by_one) {
                const Vec3 p = eye.light_rotation * point + eye.light_from_camera.translation;
                if (light.hidden == Share::kSome && eye.caster.is_hidden(p, body, *light.shade)) continue;
                const double nearness = 1 / p.z(), distance2 = p.squaredNorm();
                Vec2 distorted;
                Model::formula(model.coefficients.data(), p.x() * nearness, p.y() * nearness, distorted.x(),
                               distorted.y());
                use(seen.points[i], Arriving{lens.intrinsics.pixel_from_normalized(distorted),
                                             strength / (distance2 * std::sqrt(distance2)), p.z()});
                continue;
              }
            }
            const BodyHit hit{body, 1, {eyes.camera.eye_in_body(body) + eyes.camera.in_body(body, point)}};
            if (const auto one = arriving(l, eyes, hit, seen.normal, point, in_light))
              use(seen.points[i], *one);
          }
        },
        lens.distortion);
  }

 private:
  const std::vector<RoomLight>& lights_;
  std::vector<TileIndex> tiles_;
};

}  // namespace procam::simulate::internal
