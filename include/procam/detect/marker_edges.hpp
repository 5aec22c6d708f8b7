#pragma once
/// ArUco and AprilTag markers in one image, refined by procam's own last step: their edges, not their
/// corners.
///
/// A corner of a blurred marker is rounded, so a fit to the corner itself is biased inwards by a
/// fraction of the blur. The straight edges between are not. Every border between a black and a white cell
/// (the four sides, and inner ones where the cells are large enough) is cut into short pieces that keep away
/// from the borders' ends; each piece is modelled as
///   I(p) = (a + b Phi((d - d0) / s)) * lamp(p),
/// d the distance across the edge, Phi the normal distribution, lamp a ramp that the white round the marker
/// shows, and fitted by Gauss-Newton over the pixels themselves, so that its variance follows from its
/// residual. A homography, through the lens where it is known, is then fitted to all edges together with one
/// number that moves all edges towards white or black (ink spread, gamma, exposure), robustly: what a hand
/// covers is rejected. The corners are where it puts the square's corners; procam's pixel convention (integer
/// centres) holds independent of the detector's bias, which is only the start.
///
/// A marker whose cells are below 4.5 pixels has few such edges. It is fitted as a whole, known cells, blur,
/// light and gamma to all its pixels, and has corners with their covariance but no edges.
#include <filesystem>
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/board/marker_dictionary.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::detect {

/// The cells of a known dictionary.
PROCAM_EXPORT MarkerCells marker_cells(MarkerDictionary dictionary);

/// The cells of a dictionary of one's own, in OpenCV's file form (nmarkers, markersize, marker_0: "0110...").
/// Throws Error(kIo) when the file cannot be read, Error(kInput) when it is no such dictionary.
PROCAM_EXPORT MarkerCells load_marker_cells(const std::filesystem::path& path);

struct MarkerEdgeOptions {
  /// The camera, where it is known: edges that the lens bends are straightened. Without it a marker that
  /// fills the image of a wide lens has corners off by its bend.
  std::optional<Camera> camera;
};

/// All markers of the dictionary, by id; of two with one id the larger, with the remark "marker_twice".
/// Nothing found: no markers and "markers_not_found". Throws std::invalid_argument for an empty or
/// multi-channel image, or one whose size is not the camera's.
PROCAM_EXPORT MarkerDetections detect_marker_edges(const ViewU8& image, const MarkerCells& codes,
                                                   const MarkerEdgeOptions& options = {});

}  // namespace procam::detect
