#pragma once
/// World made ready for rays: everything in the camera's frame.
#include "procam/simulate/world.hpp"

namespace procam::simulate::internal {

struct Hit {
  Vec3 point_in_camera;
  Vec3 normal_in_camera;  ///< towards the camera
  bool on_board = false;
  Vec2 point_on_board = Vec2::Zero();  ///< metres, when on_board
  bool printed_side = false;
};

/// Projector light at a point.
struct Lighting {
  Vec2 projector_pixel;   ///< may lie outside the picture
  double irradiance = 0;  ///< of full light: cos / d^2
  double depth = 0;       ///< along the projector's axis, metres
};

class Scene {
 public:
  explicit Scene(const World& world);

  const Camera& camera() const { return camera_; }
  const Projector& projector() const { return projector_; }
  /// Of the true lenses from these.
  const LensDeviation& camera_deviation() const { return camera_deviation_; }

  /// What the camera sees along a direction (z = 1 or unit, no matter).
  std::optional<Hit> hit(const Vec3& direction_in_camera) const;
  /// nullopt from behind, in the board's shadow, or outside the projector's lens.
  std::optional<Lighting> lighting(const Hit& hit) const;
  /// Where a direction meets the board's sheet, or its continuation, x and y in the board's frame; nullopt when it does not.
  std::optional<Vec2> meet_sheet(const Vec3& direction_in_camera) const;

  double white_albedo() const { return white_albedo_; }
  double wall_albedo() const { return wall_albedo_; }
  double ambient() const { return ambient_; }

 private:
  bool on_paper(const Vec2& point_on_board) const;

  Camera camera_;
  Projector projector_;
  LensDeviation camera_deviation_, projector_deviation_;
  double white_albedo_;
  ArtworkRectangle paper_;
  BentSheet sheet_;
  Pose projector_from_camera_, board_from_camera_, camera_from_board_;
  Vec3 projector_in_camera_;
  Plane wall_in_camera_;
  double wall_albedo_, ambient_;
};

}  // namespace procam::simulate::internal
