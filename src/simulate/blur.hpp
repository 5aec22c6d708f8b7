#pragma once
/// Gaussian blur on the pixel grid.
#include "procam/core/base/image.hpp"

namespace procam::simulate::internal {

/// The discrete analogue of the Gaussian, k[n] = exp(-t) I_n(t) with t = sigma^2 (T. Lindeberg, "Scale-space
/// for discrete signals", PAMI 12(3), 1990): unlike the sampled Gaussian its variance is sigma^2 however
/// small sigma is. Returns k[0] .. k[radius], sum k[0] + 2 (k[1] + ...) = 1; {1} for sigma = 0.
std::vector<float> gaussian_kernel(double sigma);

/// One-channel image * kernel along x and y. Beyond the border the outermost pixels repeat.
ImageF convolve(const ImageF& image, const std::vector<float>& kernel);

/// One-channel image * Gaussian of many pixels: of the means of 16x16 pixels, linear between. For sigma above
/// 32 pixels.
ImageF low_pass(const ImageF& image, double sigma);

}  // namespace procam::simulate::internal
