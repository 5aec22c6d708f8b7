#pragma once
/// A depth image as cameras give it, and how far it may be off.
///
/// A pixel holds the depth z along the optical axis (not the distance along the ray). Nothing was measured
/// where it is 0, negative or not finite.
#include <cmath>
#include <cstdint>

#include "procam/core/base/depth_pixels.hpp"

namespace procam::depth {

/// A look at a depth image: 16-bit units of `metres_per_unit`, or floats in metres.
struct DepthImage {
  ImageView<const std::uint16_t> units;
  double metres_per_unit = 0.001;
  ViewF metres;

  /// Throws std::invalid_argument for several channels, or a unit that is not positive and finite.
  DepthImage(ImageView<const std::uint16_t> depth, double unit) : units(depth), metres_per_unit(unit) {
    require(depth.channels == 1, "DepthImage: a depth image has one channel");
    require(unit > 0 && unit < 1, "DepthImage: the unit must be between 0 and 1 metre");
  }
  explicit DepthImage(ViewF depth) : metres(depth) {
    require(depth.channels == 1, "DepthImage: a depth image has one channel");
  }
  /// Of pixels that outlive it; the unit is that of 16-bit ones.
  DepthImage(const DepthPixels& pixels, double unit)
      : DepthImage(pixels.index() == 0 ? DepthImage(std::get<0>(pixels).view(), unit)
                                       : DepthImage(std::get<1>(pixels).view())) {}

  ImageSize size() const { return units.data ? units.size() : metres.size(); }
  /// Metres; 0 where nothing was measured.
  float at(int x, int y) const {
    if (units.data) return float(units.at(x, y) * metres_per_unit);
    const float z = metres.at(x, y);
    return z > 0 && z < 1e6f ? z : 0.0f;  // NaN fails the comparison
  }
};

/// Standard deviation of one reading at depth z: sigma(z) = a + b z + c z^2, metres, never below a tenth of a
/// millimetre.
///
/// Averaging does not improve all of it: neighbouring pixels share an error (quantised disparities form
/// bands, lens models are off). The error of the mean of a patch, independent of its size, is
///
///   correlated_sigma(z)^2 = (correlated_share sigma(z))^2 + correlated_floor^2
struct DepthNoise {
  double a = 0, b = 0, c = 0;
  double correlated_share = 1, correlated_floor = 0.004;

  double sigma(double z) const {
    const double s = a + (b + c * z) * z;
    return s > 1e-4 ? s : 1e-4;
  }
  double correlated_sigma(double z) const {
    const double s = correlated_share * sigma(z);
    return std::sqrt(s * s + correlated_floor * correlated_floor);
  }

  /// Structured light of the first Kinect: disparities of sigma 1/2 unit make 1.425e-3 z^2 (K. Khoshelham,
  /// S. O. Elberink, "Accuracy and resolution of Kinect depth data for indoor mapping applications", Sensors
  /// 12, 2012, equation 11), with what remains near the camera by C. V. Nguyen, S. Izadi, D. Lovell,
  /// "Modeling Kinect sensor noise", 3DIMPVT 2012, whose 0.0012 + 0.0019 (z - 0.4)^2 this is, multiplied out.
  static DepthNoise kinect_v1() { return {1.504e-3, -1.52e-3, 1.9e-3, 1.1, 0.004}; }
  /// Time of flight, facing the camera (P. Fankhauser et al., "Kinect v2 for mobile robot navigation:
  /// evaluation and modeling", ICAR 2015).
  static DepthNoise time_of_flight() { return {1.5e-3, -0.5e-3, 0.3e-3, 1, 0.005}; }
  /// Depths of scan-surfaces, Gray code or phase shift of a megapixel projector, as simulated at level paper: between edges of
  /// stripes they are interpolated, so that neighbours vary less (0.2 mm at 1.3 m) than what they share.
  static DepthNoise scan() { return {1e-4, 0, 5e-5, 1, 1e-3}; }
  /// Any stereo pair: sigma = z^2 disparity_sigma / (focal_px baseline).
  static DepthNoise stereo(double focal_px, double baseline, double disparity_sigma_px) {
    require(focal_px > 0 && baseline > 0 && disparity_sigma_px > 0,
            "DepthNoise::stereo: focal length, baseline and sigma must be positive");
    return {0, 0, disparity_sigma_px / (focal_px * baseline), 1, 0.004};
  }
};

}  // namespace procam::depth
