#pragma once
/// What content asks of people: is a hand on the surface, where does it point, who is in the zone.
///
/// Points on a surface are metres in the surface's own plane (x right, y down as the content is read, z into
/// the wall): surface_from_sensor = surface_from_world * world_from_sensor. State, where there is one, is a
/// small value that gets the next event with its time: no clock is read.
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/ray.hpp"
#include "procam/people/people.hpp"

namespace procam::people {

struct SurfacePoint {
  Vec2 point = Vec2::Zero();  ///< the foot of the perpendicular
  double distance = 0;  ///< in front of the surface; negative: inside the wall, which noise makes happen
};
PROCAM_EXPORT SurfacePoint on_surface(const Vec3& point_in_sensor, const Pose& surface_from_sensor);

/// From the head through the hand: of the lines that can be had from joints the one that people mean (K.
/// Nickel, R. Stiefelhagen, "Visual recognition of pointing gestures for human-robot interaction", Image and
/// Vision Computing 25(12), 2007). nullopt without both, or when they are closer than 0.2 m: a hand at the
/// face points nowhere.
PROCAM_EXPORT std::optional<Ray> pointing_ray(const Skeleton& person, Side side);
/// Where a ray meets the surface's plane; nullopt when it leads away from it.
PROCAM_EXPORT std::optional<Vec2> hit_on_surface(const Ray& ray_in_sensor, const Pose& surface_from_sensor);

struct ZoneOptions {
  double margin = 0.03;    ///< hysteresis, metres: entered that far inside, left that far outside
  double dwell = 1.0;      ///< seconds inside until it counts as meant
  double patience = 0.25;  ///< seconds without a point until the zone is left
};
/// Enter, leave and dwell, each reported once.
class PROCAM_EXPORT Zone {
 public:
  enum class Event { kNone, kEntered, kDwelled, kLeft };
  explicit Zone(Points2 polygon, const ZoneOptions& options = {});

  /// Times do not go back. nullopt: nothing was seen.
  Event update(const std::optional<Vec2>& point, double time);
  bool is_inside() const { return entered_.has_value(); }
  /// Seconds since it was entered, as a share of the dwell, 0..1: what a ring around the hand shows.
  double progress(double time) const;

 private:
  Points2 polygon_;
  ZoneOptions options_;
  std::optional<double> entered_;
  double seen_ = 0;
  bool has_dwelled_ = false;
};

struct TouchOptions {
  double near = 0.06;  ///< metres from the surface at which a touch begins: a hand's joint is in its middle
  double far = 0.12;   ///< and at which it ends
};
class Touch {
 public:
  explicit Touch(const TouchOptions& options = {}) : options_(options) {}
  /// Whether the hand touches; nullopt (not seen) ends a touch.
  bool update(const std::optional<SurfacePoint>& hand) {
    is_touching_ = hand && hand->distance < (is_touching_ ? options_.far : options_.near);
    return is_touching_;
  }

 private:
  TouchOptions options_;
  bool is_touching_ = false;
};

/// A forbidden zone: the first joint of anybody whose foot is inside the polygon and that is nearer to the
/// surface than `height`, on either side. nullopt: nobody is there.
PROCAM_EXPORT std::optional<Vec2> trespass(const std::vector<TrackedPerson>& people,
                                           const Pose& surface_from_sensor, const Points2& polygon,
                                           double height);

}  // namespace procam::people
