#include "wall.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_fit.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/triangulate.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/session/reader.hpp"
#include "wall_geometry.hpp"

namespace procam::studio {
namespace {

struct PlaneFit {
  Plane plane;
  double rms = 0;
  std::size_t used = 0;
};

PlaneFit fit_plane(const Points3& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= double(points.size());
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(scatter);
  const Vec3 normal = solver.eigenvectors().col(0);
  return {{normal, -normal.dot(mean)},
          std::sqrt(std::max(0.0, solver.eigenvalues()[0]) / double(points.size())),
          points.size()};
}

/// Points off the plane (a cable, a wrong stripe) are rejected at four times the rms, until none is.
PlaneFit fit_plane_robustly(Points3 points) {
  constexpr int kRounds = 10;
  PlaneFit fit = fit_plane(points);
  for (int round = 0; round < kRounds; ++round) {
    const double limit = 4 * fit.rms;
    const auto end = std::remove_if(points.begin(), points.end(), [&](const Vec3& p) {
      return std::abs(fit.plane.signed_distance(p)) > limit;
    });
    if (end == points.end() || end - points.begin() < 10) break;
    points.erase(end, points.end());
    fit = fit_plane(points);
  }
  return fit;
}

/// Its z points away from the camera.
Plane away_from(const Vec3& eye, Plane plane) {
  if (plane.signed_distance(eye) > 0) return {-plane.normal, -plane.offset};
  return plane;
}

Error no_clicked_surface(const Surface& surface) {
  return Error(ErrorKind::kInput, "surface '" + surface.name + "'",
               "it is neither a plane nor a round wall with four corners in the rig's frame",
               "change its file, or remove it here and click it again");
}

std::array<Vec3, kCorners> required_corners(const Surface& surface) {
  if (const auto corners = corners_in_rig(surface)) return *corners;
  throw no_clicked_surface(surface);
}

ContentToRig points_of(const Surface& surface) {
  if (auto point = content_to_rig(surface)) return std::move(*point);
  throw no_clicked_surface(surface);
}

/// The cylinder that a round surface was made from: its points lie on it exactly.
RoundWall wall_below(const Surface& surface, const GridSurface& shape) {
  Points3 points;
  for (const Vec3& p : shape.points) points.push_back(shape.frame_from_surface * p);
  constexpr double kExact = 1e-5;  // metres: rounded numbers of a file
  const auto wall = fit_round_wall(points, std::nullopt);
  if (!wall || !(wall->rms < kExact) || wall->points < points.size()) throw no_clicked_surface(surface);
  return *wall;
}

Points3 points_inside(const std::vector<ScanPoint>& scan, const CameraCorners& corners,
                      const std::string& name) {
  require_convex(corners);
  Points3 inside;
  for (const ScanPoint& point : scan)
    if (is_inside(corners, point.camera_pixel)) inside.push_back(point.in_rig);
  constexpr std::size_t kFewest = 50;
  if (inside.size() < kFewest)
    throw Error(
        ErrorKind::kNotEnoughData, "surface '" + name + "'",
        "the projector lights only " + std::to_string(inside.size()) + " measured points inside its corners",
        "click corners within the light, or move the projector and measure again");
  return inside;
}

using PixelOf = std::function<std::optional<Vec2>(const Vec3&)>;

PixelOf camera_of(const Rig& rig) {
  return [&rig](const Vec3& point) { return camera_pixel(rig, point); };
}
PixelOf projector_of(const Rig& rig, const std::string& name) {
  return [&rig, name](const Vec3& point) { return projector_pixel(rig, point, name); };
}

std::vector<Vec2> seen_corners(const Surface& surface, const PixelOf& pixel_of) {
  std::vector<Vec2> seen;
  if (const auto corners = corners_in_rig(surface))
    for (const Vec3& corner : *corners)
      if (const auto pixel = pixel_of(corner)) seen.push_back(*pixel);
  return seen;
}

std::vector<Vec2> seen_outline(const Surface& surface, const PixelOf& pixel_of) {
  std::vector<Vec2> seen;
  const auto point = content_to_rig(surface);
  if (!point) return seen;
  constexpr int kAlongASide = 16;
  const auto& at = content_corners();
  for (std::size_t side = 0; side < 4; ++side)
    for (int i = 0; i < kAlongASide; ++i)
      if (const auto pixel =
              pixel_of((*point)(at[side] + i / double(kAlongASide) * (at[(side + 1) % 4] - at[side]))))
        seen.push_back(*pixel);
  return seen;
}

/// The corner moved along its wall to where the ray meets it.
Surface slide(const Surface& surface, const Rig& rig, int corner, const std::optional<Ray>& ray) {
  std::array<Vec3, 4> corners = required_corners(surface);
  const auto* grid = std::get_if<GridSurface>(&surface.geometry);
  std::optional<RoundWall> wall;
  if (grid != nullptr) wall = wall_below(surface, *grid);
  std::optional<Vec3> met;
  if (ray && wall) met = intersect(*ray, *wall, 0.5 * (corners[0] + corners[2]));
  if (ray && !wall)
    met = intersect(*ray, Plane::of_xy(std::get<PlanarSurface>(surface.geometry).frame_from_surface));
  if (!met || corner < 0 || corner > 3)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "the corner's ray does not meet its wall", "drop the corner on the wall");
  corners[std::size_t(corner)] = *met;
  Surface moved = surface;
  if (wall) {
    moved.geometry = round_shape(corners, *wall, rig.camera().rig_from_camera.translation);
  } else {
    auto& shape = std::get<PlanarSurface>(moved.geometry);
    shape.points[std::size_t(corner)] = Vec3(shape.frame_from_surface.inverse() * *met).head<2>();
  }
  CameraCorners seen_now;
  const std::vector<Vec2> seen = seen_corners(moved, camera_of(rig));
  if (seen.size() == 4) {
    std::copy(seen.begin(), seen.end(), seen_now.begin());
    require_convex(seen_now);
  }
  return moved;
}

}  // namespace

static bool is_in_frame(const Vec2& pixel, ImageSize size) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() <= size.width - 0.5 &&
         pixel.y() <= size.height - 0.5;
}

/// By the frames of one projector.
static void add_scan(const std::filesystem::path& view, const RigProjector& projector, const Rig& rig,
                     int step, std::vector<ScanPoint>& scan) {
  const pattern::GrayCode code{projector.projector.size()};
  const io::CaptureFolder captured = io::load_capture_folder(view, pattern::frame_count(code));
  std::vector<ViewU8> views(captured.frames.begin(), captured.frames.end());
  const DecodedMap map = pattern::decode(views, code);
  if (!(map.camera_size() == rig.camera().camera.size))
    throw Error(ErrorKind::kInput, view.string(),
                "its images have " + counts(map.camera_size()) + " pixels and the rig's camera " +
                    counts(rig.camera().camera.size),
                "measure the wall again");
  constexpr double kContrast = 12;
  for (int y = 0; y < map.camera_size().height; y += step)
    for (int x = 0; x < map.camera_size().width; x += step) {
      if (!map.decoded(x, y) || map.contrast.at(x, y) < kContrast) continue;
      const Vec2 pixel(x, y);
      const auto seen = camera_ray(rig, pixel),
                 lit = projector_ray(rig, *map.projector_pixel(x, y), projector.name);
      if (!seen || !lit) continue;
      if (const auto met = triangulate({*seen, *lit})) scan.push_back({pixel, met->point});
    }
}

std::vector<ScanPoint> read_scan(const std::filesystem::path& folder, const Rig& rig, int step) {
  std::vector<ScanPoint> scan;
  for (const RigProjector& projector : rig.projectors)
    add_scan(folder / "view_00" / (rig.projectors.size() > 1 ? projector.name : ""), projector, rig, step,
             scan);
  if (scan.empty())
    throw Error(ErrorKind::kNotEnoughData, "the wall's measurement", "the camera saw none of the stripes",
                "point camera and projector at the same part of the wall, and measure again");
  return scan;
}

FittedSurface surface_on(const Plane& known, const Rig& rig, const CameraCorners& corners,
                         const std::string& name) {
  require_convex(corners);
  const Plane plane = away_from(rig.camera().rig_from_camera.translation, known);
  FittedSurface fitted;
  fitted.surface.name = name;
  fitted.surface.geometry = flat_shape(
      corners_on([&](const Ray& ray) { return intersect(ray, plane); }, rig, corners, name), plane);
  return fitted;
}

FittedSurface fit_surface(const std::vector<ScanPoint>& scan, const Rig& rig, const CameraCorners& corners,
                          const std::string& name) {
  const Points3 inside = points_inside(scan, corners, name);
  const PlaneFit fit = fit_plane_robustly(inside);
  FittedSurface fitted = surface_on(fit.plane, rig, corners, name);
  fitted.rms = fit.rms;
  fitted.points = fit.used;
  // As a round wall it would be closer to the points by more than chance.
  constexpr double kCloser = 0.7;
  const auto round = fit_round_wall(inside, std::nullopt);
  fitted.looks_round = round && round->rms < kCloser * fit.rms && round->points > inside.size() / 2;
  return fitted;
}

FittedSurface fit_round_surface(const std::vector<ScanPoint>& scan, const Rig& rig,
                                const CameraCorners& corners, const std::string& name,
                                const std::optional<double>& radius) {
  const Points3 inside = points_inside(scan, corners, name);
  const auto wall = fit_round_wall(inside, radius);
  if (!wall)
    throw Error(ErrorKind::kInput, "surface '" + name + "'", "the measured points show no curvature",
                "choose the shape 'flat', or corners that are farther apart");
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : inside) mean += p / double(inside.size());
  FittedSurface fitted;
  fitted.surface.name = name;
  fitted.surface.geometry =
      round_shape(corners_on([&](const Ray& ray) { return intersect(ray, *wall, mean); }, rig, corners, name),
                  *wall, rig.camera().rig_from_camera.translation);
  fitted.rms = wall->rms;
  fitted.points = wall->points;
  fitted.radius = wall->radius;
  return fitted;
}

Surface move_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& camera_pixel_at) {
  return slide(surface, rig, corner,
               camera_pixel_at.allFinite() ? camera_ray(rig, camera_pixel_at) : std::nullopt);
}

Surface move_lit_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& projector_pixel_at,
                        const std::string& projector) {
  return slide(
      surface, rig, corner,
      projector_pixel_at.allFinite() ? projector_ray(rig, projector_pixel_at, projector) : std::nullopt);
}

std::vector<Vec2> corners_in_camera(const Surface& surface, const Rig& rig) {
  return seen_corners(surface, camera_of(rig));
}
std::vector<Vec2> corners_in_frame(const Surface& surface, const Rig& rig, const std::string& projector) {
  return seen_corners(surface, projector_of(rig, projector));
}
std::vector<Vec2> outline_in_camera(const Surface& surface, const Rig& rig) {
  return seen_outline(surface, camera_of(rig));
}
std::vector<Vec2> outline_in_frame(const Surface& surface, const Rig& rig, const std::string& projector) {
  return seen_outline(surface, projector_of(rig, projector));
}

Vec2 content_at(const Surface& surface, const Rig& rig, const Vec2& camera_pixel_at) {
  const ContentToRig point = points_of(surface);
  const auto seen = [&](const Vec2& uv) { return camera_pixel(rig, point(uv)); };
  // Gauss-Newton in the unit square: the map is smooth and one to one.
  Vec2 uv(0.5, 0.5);
  constexpr int kIterations = 50;
  constexpr double kStep = 1e-4, kClose = 1e-9;
  for (int i = 0; i < kIterations; ++i) {
    const auto here = seen(uv);
    Mat2 slope;
    for (int k = 0; k < 2; ++k) {
      const double step = uv[k] < 0.5 ? kStep : -kStep;
      const auto there = seen(uv + step * Vec2::Unit(k));
      if (!here || !there || !camera_pixel_at.allFinite())
        throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", "the camera does not see all of it",
                    "click in the camera's image, inside the surface");
      slope.col(k) = (*there - *here) / step;
    }
    const Vec2 next =
        (uv + slope.colPivHouseholderQr().solve(camera_pixel_at - *here)).cwiseMax(0).cwiseMin(1);
    const double moved = (next - uv).norm();
    uv = next;
    if (!(moved > kClose)) break;
  }
  return uv;
}

Pose tangent_at(const Surface& surface, const Rig& rig, const Vec2& camera_pixel_at) {
  const ContentToRig point = points_of(surface);
  const Vec2 uv = content_at(surface, rig, camera_pixel_at);
  // Over as much as a chord of a round wall's grid spans.
  constexpr double kStep = 0.01;
  std::array<Vec3, 2> along;
  for (int k = 0; k < 2; ++k) {
    const Vec2 step = kStep * Vec2::Unit(k);
    along[std::size_t(k)] = point((uv + step).cwiseMin(1)) - point((uv - step).cwiseMax(0));
  }
  const Vec3 at = point(uv), eye = rig.camera().rig_from_camera.translation;
  Vec3 normal = along[0].cross(along[1]).normalized();
  if (normal.dot(at - eye) < 0) normal = -normal;
  const Pose& base = place_of(surface.geometry)->frame_from_surface;
  const Eigen::Quaterniond turned = rotation_between(base.rotate(Vec3::UnitZ()), normal) * base.rotation;
  const Vec3 in_base = base.inverse() * at;
  return Pose(turned, at - turned * Vec3(in_base.x(), in_base.y(), 0));
}

std::vector<std::vector<Vec2>> masks_in_camera(const Surface& surface, const Rig& rig) {
  std::vector<std::vector<Vec2>> masks;
  const auto point = content_to_rig(surface);
  if (!point) return masks;
  for (const Points2& hole : surface.shape.holes) {
    std::vector<Vec2>& mask = masks.emplace_back();
    for (const Vec2& corner : hole)
      if (const auto pixel = camera_pixel(rig, (*point)(corner))) mask.push_back(*pixel);
  }
  return masks;
}

Vec2 side_lengths(const Surface& surface) {
  const auto point = content_to_rig(surface);
  if (!point) return Vec2::Zero();
  constexpr int kChords = 64;
  Vec2 lengths = Vec2::Zero();
  for (int axis = 0; axis < 2; ++axis)
    for (int i = 0; i < kChords; ++i)
      lengths[axis] += ((*point)((i + 1) / double(kChords) * Vec2::Unit(axis)) -
                        (*point)(i / double(kChords) * Vec2::Unit(axis)))
                           .norm();
  return lengths;
}

TrueLanding true_landing(const Surface& surface, const Rig& estimated, const Rig& truth,
                         const OnWall& on_wall) {
  const ContentToRig content_to_rig = points_of(surface);
  TrueLanding landing;
  double squares = 0;
  constexpr int kGrid = 9;
  for (const RigProjector& projector : estimated.projectors)
    for (int j = 0; j < kGrid; ++j)
      for (int i = 0; i < kGrid; ++i) {
        const Vec3 point = content_to_rig(Vec2(i, j) / (kGrid - 1.0));
        const auto seen = camera_pixel(estimated, point),
                   lit = projector_pixel(estimated, point, projector.name);
        if (!lit || !is_in_frame(*lit, projector.projector.size())) continue;
        const auto wanted = seen ? camera_ray(truth, *seen) : std::nullopt;
        const auto light = projector_ray(truth, *lit, projector.name);
        if (!wanted || !light) continue;
        const auto wanted_at = on_wall(*wanted), light_at = on_wall(*light);
        if (!wanted_at || !light_at) continue;
        const double mm = 1e3 * (*wanted_at - *light_at).norm();
        squares += mm * mm;
        landing.worst_mm = std::max(landing.worst_mm, mm);
        ++landing.points;
      }
  if (landing.points > 0) landing.rms_mm = std::sqrt(squares / landing.points);
  return landing;
}

}  // namespace procam::studio
