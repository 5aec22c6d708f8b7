#pragma once
/// How much of a camera's image or a projector's picture the views of a session have covered with board
/// points: the union of the views' convex hulls, on a raster. Lenses are known where points were, and
/// extrapolated elsewhere. Without a board: the cells in which light was read.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::session {

class PROCAM_EXPORT Coverage {
 public:
  explicit Coverage(ImageSize device);

  /// One view's points, in pixels of the device. Fewer than three cover nothing.
  void add(const Points2& points);
  /// One view's points, so dense that each cell which the view covers holds one: no hull, and none is drawn.
  void add_dense(const Points2& points);
  /// Of the device's area, 0..1.
  double share() const;
  /// The ninth of the picture that is covered least, in words ("top left", "middle"); empty when none is
  /// below a half.
  std::string emptiest_part() const;
  /// Views that covered each cell of the raster; its longer side has 160 cells.
  const ImageU8& views() const { return views_; }
  /// All points so far, in cells of the raster.
  const Points2& points() const { return points_; }

 private:
  Vec2 cell_of(const Vec2& pixel) const;

  double scale_;  ///< cells a pixel
  ImageU8 views_;
  Points2 points_;
};

/// Side by side, three channels: dark where nothing was, greener with each view, points white.
PROCAM_EXPORT ImageU8 draw(const std::vector<const Coverage*>& devices);

}  // namespace procam::session
