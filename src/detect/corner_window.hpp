#pragma once
/// The pixels that a corner's fit takes from an image.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "corner_fit.hpp"
#include "procam/core/base/detail/four.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::detect {

/// Pixels, eight by eight, as seen from one of them: in whole floats. Copies of one of them fill up the last eight.
class Samples {
 public:
  using Float8 = procam::detail::Float8;
  Samples() = default;
  explicit Samples(const Vec2& near) : origin_(near.array().round()) {}
  const Vec2& origin() const { return origin_; }
  /// Neighbours in a row, from (x, y) on.
  void add(int x, int y, const std::uint8_t* greys, int count) {
    if (count <= 0) return;
    make_room(size_ + std::size_t(count));
    const float from_x = float(x - origin_.x()), from_y = float(y - origin_.y());
    float* const to_x = floats(x_) + size_;
    float* const to_y = floats(y_) + size_;
    float* const to_grey = floats(grey_) + size_;
    for (int i = 0; i < count; ++i) {
      to_x[i] = from_x + float(i);
      to_y[i] = from_y;
      to_grey[i] = greys[i];
    }
    size_ += std::size_t(count);
  }
  void add(int x, int y, std::uint8_t grey) {
    make_room(size_ + 1);
    floats(x_)[size_] = float(x - origin_.x());
    floats(y_)[size_] = float(y - origin_.y());
    floats(grey_)[size_++] = grey;
  }
  /// After the last pixel.
  void fill_up() {
    if (size_ == 0) return;
    make_room(groups() * Float8::kSize);
    for (std::vector<Float8>* each : {&x_, &y_, &grey_})
      std::fill(floats(*each) + size_, floats(*each) + groups() * Float8::kSize, floats(*each)[size_ - 1]);
  }
  std::size_t size() const { return size_; }
  std::size_t groups() const { return (size_ + Float8::kSize - 1) / Float8::kSize; }
  const Float8& x(std::size_t group) const { return x_[group]; }
  const Float8& y(std::size_t group) const { return y_[group]; }
  const Float8& grey(std::size_t group) const { return grey_[group]; }
  /// Of the last group, which lanes are copies.
  Float8 filling() const {
    Float8 filling(0);
    for (std::size_t i = (size_ - 1) % Float8::kSize + 1; i < Float8::kSize; ++i) filling[i] = 1;
    return filling;
  }

 private:
  static float* floats(std::vector<Float8>& lanes) { return reinterpret_cast<float*>(lanes.data()); }
  void make_room(std::size_t pixels) {
    if (pixels > x_.size() * Float8::kSize) grow(pixels);
  }
  void grow(std::size_t pixels) {
    const std::size_t more = std::max(pixels / Float8::kSize + 1, 2 * x_.size());
    for (std::vector<Float8>* each : {&x_, &y_, &grey_}) each->resize(more);
  }

  Vec2 origin_ = Vec2::Zero();
  std::vector<Float8> x_, y_, grey_;
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
