#pragma once
/// A small true world: a rig before a printed board, a wall behind the board. And the truth about it,
/// from direct projection: where each board corner is in the camera's and the projector's picture, and which
/// projector pixel lights what a camera pixel sees.
///
/// Light: the projector sends the same intensity in all directions, its irradiance on a surface at distance d
/// and angle a is cos(a) / d^2 (1 at one metre, straight on). Surfaces are Lambertian and do not light each
/// other; the board throws a shadow on the wall. ambient light falls on everything alike.
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/board_artwork.hpp"
#include "procam/core/geometry/bent_sheet.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/simulate/lens_deviation.hpp"

namespace procam::simulate {

/// A board printed on a white sheet. The back of the sheet is white.
struct PrintedBoard {
  Board layout;
  double margin = 0.04;       ///< white paper round the print, metres
  double white_albedo = 0.8;  ///< 0..1
  double black_albedo = 0.06;
  Vec2 blank = Vec2::Zero();  ///< more white paper to the right and below, metres
  /// What is black (detect::board_artwork). A chessboard's squares need none.
  BoardArtwork artwork = {};
  BentSheet sheet = {};  ///< what the paper is: z of print, margin and blank paper alike
};

struct World {
  Rig rig;  ///< one camera, one projector
  PrintedBoard board;
  Pose rig_from_board;
  Plane wall_in_rig{Vec3(0, 0, -1), 3};
  double wall_albedo = 0.6;
  double ambient = 0;  ///< irradiance, in units of the projector's at one metre
  LensDeviation camera_deviation = {}, projector_deviation = {};  ///< of the true lenses from the rig's
};

/// A surface frame on the wall: origin where the camera's axis meets it, x as the camera's, z into the wall.
/// Throws std::invalid_argument when the camera does not face the wall.
PROCAM_EXPORT Pose rig_from_wall(const World& world);
/// The world before its wall alone: the sheet is behind the camera, as far away as the wall (so that captures
/// are exposed as for a sheet on the wall).
PROCAM_EXPORT World with_bare_wall(World world);

/// The sheet's corners in the board's frame, clockwise from the origin's, metres.
PROCAM_EXPORT Points3 sheet_corners_in_board(const PrintedBoard& board);

/// The board's points that fall on the camera's image / that the projector's picture covers, at their exact
/// pixels. Occlusion is ignored: nothing stands before the board.
PROCAM_EXPORT std::vector<Observation> board_in_camera(const World& world);
PROCAM_EXPORT std::vector<Observation> board_in_projector(const World& world);

/// Where the camera sees that light; nullopt where it falls outside the sheet or the image.
PROCAM_EXPORT std::optional<Vec2> camera_pixel_of_light(const World& world, const Vec2& projector_pixel);

/// The projector pixel whose light falls on the surface point that a camera pixel sees; nullopt where the
/// camera sees nothing, or where no projector light arrives (outside its picture, in the board's shadow, from
/// behind).
PROCAM_EXPORT std::optional<Vec2> projector_pixel_seen_at(const World& world, const Vec2& camera_pixel);

/// projector_pixel_seen_at() for the centres of all camera pixels.
struct ProjectorMap {
  ImageF pixel;  ///< two channels, x and y; 0 where not lit
  ImageU8 lit;   ///< 1 where projector light arrives, else 0
};
PROCAM_EXPORT ProjectorMap projector_map(const World& world);

}  // namespace procam::simulate
