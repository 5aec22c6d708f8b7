#pragma once
/// People, and whatever else has come before the known walls, are kept out of the light: by depth, where a
/// skeleton tracker would miss them.
///
///   const ImageF background = median_of_the_empty_room;      // metres along the optical axis
///   ...
///   darken_silhouettes(frame, projector, projector_from_camera, {camera, depth, background}, age);
///
/// A reading that is nearer than the background by more than `nearer` is somebody. Around each such point a
/// ball
///
///   r = margin + speed * age + half of what a pixel of the depth camera spans there
///
/// is black in the projector's frame, outwards by what a block of the mask (8 x 8 pixels) cannot tell apart.
/// It fails dark:
/// - where most of a block of 4 x 4 readings is missing that the empty room had, somebody may be anywhere
/// along
///   these rays from `nearest` on: all of them are dark;
/// - a reading where the empty room had none is somebody;
/// - something at the lens, or depth older than `fresh`, darkens the whole picture.
///
/// As darken_heads(), it is a courtesy to eyes: light that the depth camera does not see stays lit, and so
/// does what is hidden behind what it sees by more than the margin.
#include "procam/core/camera.hpp"
#include "procam/track/eye_safe.hpp"

namespace procam::track {

struct SilhouetteOptions {
  double nearer = 0.12;  ///< metres before the background: above the sensor's noise and what hangs on a wall
  double margin = 0.1;   ///< metres around every reading
  double speed = 1.5;    ///< m/s that somebody moves since the depth was seen
  double fresh = 0.3;    ///< seconds after which depth is no news
  double nearest = 0.5;  ///< metres: where nothing was measured, somebody is no nearer than this
};

/// Depth along the optical axis, metres; 0, negative or not finite: no reading. Both of the camera's size.
struct DepthView {
  const Camera& camera;
  ViewF depth, background;
};

/// `age`: seconds from the moment of the depth image to the light. Throws std::invalid_argument for a frame
/// that has not the projector's size, or depth images that have not the camera's.
Darkened darken_silhouettes(ImageView<std::uint8_t> frame, const Projector& projector,
                            const Pose& projector_from_camera, const DepthView& seen, double age,
                            const SilhouetteOptions& options = {});

}  // namespace procam::track
