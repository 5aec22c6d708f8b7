#include "wall.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_fit.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/triangulate.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/session/reader.hpp"
#include "round_wall.hpp"

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

std::optional<Vec2> projector_pixel(const Rig& rig, const Vec3& point_in_rig) {
  return rig.projector().projector.project(rig.projector().rig_from_projector.inverse() * point_in_rig);
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

constexpr std::size_t kCorners = 4;
const std::array<Vec2, kCorners>& content_corners() {
  static const std::array<Vec2, kCorners> corners = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  return corners;
}

/// Content coordinates to points in the rig's frame.
using ContentToRig = std::function<Vec3(const Vec2&)>;

/// None for meshes, for surfaces of pixels, and in other frames.
std::optional<ContentToRig> content_to_rig(const Surface& surface) {
  const InRoom* place = place_of(surface.geometry);
  if (place == nullptr || place->frame != "rig") return std::nullopt;
  return std::visit(
      [](const auto& shape) -> std::optional<ContentToRig> {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, PlanarSurface>) {
          const Mat3 plane_from_content =
              fit_homography(shape.content, shape.points).destination_from_source.matrix();
          return [shape, plane_from_content](const Vec2& uv) -> Vec3 {
            const Vec3 on_plane = plane_from_content * uv.homogeneous();
            return shape.frame_from_surface *
                   Vec3(on_plane.x() / on_plane.z(), on_plane.y() / on_plane.z(), 0);
          };
        } else if constexpr (std::is_same_v<Shape, PixelSurface> || std::is_same_v<Shape, MeshSurface>) {
          return std::nullopt;
        } else {
          if (shape.fault() != nullptr) return std::nullopt;
          return [shape](const Vec2& uv) -> Vec3 { return shape.frame_from_surface * shape.point(uv); };
        }
      },
      surface.geometry);
}

/// The corners of a surface in the rig's frame, in the order of content_corners(), where they can be dragged: of a plane by
/// its four corners, and of a grid. None for other kinds and frames.
std::optional<std::array<Vec3, kCorners>> corners_in_rig(const Surface& surface) {
  if (const auto* plane = std::get_if<PlanarSurface>(&surface.geometry)) {
    const bool by_corners = std::equal(plane->content.begin(), plane->content.end(),
                                       content_corners().begin(), content_corners().end());
    if (!by_corners || plane->points.size() != kCorners) return std::nullopt;
  } else if (!std::holds_alternative<GridSurface>(surface.geometry)) {
    return std::nullopt;
  }
  const auto point = content_to_rig(surface);
  if (!point) return std::nullopt;
  std::array<Vec3, kCorners> corners;
  for (std::size_t i = 0; i < kCorners; ++i) corners[i] = (*point)(content_corners()[i]);
  return corners;
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

/// x along the upper side, z away from the camera.
Pose content_frame(const Vec3& top_left, const Vec3& top_right, const Vec3& normal) {
  const Vec3 x = (top_right - top_left).normalized();
  const Vec3 z = (normal - normal.dot(x) * x).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return Pose(axes, top_left);
}

PlanarSurface flat_shape(const std::array<Vec3, 4>& corners, const Plane& plane) {
  PlanarSurface shape;
  shape.frame = "rig";
  shape.frame_from_surface = content_frame(corners[0], corners[1], plane.normal);
  shape.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec3& corner : corners)
    shape.points.push_back(Vec3(shape.frame_from_surface.inverse() * corner).head<2>());
  return shape;
}

/// Content is laid on the unrolled wall by the homography of its corners.
GridSurface round_shape(const std::array<Vec3, 4>& corners, const RoundWall& wall, const Vec3& eye) {
  const Vec3 mean = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  const Vec3 ahead = wall.across(mean).normalized(), sideways = wall.axis.cross(ahead);
  Points2 unrolled;  // arc length, height
  for (const Vec3& corner : corners) {
    const Vec3 out = wall.across(corner);
    unrolled.emplace_back(wall.radius * std::atan2(out.dot(sideways), out.dot(ahead)),
                          (corner - wall.middle).dot(wall.axis));
  }
  const Mat3 unrolled_from_content =
      fit_homography({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, unrolled).destination_from_source.matrix();
  // A chord is farther from its arc than this nowhere, metres.
  constexpr double kSagitta = 5e-5;
  const double cell = std::sqrt(8 * wall.radius * kSagitta);
  const auto cells = [&](int from, int to, int other_from, int other_to) {
    const double length =
        std::max(std::abs(unrolled[std::size_t(to)].x() - unrolled[std::size_t(from)].x()),
                 std::abs(unrolled[std::size_t(other_to)].x() - unrolled[std::size_t(other_from)].x()));
    return std::clamp(int(std::ceil(length / cell)), 8, 128);
  };
  GridSurface shape;
  shape.frame = "rig";
  const double side = ahead.dot(eye - mean) > 0 ? -1 : 1;
  shape.frame_from_surface = content_frame(corners[0], corners[1], side * ahead);
  shape.columns = cells(0, 1, 3, 2) + 1;
  shape.rows = cells(0, 3, 1, 2) + 1;
  const Pose surface_from_rig = shape.frame_from_surface.inverse();
  for (int j = 0; j < shape.rows; ++j)
    for (int i = 0; i < shape.columns; ++i) {
      const Vec2 at = Vec3(unrolled_from_content * Vec3(i / (shape.columns - 1.0), j / (shape.rows - 1.0), 1))
                          .hnormalized();
      const double angle = at.x() / wall.radius;
      shape.points.push_back(surface_from_rig *
                             Vec3(wall.middle + at.y() * wall.axis +
                                  wall.radius * (std::cos(angle) * ahead + std::sin(angle) * sideways)));
    }
  return shape;
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

/// Where the corners' rays meet the wall.
std::array<Vec3, 4> corners_on(const std::function<std::optional<Vec3>(const Ray&)>& meet, const Rig& rig,
                               const CameraCorners& corners, const std::string& name) {
  std::array<Vec3, 4> on_wall;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto ray = camera_ray(rig, corners[i]);
    const auto met = ray ? meet(*ray) : std::nullopt;
    if (!met)
      throw Error(ErrorKind::kInput, "surface '" + name + "'", "a corner's ray does not meet the wall",
                  "click corners on the wall");
    on_wall[i] = *met;
  }
  return on_wall;
}

using PixelOf = std::optional<Vec2> (*)(const Rig&, const Vec3&);

std::vector<Vec2> seen_corners(const Surface& surface, const Rig& rig, PixelOf pixel_of) {
  std::vector<Vec2> seen;
  if (const auto corners = corners_in_rig(surface))
    for (const Vec3& corner : *corners)
      if (const auto pixel = pixel_of(rig, corner)) seen.push_back(*pixel);
  return seen;
}

std::vector<Vec2> seen_outline(const Surface& surface, const Rig& rig, PixelOf pixel_of) {
  std::vector<Vec2> seen;
  const auto point = content_to_rig(surface);
  if (!point) return seen;
  constexpr int kAlongASide = 16;
  const auto& at = content_corners();
  for (std::size_t side = 0; side < 4; ++side)
    for (int i = 0; i < kAlongASide; ++i)
      if (const auto pixel =
              pixel_of(rig, (*point)(at[side] + i / double(kAlongASide) * (at[(side + 1) % 4] - at[side]))))
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
  const std::vector<Vec2> seen = seen_corners(moved, rig, camera_pixel);
  if (seen.size() == 4) {
    std::copy(seen.begin(), seen.end(), seen_now.begin());
    require_convex(seen_now);
  }
  return moved;
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

Surface move_lit_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& projector_pixel_at) {
  return slide(surface, rig, corner,
               projector_pixel_at.allFinite() ? projector_ray(rig, projector_pixel_at) : std::nullopt);
}

std::vector<Vec2> corners_in_camera(const Surface& surface, const Rig& rig) {
  return seen_corners(surface, rig, camera_pixel);
}
std::vector<Vec2> corners_in_frame(const Surface& surface, const Rig& rig) {
  return seen_corners(surface, rig, projector_pixel);
}
std::vector<Vec2> outline_in_camera(const Surface& surface, const Rig& rig) {
  return seen_outline(surface, rig, camera_pixel);
}
std::vector<Vec2> outline_in_frame(const Surface& surface, const Rig& rig) {
  return seen_outline(surface, rig, projector_pixel);
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
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond::FromTwoVectors(base.rotate(Vec3::UnitZ()), normal) * base.rotation;
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
  const Pose projector_from_rig = estimated.projector().rig_from_projector.inverse();
  TrueLanding landing;
  double squares = 0;
  constexpr int kGrid = 9;
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i) {
      const Vec3 point = content_to_rig(Vec2(i, j) / (kGrid - 1.0));
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
