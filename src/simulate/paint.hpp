#pragma once
/// What a body reflects, made ready for many questions.
#include "paper.hpp"
#include "shape.hpp"
#include "summed_picture.hpp"

namespace procam::simulate::internal {

class PreparedPaint {
 public:
  /// Throws std::invalid_argument for an albedo outside 0..1, a picture without texels, or a print on a shape
  /// that is not flat.
  explicit PreparedPaint(const Body& body);

  /// Is the albedo the same all over that side?
  bool is_plain(bool front) const { return std::holds_alternative<double>(front ? front_ : back_); }
  double plain_albedo(bool front) const { return std::get<double>(front ? front_ : back_); }
  /// Mean over a ray's share of the camera pixel, which spans the parallelogram (across, down) about the
  /// point: taken over the box of the same variance along each axis of the drawing.
  double albedo(bool front, const Vec3& point, const Vec3& across, const Vec3& down) const;

 private:
  struct Print {
    SummedPicture picture;
    double white, black;
  };
  using Side = std::variant<double, Print, Paper>;
  static Side side_of(const Body& body);

  const Shape* shape_;
  Side front_, back_;
};

}  // namespace procam::simulate::internal
