#pragma once
/// The planes of a room as a moving depth camera sees them again and again: each keeps its name, its estimate
/// gets better, and its content stays where it is.
///
///   PlaneMap map({up_in_world});
///   for (...) {
///     map.update(find_planes(image, rays), image, rays, world_from_camera, time);
///     solve_surfaces(map.surfaces(), projector, world_from_projector) ...
///   }
///
/// A detected plane belongs to a plane of the map when it is parallel and level with it where it is seen.
/// Both are then fused as Gaussians of (two turns, offset), the camera's pose covariance included (an
/// information filter; Smith, Self, Cheeseman, "Estimating uncertain spatial relationships in robotics",
/// 1990). Constant sensor errors do not average out: `process_noise` keeps the covariance from shrinking as
/// if they did.
///
/// Obstacles in front of a plane are found in its raster. The free share of each cell follows the readings
/// with the time constant `free_space_tau`: a person who passes changes nothing, an object that stays makes
/// the content smaller. The content is the largest free rectangle inside its first rectangle; it grows back
/// when that is free again.
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/depth/surfaces.hpp"

namespace procam::depth {

struct PlaneMapOptions {
  Vec3 up_in_world = Vec3::UnitZ();
  DepthNoise noise = DepthNoise::kinect_v1();  ///< as for find_planes()
  /// A plane gets its name after this many frames, and only where it was free for about a third of
  /// `free_space_tau`: a person's back is no surface.
  int min_observations = 3;
  /// Metres. Largest sigma of the content's corners along the normal for a plane to get its name; after ten
  /// times `min_observations` frames it gets it anyway. Less certain content would move.
  double max_corner_sigma = 0.002;
  double free_space_tau = 1.5;    ///< seconds in which a cell's free share follows by 63 %
  double process_noise = 0.5e-3;  ///< metres and radians a square root second that a plane may be off more
  double largest_angle = 5 * kDegree;    ///< between detection and map, beside three sigmas
  double largest_gap = 0.05;             ///< metres, likewise
  double cell = 0.02;                    ///< metres, of the rasters
  double margin = 0.01, min_side = 0.2;  ///< metres, as in AreaOptions
};

struct MapPlane {
  std::string name;  ///< empty until it is believed; then it never changes
  PlaneKind kind = PlaneKind::kUnknown;
  PlaneEstimate in_world;
  Pose world_from_plane;  ///< upright as first read; follows the estimate, turns no more than it must
  PlaneRaster raster;     ///< free: 1 where content may be
  ImageF free_share;      ///< of each cell, 0..1; negative: never seen
  std::optional<FreeRectangle> home;     ///< the content's first place
  std::optional<FreeRectangle> content;  ///< what of it is free now
  int seen = 0;                          ///< frames
  double last_seen = 0;                  ///< seconds
};

class PROCAM_EXPORT PlaneMap {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit PlaneMap(const PlaneMapOptions& options = {});

  /// One frame at `time`, seconds, which must not go back. Throws std::invalid_argument for images of another
  /// size than the camera's or a pose that is not finite.
  void update(const Planes& planes, const DepthImage& image, const RayTable& rays,
              const PoseWithCovariance& world_from_camera, double time);

  const std::vector<MapPlane>& planes() const { return planes_; }
  /// Of all named planes with content, in the frame "world".
  SurfaceSet surfaces() const;
  /// Content may move: each plane's home becomes the largest rectangle that is free now.
  void replan();

 private:
  MapPlane* match(const PlaneEstimate& in_world, const Vec3& middle_in_world);
  void fuse(MapPlane& plane, const PlaneEstimate& in_world);
  struct Frame;
  void look(MapPlane& plane, int id, const Frame& frame, double blend) const;
  void choose_content(MapPlane& plane) const;
  void name_new(const Pose& world_from_camera);

  PlaneMapOptions options_;
  std::vector<MapPlane> planes_;
  std::vector<int> names_given_ = std::vector<int>(6);  ///< by PlaneKind
  double time_ = 0;
  bool started_ = false;
};

}  // namespace procam::depth
