#pragma once
/// Images of the rig's own projection on walls and floor, during a drive -> sightings of planes for calibrate::calibrate_mount().
///
///   session::LightImages images;
///   images.folder = "images";        // of the rig's camera, each called after its time
///   images.pattern = "markers";      // the projector shows its board frame all the time
///   const session::PlaneSightings seen = session::planes_in_light(images, rig.camera(), rig.projector());
///
/// The robot moves, so that each image counts alone: there is none under flat light of the same pose. The board's points are
/// found in the image as it is. Prints and edges within the light disturb them; blank surfaces are best. Of markers and charuco any
/// part is enough; chessboards and circles must be seen as a whole. Best are markers: each is fitted by itself
/// (detect::detect_marker_edges), on whatever surface it falls. Markers that fit worse than their neighbours lie across a crease of two
/// surfaces, and are rejected. The other boards are taken as flat (detect::detect_board).
///
/// The planes are those of track::sight_planes(): in a corner and on furniture an image gives several. Which sightings are of
/// one plane is for calibrate_mount() to find: the names are empty.
#include <filesystem>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/session/mount_planes.hpp"
#include "procam/track/sight_plane.hpp"

namespace procam::session {

struct LightImages {
  std::filesystem::path folder;  ///< names as for sightings_in_images(): seconds or nanoseconds
  std::string pattern =
      "markers";        ///< as for make_pattern(): chessboard, charuco, markers, circles; no colour
  int min_points = 12;  ///< of the board on a plane, 4 at least: corners, or centres of discs
  track::SightPlaneOptions plane = {};  ///< min_points as above
};

/// Remark: "images_skipped", with the counts and the most frequent cause: too little of the
/// board, or no plane. Throws Error kIo (folder, file), kInput (a name that is no time, an image of another size than
/// the camera's, a pattern that is no projected board or is in colour), kNotEnoughData (no plane in any image).
PROCAM_EXPORT PlaneSightings planes_in_light(const LightImages& images, const RigCamera& camera,
                                             const RigProjector& projector,
                                             const ReadingProgress& progress = {});

/// The frame to show meanwhile, one channel: the second one of make-patterns. Throws Error(kInput) as planes_in_light() does.
PROCAM_EXPORT ImageU8 still_frame(const std::string& pattern, ImageSize projector_size);

}  // namespace procam::session
