#pragma once
/// What a true lens does beyond its model: a device whose model projects a point to p shows it at p + d(p), with d a smooth
/// displacement, of which the model's own parameters can take nothing (core/lens/lens_change.hpp). Real lenses
/// have some hundredths of a pixel (T. Schoeps et al., "Why Having 10,000 Parameters in Your Camera Model Is Better Than
/// Twelve", CVPR 2020).
///
/// d is a sum of six plane waves an axis, of random direction and phase, half a wave to three across the picture's width.
#include <cstdint>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::simulate {

class LensDeviation {
 public:
  LensDeviation() = default;
  /// `rms_px` of |d| over the picture. Equal seeds make equal deviations.
  PROCAM_EXPORT LensDeviation(const Camera& lens, double rms_px, std::uint64_t seed);

  bool empty() const { return nodes_.size().width == 0; }
  /// d(p), pixels; as at its border beyond the picture.
  PROCAM_EXPORT Vec2 at(const Vec2& pixel) const;

 private:
  ImageF nodes_;  ///< two channels: d every 16 pixels, linear between
};

}  // namespace procam::simulate
