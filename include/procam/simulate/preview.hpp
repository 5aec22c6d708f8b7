#pragma once
/// What a person in the room would see of a projection.
///
///   Room room = simulate::room_of(scene);                     // surfaces; add furniture if you like
///   RoomLight light{projector, Pose(), {frame}};              // in the scene's frame, the projector's own
///   light.gamma = simulate::kSrgb;
///   ImageU8 seen = simulate::preview(room, {light}, eye, projector_from_eye);
///
/// It is room_view() with the settings of a picture to look at: colours as they are, 9 rays a pixel where
/// anything borders on anything, and an exposure such that a tenth of what the projectors' full light falls
/// on would be brighter than white. So distance and incidence (cos / d^2), shadows, spilled light, overlaps
/// and a projector's black are seen as the room shows them; everything is in focus unless a light has a lens.
#include "procam/core/base/export.hpp"
#include "procam/core/surface/scene.hpp"
#include "procam/simulate/room_view.hpp"

namespace procam::simulate {

/// The scene's surfaces as matt white bodies, in the scene's frame, named by their places "0", "1", ...: a
/// plane's content area, a mesh's triangles, less where the item's mask is below one half. Round every plane
/// a backdrop of a fifth of its size on each side: most are part of a wall. Contents are not looked at; pixel
/// surfaces have no place in the room.
PROCAM_EXPORT Room room_of(const Scene& scene);

struct PreviewOptions {
  /// The room's own light, over the light of full projection that is shown as white. 0: the room's as it is.
  double ambient = 0.04;
  int threads = 0;  ///< 0: as many as the machine has. The result does not depend on it
};

/// The eye's picture, RGB, sRGB. Of each light the first frame is shown. Throws std::invalid_argument as
/// room_view().
PROCAM_EXPORT ImageU8 preview(const Room& room, const std::vector<RoomLight>& lights, const Camera& eye,
                              const Pose& room_from_eye, const PreviewOptions& options = {});

}  // namespace procam::simulate
