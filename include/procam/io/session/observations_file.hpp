#pragma once
/// Correspondences as a table: CSV or NumPy's .npy. For people whose corners and projector pixels come from
/// other programs, and for those who want what procam found.
///
///   # board: chessboard:7x9:75mm
///   # camera: camera 1280x1024
///   # projector: projector 1024x768
///   view, device, point, u, v, sigma
///   pose_00, camera, 0, 612.31, 208.77, 0.05
///   pose_00, projector, 0, 411.02, 530.96, 0.1
///
/// A row is one point of the board at one pixel of one device. Columns are named by the first line that is no
/// comment, in any order; separators are commas, semicolons or tabs.
///
/// | column | |
/// |---|---|
/// | view | the placement of the board: a name or a number |
/// | device | a name or a number: cameras from 0, then projectors |
/// | point | index into points_in_board() (core/board/board.hpp); or |
/// | x, y, z | the point in the board's frame, metres, z = 0 |
/// | u, v | the pixel; (0, 0) is the centre of the top-left pixel (docs/conventions.md) |
/// | sigma | optional: standard deviation of u and of v, pixels, default 0.1; or |
/// | var_u, cov_uv, var_v | optional: the covariance, pixels^2 |
/// | camera | optional: of a projector's pixel, the camera that read it; default: the only camera |
/// | correlated | optional: 1 where a projector's pixel was read at the camera's corner (Gray code, phase shift), |
/// | | 0 where its error is independent of the corner's; default 1 |
///
/// The covariance of a correlated projector pixel includes the error of the camera's corner
/// (Observation::correlated_with_camera).
///
/// A negative point (-1, -2, ...) is a corner of the projected pattern that falls on the board's sheet at an
/// unknown position: in each view one row of the projector, whose pixel is exact, and one of the camera.
///
/// The lines "# board:", "# camera:" and "# projector:" give what the caller does not (a camera's or
/// projector's name and size); other comments are skipped. A .npy file has no comments: an array with the
/// columns view, device, point, u, v [, sigma] or view, device, x, y, z, u, v [, sigma], or records with
/// named fields, all of them numbers.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::io {

/// Values of the caller; they override the file.
struct ObservationsContext {
  std::optional<Board> board;   ///< without it and without a "# board:" line: from a grid of x, y, z
  std::vector<Device> devices;  ///< any order; a device of the same name in the file is replaced
};

/// Correspondences of all rows: cameras first among the devices, in the order given, then projectors; views
/// in the order of their first rows. Throws Error(kIo) for a file that cannot be read, Error(kInput) naming
/// file, line and column.
PROCAM_EXPORT Correspondences load_observations(const std::filesystem::path& path,
                                                const ObservationsContext& context = {});

/// Writes CSV, or records of numbers for a name that ends in .npy (which then needs a context to be read).
/// Every number reads back as the same double. Throws Error(kIo).
PROCAM_EXPORT void save_observations(const std::filesystem::path& path,
                                     const Correspondences& correspondences);

}  // namespace procam::io
