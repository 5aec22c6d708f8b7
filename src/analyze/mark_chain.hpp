#pragma once
/// Errors of marks of light on a plane, or on a plane of its own for each (StatedSurface::tangents), as a function of
/// all that they depend on, with derivatives.
///
/// The state x: what the rig's covariance names, the projector's place last of it (also where the rig holds
/// it fixed), then six of the surface's pose; poses as left increments. A ray of bearing m from a device at T
/// meets the plane z = 0 of the surface S at p (rig frame), s bearings away. With E the 2x3 matrix that
/// slides a point along the ray back onto the plane, in the surface's axes, and R_S from the rig's axes to
/// the surface's:
///
///   d place = E R_S ([-hat(p) I] (xi_T - xi_S) + s R_T dm)
///
/// The camera's derivatives are those of its ray to the place that the light is to reach, as in a fit of
/// pixels: along its own ray, an error would seem smaller on a nearer surface, though no pixel is better
/// explained.
#include <optional>
#include <string>
#include <vector>

#include "procam/analyze/verify.hpp"

namespace procam::analyze {

/// Left increments of the two things that may have moved.
struct Moved {
  Vec6 projector = Vec6::Zero(), surface = Vec6::Zero();
};

struct LinearMarks {
  VecX error;               ///< x and y of each mark, metres
  MatX by_state;            ///< 2 rows a mark
  std::vector<Mat2> noise;  ///< of the detected pixel, on the surface
};

class MarkChain {
 public:
  MarkChain(const Rig& rig, const RigCamera& camera, const RigProjector& projector,
            const StatedSurface& surface, const std::vector<LightPoint>& marks);

  std::size_t marks() const { return seen_.size(); }
  /// nullopt when a ray does not meet the surface.
  std::optional<Vec2> intended(std::size_t mark, const Moved& moved = {}) const;
  std::optional<Vec2> error(std::size_t mark, const Moved& moved = {}) const;
  /// Where in the mark's chain it ends, as the end of a sentence; empty when error() has a value.
  std::string flaw(std::size_t mark) const;

  /// Of these marks, all of which must have an error as stated; nullopt when one has none any more.
  std::optional<LinearMarks> linearise(const std::vector<std::size_t>& marks, const Moved& moved) const;

  /// Covariance of the state as rig and surface state it.
  const MatX& stated() const { return stated_; }
  Eigen::Index projector_place() const { return projector_place_; }  ///< first of its six rows
  Eigen::Index surface_place() const { return stated_.rows() - 6; }
  /// Rows of the state before the surface's: names as in the rig's covariance.
  const std::vector<std::string>& rig_names() const { return rig_names_; }

 private:
  /// A pixel's bearing in its device's frame, and how it moves with the lens and with the pixel.
  struct Bearing {
    Vec3 direction;
    Eigen::Matrix<double, 3, Eigen::Dynamic> by_lens;
    Eigen::Matrix<double, 3, 2> by_pixel = Eigen::Matrix<double, 3, 2>::Zero();
  };
  static std::vector<std::optional<Bearing>> bearings(const Camera& lens, const Points2& pixels);

  std::vector<std::optional<Bearing>> seen_, shown_;
  std::vector<Mat2> pixel_noise_;
  Pose rig_from_camera_, rig_from_projector_;
  std::vector<Pose> rig_from_plane_;  ///< of each mark, as stated
  MatX surface_by_camera_;
  std::vector<std::string> rig_names_;
  /// Columns of the camera's lens and place, and of the projector's lens; -1: held fixed.
  std::vector<Eigen::Index> camera_columns_, projector_lens_;
  Eigen::Index projector_place_ = 0;
  MatX stated_;
};

}  // namespace procam::analyze
