#pragma once
/// What a camera records of markers that hang on a wall.
///
///   level = lamp * albedo, blurred and gathered over each pixel, with noise
///   grey  = round(255 (clamp((1 - glare) level + glare * mean level) / 255)^(1 / gamma))
///
/// The wall is everything that no sheet covers. Every sheet is a black square with its cells on a white rim.
/// Borders of cells are integrated over each ray's share of the pixel, so they lie right to a few thousandths
/// of a pixel.
#include <cstdint>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/simulate/world.hpp"

namespace procam::simulate {

struct MarkerViewOptions {
  double white_grey = 200, black_grey = 18, wall_grey = 120;  ///< in the image's middle
  /// Light falls off to the right and to the bottom by this share over the image.
  double falloff = 0.3;
  double rim_cells = 1.5;       ///< white paper round the black square, cells
  double blur_px = 0.7;         ///< sigma of the lens
  NoiseModel noise{2.0, 0.01};  ///< of the linear level
  double gamma = 1;             ///< of the camera; the greys above are linear
  double glare = 0;             ///< light that the lens scatters over the image, share
  std::uint64_t seed = 0;
};

/// The camera's image of the markers; where sheets overlap in the image the first one shows. Throws
/// std::invalid_argument for a size that is not positive, an id that the codes lack, or options out of range.
PROCAM_EXPORT ImageU8 marker_view(const Camera& camera, const Pose& camera_from_world,
                                  const std::vector<PlacedMarker>& markers, const MarkerCells& codes,
                                  const MarkerViewOptions& options = {});

/// Markers with their true places.
struct HungMarkers {
  MarkerMap map;
  Pose rig_from_world;  ///< the world is the frame of the first marker
};

/// Four markers (ids 3, 7, 11, 20 of apriltag_36h11; sides of a tenth of the camera's distance and less) on
/// the wall of the world, round the point that the camera's axis meets, each turned a little in its plane.
/// Throws std::invalid_argument when the camera does not face the wall.
PROCAM_EXPORT HungMarkers hang_markers(const World& world);

}  // namespace procam::simulate
