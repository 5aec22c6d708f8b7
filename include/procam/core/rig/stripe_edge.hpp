#pragma once
/// StripeEdge: one sub-pixel measurement "this camera position sees this projector coordinate".
///
/// A stripe edge knows one projector coordinate only (x of a column boundary, y of a row boundary). Its error
/// is along the camera axis that was scanned; the residual of a model that maps camera to projector pixels is
/// (modelled coordinate - projector_coordinate) / (|d coordinate / d scan| * sigma_px).
#include <cstdint>

#include "procam/core/base/types.hpp"

namespace procam {

/// The projector coordinate that a stripe pattern encodes.
enum class StripeAxis : std::uint8_t {
  kColumn,  ///< vertical stripes: projector x
  kRow      ///< horizontal stripes: projector y
};

/// The camera direction in which neighbouring pixels were compared.
enum class ScanAxis : std::uint8_t { kCameraX, kCameraY };

struct StripeEdge {
  Vec2 camera_pixel;                ///< integer across the scan, sub-pixel along it
  double projector_coordinate = 0;  ///< the boundary, e.g. k*step - 1/2
  double sigma_px = 0;  ///< expected standard deviation of camera_pixel along the scan, camera pixels
  StripeAxis axis = StripeAxis::kColumn;
  ScanAxis scan = ScanAxis::kCameraX;
};

}  // namespace procam
