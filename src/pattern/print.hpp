#pragma once
/// The printed board as one picture of the camera shows it: which place of the board a pixel sees, and
/// whether a blurred edge of the print is near.
#include <optional>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/board/artwork_index.hpp"
#include "procam/core/geometry/homography.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::pattern {

/// Camera pixel -> place on the board, in pitches (pitch_of): a homography of the seen points, and a cubic
/// polynomial for what the lens bends. Outliers are weighted down.
class BoardPlace {
 public:
  /// nullopt with fewer than four points, or points that fix no homography.
  static std::optional<BoardPlace> fit(const Detections& in_camera, const Board& board);

  std::optional<Vec2> at(const Vec2& pixel) const;
  /// d place / d pixel; zero where the place is beyond the horizon.
  Mat2 jacobian(const Vec2& pixel) const;

 private:
  using Terms = Eigen::Matrix<double, 10, 1>;
  Terms terms(const Vec2& in_homography) const;

  Homography homography_;
  Vec2 middle_ = Vec2::Zero();
  double half_ = 1;  ///< of the seen points' extent, pitches
  Eigen::Matrix<double, 10, 2> bend_ = Eigen::Matrix<double, 10, 2>::Zero();
};

class Print {
 public:
  /// `border_px`: nearer than this to where dark and light print meet, a pixel is not clear.
  Print(const BoardPlace& place, const Detections& in_camera, const Board& board, const BoardArtwork& artwork,
        double border_px);

  /// Where light is read, pitches: a pitch round the seen points, as far as the print (markers and circles:
  /// the sheet) reaches.
  const Vec2& low() const { return low_; }
  const Vec2& high() const { return high_; }

  /// The place that a pixel sees; nullopt off that area.
  std::optional<Vec2> place_at(const Vec2& pixel) const;
  bool clear(const Vec2& pixel) const;

  /// 1 at the pixels from which an edge on clear print may begin, towards larger x or y.
  ImageU8 area() const;

 private:
  /// Could the block of pixels from (x0, y0) on see the area? The map bends little over a block: no farther
  /// than the block's own size beyond its corners.
  bool may_hold_print(int x0, int y0) const;

  BoardPlace place_;
  Vec2 low_, high_;
  ImageU8 clear_;  ///< 1 where it is
};

}  // namespace procam::pattern
