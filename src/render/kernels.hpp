#pragma once
/// The work on rows of pixels: in plain C++, by Highway in vectors of 256 bits (AVX2) or 128 (NEON) and, where
/// most time goes on x86, of 512 (AVX-512 with VBMI and VNNI). All give the same bits; which of them runs is
/// chosen when the program runs.
///
/// Two kinds of pixel, both RGBA, premultiplied:
///   Light: 16 bits, 0..kFull. What is averaged: light, or values as they stand times 128.
///   Value: 8 bits, 0..255. For plain interpolation of values, as fast as it goes.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "procam/core/base/export.hpp"

namespace procam::render {

/// The part of the frame that is drawn at a time: wide, as memory is read and written in long runs; low, so
/// that it stays in the cache.
inline constexpr int kTileWidth = 128, kTileHeight = 16;
inline constexpr int kLanes = 8;                      ///< pixels that the kernels work on together
inline constexpr int kRowRoom = kTileWidth + kLanes;  ///< rows of pixels are written in whole groups

using Light = std::int16_t;
using Value = std::uint8_t;
inline constexpr int kFull = 255 * 128;  ///< full light, and an alpha of 1

inline constexpr float kRowsAhead = 3;  ///< how far ahead memory is asked for

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

/// Beyond the horizon (only under pixels that the content touches in part) q_z is taken as this: somewhere at
/// the border.
inline constexpr float kMinDepth = 1e-9f;

/// Is q linear in s, as without a lens? Then the squares' products add nothing, to the bit.
inline bool is_straight(const RowMap& row) {
  return row.q[6] == 0 && row.q[7] == 0 && row.q[8] == 0;
}

/// Samples of one pixel: a regular grid of across x down points, spread over these shares of its sides.
struct FilterGrid {
  int level = 0;
  int across = 1, down = 1;
  float share_across = 0, share_down = 0;
};
inline constexpr int kMaxTaps = 128;  ///< across * down: what 32-bit sums hold

/// A picture ready to be sampled. One more column and row than the picture has, copies of the last.
template <typename Pixel>
struct TexelsView {
  const Pixel* data = nullptr;  ///< 4 a texel; Values less 128, as signed bytes are
  int width = 0, height = 0;
  int stride = 0;  ///< texels
};

/// Positions in these parts of a texel fit 32 bits and rows of texels 16, if this holds.
inline constexpr float kStepsAcross = 128, kStepsDown = 65536;
inline bool has_short_sides(const TexelsView<Value>& texels) {
  return texels.height < 32768 && texels.stride < 32768;
}

/// Where the pixels of a row look: texels from the first; the two bytes 128 - right and right, of 128; and in
/// the lower 16 bits how far down, of 2^15.
constexpr int kCellRoom = kTileWidth + 16;  ///< they are found and read in whole groups
struct RowCells {
  alignas(64) std::int32_t offset[kCellRoom], shares[kCellRoom], down[kCellRoom];

  /// [begin, end) look at the first texel.
  void clear(int begin, int end) {
    for (std::int32_t* const numbers : {offset, shares, down}) std::fill(numbers + begin, numbers + end, 0);
  }
};

/// The rays of a tile's pixels, and of one pixel more on each side, row by row; NaN: none.
inline constexpr int kRayAcross = kTileWidth + 2, kRayDown = kTileHeight + 2;
inline constexpr int kRayRoom = kRayAcross * kRayDown + kLanes;
constexpr int ray_place(int x, int y) {  ///< of a pixel, in the tile
  return (y + 1) * kRayAcross + x + 1;
}
inline constexpr int kNeighbours[] = {-kRayAcross - 1, -kRayAcross, -kRayAcross + 1, -1, 1,
                                      kRayAcross - 1,  kRayAcross,  kRayAcross + 1};
struct Rays {
  alignas(32) float x[kRayRoom], y[kRayRoom], z[kRayRoom];
};

/// A part of a plane that rays d meet: inside where borders . d >= 0 for all (of a triangle three, of a
/// plane's content four), nearness . d = 1 / distance in lengths of d, content coordinates q = content d.
struct Facet {
  float borders[4][3];
  float nearness[3];
  float content[3][3];
};
/// Pixels [x0, x1) x [y0, y1) whose middles a facet may touch, also just outside the frame.
struct FacetBox {
  std::int16_t x0, y0, x1, y1;
  std::int32_t facet;
};
/// What a surface shows at each of those rays; facet -1: nothing, and nearness 0.
struct Hits {
  alignas(32) float nearness[kRayRoom];
  std::int32_t facet[kRayRoom];
};
/// Share of a step that is none whatever the facets say: on a mesh of tiny facets theirs is not the
/// surface's direction.
inline constexpr float kLevel = 0.125f;

/// A bit for each pixel of a tile's row.
static_assert(kTileWidth == 128);
struct RowBits {
  std::uint64_t words[2] = {};

  bool operator[](int x) const { return (words[x / 64] >> (x % 64) & 1) != 0; }
  void set(int x) { words[x / 64] |= std::uint64_t(1) << (x % 64); }
  void set(int begin, int end) {
    for (const int word : {0, 1}) {
      const int first = std::max(begin - 64 * word, 0), last = std::min(end - 64 * word, 64);
      if (first < last) words[word] |= ~std::uint64_t(0) >> (64 - (last - first)) << first;
    }
  }
  RowBits operator&(const RowBits& other) const {
    return {{words[0] & other.words[0], words[1] & other.words[1]}};
  }
  RowBits operator~() const { return {{~words[0], ~words[1]}}; }
  /// One after the last that is set; 0: none.
  int end() const {
    if (words[1] != 0) return 128 - __builtin_clzll(words[1]);
    return words[0] != 0 ? 64 - __builtin_clzll(words[0]) : 0;
  }
  /// The first of [x, end) that is set; end: none.
  int first(int x, int end) const {
    while (x < end) {
      const std::uint64_t left = words[x / 64] >> (x % 64);
      if (left != 0) return std::min(x + __builtin_ctzll(left), end);
      x = (x / 64 + 1) * 64;
    }
    return end;
  }
};
/// Where the pixels of a row look, as fractions of the content, as in Points.
struct TexCoords {
  alignas(32) float of[6][kRowRoom];  ///< u, v, u_x, v_x, u_y, v_y
};

struct Kernels {
  /// Fills pixels [begin, end) of `points`, and some after them; the slopes only if asked for.
  void (*locate)(const RowMap& row, int begin, int end, bool slopes, Points& points);
  /// Writes count pixels to `to`, or up to the next multiple of kLanes, from points [begin, begin + count).
  void (*sample_values)(const TexelsView<Value>& texels, const Points& points, int begin, int count,
                        Value* to);
  /// What locate and sample_values do, in loops that the processor looks ahead in. First where pixels
  /// [begin, end) look, into the cells from `at` on, and some after them, all in the picture. (u, v) of the
  /// row are in 1 / kStepsAcross and 1 / kStepsDown of a texel.
  void (*find_cells)(const TexelsView<Value>& texels, const RowMap& row, int begin, int end, int at,
                     RowCells& cells);
  /// Then as sample_values. `soon` as in Points. Reads cells up to the next multiple of 16.
  void (*sample_cells)(const TexelsView<Value>& texels, const RowCells& cells, std::ptrdiff_t soon, int count,
                       Value* to);
  void (*sample_light)(const TexelsView<Light>& texels, const FilterGrid& taps, const Points& points,
                       int begin, int count, Light* to);
  /// What was drawn over what was there.
  void (*values_over)(const Value* drawn, int count, Value* there);
  void (*light_over)(const Light* drawn, int count, Light* there);
  /// What was drawn keeps the share that the mask's alpha says.
  void (*values_alpha)(const Value* mask, int count, Value* drawn);
  void (*light_alpha)(const Light* mask, int count, Light* drawn);
  /// The colours as 3 bytes a pixel; exactly count of them.
  void (*values_to_rgb)(const Value* from, int count, std::uint8_t* to);
  /// 3 bytes a texel as opaque texels of a TexelsView; exactly count of them.
  void (*rgb_to_texels)(const std::uint8_t* from, int count, Value* to);
  /// `count` rays from place `first` on; d(s) = q, s as in the map.
  void (*follow)(const RowMap& row, int first, int count, Rays& rays);
  /// Change of `count` rays towards the one `step` places on: half the way between the neighbours, or as far
  /// as there are any.
  void (*find_slopes)(const Rays& rays, int step, int first, int count, Rays& slopes);
  /// Finds what the rays of the tile that begins at pixel (x, y) hit, its rim's as well: of each the nearest
  /// facet, or the first of those. Looks at the first `borders` borders.
  void (*cast)(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x, int y,
               const Rays& rays, Hits& hits);
  /// Which of `count` pixels hit something; and which are edges: pixels one of whose neighbours shows
  /// nothing, or another part of the surface behind or before it, by over `kLevel * step` of its nearness and
  /// by over `step` of what the pixel's facet would have there. Or that show nothing, and a neighbour does.
  /// NaN: no neighbour.
  void (*find_steps)(const Facet* facets, const Rays& rays, const Hits& hits, int first, int count,
                     float step, RowBits& met, RowBits& edges);
  /// Where `count` pixels look; 0 where they hit nothing.
  void (*look)(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down, const Hits& hits,
               int first, int count, bool slopes, TexCoords& texcoords);
};

extern const Kernels kPlainKernels;
/// By Highway: there where it was found, on x86 for machines with AVX2 and on 64-bit ARM for all.
extern const Kernels kWideKernels;
/// Replaces those that there are in vectors of 512 bits. `gathers`: texels are read by gather
/// instructions, else one by one.
void use_widest(Kernels& kernels, bool gathers);
/// Does this machine gather faster than it loads one by one? Intel's do; AMD's split a gather into more steps
/// than the loads take (a frame takes 1.25 times as long on Zen 4).
PROCAM_EXPORT bool gathers_fast();
/// Those for vectors of at most so many bits, of those that this machine has; 0: plain code.
PROCAM_EXPORT const Kernels& kernels_for(int vector_bits, bool gathers = gathers_fast());
/// The best this machine has.
inline const Kernels& best_kernels() {
  return kernels_for(512);
}

}  // namespace procam::render
