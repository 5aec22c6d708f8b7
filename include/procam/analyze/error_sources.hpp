#pragma once
/// What the light's place on a surface depends on, and how well each of it is known.
///
/// A surface point X (surface frame, z = 0) reaches the projector's pixel by the chain
///
///   pixel = project(lens, projector_from_rig * rig_from_world * world_from_surface * X).
///
/// Every link may be wrong: the lens and the projector's place in the rig (the rig file's covariance), the
/// rig's pose (a localiser, a marker), the surface's pose (the map), the moment (the rig moves on between the
/// pose and the light), and the pixel (content moves in whole ones). Errors of poses are increments in the
/// thing's own frame (right increments, [rotation, translation]):
///
///   true world_from_rig = world_from_rig * exp(xi),      true world_from_surface = world_from_surface *
///   exp(xi)
///
/// so that "10 mm and half a degree" means the same wherever the world's origin lies.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::analyze {

/// Position and rotation each alike in all directions and independent: sigma_position metres, sigma_rotation
/// radians, about the thing's own origin. Throws std::invalid_argument for a negative sigma or NaN.
PROCAM_EXPORT Mat6 isotropic_pose_covariance(double sigma_position, double sigma_rotation);

/// Of the right increment, in the thing's own frame: Ad(T^-1) C Ad(T^-1)^T, from core's left increments.
PROCAM_EXPORT Mat6 own_frame_covariance(const PoseWithCovariance& parent_from_thing);

/// The rig moves while its pose travels to the light.
struct RobotMotion {
  Vec6 twist = Vec6::Zero();         ///< of the rig in its own frame, rad/s and m/s
  Vec6 twist_sigma = Vec6::Zero();   ///< how well it is known where it is used to predict
  Vec6 acceleration = Vec6::Zero();  ///< the change of the twist, which constant-twist prediction misses
  double delay = 0;                  ///< seconds from the pose's stamp to the light
  double delay_sigma = 0;
  bool predicted = false;  ///< the pose is moved on by twist * delay before it is used
};

/// The rig's pose was measured through its own camera (a marker): what the calibration has wrong of that
/// camera moves the pose, and the light with it. One error, two ways.
struct PoseThroughCamera {
  std::vector<std::string> names;  ///< parameters of the calibration: "camera.fx", "rig_from_camera.rx", ...
  /// d xi / d parameter, 6 x names: of world_from_rig's right increment.
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_parameters;
};

struct ErrorSources {
  NamedCovariance calibration;   ///< rig.covariance; empty: the rig is taken as exact
  Mat6 rig_pose = Mat6::Zero();  ///< of world_from_rig, right increment
  Mat6 map = Mat6::Zero();       ///< of the surface's pose, right increment
  RobotMotion motion;
  /// Half a pixel at most in either direction, all offsets alike: 1 / sqrt(12). 0 where content is drawn
  /// between pixels (procam's renderer does).
  double pixel_sigma = 0;
  /// Beside rig_pose, which then holds the image's and the marker map's share alone.
  std::optional<PoseThroughCamera> through_camera = std::nullopt;
};

/// Sets `rig_pose` and `through_camera` from where the camera saw its markers: `covariance` of
/// camera_from_world's left increment as image and map leave it, `by_lens` its derivative by the camera's
/// parameters (columns as parameter_names()). track::LocateResult holds all three. With d the true minus the
/// believed parameters,
///
///   xi = -(d rig_from_camera + Ad(rig_from_camera) (by_lens d + noise)).
PROCAM_EXPORT void set_measured_pose(ErrorSources& sources, const RigCamera& camera, const Mat6& covariance,
                                     const MatX& by_lens);

/// The links between one projector's pixel and one surface, as they are believed to be.
struct LightPath {
  RigProjector projector;
  Pose rig_from_surface;
  bool through_pose = true;  ///< the surface stands in the world: the rig's pose and motion take part
  bool through_mount =
      true;  ///< the surface stands in the world or the rig: the projector's place in it does
};

/// `frame` is the surface's: "world", "rig" or "projector" (core/surface/surface.hpp). Throws Error(kInput) for
/// another frame, or "world" without the rig's pose.
PROCAM_EXPORT LightPath light_path(const RigProjector& projector, const std::string& frame,
                                   const Pose& frame_from_surface,
                                   const std::optional<Pose>& world_from_rig = std::nullopt);

/// A wall in the rig's frame. The surface's origin is the wall's point nearest to the rig's; its axes lie in
/// the wall, z into it.
PROCAM_EXPORT LightPath light_path(const RigProjector& projector, const Plane& wall_in_rig);

/// Where the light of a pixel lands on the surface, metres along its x and y; nullopt when it misses.
PROCAM_EXPORT std::optional<Vec2> landing_place(const LightPath& path, const Vec2& pixel);

}  // namespace procam::analyze
