#pragma once
/// What a body reflects, made ready for many questions.
#include <array>
#include <vector>

#include "paper.hpp"
#include "shape.hpp"
#include "summed_picture.hpp"

namespace procam::simulate::internal {

/// Albedo for the red, green and blue light of a projector; of what has no colour, three times the same.
using Bands = std::array<double, 3>;

/// A ray's share of the camera pixel on a surface: the parallelogram (across, down) about the point.
struct Footprint {
  Vec3 across = Vec3::Zero(), down = Vec3::Zero();
};

class PreparedPaint {
 public:
  /// Throws std::invalid_argument for an albedo outside 0..1, a picture without texels or of other than one
  /// or three channels, or a print on a shape that is not flat.
  explicit PreparedPaint(const Body& body);

  /// Is the albedo the same all over that side?
  bool is_plain(bool front) const { return std::holds_alternative<double>(front ? front_ : back_); }
  bool is_coloured() const;
  /// Mean over a ray's share of the camera pixel: over the box of the same variance along each axis of the
  /// drawing.
  Bands albedo(bool front, const Spot& spot, const Footprint& share) const;

 private:
  struct Print {
    std::vector<SummedPicture> channels;  ///< one or three
    double white, black;
  };
  using Side = std::variant<double, Print, Paper>;
  static Side side_of(const Body& body);

  const Shape* shape_;
  Side front_, back_;
};

}  // namespace procam::simulate::internal
