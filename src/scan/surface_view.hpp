#pragma once
/// A scan as a surface that other stations are compared with: planes fitted around each pixel.
#include <optional>
#include <vector>

#include "procam/scan/stations.hpp"

namespace procam::scan {

/// Of one pixel, in the rig's frame.
struct SurfacePoint {
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  ///< towards the camera
  Vec2 pixel = Vec2::Zero();
  double depth = 0, sigma = 0;  ///< sigma: of the light's noise, along the normal
};

class SurfaceView {
 public:
  SurfaceView(const Scan& scan, int threads);

  const Scan& scan() const { return *scan_; }
  bool has_plane(int x, int y) const { return planes_.at(x, y, 2) != 0; }
  /// has_plane() is required.
  SurfacePoint at(int x, int y) const;
  /// The measured point itself, in the rig's frame.
  Vec3 measured_point(int x, int y) const {
    return scan_->camera.rig_from_camera * Vec3(ray(x, y) * double(scan_->depth.at(x, y)));
  }
  /// With z 1, in the camera's frame.
  Vec3 ray(int x, int y) const { return Vec3(rays_.at(x, y, 0), rays_.at(x, y, 1), 1); }
  /// The pixel that sees a point of the rig's frame; nullopt outside of the image.
  std::optional<Eigen::Vector2i> pixel_of(const Vec3& point_in_rig) const;
  /// Depth of a point of the rig's frame in the camera.
  double depth_of(const Vec3& point_in_rig) const { return (camera_from_rig_ * point_in_rig).z(); }
  int plane_count() const { return plane_count_; }

 private:
  const Scan* scan_;
  Pose camera_from_rig_;
  ImageF rays_, planes_;  ///< planes: n with n . p = 1 in the camera's frame; zero: none
  int plane_count_ = 0;
};

/// A station as surfaces, and points of it spread evenly.
struct StationView {
  std::vector<SurfaceView> views;
  /// At most about `count` of the pixels that have a plane, with the number of their view.
  struct Sample {
    int view = 0;
    SurfacePoint at;
  };
  std::vector<Sample> samples(int count) const;
};

std::vector<StationView> station_views(const std::vector<Station>& stations, int threads);

}  // namespace procam::scan
