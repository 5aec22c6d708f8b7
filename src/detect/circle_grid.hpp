#pragma once
/// Centres of a grid of dark discs in one image.
///
/// The image of a disc's rim is fitted to the pixels round it as a blurred ellipse,
///   I(p) = a + g_a . r + (b + g_b . r) erf(d(p) / (sqrt2 s)),   r = p - c,
///   d = (q - 1) q / |A r|,  q^2 = r^T A r   (signed distance to the ellipse, to first order),
/// by damped Gauss-Newton over centre c, shape A, blur s and the light.
///
/// An ellipse's centre is not where the disc's centre appears: perspective moves it by about the squared
/// radius times the map's second derivative: 0.1 px for discs 30 px wide on a 250 mm board tilted by 26
/// degrees. The observation is corrected for it: the known disc is drawn through the map of the whole board
/// (homography and a simple lens, fitted to all centres), the centre of its ellipse is compared with the
/// mapped centre, and the difference is added. `diameter` must therefore be the printed one: the correction
/// grows with its square.
#include "procam/core/base/image.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/detect/detect_board.hpp"

namespace procam::detect {

using CircleGridOptions = BoardOptions::Circles;

/// The discs' centres, each with its covariance. All discs must show: nothing says which one a disc is but
/// its place among the others. Where the board looks the same turned (CircleGrid::is_symmetric_180) its
/// first point is the one towards the image's top left; never mirrored.
///
/// Without a board the observations are empty and the diagnostics say "board_not_found"; "circles_left_out"
/// counts those that could not be refined. Throws std::invalid_argument for an empty or multi-channel image
/// or a board with a flaw().
Detections detect_circle_grid(const ViewU8& image, const CircleGrid& board,
                              const CircleGridOptions& options = {});

}  // namespace procam::detect
