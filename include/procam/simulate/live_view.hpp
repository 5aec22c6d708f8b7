#pragma once
/// A room as a camera sees it while a projector shows one frame after the other.
///
///   const simulate::LiveView view(room, camera, room_from_camera, light, options);   // a second
///   ImageU8 seen = view.capture(frame, 0);                                           // some 30 ms at 1280x720
///
/// All rays are followed once. Of each camera pixel remain its projector position (u, v), its level under full light and
/// its level without: the means over its rays. A frame is then
///
///   light  = (black + (1 - black) (frame / 255)^gamma_l) * gaussian(s)      s: blur, defocus and the camera pixel's
///                                                                          footprint, between two widths
///   level  = unlit + lit * light(u, v)
///   grey   as in capture.hpp, with glare
///
/// The difference from room_view(): one position a pixel instead of many rays, so that the borders of shadows and
/// bodies are right to a pixel only, and discs of defocus are Gaussians of the same variance.
#include <cstdint>
#include <memory>

#include "procam/core/base/export.hpp"
#include "procam/simulate/room_view.hpp"

namespace procam::simulate {

struct LiveViewOptions {
  RoomViewOptions view;  ///< grey captures; `colour`, `crosstalk`, `lens` and the times are not used
  double glare = 0;      ///< light that the camera's lens scatters over its image, share (capture.hpp)
};

class PROCAM_EXPORT LiveView {
 public:
  /// Of `light`, the frames are not used. Throws std::invalid_argument as room_view() does.
  LiveView(const Room& room, const Camera& camera, const Pose& room_from_camera, const RoomLight& light,
           const LiveViewOptions& options);
  ~LiveView();
  LiveView(LiveView&&) noexcept;
  LiveView& operator=(LiveView&&) noexcept;

  /// Grey levels per unit of light, as given or as found.
  double exposure() const;
  /// The projector pixel that lights the point which the centre of each camera pixel sees.
  const ProjectorMap& light() const;
  /// A frame as light, blurred: most of the work, once for all images of it.
  class Light;
  std::shared_ptr<const Light> light_of(ViewU8 frame) const;

  /// The camera's image while the projector shows `frame` (grey or RGB, its size). Noise differs by `number`.
  ImageU8 capture(ViewU8 frame, std::uint64_t number) const;
  ImageU8 capture(const Light& light, std::uint64_t number) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::simulate
