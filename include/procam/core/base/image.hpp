#pragma once
/// Pixels in memory: ImageView looks at them, Image owns them. No file formats here (see io) and no OpenCV.
///
/// Rows are `stride` elements apart; channels are interleaved. Pixel (x, y) has its centre at (x, y).
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/types.hpp"

namespace procam {

/// A non-owning look at interleaved pixels of type T (const T for read-only).
template <typename T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  int channels = 1;
  std::ptrdiff_t stride = 0;  ///< elements (not bytes) from one row to the next

  ImageView() = default;
  ImageView(T* pixels, int w, int h, int c = 1, std::ptrdiff_t row_stride = 0)
      : data(pixels),
        width(w),
        height(h),
        channels(c),
        stride(row_stride != 0 ? row_stride : std::ptrdiff_t(w) * c) {}
  /// A view that writes can be looked at by one that reads.
  template <typename U,
            typename = std::enable_if_t<std::is_same<const U, T>::value && !std::is_same<U, T>::value>>
  ImageView(const ImageView<U>& other)
      : ImageView(other.data, other.width, other.height, other.channels, other.stride) {}

  bool empty() const { return width <= 0 || height <= 0; }
  ImageSize size() const { return {width, height}; }
  T* row(int y) const { return data + y * stride; }
  T& at(int x, int y, int c = 0) const { return data[y * stride + std::ptrdiff_t(x) * channels + c]; }
};

/// Owns its pixels, rows without gaps.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels = 1, T fill = T())
      : width_(width), height_(height), channels_(channels) {
    require(width >= 0 && height >= 0 && channels >= 1, "Image: negative size or no channel");
    pixels_.assign(std::size_t(width) * std::size_t(height) * std::size_t(channels), fill);
  }
  explicit Image(ImageSize size, int channels = 1, T fill = T())
      : Image(size.width, size.height, channels, fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  ImageSize size() const { return {width_, height_}; }
  bool empty() const { return pixels_.empty(); }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  T* row(int y) { return pixels_.data() + std::ptrdiff_t(y) * width_ * channels_; }
  const T* row(int y) const { return pixels_.data() + std::ptrdiff_t(y) * width_ * channels_; }
  T& at(int x, int y, int c = 0) { return row(y)[std::ptrdiff_t(x) * channels_ + c]; }
  const T& at(int x, int y, int c = 0) const { return row(y)[std::ptrdiff_t(x) * channels_ + c]; }

  ImageView<T> view() { return {pixels_.data(), width_, height_, channels_}; }
  ImageView<const T> view() const { return {pixels_.data(), width_, height_, channels_}; }
  operator ImageView<T>() { return view(); }
  operator ImageView<const T>() const { return view(); }

 private:
  int width_ = 0, height_ = 0, channels_ = 1;
  std::vector<T> pixels_;
};

using ImageU8 = Image<std::uint8_t>;
using ImageF = Image<float>;
using ViewU8 = ImageView<const std::uint8_t>;
using ViewF = ImageView<const float>;

}  // namespace procam
