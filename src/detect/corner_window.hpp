#pragma once
/// The pixels that a corner's fit takes from an image.
#include <algorithm>
#include <cmath>
#include <vector>

#include "corner_fit.hpp"
#include "procam/core/base/detail/four.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::detect {

/// Pixels, eight by eight, as seen from one of them: in whole floats. Copies of their first fill up the last
/// eight.
class Samples {
 public:
  using Float8 = procam::detail::Float8;
  struct Group {
    Float8 x, y, grey;
  };
  Samples() = default;
  explicit Samples(const Vec2& near) : origin_(near.array().round()) {}
  const Vec2& origin() const { return origin_; }
  void add(int x, int y, float grey) {
    const std::size_t lane = size_++ % Float8::kSize;
    const float from_x = float(x - origin_.x()), from_y = float(y - origin_.y());
    if (lane == 0) groups_.push_back({from_x, from_y, grey});
    groups_.back().x[lane] = from_x;
    groups_.back().y[lane] = from_y;
    groups_.back().grey[lane] = grey;
  }
  std::size_t size() const { return size_; }
  const std::vector<Group>& groups() const { return groups_; }
  /// Of the last group, which lanes are copies.
  Float8 filling() const {
    Float8 filling(0);
    for (std::size_t i = (size_ - 1) % Float8::kSize + 1; i < Float8::kSize; ++i) filling[i] = 1;
    return filling;
  }

 private:
  Vec2 origin_ = Vec2::Zero();
  std::vector<Group> groups_;
  std::size_t size_ = 0;
};

/// Which pixels of a window are taken. A window of many pixels is almost all flat: there a few pixels tell
/// the light as well as all of them, while every pixel near an edge carries information.
struct Sampling {
  int every = 1;    ///< of so many pixels one is taken
  double band = 0;  ///< pixels closer to an edge than this are all taken

  double spacing() const { return std::sqrt(every); }
};

/// The pixels within `share` squares of the corner along both grid directions, at least two pixels. Near the image's rim
/// the share is as large as the image allows: a window cut by the rim would not be symmetric about the corner, and errors
/// of the model would move the corner.
struct Window {
  const CornerNeighbourhood& around;
  double share_x, share_y, det;
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  bool usable = false;

  Window(const CornerNeighbourhood& of, double share, const ViewU8& image);
  double square() const { return std::min(around.e_x.norm(), around.e_y.norm()); }
  /// Of the whole parallelogram.
  double pixels() const { return 4 * std::abs(det) * share_x * share_y; }

  Samples samples(const ViewU8& image, const Sampling& sampling) const;
};

}  // namespace procam::detect
