#pragma once
/// A room as a camera sees it while projectors show one frame after the other.
///
///   const simulate::LiveView view(room, camera, room_from_camera, light, options);   // a second
///   ImageU8 seen = view.capture(frame, 0);                                           // some 30 ms at 1280x720
///
/// All rays are followed once. Of each camera pixel remain its level without light and, for each projector, its position (u, v)
/// and level under full light: the means over its rays. With one frame for each projector, an image is then
///
///   light  = (black + (1 - black) (frame / 255)^gamma_l) * gaussian(s)      s: blur, defocus and the camera pixel's
///                                                                          footprint, between two widths
///   level  = unlit + sum over projectors of lit * light(u, v)
///   grey   as in capture.hpp, with glare
///
/// The difference from room_view(): one position a pixel instead of many rays, so that the borders of shadows and
/// bodies are right to a pixel only, and discs of defocus are Gaussians of the same variance.
#include <cstdint>
#include <memory>
#include <vector>

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
  /// By several projectors.
  LiveView(const Room& room, const Camera& camera, const Pose& room_from_camera,
           const std::vector<RoomLight>& lights, const LiveViewOptions& options);
  ~LiveView();
  LiveView(LiveView&&) noexcept;
  LiveView& operator=(LiveView&&) noexcept;

  /// Grey levels per unit of light, as given or as found.
  double exposure() const;
  /// The pixel of that projector that lights the point which the centre of each camera pixel sees.
  const ProjectorMap& light(std::size_t projector = 0) const;
  /// A frame as light, blurred: most of the work, once for all images of it.
  class Light;
  std::shared_ptr<const Light> light_of(ViewU8 frame, std::size_t projector = 0) const;

  /// The camera's image while the only projector shows `frame` (grey or RGB, its size). Noise differs by `number`.
  ImageU8 capture(ViewU8 frame, std::uint64_t number) const;
  ImageU8 capture(const Light& light, std::uint64_t number) const;
  /// While each projector shows its own frame. Throws std::invalid_argument unless there is one for each.
  ImageU8 capture(const std::vector<std::shared_ptr<const Light>>& lights, std::uint64_t number) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::simulate
