#pragma once
/// Peers of procam's calibration: OpenCV's two usual ways, and a plain bundle adjustment that is told the
/// truth about outliers. And the yardstick for all of them: where the light lands.
#include <Eigen/Geometry>
#include <functional>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/options.hpp"
#include "procam/core/base/image.hpp"
#include "procam/simulate/session.hpp"

namespace procam::test {

/// The part of the projector's picture that the views cover: 5 to 95 % of the measured pixels, along each
/// axis.
Eigen::AlignedBox2d covered_core(const Correspondences& data);

/// RMS distance between true and estimated light of 9 x 7 pixels of `core`, on walls across the true axis at
/// 1, 1.5, 2, 2.5 and 3 m; millimetres.
double light_rms_mm(const Rig& estimated, const Rig& truth, const Eigen::AlignedBox2d& core);

/// The projector pixel, in whole numbers, that a Gray code says a camera pixel of a view sees.
using DecodedPixel = std::function<std::optional<Vec2>(std::size_t view, int x, int y)>;

/// findChessboardCorners and cornerSubPix; empty when the board is not found.
std::vector<Observation> opencv_corners(const ViewU8& image, const Chessboard& board);

/// findChessboardCornersSB, which finds boards beside other boards and in uneven light; empty without a
/// board.
std::vector<Observation> opencv_corners_by_sectors(const ViewU8& image, const Chessboard& board);

/// Gray code with OpenCV: from the camera corners in `data`, the projector's pixel of each by a local
/// homography of the decoded pixels round it (D. Moreno and G. Taubin, "Simple, accurate, and robust
/// projector-camera calibration", 3DIMPVT 2012; 47 x 47 pixels, RANSAC), calibrateCamera for each device,
/// stereoCalibrate.
Rig opencv_rig_of_gray_code(const Correspondences& data, const DecodedPixel& decoded);

/// Printed and projected boards with OpenCV: the camera by calibrateCamera from the print, each projected
/// corner where its ray meets the board's plane, the projector by calibrateCamera from these places,
/// stereoCalibrate.
Rig opencv_rig_of_light_points(const Correspondences& data);

/// calibrate::bundle_adjust by plain least squares with the detectors' own covariances, begun at the truth
/// and without the true outliers: measurements further from the truth than five times the noise (from the
/// median).
Rig told_bundle(const Correspondences& data, const simulate::SimulatedSession& truth,
                const calibrate::Options& options);

}  // namespace procam::test
