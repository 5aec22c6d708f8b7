#pragma once
/// People are kept out of the light: a dark disc around every head, in the projector's own pixels.
///
///   options.draw = [&](const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
///     const auto work = renderer.render(scene, projector, frame);
///     darken_heads(frame, projector, projector_from_sensor, track, light_time);      // last, over
///     everything return work;
///   };
///
/// Each head is a ball: its radius, a margin, what the head may have moved since it was seen, and three
/// sigmas of where it is,
///   r = radius + margin + speed * age + 3 sigma.
/// Its outline, seen from the lens, is the circle in which the lines of sight touch it, projected through the
/// full lens model; every pixel within it is black. It fails dark: a head that reaches the lens, an outline
/// that the lens model cannot tell, and (unless said otherwise) no news of people for `fresh` seconds darken
/// the whole picture. A person without any joint of the head is darkened as a whole, down to the last joint
/// seen.
///
/// It is a courtesy to eyes, not a safety device: what the sensor does not see is not kept out of the light.
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/people/people.hpp"

namespace procam::people {

struct EyeSafeOptions {
  double radius = 0.14;  ///< of a head with its hair, metres
  double margin = 0.06;
  double speed = 1.5;             ///< m/s that a head moves unseen: a brisk walk
  double fresh = 0.3;             ///< seconds without news of people after which the picture is dark
  bool dark_without_news = true;  ///< off: without news the light goes on
};

struct MaskResult {
  bool blanked = false;     ///< the whole picture
  int masked = 0;           ///< darkened; of silhouettes, blocks of readings
  const char* reason = "";  ///< the whole picture is dark
};

/// Blackens the heads in a frame of the projector's size, any number of channels (std::invalid_argument
/// otherwise). `people` from PeopleTrack::at(light_time); `newest` from PeopleTrack::newest().
PROCAM_EXPORT MaskResult darken_heads(ImageView<std::uint8_t> frame, const Projector& projector,
                                      const Pose& projector_from_sensor,
                                      const std::vector<TrackedPerson>& people,
                                      const std::optional<double>& newest, double light_time,
                                      const EyeSafeOptions& options = {});
/// The same, asking the track.
PROCAM_EXPORT MaskResult darken_heads(ImageView<std::uint8_t> frame, const Projector& projector,
                                      const Pose& projector_from_sensor, const PeopleTrack& track,
                                      double light_time, const EyeSafeOptions& options = {});

}  // namespace procam::people
