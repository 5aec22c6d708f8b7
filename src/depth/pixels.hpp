#pragma once
/// The work on every pixel, eight at a time: readings to inverse depths, sums over a cell, labels of a cell.
/// Compiled for AVX2 and for any processor, with the same bits; which of them runs is chosen when the program
/// runs.
#include <array>
#include <cstddef>
#include <cstdint>

namespace procam::depth::internal {

inline constexpr int kLanes = 8;  ///< pixels worked on together: a cell's row

/// Rows of a cell, each eight numbers: `begin`, begin + stride, ...
struct CellRows {
  const float* begin = nullptr;
  std::ptrdiff_t stride = 0;
};

/// Of inverse depths q, 0 where there is none, and rays (u, v) of a cell.
struct CellInput {
  CellRows q, u, v;
};

/// Sums over a cell's readings of p = q - q0 and of x = focal (u - u0), y = focal (v - v0), pixels about
/// (u0, v0).
struct Sums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, p = 0, xp = 0, yp = 0, pp = 0;
};
/// What the sums are about.
struct SumsAbout {
  float focal = 1, u0 = 0, v0 = 0, q0 = 0;
};

inline constexpr std::size_t kMaxCandidates = 4;

/// Planes 1/z = a u + b v + c that a cell's pixels may be of: of those less than `gate` away the nearest.
struct Candidates {
  std::size_t count = 0;
  float gate = 0;
  std::array<std::int32_t, kMaxCandidates> id{};
  std::array<float, kMaxCandidates> a{}, b{}, c{};
};

/// The labels of a cell's pixels, row by row.
struct LabelRows {
  std::int16_t* begin = nullptr;
  std::ptrdiff_t stride = 0;
};
/// Labels of pixels that no candidate gets.
struct OtherLabels {
  std::int16_t no_plane = 0;    ///< no candidate is near
  std::int16_t no_reading = 0;  ///< no inverse depth
};

struct PixelKernels {
  /// 1 / (unit * in), 0 where that is outside nearest .. farthest. `count` is a multiple of kLanes.
  void (*invert_units)(const std::uint16_t* in, int count, float unit, float nearest, float farthest,
                       float* out);
  /// 1 / in, likewise, also for what is not finite.
  void (*invert_metres)(const float* in, int count, float nearest, float farthest, float* out);
  /// True when all 64 pixels have a reading: then those of the sums that p is part of.
  bool (*sum_whole)(const CellInput& cell, const SumsAbout& about, Sums& sums);
  /// All sums over those that have.
  void (*sum_some)(const CellInput& cell, const SumsAbout& about, Sums& sums);
  /// Labels of `rows` rows. Adds to `pixels` how many each candidate got.
  void (*label)(const CellInput& cell, int rows, const Candidates& of, const OtherLabels& others,
                const LabelRows& labels, std::array<int, kMaxCandidates>& pixels);
};
/// Those that suit this processor, or were last asked for by use_pixel_kernels().
const PixelKernels& pixel_kernels();

enum class PixelPath { kAnyProcessor, kAvx2 };
/// For tests, which compare them. False, and nothing changes, where this processor cannot run them.
bool use_pixel_kernels(PixelPath path);

}  // namespace procam::depth::internal
