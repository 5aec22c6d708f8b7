#pragma once
/// What a structured-light depth camera (Kinect and its kin) reports in a room, and the truth beside it.
///
/// In this order, a pixel at true depth z whose surface is turned by theta (0: facing the camera):
///
///   edges    reads the depth at a position moved by N(0, sigma_l^2) an axis, where another surface begins:
///            sigma_l = 0.8 + 0.035 theta / (pi/2 - theta) [pixels]
///   axial    z + N(0, sigma_z^2), sigma_z = 0.0012 + 0.0019 (z - 0.4)^2
///            + 0.0001 / sqrt(z) * theta^2 / (pi/2 - theta)^2 [metres]
///   disparity  fx b / z rounded to `disparity_step`; the rounding's own variance is part of sigma_z^2
///   holes    nothing there; beyond `nearest` .. `farthest`; theta above `grazing`; in the emitter's
///            shadow beside something nearer; a share `dropout` anywhere
///
/// sigma_l, sigma_z: C. V. Nguyen, S. Izadi, D. Lovell, "Modeling Kinect sensor noise for improved 3D
/// reconstruction and tracking", 3DIMPVT 2012, equations 1 and 3 (measured on planes up to 80 degrees; their
/// third term begins at 60 degrees, here it grows from 0, where it is small). Disparities in eighths of a
/// pixel and the emitter 75 mm beside the camera: K. Khoshelham, S. O. Elberink, "Accuracy and resolution of
/// Kinect depth data for indoor mapping applications", Sensors 12, 2012. Neighbouring pixels are independent,
/// which the real sensor's are not.
#include <cstdint>

#include "procam/core/base/export.hpp"
#include "procam/simulate/room_view.hpp"

namespace procam::simulate {

struct DepthSensor {
  Camera camera{{640, 480}, {585, 585, 319.5, 239.5, 0}, NoDistortion{}};
  /// Where the emitter stands: its baseline and its shadows.
  Vec3 emitter_in_camera = Vec3(-0.075, 0, 0);
  double nearest = 0.5, farthest = 4.5;    ///< metres
  double grazing = 1.4;                    ///< radians between ray and normal
  double disparity_step = 0.125;           ///< pixels; 0: no rounding
  double edge_noise = 1, axial_noise = 1;  ///< factors of the laws above
  double dropout = 0;                      ///< share of pixels lost for no reason
};

struct DepthView {
  ImageF metres;             ///< z in the camera's frame, measured; 0: hole
  Image<std::uint16_t> mm;   ///< the same, rounded to millimetres; 0: hole
  ImageF true_metres;        ///< without noise and holes; 0: nothing there
  Image<std::int16_t> body;  ///< of the pixel's centre, number in the room; -1: nothing
  ImageF angle;              ///< theta, radians; 0 where there is nothing
  ImageU8 shadowed;          ///< 1 where the emitter's light does not arrive
};

/// The standard deviation of an axial reading at depth z of a surface turned by theta, metres.
PROCAM_EXPORT double axial_sigma(double z, double theta);
/// Of a place along each axis of the image, pixels.
PROCAM_EXPORT double lateral_sigma(double theta);

/// Equal seeds give equal views. Throws std::invalid_argument for numbers out of range or bodies that cannot
/// be.
PROCAM_EXPORT DepthView depth_view(const Room& room, const DepthSensor& sensor, const Pose& room_from_camera,
                                   std::uint64_t seed, int threads = 0);
/// The view with the noise of another seed: a sensor's next image of a room that stays as it is, without tracing the rays
/// again. Throws std::invalid_argument for a view of another sensor's size.
PROCAM_EXPORT DepthView read_again(DepthView view, const DepthSensor& sensor, std::uint64_t seed);

}  // namespace procam::simulate
