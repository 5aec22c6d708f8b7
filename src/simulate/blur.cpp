#include "blur.hpp"

#include <algorithm>
#include <cmath>

namespace procam::simulate::internal {
namespace {

/// As std::lgamma(), which writes a variable of the whole process (signgam): views are blurred by several threads.
double thread_safe_lgamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

/// exp(-t) I_n(t) by the power series of the modified Bessel function; all terms positive, so nothing
/// cancels.
double bessel_weight(int n, double t) {
  double term = std::exp(n * std::log(0.5 * t) - thread_safe_lgamma(n + 1.0) - t);
  double sum = term;
  for (int k = 1; term > 1e-18 * sum; ++k) {
    term *= 0.25 * t * t / (double(k) * (k + n));
    sum += term;
  }
  return sum;
}

}  // namespace

std::vector<float> gaussian_kernel(double sigma) {
  if (!(sigma > 0)) return {1.f};
  const double t = sigma * sigma;
  std::vector<double> weights{bessel_weight(0, t)};
  double sum = weights[0];
  while (weights.back() > 1e-6) {
    weights.push_back(bessel_weight(int(weights.size()), t));
    sum += 2 * weights.back();
  }
  std::vector<float> kernel;
  for (const double weight : weights) kernel.push_back(float(weight / sum));
  return kernel;
}

ImageF convolve(const ImageF& image, const std::vector<float>& kernel) {
  if (kernel.size() <= 1) return image;
  const int width = image.width(), height = image.height(), radius = int(kernel.size()) - 1;
  ImageF along_x(image.size());
  std::vector<float> padded(std::size_t(width + 2 * radius));
  for (int y = 0; y < height; ++y) {
    const float* in = image.row(y);
    std::fill_n(padded.begin(), radius, in[0]);
    std::copy_n(in, width, padded.begin() + radius);
    std::fill_n(padded.end() - radius, radius, in[width - 1]);
    const float* middle = padded.data() + radius;
    float* out = along_x.row(y);
    for (int x = 0; x < width; ++x) out[x] = kernel[0] * middle[x];
    for (int k = 1; k <= radius; ++k)
      for (int x = 0; x < width; ++x) out[x] += kernel[std::size_t(k)] * (middle[x - k] + middle[x + k]);
  }
  ImageF result(image.size());
  for (int y = 0; y < height; ++y) {
    float* out = result.row(y);
    const float* middle = along_x.row(y);
    for (int x = 0; x < width; ++x) out[x] = kernel[0] * middle[x];
    for (int k = 1; k <= radius; ++k) {
      const float* above = along_x.row(std::max(y - k, 0));
      const float* below = along_x.row(std::min(y + k, height - 1));
      for (int x = 0; x < width; ++x) out[x] += kernel[std::size_t(k)] * (above[x] + below[x]);
    }
  }
  return result;
}

ImageF low_pass(const ImageF& image, double sigma) {
  constexpr int kBlock = 16;
  const int columns = (image.width() + kBlock - 1) / kBlock, rows = (image.height() + kBlock - 1) / kBlock;
  ImageF means(columns, rows);
  for (int row = 0; row < rows; ++row) {
    const int end_y = std::min((row + 1) * kBlock, image.height());
    for (int column = 0; column < columns; ++column) {
      const int begin_x = column * kBlock, end_x = std::min(begin_x + kBlock, image.width());
      double sum = 0;
      for (int y = row * kBlock; y < end_y; ++y)
        for (int x = begin_x; x < end_x; ++x) sum += image.at(x, y);
      means.at(column, row) = float(sum / (double(end_x - begin_x) * (end_y - row * kBlock)));
    }
  }
  const ImageF smooth = convolve(means, gaussian_kernel(sigma / kBlock));
  ImageF result(image.size());
  for (int y = 0; y < image.height(); ++y) {
    const float v = std::clamp((float(y) + 0.5f) / kBlock - 0.5f, 0.f, float(rows - 1));
    const int above = std::min(int(v), std::max(rows - 2, 0)), below = std::min(above + 1, rows - 1);
    const float down = v - float(above);
    float* out = result.row(y);
    for (int x = 0; x < image.width(); ++x) {
      const float u = std::clamp((float(x) + 0.5f) / kBlock - 0.5f, 0.f, float(columns - 1));
      const int left = std::min(int(u), std::max(columns - 2, 0)), right = std::min(left + 1, columns - 1);
      const float across = u - float(left);
      out[x] = (1 - down) * ((1 - across) * smooth.at(left, above) + across * smooth.at(right, above)) +
               down * ((1 - across) * smooth.at(left, below) + across * smooth.at(right, below));
    }
  }
  return result;
}

}  // namespace procam::simulate::internal
