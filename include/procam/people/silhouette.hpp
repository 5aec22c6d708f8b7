#pragma once
/// People, and whatever else has come before the known room, are kept out of the light: by depth, where a
/// skeleton tracker would miss them.
///
///   const ImageF background = ...;                     // of the empty room, metres along the optical axis
///   const Silhouettes seen = find_silhouettes({camera, depth, background});      // as depth comes
///   darken_silhouettes(frame, projector, projector_from_camera, seen, age);      // as frames are due
///
/// A reading that is nearer than the background by more than `nearer` is somebody, and so is one where the
/// empty room had none. Around each such place a ball
///
///   r = margin + speed * age + half of what a block of readings spans there
///
/// is black in the projector's frame, outwards by what a block of the mask (8 x 8 pixels) cannot tell apart.
/// It fails dark:
/// - where readings are missing that the empty room had, a head that returns no light may be: anywhere along
///   these rays where the gap is as wide as a head or wider, that is from
///
///     z = f head / (half the gap's width in pixels)
///
///   on. Single missing readings and the narrow shadows of the sensor's own emitter so cost nothing, a sensor
///   that is covered costs all that it would see;
/// - something at the lens, or depth older than `fresh`, darkens the whole picture.
///
/// As darken_heads(), it is a courtesy to eyes: light that the depth camera does not see stays lit, and so
/// does what is hidden behind what it sees by more than the margin.
#include "procam/core/base/export.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/people/eye_safe.hpp"

namespace procam::people {

struct SilhouetteOptions {
  double nearer = 0.12;  ///< metres before the background: above the sensor's noise and what hangs on a wall
  double margin = 0.1;   ///< metres around every reading
  double speed = 1.5;    ///< m/s that somebody moves since the depth was seen
  double fresh = 0.3;    ///< seconds after which depth is no news
  double nearest = 0.5;  ///< metres: where nothing was measured, somebody is no nearer than this
  double head = 0.06;    ///< metres: half the breadth of the slimmest head that may return no light
};

/// Depth along the optical axis, metres; 0, negative or not finite: no reading. Both of the camera's size.
struct SilhouetteInput {
  const Camera& camera;
  ViewF depth, background;
};

/// What may be somebody, in the depth camera's frame.
struct Silhouettes {
  /// A block of readings: somebody's surface is within `radius` of it.
  struct Seen {
    Vec3 middle = Vec3::Zero();
    double radius = 0;
  };
  /// A block without readings: somebody may be at z (way.x, way.y, 1), z from `from` to `to`, within
  /// `radius_per_metre` z.
  struct Unseen {
    Vec3 way = Vec3::Zero();
    double from = 0, to = 0, radius_per_metre = 0;
  };
  std::vector<Seen> seen;
  std::vector<Unseen> unseen;
};

/// Throws std::invalid_argument for depth images that have not the camera's size.
PROCAM_EXPORT Silhouettes find_silhouettes(const SilhouetteInput& view,
                                           const SilhouetteOptions& options = {});

/// `age`: seconds from the moment of the depth image to the light. Throws std::invalid_argument for a frame
/// that has not the projector's size.
PROCAM_EXPORT MaskResult darken_silhouettes(ImageView<std::uint8_t> frame, const Projector& projector,
                                            const Pose& projector_from_camera, const Silhouettes& silhouettes,
                                            double age, const SilhouetteOptions& options = {});

}  // namespace procam::people
