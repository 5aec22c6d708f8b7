#include "wall.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_fit.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/triangulate.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/session/reader.hpp"

namespace procam::studio {
namespace {

std::optional<Ray> camera_ray(const Rig& rig, const Vec2& pixel) {
  const RigCamera& camera = rig.camera();
  const std::optional<Vec3> direction = camera.camera.unproject(pixel);
  if (!direction) return std::nullopt;
  return camera.rig_from_camera * Ray{Vec3::Zero(), *direction};
}

std::optional<Ray> projector_ray(const Rig& rig, const Vec2& pixel) {
  const RigProjector& projector = rig.projector();
  const std::optional<Ray> ray = projector.projector.emit(pixel);
  if (!ray) return std::nullopt;
  return projector.rig_from_projector * *ray;
}

std::optional<Vec2> camera_pixel(const Rig& rig, const Vec3& point_in_rig) {
  return rig.camera().camera.project(rig.camera().rig_from_camera.inverse() * point_in_rig);
}

/// Twice the signed area of a, b, c: positive where they run clockwise in the image.
double sense(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

void require_convex(const CameraCorners& corners) {
  for (std::size_t i = 0; i < 4; ++i) {
    constexpr double kSmallest = 50;  // pixels^2
    const Vec2 &a = corners[i], &b = corners[(i + 1) % 4], &c = corners[(i + 2) % 4];
    if (!(a.allFinite() && sense(a, b, c) > kSmallest))
      throw Error(ErrorKind::kInput, "corners of a surface",
                  "they are no quadrilateral in the order top left, top right, bottom right, bottom left",
                  "click the four corners again, clockwise from the content's top left");
  }
}

bool is_inside(const CameraCorners& corners, const Vec2& pixel) {
  for (std::size_t i = 0; i < 4; ++i)
    if (sense(corners[i], corners[(i + 1) % 4], pixel) <= 0) return false;
  return true;
}

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

Plane plane_of(const Surface& surface) {
  return Plane::of_xy(std::get<PlanarSurface>(surface.geometry).frame_from_surface);
}

const PlanarSurface& planar(const Surface& surface) {
  const auto* plane = std::get_if<PlanarSurface>(&surface.geometry);
  if (plane == nullptr || plane->frame != "rig" || plane->points.size() != 4)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "it is no plane with four corners in the rig's frame",
                "change its file, or remove it here and click it again");
  return *plane;
}

}  // namespace

std::vector<ScanPoint> read_scan(const std::filesystem::path& folder, const Rig& rig, int step) {
  const ImageSize size = rig.projector().projector.size();
  const pattern::GrayCode code{size};
  const io::CaptureFolder captured = io::load_capture_folder(folder / "view_00", pattern::frame_count(code));
  std::vector<ViewU8> views(captured.frames.begin(), captured.frames.end());
  const DecodedMap map = pattern::decode(views, code);
  if (!(map.camera_size() == rig.camera().camera.size))
    throw Error(ErrorKind::kInput, folder.string(),
                "its images have " + counts(map.camera_size()) + " pixels and the rig's camera " +
                    counts(rig.camera().camera.size),
                "measure the wall again");
  std::vector<ScanPoint> scan;
  constexpr double kContrast = 12;
  for (int y = 0; y < map.camera_size().height; y += step)
    for (int x = 0; x < map.camera_size().width; x += step) {
      if (!map.decoded(x, y) || map.contrast.at(x, y) < kContrast) continue;
      const Vec2 pixel(x, y);
      const auto seen = camera_ray(rig, pixel), lit = projector_ray(rig, *map.projector_pixel(x, y));
      if (!seen || !lit) continue;
      if (const auto met = triangulate({*seen, *lit})) scan.push_back({pixel, met->point});
    }
  if (scan.empty())
    throw Error(ErrorKind::kNotEnoughData, "the wall's measurement", "the camera saw none of the stripes",
                "point camera and projector at the same part of the wall, and measure again");
  return scan;
}

FittedSurface fit_surface(const std::vector<ScanPoint>& scan, const Rig& rig, const CameraCorners& corners,
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
  const PlaneFit fit = fit_plane_robustly(std::move(inside));
  const Plane plane = away_from(rig.camera().rig_from_camera.translation, fit.plane);

  std::array<Vec3, 4> on_plane;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto ray = camera_ray(rig, corners[i]);
    const auto met = ray ? intersect(*ray, plane) : std::nullopt;
    if (!met)
      throw Error(ErrorKind::kInput, "surface '" + name + "'", "a corner's ray does not meet the wall",
                  "click corners on the wall");
    on_plane[i] = *met;
  }
  const Vec3 x = (on_plane[1] - on_plane[0]).normalized();
  Mat3 axes;
  axes << x, plane.normal.cross(x), plane.normal;
  PlanarSurface shape;
  shape.frame = "rig";
  shape.frame_from_surface = Pose(axes, on_plane[0]);
  shape.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec3& corner : on_plane)
    shape.points.push_back(Vec3(shape.frame_from_surface.inverse() * corner).head<2>());
  FittedSurface fitted;
  fitted.surface.name = name;
  fitted.surface.geometry = shape;
  fitted.rms = fit.rms;
  fitted.points = fit.used;
  return fitted;
}

Surface move_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& camera_pixel_at) {
  PlanarSurface shape = planar(surface);
  const auto ray = camera_pixel_at.allFinite() ? camera_ray(rig, camera_pixel_at) : std::nullopt;
  const auto met = ray ? intersect(*ray, plane_of(surface)) : std::nullopt;
  if (!met || corner < 0 || corner > 3)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'",
                "the corner's ray does not meet its plane", "drop the corner on the wall");
  shape.points[std::size_t(corner)] = Vec3(shape.frame_from_surface.inverse() * *met).head<2>();
  Surface moved = surface;
  moved.geometry = shape;
  CameraCorners corners;
  const std::vector<Vec2> seen = corners_in_camera(moved, rig);
  if (seen.size() == 4) {
    std::copy(seen.begin(), seen.end(), corners.begin());
    require_convex(corners);
  }
  return moved;
}

std::vector<Vec2> corners_in_camera(const Surface& surface, const Rig& rig) {
  std::vector<Vec2> seen;
  const auto* shape = std::get_if<PlanarSurface>(&surface.geometry);
  if (shape == nullptr || shape->frame != "rig") return seen;
  for (const Vec2& point : shape->points)
    if (const auto pixel = camera_pixel(rig, shape->frame_from_surface * Vec3(point.x(), point.y(), 0)))
      seen.push_back(*pixel);
  return seen;
}

Vec2 side_lengths(const Surface& surface) {
  const auto* shape = std::get_if<PlanarSurface>(&surface.geometry);
  if (shape == nullptr || shape->points.size() != 4) return Vec2::Zero();
  return {(shape->points[1] - shape->points[0]).norm(), (shape->points[3] - shape->points[0]).norm()};
}

TrueLanding true_landing(const Surface& surface, const Rig& estimated, const Rig& truth,
                         const OnWall& on_wall) {
  const PlanarSurface& shape = planar(surface);
  const Mat3 plane_from_content =
      fit_homography(shape.content, shape.points).destination_from_source.matrix();
  const Pose projector_from_rig = estimated.projector().rig_from_projector.inverse();
  TrueLanding landing;
  double squares = 0;
  constexpr int kGrid = 9;
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i) {
      const Vec3 on_plane = plane_from_content * Vec3(i / (kGrid - 1.0), j / (kGrid - 1.0), 1);
      const Vec3 point =
          shape.frame_from_surface * Vec3(on_plane.x() / on_plane.z(), on_plane.y() / on_plane.z(), 0);
      const auto seen = camera_pixel(estimated, point);
      const auto lit = estimated.projector().projector.project(projector_from_rig * point);
      const auto wanted = seen ? camera_ray(truth, *seen) : std::nullopt;
      const auto light = lit ? projector_ray(truth, *lit) : std::nullopt;
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
