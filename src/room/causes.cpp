/// Why a room gives no rig.
#include "epipolar.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_robust.hpp"
#include "start.hpp"

namespace procam::room {
namespace {

/// Median distance of a map's light from a homography of the camera's rays, projector pixels; large where none fits.
/// The projector's distortion is part of it.
double off_homography(const RoomPoints& points, const LensPlan& plan, int map) {
  Points2 rays, pixels;
  const Camera& lens =
      plan.lenses[std::size_t(points.positions[std::size_t(points.maps[std::size_t(map)].position)].camera)];
  for (const RoomPoint& point : points.points) {
    if (point.readings[0].map != map) continue;
    const std::optional<Vec3> bearing = lens.unproject(point.readings[0].camera_pixel);
    if (!bearing || !(bearing->z() > 1e-6)) continue;
    rays.push_back(bearing->head<2>() / bearing->z());
    pixels.push_back(point.readings[0].projector_pixel);
  }
  if (rays.size() < 16) return 1e6;
  try {
    RobustHomographyOptions options;
    options.sigma = 2;
    options.max_samples = 300;
    const HomographyFit fit = fit_homography_robust(rays, pixels, options);
    std::vector<double> off;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::optional<Vec2> at = fit.destination_from_source.apply(rays[i]);
      off.push_back(at ? (*at - pixels[i]).norm() : 1e6);
    }
    return quantile(off, 0.8);
  } catch (const Error&) {
    return 1e6;
  }
}

/// Do all camera positions differ from the first by a rotation alone?
bool only_rotated(const RoomPoints& points, const LensPlan& plan) {
  if (points.positions.size() < 2) return false;
  bool any = false;
  for (int b = 1; b < int(points.positions.size()); ++b) {
    std::vector<ImagePair> rays;
    for (const RoomPoint& point : points.points) {
      const int from = points.maps[std::size_t(point.readings[0].map)].position;
      for (std::size_t r = 1; r < point.readings.size(); ++r) {
        const int to = points.maps[std::size_t(point.readings[r].map)].position;
        if (to == from || (from != 0 && to != 0) || (from != b && to != b)) continue;
        const auto lens = [&](int p) {
          return plan.lenses[std::size_t(points.positions[std::size_t(p)].camera)];
        };
        const auto x = lens(from).unproject(point.readings[0].camera_pixel),
                   y = lens(to).unproject(point.readings[r].camera_pixel);
        if (!x || !y || !(x->z() > 1e-6) || !(y->z() > 1e-6)) continue;
        const Vec2 first = x->head<2>() / x->z(), second = y->head<2>() / y->z();
        rays.push_back(from == 0 ? ImagePair{first, second} : ImagePair{second, first});
      }
    }
    if (rays.size() < 16) continue;
    if (rotation_error(rays) > 6e-4) return false;
    any = true;
  }
  return any;
}

}  // namespace

void refuse_if_turned_only(const RoomPoints& points, const LensPlan& plan, const std::string& seen) {
  if (only_rotated(points, plan))
    throw Error(ErrorKind::kDegenerate, "the room's light",
                "the camera was only turned between the views, not moved: " + seen,
                "move it sideways between the views by a tenth of the room's distance or more");
}

void refuse_room(const RoomPoints& points, const LensPlan& plan, const std::string& seen, double parallax) {
  constexpr double kSmallParallax = 1.5 * kDegree, kFlatPx = 4;
  const std::string what = "the room's light";
  refuse_if_turned_only(points, plan, seen);
  bool flat = true;
  for (int map = 0; map < int(points.maps.size()); ++map) flat &= off_homography(points, plan, map) < kFlatPx;
  if (parallax >= 0 && parallax < kSmallParallax)
    throw Error(ErrorKind::kDegenerate, what,
                format("the devices stand too close together, a point's rays meet at %.2g degrees: ",
                       parallax / kDegree) +
                    seen,
                "put the camera farther from the projector, by a tenth of the room's distance or more");
  if (flat)
    throw Error(
        ErrorKind::kDegenerate, what,
        "all of it lies on one plane, or camera and projector stand in one place: " + seen,
        points.positions.size() < 2
            ? "let the picture fall into a corner or on boxes before the wall, and capture from two camera positions"
            : "let the picture fall into a corner or on boxes before the wall, or give the projector's lens shift and "
              "throw ratio from its data sheet");
  if (points.positions.size() < 2)
    throw Error(
        ErrorKind::kDegenerate, what,
        "one camera position determines two of the three numbers of the projector's lens (focal length, principal "
        "point): " +
            seen,
        "capture a second view from another place of the camera, or give the lens shift or the throw ratio from the "
        "projector's data sheet");
  throw Error(
      ErrorKind::kDegenerate, what, seen,
      plan.cameras_known
          ? "capture one more view from another place of the camera, where the room has more depth"
          : "give the camera's lens (a calibrate-camera result), or one more view from another place");
}

}  // namespace procam::room
