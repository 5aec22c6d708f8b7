#pragma once
/// Where every pixel of a depth camera looks, through its lens, worked out once per camera.
///
/// A pixel's ray is (u, v, 1): its point is z (u, v, 1), z the depth.
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::depth {

class PROCAM_EXPORT RayTable {
 public:
  /// Images are read in cells of this many pixels a side.
  static constexpr int kCell = 8;

  /// Throws std::invalid_argument for an image without pixels, or a focal length that is not positive.
  explicit RayTable(const Camera& camera);

  const Camera& camera() const { return camera_; }
  ImageSize size() const { return camera_.size; }
  /// Cells; those at the right and lower edge may be cut.
  int columns() const { return columns_; }
  int rows() const { return rows_; }

  float u(int x, int y) const { return u_.at(x, y); }
  float v(int x, int y) const { return v_.at(x, y); }
  /// A row's u and v from pixel x on. Without lens and skew all rows share one u, all columns one v, and 16
  /// rows of the tables stay in the cache.
  const float* u_from(int x, int y) const { return u_.row(separable_ ? 0 : y) + x; }
  const float* v_from(int x, int y) const { return v_.row(y) + (separable_ ? 0 : x); }

  /// A cell's pixels about its middle, and their sums when all of them have a reading. `whole`: the cell has
  /// all its pixels, and each has a ray.
  struct CellRays {
    double u = 0, v = 0;  ///< of the middle
    bool whole = false;
    double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;  ///< of x = fx (u - middle), y likewise
  };
  const CellRays& cell(int column, int row) const {
    return cells_[std::size_t(row) * std::size_t(columns_) + std::size_t(column)];
  }

  bool is_pinhole() const { return shift_.empty(); }
  /// The pixel of a ray, through the lens; far outside of the image it is only roughly right.
  Vec2 pixel_of(double u, double v) const;

 private:
  Camera camera_;
  int columns_ = 0, rows_ = 0;
  bool separable_ = false;
  ImageF u_, v_;  ///< NaN where the lens model has no inverse
  std::vector<CellRays> cells_;
  // What the lens adds to the pinhole's pixel, on a lattice over the image; empty for a pinhole.
  int lattice_columns_ = 0, lattice_rows_ = 0;
  Points2 shift_;
};

}  // namespace procam::depth
