#pragma once
/// Three projectors of one rig before two walls in a corner, and the light that the walls show.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "procam/core/base/color.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/show/projection.hpp"
#include "show_blend.hpp"

namespace procam::show {

inline Pose looking(const Vec3& from, const Vec3& to, double roll) {
  const Vec3 forward = (to - from).normalized();
  const Vec3 right = Vec3::UnitY().cross(forward).normalized();
  Mat3 rotation;
  rotation << right, forward.cross(right), forward;
  return (Pose(rotation, from) * Pose(so3_exp<double>(Vec3(0, 0, roll)), Vec3::Zero())).inverse();
}

/// A wall of the world with two sides, metres.
inline Surface corner_wall(const std::string& name, const Vec3& corner, const Vec3& right, const Vec3& down) {
  Mat3 rotation;
  const Vec3 normal = right.cross(down).normalized();
  rotation << right.normalized(), normal.cross(right.normalized()), normal;
  PlanarSurface plane;
  plane.frame = "world";
  plane.frame_from_surface = Pose(rotation, corner);
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {{0, 0}, {right.norm(), 0}, {right.norm(), down.norm()}, {0, down.norm()}};
  return {name, plane, {}, "#ffffff"};
}

/// Three lopsided projectors of one rig before a corner; "left" and "right" overlap, "far" overlaps "left" alone.
struct Corner {
  Rig rig;
  Pose rig_from_world = Pose(so3_exp(Vec3(0.2, -0.4, 0.1)), Vec3(0.3, -0.2, 0.15));
  SurfaceSet surfaces;

  Corner() {
    add("left", {{320, 240}, {420, 413, 150.3, 121.6, 1.1}, BrownConrady{{-0.1, 0.02, 1e-3, -5e-4, 0}}},
        looking({-0.55, 0.1, 0}, {-0.3, 0.05, 2.1}, 0.03));
    add("right", {{400, 250}, {515, 522, 210.4, 110.9, -0.7}, {}},
        looking({0.7, -0.12, 0.25}, {0.36, 0.0, 2.1}, -0.05));
    add("far", {{300, 260}, {420, 413, 150.3, 121.6, 1.1}, {}},
        looking({-1.5, 0.1, 0.3}, {-1.5, 0.05, 1.9}, 0.02));
    surfaces.surfaces = {corner_wall("left wall", {-2.0, -1.3, 1.6}, {2.1, 0, 0.9}, {0, 2.6, 0}),
                         corner_wall("right wall", {0.1, -1.3, 2.5}, {1.9, 0, -1.3}, {0, 2.6, 0})};
  }
  void add(const std::string& name, const Camera& lens, const Pose& projector_from_world) {
    RigProjector projector;
    projector.name = name;
    projector.projector.inverse_camera = lens;
    projector.rig_from_projector = rig_from_world * projector_from_world.inverse();
    rig.projectors.push_back(projector);
  }
  Pose projector_from_world(const std::string& name) const {
    return (rig.projector(name).rig_from_projector.inverse() * rig_from_world).normalized();
  }
  BlendPlan plan(const std::string& name) const {
    BlendPlan plan;
    plan.rig = rig;
    plan.projector = name;
    plan.rig_from_world = rig_from_world;
    return plan;
  }
  BlendScene scene(const std::string& name, ProjectorNames lit) const {
    return {std::move(lit), rig.projector(name).rig_from_projector, surfaces};
  }
  /// As a show draws it.
  ImageU8 frame(const std::string& name, const ProjectorNames& lit, const ImageU8& content,
                const BlendSettings& settings = {}) const {
    ProjectionOptions options;
    options.projector = name;
    options.projector_from_world = projector_from_world(name);
    Projection projection(rig, options);
    Show show;
    show.surfaces = surfaces;
    for (int i = 0; i < 2; ++i) show.contents.push_back(device::still_content(content));
    projection.set_show(show);
    BlendPlan planned = plan(name);
    planned.settings = settings;
    projection.set_blend(make_blend(planned, scene(name, lit)).blend);
    ImageU8 frame(projection.frame_size(), 3);
    projection.draw(0, 0, frame);
    return frame;
  }
};

struct Wall {
  double mean = 0, deviation = 0, worst = 0;  ///< of the mean
  int places = 0, by_several = 0;
};

/// What both walls show while these projectors show these frames: no nearer than two pixels to the border of a frame.
inline Wall seen_light(const Corner& corner, const ProjectorNames& lit, const std::vector<ImageU8>& frames,
                       double black = 0) {
  constexpr double kMargin = 2;
  std::vector<double> lights;
  Wall wall;
  for (const Surface& surface : corner.surfaces.surfaces) {
    const auto& plane = std::get<PlanarSurface>(surface.geometry);
    for (double v = 0.01; v < 0.99; v += 0.0123)
      for (double u = 0.01; u < 0.99; u += 0.0117) {
        const Vec3 point =
            plane.frame_from_surface * Vec3(u * plane.points[2].x(), v * plane.points[2].y(), 0);
        double light = 0;
        int lamps = 0;
        bool at_border = false;
        for (std::size_t i = 0; i < lit.size(); ++i) {
          const Projector& projector = corner.rig.projector(lit[i]).projector;
          const auto pixel = projector.project(corner.projector_from_world(lit[i]) * point);
          const auto inside = [&](double margin) {
            return pixel && pixel->minCoeff() >= margin &&
                   pixel->x() <= projector.size().width - 1 - margin &&
                   pixel->y() <= projector.size().height - 1 - margin;
          };
          if (!inside(kMargin)) {
            at_border = at_border || inside(-kMargin);
            continue;
          }
          const int x = int(pixel->x()), y = int(pixel->y());
          const double s = pixel->x() - x, t = pixel->y() - y;
          const auto at = [&](int px, int py) { return light_from_srgb(frames[i].at(px, py, 1) / 255.0); };
          const double shown = (1 - t) * ((1 - s) * at(x, y) + s * at(x + 1, y)) +
                               t * ((1 - s) * at(x, y + 1) + s * at(x + 1, y + 1));
          light += black + (1 - black) * shown;
          ++lamps;
        }
        if (lamps == 0 || at_border) continue;
        wall.by_several += lamps > 1;
        lights.push_back(light);
      }
  }
  wall.places = int(lights.size());
  for (const double light : lights) wall.mean += light / double(lights.size());
  for (const double light : lights) {
    wall.worst = std::max(wall.worst, std::abs(light / wall.mean - 1));
    wall.deviation += std::pow(light / wall.mean - 1, 2) / double(lights.size());
  }
  wall.deviation = std::sqrt(wall.deviation);
  return wall;
}

inline std::vector<ImageU8> frames_of(const Corner& corner, const ProjectorNames& lit, std::uint8_t value,
                                      const BlendSettings& settings = {}) {
  std::vector<ImageU8> frames;
  for (const std::string& name : lit)
    frames.push_back(corner.frame(name, lit, ImageU8(8, 8, 3, value), settings));
  return frames;
}

}  // namespace procam::show
