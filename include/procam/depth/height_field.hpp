#pragma once
/// A surface that moves and deforms before a depth camera (sand, a cloth), as heights over a reference plane.
///
///   const ReferencePlane plane = fit_reference_plane(image, rays);
///   HeightField field(plane.size);
///   field.update(image, rays, plane.camera_from_reference.inverse(), exposure);    // as images come
///   const HeightMap now = field.at(light_time);                                    // as frames are due
///   const auto mesh = mesh_of(now);
///
/// Reference frame: x right, y down, z away from the camera, metres; the field covers 0 .. size.x, 0 .. size.y, and a point
/// of height h is (x, y, -h). Heights are known at the middles of square cells.
///
/// Every cell is a Kalman filter with height h and rate r, driven by white acceleration of spectral density q [m^2/s^3]:
///
///   h(t + dt) = h + r dt,  Q = q [dt^3/3  dt^2/2; dt^2/2  dt]
///
/// (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, section 6.2.2).
/// It so lags behind nothing that rises evenly, and at(t) reaches the moment of the light. A measurement is the mean of
/// the readings of 3 x 3 cells with the weights (1 2 1)(1 2 1)^T, moved to the cell's middle along the slope. Its
/// variance is that of the sensor's model along the ray through a surface of slope g:
///
///   var = sigma(z)^2 (d_z + g . d_xy)^2 sum k^2 n / (sum k n)^2,   d: the ray (u, v, 1) in the reference frame
///
/// The stated standard deviation is that of noise. What all readings share (DepthNoise::correlated_sigma(), the lens) is not in it.
///
/// People are not fused. Readings above `max_height`, or that differ from the prediction by more than `max_jump` plus four
/// sigma, cover their cell and all within `margin`: it is a hole until they are gone. What rests for `settle_after`
/// is sand, and so is at once whatever lies lower than before, because nobody is under the sand.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/depth/depth_image.hpp"
#include "procam/depth/ray_table.hpp"

namespace procam::depth {

/// A rectangle of a depth camera's pixels.
struct PixelRegion {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Where heights are counted from.
struct ReferencePlane {
  Pose camera_from_reference;
  Vec2 size = Vec2::Zero();  ///< metres
};

/// The plane that fits the readings of a region best (least squares in z over the camera's x and y, by Huber's weights),
/// and on it the largest upright rectangle whose corners the region sees. No region: a tenth of the image is left
/// out at each border. Throws Error(kInput) for a region that is not inside of the image, Error(kNotEnoughData) where
/// fewer than a quarter of its pixels have readings, Error(kDegenerate) where the plane is seen from its edge.
PROCAM_EXPORT ReferencePlane fit_reference_plane(const DepthImage& image, const RayTable& rays,
                                                 const std::optional<PixelRegion>& region = std::nullopt);

struct HeightFieldOptions {
  DepthNoise noise = DepthNoise::kinect_v1();
  double cell = 0.01;          ///< metres, the side of a cell
  double acceleration = 0.03;  ///< spectral density q, m^2/s^3
  double max_height = 0.25;    ///< metres; what is higher is no part of the surface
  double max_jump = 0.03;      ///< metres from one image to the next
  double settle_after = 2;     ///< seconds
  double margin = 0.03;        ///< metres around what covers the surface
  double max_sigma = 0.01;     ///< metres; a cell that is less certain at the last image is a hole
  double max_gap = 0.03;       ///< metres; narrower holes without readings are bridged
};

/// Heights at a moment, row by row, at the middles of the cells.
struct HeightMap {
  double cell = 0;  ///< metres
  ImageF height;    ///< metres; 0 in a hole
  ImageF sigma;     ///< standard deviation, metres; 0 in a hole

  bool is_known(int column, int row) const { return sigma.at(column, row) > 0; }
};

class PROCAM_EXPORT HeightField {
 public:
  /// Throws std::invalid_argument for a size under two cells or above 1000 a side, and for options out of range.
  explicit HeightField(const Vec2& size, const HeightFieldOptions& options = {});

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Vec2 size() const { return options_.cell * Vec2(columns_, rows_); }

  /// One image, exposed at `time` (seconds); images that are older than the last are omitted. Throws std::invalid_argument
  /// for another size than the rays' and a pose or time that is not finite.
  void update(const DepthImage& image, const RayTable& rays, const Pose& reference_from_camera, double time);

  /// The surface at a time, at most 0.2 s after the last image: later times are that one.
  HeightMap at(double time) const;

  /// Is something before the surface there, in the last image?
  bool is_covered(int column, int row) const { return hidden_[index(column, row)] != 0; }
  /// Depth along the optical axis that the camera would see were nobody there, metres; 0 in holes that nothing was ever
  /// seen in. Beside the field it is that of the plane at `max_height`, where the image has a reading.
  ImageF background(const DepthImage& image, const RayTable& rays, const Pose& reference_from_camera) const;

 private:
  struct Cell {
    double height = 0, rate = 0;
    double hh = 0, hr = 0, rr = 0;    ///< covariance; hh 0: nothing was ever seen
    double candidate = 0, since = 0;  ///< what rests there, if it is not the surface
    bool has_candidate = false;
  };
  struct Sums {
    float own = 0, own_height = 0, own_x = 0, own_y = 0;  ///< readings of the surface
    float above = 0, above_height = 0, below = 0, below_height = 0;
  };
  std::size_t index(int column, int row) const {
    return std::size_t(row) * std::size_t(columns_) + std::size_t(column);
  }
  void predict(double dt);
  void collect(const DepthImage& image, const RayTable& rays, const Pose& reference_from_camera);
  void find_covered(double time);
  void begin_again(Cell& cell, double height, double variance) const;
  void measure(const Pose& reference_from_camera);
  double reading_sigma(const Pose& camera_from_reference, const Vec3& point, const Vec2& slope) const;
  Vec2 slope(int column, int row) const;
  void bridge(HeightMap& map) const;

  HeightFieldOptions options_;
  int columns_ = 0, rows_ = 0;
  double time_ = 0;
  bool has_image_ = false;
  std::vector<Cell> cells_;
  std::vector<Sums> sums_;
  std::vector<float> lowest_, highest_;  ///< between which a reading is of the surface, by cell
  std::vector<std::uint8_t> covered_, hidden_;
};

/// Triangles between the middles of cells, in the reference frame; (u, v) = (x, y) / size. Without a triangle where a
/// corner is a hole.
PROCAM_EXPORT std::shared_ptr<const Mesh> mesh_of(const HeightMap& map);

}  // namespace procam::depth
