#pragma once
/// Markers as an image would show them, without an image: edges at their exact pixels plus Gaussian noise.
#include <random>

#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::test {

inline Camera wall_camera() {
  return {{1280, 960}, {1290.0, 1297.0, 655.0, 470.0, 0.6}, BrownConrady{{-0.12, 0.06, 0.0007, -0.0011, 0}}};
}

/// Sides and two inner lines of one marker, a piece every tenth of a side.
inline SeenMarker sighting(const Camera& camera, const Pose& camera_from_marker, int id, double size,
                           double sigma, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, sigma);
  const auto pixel_of = [&](const Vec2& unit) {
    return camera.project(camera_from_marker * Vec3(unit.x() * size, unit.y() * size, 0));
  };
  SeenMarker marker;
  marker.id = id;
  for (std::size_t i = 0; i < 4; ++i) marker.corners[i] = *pixel_of(marker_corners()[i]);
  marker.covariance.setIdentity();
  marker.covariance *= sigma * sigma + 1e-8;
  for (const double line : {-0.5, -0.2, 0.1, 0.5})
    for (const bool vertical : {true, false})
      for (int i = -4; i <= 4; ++i) {
        const Vec2 unit = vertical ? Vec2(line, 0.1 * i) : Vec2(0.1 * i, line);
        // Outwards is white at the sides; the inner lines have it the other way round.
        const double sign = std::abs(line) == 0.5 ? (line > 0 ? 1 : -1) : (line > 0 ? -1 : 1);
        MarkerEdge edge{unit, vertical ? Vec2(sign, 0) : Vec2(0, sign), *pixel_of(unit),
                        sigma * sigma + 1e-8};
        edge.pixel += Vec2{normal(random), normal(random)};
        marker.edges.push_back(edge);
      }
  return marker;
}

inline MarkerDetections sightings(const Camera& camera, const Pose& camera_from_world, const MarkerMap& map,
                                  double sigma, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  MarkerDetections detections;
  detections.image_size = camera.size;
  for (const PlacedMarker& placed : map.markers)
    detections.markers.push_back(sighting(camera, camera_from_world * placed.world_from_marker, placed.id,
                                          placed.size, sigma, random));
  return detections;
}

/// Three markers on a wall, one on a wall round the corner; ids and sizes differ.
inline MarkerMap room_map() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{3, 0.16, Pose()},
                 {7, 0.14, Pose(so3_exp(Vec3(0.02, -0.01, 0.4)), Vec3(0.5, 0.1, 0.01))},
                 {11, 0.18, Pose(so3_exp(Vec3(0, 0.03, -0.2)), Vec3(0.1, 0.45, -0.02))},
                 {20, 0.15, Pose(so3_exp(Vec3(0.05, 1.2, 0.1)), Vec3(-0.4, 0.2, -0.25))}};
  return map;
}

inline Pose looking_at_room() {
  return Pose(so3_exp(Vec3(0.21, -0.33, 0.07)), Vec3(-0.06, -0.17, 1.9));
}

}  // namespace procam::test
