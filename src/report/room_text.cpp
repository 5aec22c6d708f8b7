#include <cmath>

#include "fields.hpp"
#include "procam/report/room.hpp"

namespace procam::report {
namespace {

double offset_sigma(const depth::DetectedPlane& plane) {
  return std::sqrt(std::max(plane.estimate.covariance(3, 3), 0.0));
}

/// 0 for a shape without one.
double radius_of(const SurfaceGeometry& geometry) {
  return std::visit(
      [](const auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, CylinderSurface> ||
                      std::is_same_v<std::decay_t<decltype(shape)>, SphereSurface>)
          return shape.radius;
        else
          return 0.0;
      },
      geometry);
}

std::string surface_on(const depth::RoomSurfaces& room, std::size_t plane) {
  for (const depth::SurfaceArea& area : room.areas)
    if (std::size_t(area.plane) == plane) return area.name;
  return "";
}

Json surface_json(const depth::Planes& planes, const depth::RoomSurfaces& room, std::size_t i) {
  Json object;
  Fields f(object);
  f.field("name", room.set.surfaces[i].name);
  if (i >= room.areas.size()) {
    f.field("radius", radius_of(room.set.surfaces[i].geometry));
    return object;
  }
  const depth::SurfaceArea& area = room.areas[i];
  const depth::DetectedPlane& plane = planes.planes[std::size_t(area.plane)];
  f.field("kind", depth::to_string(area.kind));
  f.field("state", depth::to_string(room.states[std::size_t(area.plane)]));
  f.field("size", Vec2(area.area.rectangle->size()));
  f.field("area", area.area.area);
  f.field("normal_in_camera", plane.estimate.plane.normal);
  f.field("offset", plane.estimate.plane.offset);
  f.field("offset_sigma", offset_sigma(plane));
  f.field("rms", plane.rms);
  return object;
}

Json plane_json(const depth::Planes& planes, const depth::RoomSurfaces& room, std::size_t i) {
  const depth::DetectedPlane& plane = planes.planes[i];
  Json object;
  Fields f(object);
  f.field("state", depth::to_string(room.states[i]));
  f.optional("surface", surface_on(room, i));
  f.field("kind", depth::to_string(room.kinds[i]));
  f.field("area", plane.area);
  f.field("pixels", plane.pixels);
  f.field("normal_in_camera", plane.estimate.plane.normal);
  f.field("middle_in_camera", plane.middle);
  f.field("offset", plane.estimate.plane.offset);
  f.field("offset_sigma", offset_sigma(plane));
  f.field("rms", plane.rms);
  f.field("noise_rms", plane.noise_rms);
  return object;
}

}  // namespace

std::string to_json(const depth::Planes& planes, const depth::RoomSurfaces& room,
                    const depth::SensorKind& sensor, const depth::SensorCheck& check) {
  Json object, surfaces = Json::array(), all = Json::array();
  for (std::size_t i = 0; i < room.set.surfaces.size(); ++i)
    surfaces.push_back(surface_json(planes, room, i));
  for (std::size_t i = 0; i < planes.planes.size(); ++i) all.push_back(plane_json(planes, room, i));
  object["surfaces"] = surfaces;
  object["planes"] = all;
  Fields(object).object("sensor", [&](Fields& f) {
    f.field("model", sensor.name);
    f.field("noise_ratio", check.ratio);
    f.field("fits", check.fault.empty());
  });
  return text(object);
}

std::vector<std::string> lines(const depth::Planes& planes, const depth::RoomSurfaces& room) {
  std::vector<std::string> lines{
      format("%-12s %16s %9s %10s %12s %8s", "surface", "free", "area", "distance", "sigma", "rms")};
  for (std::size_t i = 0; i < room.set.surfaces.size(); ++i) {
    const std::string& name = room.set.surfaces[i].name;
    if (i >= room.areas.size()) {
      lines.push_back(format("%-12s radius %.3f m", name.c_str(), radius_of(room.set.surfaces[i].geometry)));
      continue;
    }
    const depth::PlaneArea& area = room.areas[i].area;
    const depth::DetectedPlane& plane = planes.planes[std::size_t(room.areas[i].plane)];
    const Vec2 size = area.rectangle->size();
    lines.push_back(format("%-12s %6.2f x %5.2f m %6.2f m2 %8.3f m %9.2f mm %5.1f mm", name.c_str(), size.x(),
                           size.y(), area.area, plane.estimate.plane.offset, 1e3 * offset_sigma(plane),
                           1e3 * plane.rms));
  }
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    if (!surface_on(room, i).empty()) continue;
    const depth::DetectedPlane& plane = planes.planes[i];
    const std::string kind = format("(%s)", depth::to_string(room.kinds[i]));
    lines.push_back(format("%-12s %16s %6.2f m2 %8.3f m %9.2f mm %5.1f mm", kind.c_str(), "none", plane.area,
                           plane.estimate.plane.offset, 1e3 * offset_sigma(plane), 1e3 * plane.rms));
  }
  return lines;
}

}  // namespace procam::report
