#pragma once
/// The work on rows of pixels, once in plain C++ and once in the vectors that many machines have (AVX2). Both
/// give the same bits; which of them runs is chosen when the program runs.
///
/// Two kinds of pixel, both RGBA, premultiplied:
///   Light: 16 bits, 0..kFull. What is averaged: light, or values as they stand times 128.
///   Value: 8 bits, 0..255. For plain interpolation of values, as fast as it goes.
#include <cstddef>
#include <cstdint>

namespace procam::render {

/// The part of the frame that is drawn at a time: wide, as memory is read and written in long runs; low, so
/// that it stays in the cache.
inline constexpr int kTileWidth = 128, kTileHeight = 16;
inline constexpr int kLanes = 8;                      ///< pixels that the kernels work on together
inline constexpr int kRowRoom = kTileWidth + kLanes;  ///< rows of pixels are written in whole groups

using Light = std::int16_t;
using Value = std::uint8_t;
inline constexpr int kFull = 255 * 128;  ///< full light, and an alpha of 1

/// Where a row of pixels looks into the content, in texels of one level from the content's corner, and how
/// that changes by one pixel to the right (x) and down (y).
struct Points {
  alignas(32) float u[kRowRoom] = {}, v[kRowRoom] = {};
  /// Texels from where a pixel looks to where one a little further down does: that memory is asked for ahead.
  std::ptrdiff_t soon = 0;
  alignas(32) float u_x[kRowRoom] = {}, v_x[kRowRoom] = {}, u_y[kRowRoom] = {}, v_y[kRowRoom] = {};
};

/// A row of pixels of one piece of the lens map: q(s) = q[0] + s (q[1] + s q[2]), s = s0 + i ds for the
/// tile's i-th pixel; (u, v) = (q_x, q_y) / q_z, and `down` is dq / d(pixel down) likewise.
struct RowMap {
  float s0, ds;
  alignas(16) float q[12], down[12];  ///< [3 power of s + (x, y, z)], three to fill the vectors
};

/// Samples of one pixel: a regular grid of across x down points, spread over these shares of its sides.
struct Taps {
  int level = 0;
  int across = 1, down = 1;
  float share_across = 0, share_down = 0;
};
inline constexpr int kMostTaps = 128;  ///< across * down: what 32-bit sums hold

/// A picture ready to be sampled. One more column and row than the picture has, copies of the last.
template <typename Pixel>
struct TexelsView {
  const Pixel* data = nullptr;  ///< 4 a texel; Values less 128, as signed bytes are
  int width = 0, height = 0;
  int stride = 0;  ///< texels
};

struct Kernels {
  /// Fills pixels [begin, end) of `points`, and some after them; the slopes only if asked for.
  void (*locate)(const RowMap& row, int begin, int end, bool slopes, Points& points);
  /// Writes count pixels to `to`, rounded up to a multiple of kLanes, from points [begin, begin + count).
  void (*sample_values)(const TexelsView<Value>& texels, const Points& points, int begin, int count,
                        Value* to);
  void (*sample_light)(const TexelsView<Light>& texels, const Taps& taps, const Points& points, int begin,
                       int count, Light* to);
  /// What was drawn over what was there.
  void (*values_over)(const Value* drawn, int count, Value* there);
  void (*light_over)(const Light* drawn, int count, Light* there);
  /// The colours as 3 bytes a pixel; exactly count of them.
  void (*values_to_rgb)(const Value* from, int count, std::uint8_t* to);
};

extern const Kernels kPlainKernels;
/// The best this machine has.
const Kernels& best_kernels();

}  // namespace procam::render
