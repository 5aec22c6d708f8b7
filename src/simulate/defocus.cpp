#include "defocus.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/parallel.hpp"

namespace procam::simulate::internal {
namespace {

/// A disc whose border falls from 1 to 0 over one pixel.
double soft_disc(double radius, int x, int y) {
  return std::clamp(radius + 0.5 - std::hypot(x, y), 0.0, 1.0);
}

double variance_of(double radius) {
  const int reach = int(std::ceil(radius + 0.5));
  double sum = 0, moment = 0;
  for (int y = -reach; y <= reach; ++y)
    for (int x = -reach; x <= reach; ++x) {
      const double weight = soft_disc(radius, x, y);
      sum += weight;
      moment += weight * x * x;
    }
  return moment / sum;
}

/// Columns [first, end) of each row that hold anything.
std::vector<std::pair<int, int>> filled_columns(const ImageF& image) {
  std::vector<std::pair<int, int>> columns;
  for (int y = 0; y < image.height(); ++y) {
    const float *row = image.row(y), *end = row + image.width();
    const auto filled = [](float value) { return value != 0; };
    const float* first = std::find_if(row, end, filled);
    while (end > first && !filled(end[-1])) --end;
    columns.emplace_back(int(first - row), int(end - row));
  }
  return columns;
}

/// The share of each pixel that is drawn with disc `number`, -kDiscs + 1 .. kDiscs - 1, from far to near.
/// False: none of any.
bool shares_of(int number, const ImageF& signed_radius, ImageF& shares) {
  bool any = false;
  for (int y = 0; y < shares.height(); ++y)
    for (int x = 0; x < shares.width(); ++x) {
      const float radius = signed_radius.at(x, y);
      const bool this_side = number == 0 || (number > 0) == (radius > 0);
      shares.at(x, y) = this_side ? disc_mix(std::abs(radius), kDiscRadii).share(std::abs(number)) : 0;
      any = any || shares.at(x, y) > 0;
    }
  return any;
}

ImageF product(const ImageF& a, const ImageF& b) {
  ImageF result(a.size());
  const std::ptrdiff_t count = std::ptrdiff_t(a.width()) * a.height();
  std::transform(a.data(), a.data() + count, b.data(), result.data(), [](float p, float q) { return p * q; });
  return result;
}

/// Pictures put together from far to near.
class Stack {
 public:
  Stack(std::size_t pictures, ImageSize size, int threads)
      : pictures_(pictures, ImageF(size)), known_(size), threads_(threads) {}

  /// The next nearer layer: the pictures' part that `shares` says, through the kernel.
  void add(const std::vector<ImageF>& pictures, const ImageF& shares, const DiscKernel& kernel) {
    const ImageSize size = shares.size();
    // Near the border a part of the kernel has nothing to gather.
    const ImageF whole = convolve(ImageF(size, 1, 1.f), kernel, threads_);
    const ImageF cover = convolve(shares, kernel, threads_);
    const ImageF behind = is_hidden_behind(cover, whole) ? convolve(known_, kernel, threads_) : ImageF();
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const ImageF layer = convolve(product(pictures[i], shares), kernel, threads_);
      const ImageF beside =
          behind.empty() ? ImageF() : convolve(product(pictures_[i], known_), kernel, threads_);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          if (!(cover.at(x, y) > 0)) continue;
          const float alpha = cover.at(x, y) / whole.at(x, y);
          const Through through = through_of(alpha, known_.at(x, y));
          float sum = layer.at(x, y) / whole.at(x, y) + through.seen * pictures_[i].at(x, y);
          float weight = alpha + through.seen;
          if (!behind.empty() && behind.at(x, y) > 1e-3f * whole.at(x, y)) {
            sum += through.hidden * beside.at(x, y) / behind.at(x, y);
            weight += through.hidden;
          }
          pictures_[i].at(x, y) = sum / weight;
        }
    }
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        known_.at(x, y) = std::min(1.f, known_.at(x, y) + cover.at(x, y) / whole.at(x, y));
  }
  std::vector<ImageF> take() { return std::move(pictures_); }

 private:
  std::vector<ImageF> pictures_;
  ImageF known_;  ///< share of each pixel that has been seen by now
  int threads_;

  /// What shows through a layer, as far as it was seen, and what nobody saw.
  struct Through {
    float seen, hidden;
  };
  static Through through_of(float alpha, float known) {
    const float open = std::max(1 - alpha, 0.f), seen = std::min(known, open);
    return {seen, open - seen};
  }
  bool is_hidden_behind(const ImageF& cover, const ImageF& whole) const {
    for (int y = 0; y < cover.height(); ++y)
      for (int x = 0; x < cover.width(); ++x) {
        const float alpha = cover.at(x, y) / whole.at(x, y);
        if (alpha > 0 && through_of(alpha, known_.at(x, y)).hidden > 0.02f) return true;
      }
    return false;
  }
};

}  // namespace

double disc_radius(const ThinLens& lens, const Camera& device, double depth) {
  const double focal_length = std::sqrt(device.intrinsics.fx * device.intrinsics.fy);
  const double radius = 0.5 * lens.aperture * focal_length * (1 / depth - 1 / lens.focus);
  return std::clamp(radius, -kDiscRadii.back(), kDiscRadii.back());
}

DiscKernel disc_kernel(double radius) {
  if (!(radius > 0)) return {};
  double low = 0, high = radius + 1;  // of the soft disc with the disc's variance
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (variance_of(middle) < 0.25 * radius * radius ? low : high) = middle;
  }
  DiscKernel kernel{int(std::ceil(high + 0.5)) - 1, {}};
  double sum = 0;
  for (int y = -kernel.reach; y <= kernel.reach; ++y)
    for (int x = -kernel.reach; x <= kernel.reach; ++x) sum += soft_disc(high, x, y);
  for (int y = -kernel.reach; y <= kernel.reach; ++y)
    for (int x = -kernel.reach; x <= kernel.reach; ++x)
      kernel.weights.push_back(float(soft_disc(high, x, y) / sum));
  return kernel;
}

ImageF convolve(const ImageF& image, const DiscKernel& kernel, int threads) {
  if (kernel.reach == 0) return image;
  const int width = image.width(), height = image.height(), reach = kernel.reach, side = 2 * reach + 1;
  const std::vector<std::pair<int, int>> filled = filled_columns(image);
  ImageF result(image.size());
  parallel_for(height, threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y)
      for (int j = std::max(-reach, -y); j <= std::min(reach, height - 1 - y); ++j) {
        const float* weights = kernel.weights.data() + (j + reach) * side + reach;
        const auto [first, last] = filled[std::size_t(y + j)];
        if (first >= last) continue;
        for (int i = -reach; i <= reach; ++i) {
          const float weight = weights[i], *in = image.row(y + j);
          if (!(weight > 0)) continue;
          float* out = result.row(y) + i;
          const int from = std::max(first, -i), to = std::min(last, width - i);
          for (int x = from; x < to; ++x) out[x] += weight * in[x];
        }
      }
  });
  return result;
}

void defocus(std::vector<ImageF>& pictures, const ImageF& signed_radius, int threads) {
  Stack stack(pictures.size(), signed_radius.size(), threads);
  ImageF shares(signed_radius.size());
  for (int number = 1 - kDiscs; number < kDiscs; ++number)
    if (shares_of(number, signed_radius, shares))
      stack.add(pictures, shares, disc_kernel(kDiscRadii[std::size_t(std::abs(number))]));
  pictures = stack.take();
}

}  // namespace procam::simulate::internal
