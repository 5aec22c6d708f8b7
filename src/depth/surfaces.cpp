#include "procam/depth/surfaces.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include "plane_kinds.hpp"

namespace procam::depth {
namespace {

constexpr double kLevel = 12 * kDegree;
constexpr double kTableStep = 0.15;  ///< metres: what lies lower is below

/// Depth of a pixel on its plane.
Vec3 point_on(const Plane& plane, const RayTable& rays, int x, int y) {
  const Vec3 ray(double(rays.u(x, y)), double(rays.v(x, y)), 1);
  return ray * (-plane.offset / plane.normal.dot(ray));
}

bool something_below(const DepthImage& image, const RayTable& rays, const Vec3& up, double height) {
  int below = 0, all = 0;
  for (int y = 2; y < rays.size().height; y += 4)
    for (int x = 2; x < rays.size().width; x += 4) {
      const double z = double(image.at(x, y));
      if (!(z > 0) || std::isnan(rays.u(x, y))) continue;
      ++all;
      below += up.dot(z * Vec3(double(rays.u(x, y)), double(rays.v(x, y)), 1)) < height - kTableStep;
    }
  return 100 * below > all;
}

/// How far to the right its pixels are seen.
double bearing(const Vec3& middle) {
  return std::atan2(middle.x(), middle.z());
}

PlaneState state(const DetectedPlane& plane, bool has_rectangle) {
  constexpr double kWorstRms = 0.02;
  if (!has_rectangle) return PlaneState::kNoFreeRectangle;
  if (!(plane.rms > kWorstRms)) return PlaneState::kFree;
  return plane.rms > 2 * plane.noise_rms ? PlaneState::kUneven : PlaneState::kNoisy;
}

/// Letters by kind, numbers by place; a kind that is there once and stands for itself needs no number.
std::string name_of(const std::string& kind, int number, int count) {
  if (count == 1 && (kind == "floor" || kind == "ceiling")) return kind;
  return kind + "_" + std::to_string(number);
}

/// Where two planes meet: their line, and the places along it at which both are seen.
struct Meeting {
  Vec3 point, along;  ///< along: zero for planes that are as good as parallel
  std::vector<double> places;
};

Meeting meeting_of(const Plane& first, const Plane& second) {
  Meeting meeting;
  meeting.along = first.normal.cross(second.normal);
  const double sine = meeting.along.norm();
  if (sine > std::sin(15 * kDegree)) {
    meeting.point =
        (first.offset * second.normal - second.offset * first.normal).cross(meeting.along) / (-sine * sine);
    meeting.along /= sine;
  } else {
    meeting.along.setZero();
  }
  return meeting;
}

/// nullopt for planes that are seen together at too few places, or over too short a part of the line.
std::optional<CornerLine> corner_line(const Planes& planes, int first, int second, Meeting meeting) {
  constexpr std::size_t kMin = 12;  // places where they meet
  if (meeting.places.size() < kMin) return std::nullopt;
  std::sort(meeting.places.begin(), meeting.places.end());
  const std::size_t trim = meeting.places.size() / 50;
  CornerLine line{first, second, meeting.point + meeting.places[trim] * meeting.along,
                  meeting.point + meeting.places[meeting.places.size() - 1 - trim] * meeting.along, 0};
  if (!((line.to - line.from).norm() > 0.1)) return std::nullopt;
  const auto &a = planes.planes[std::size_t(first)], &b = planes.planes[std::size_t(second)];
  const double between =
      std::acos(std::clamp(a.estimate.plane.normal.dot(b.estimate.plane.normal), -1.0, 1.0));
  // Seen from a room's inside, each plane lies before the other.
  const bool inside =
      a.estimate.plane.signed_distance(b.middle) + b.estimate.plane.signed_distance(a.middle) > 0;
  line.angle = inside ? kPi - between : kPi + between;
  return line;
}

}  // namespace

const char* to_string(PlaneKind kind) {
  constexpr std::array<const char*, 6> kNames{"plane", "wall", "floor", "ceiling", "table", "slope"};
  return kNames[std::size_t(kind)];
}

const char* to_string(PlaneState state) {
  constexpr std::array<const char*, 4> kNames{"free", "uneven", "noisy", "no_free_rectangle"};
  return kNames[std::size_t(state)];
}

std::vector<PlaneKind> kinds_of(const Planes& planes, const DepthImage& image, const RayTable& rays,
                                const std::optional<Vec3>& up_in_camera) {
  std::vector<PlaneKind> kinds(planes.planes.size(), PlaneKind::kUnknown);
  if (!up_in_camera) return kinds;
  require(up_in_camera->allFinite() && up_in_camera->norm() > 0, "kinds_of: up is no direction");
  const Vec3 up = up_in_camera->normalized();
  double lowest = 1e9;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const DetectedPlane& plane = planes.planes[i];
    const double rise = plane.estimate.plane.normal.dot(up);
    if (std::abs(rise) < std::sin(kLevel))
      kinds[i] = PlaneKind::kWall;
    else if (rise > std::cos(kLevel))
      kinds[i] = PlaneKind::kTable, lowest = std::min(lowest, up.dot(plane.middle));
    else if (rise < -std::cos(kLevel))
      kinds[i] = PlaneKind::kCeiling;
    else
      kinds[i] = PlaneKind::kSlope;
  }
  if (lowest > 1e8 || something_below(image, rays, up, lowest)) return kinds;
  for (std::size_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == PlaneKind::kTable && up.dot(planes.planes[i].middle) < lowest + kTableStep)
      kinds[i] = PlaneKind::kFloor;
  return kinds;
}

std::vector<CornerLine> corner_lines(const Planes& planes, const RayTable& rays) {
  require(planes.labels.size() == rays.size(), "corner_lines: the labels are not of the camera's size");
  constexpr int kReach = 8;       // pixels from one plane to the other
  constexpr double kNear = 0.06;  // metres from the line
  std::map<std::pair<int, int>, Meeting> meetings;
  const int count = int(planes.planes.size());
  const auto meet = [&](int x0, int y0, int x1, int y1) {
    int a = planes.labels.at(x0, y0), b = planes.labels.at(x1, y1);
    if (a < 0 || b < 0 || a == b || a >= count || b >= count) return;
    const Vec3 p = point_on(planes.planes[std::size_t(a)].estimate.plane, rays, x0, y0);
    if (a > b) std::swap(a, b);
    auto [at, fresh] = meetings.try_emplace({a, b});
    Meeting& meeting = at->second;
    if (fresh)
      meeting = meeting_of(planes.planes[std::size_t(a)].estimate.plane,
                           planes.planes[std::size_t(b)].estimate.plane);
    if (meeting.along.isZero()) return;
    const Vec3 d = p - meeting.point;
    const double s = d.dot(meeting.along);
    if ((d - s * meeting.along).norm() < kNear) meeting.places.push_back(s);
  };
  for (int y = 0; y + kReach < planes.labels.height(); y += 2)
    for (int x = 0; x + kReach < planes.labels.width(); x += 2) {
      if (planes.labels.at(x, y) < 0) continue;
      meet(x, y, x + kReach, y);
      meet(x, y, x, y + kReach);
    }
  std::vector<CornerLine> lines;
  for (auto& [pair, meeting] : meetings)
    if (const auto line = corner_line(planes, pair.first, pair.second, std::move(meeting)))
      lines.push_back(*line);
  return lines;
}

PlanarSurface planar_surface(const Pose& frame_from_plane, const FreeRectangle& rectangle,
                             const std::string& frame) {
  PlanarSurface surface;
  surface.frame = frame;
  const Vec2 size = rectangle.size();
  surface.frame_from_surface =
      Pose(frame_from_plane.rotation, frame_from_plane * Vec3(rectangle.low.x(), rectangle.low.y(), 0));
  surface.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  surface.points = {{0, 0}, {size.x(), 0}, size, {0, size.y()}};
  return surface;
}

RoomSurfaces surfaces_from_planes(const Planes& planes, const DepthImage& image, const RayTable& rays,
                                  const SurfaceOptions& options) {
  require(image.size() == rays.size() && planes.labels.size() == rays.size(),
          "surfaces_from_planes: image, labels and camera differ in size");
  RoomSurfaces out;
  out.kinds = kinds_of(planes, image, rays, options.up_in_camera);
  out.corners = corner_lines(planes, rays);
  const Vec3 up = options.up_in_camera.value_or(Vec3(0, -1, 0));

  std::vector<SurfaceArea> areas;
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    SurfaceArea area{"", out.kinds[i], int(i), area_of(planes, i, rays, up, options.area)};
    out.states.push_back(state(planes.planes[i], area.area.rectangle.has_value()));
    if (!area.area.rectangle) continue;
    areas.push_back(std::move(area));
  }
  std::stable_sort(areas.begin(), areas.end(), [&](const SurfaceArea& a, const SurfaceArea& b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    return bearing(planes.planes[std::size_t(a.plane)].middle) <
           bearing(planes.planes[std::size_t(b.plane)].middle);
  });
  std::map<std::string, int> totals, numbers;
  for (const SurfaceArea& area : areas) ++totals[to_string(area.kind)];
  for (SurfaceArea& area : areas) {
    const std::string kind = to_string(area.kind);
    area.name = name_of(kind, ++numbers[kind], totals[kind]);
    const PlanarSurface surface = planar_surface(options.frame_from_camera * area.area.camera_from_plane,
                                                 *area.area.rectangle, options.frame);
    out.set.surfaces.push_back({area.name, surface, {}, ""});
  }
  out.areas = std::move(areas);

  std::vector<const DetectedCurve*> curves;
  for (const DetectedCurve& curve : planes.curves) curves.push_back(&curve);
  const auto middle = [](const DetectedCurve* curve) {
    return std::visit([](const auto& shape) { return shape.point(Vec2(0.5, 0.5)); }, curve->shape);
  };
  const auto place = [](const DetectedCurve* curve) {
    return std::visit([](const auto& shape) { return shape.frame_from_surface; }, curve->shape);
  };
  std::stable_sort(curves.begin(), curves.end(), [&](const DetectedCurve* a, const DetectedCurve* b) {
    return bearing(place(a) * middle(a)) < bearing(place(b) * middle(b));
  });
  for (const DetectedCurve* curve : curves)
    std::visit(
        [&](auto shape) {
          constexpr bool kCylinder = std::is_same_v<decltype(shape), CylinderSurface>;
          const bool outside = shape.seen_from == SeenFrom::kOutside;
          const std::string kind = kCylinder ? (outside ? "column" : "niche") : (outside ? "ball" : "dome");
          shape.frame = options.frame;
          shape.frame_from_surface = options.frame_from_camera * shape.frame_from_surface;
          if (!shape.fault())
            out.set.surfaces.push_back({kind + "_" + std::to_string(++numbers[kind]), shape, {}, ""});
        },
        curve->shape);
  return out;
}

}  // namespace procam::depth
