#pragma once
/// Gray code: a projector's columns and rows written in black and white stripes, one bit a frame.
///
/// Frames, in the order of OpenCV's GrayCodePattern (step 1 is byte for byte the same):
///   column bits, most significant first, each as pattern and inverse;  row bits likewise;  white;  black.
/// A 1024x768 projector takes 20 + 20 + 2 = 42 frames. Bit b of stripe c is bit b of the reflected code c ^
/// (c >> 1) (F. Gray, US 2632058, 1953), so neighbouring stripes differ in one bit: an undecided bit at a
/// stripe's edge costs one stripe, not many.
///
/// decode() takes the captures of these frames and returns the column and row that each camera pixel sees.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/stripe_edge.hpp"

namespace procam::pattern {

/// What is shown: everything else follows from these two.
struct GrayCode {
  ImageSize projector_size;
  int step =
      1;  ///< stripe width in projector pixels; wider stripes survive a blurred projector, with fewer frames
};

/// 2 * (column bits + row bits) + 2.
PROCAM_EXPORT int frame_count(const GrayCode& gray_code);

/// For people, e.g. "frame 21 (row bit 9, inverse)".
PROCAM_EXPORT std::string frame_name(const GrayCode& gray_code, int index);
/// The picture for the projector: 0 and 255, one channel, projector_size.
PROCAM_EXPORT ImageU8 frame(const GrayCode& gray_code, int index);
/// All of them in order.
PROCAM_EXPORT std::vector<ImageU8> frames(const GrayCode& gray_code);

/// "42 frames for 1024x768 (columns 10 bits, rows 10 bits, white, black)".
PROCAM_EXPORT std::string describe(const GrayCode& gray_code);

struct DecodeOptions {
  /// White minus black, in grey levels, below which a pixel counts as unlit (shadow, or too dark to read).
  int min_contrast = 5;
  /// A bit is decided when pattern and inverse differ by this many standard deviations of their difference.
  /// Noise alone passes all of six fine bits in one pixel of a thousand, while an error on a stripe's edge
  /// costs one stripe; higher values leave gaps along the stripes' edges.
  double bit_sigmas = 1.0;
};

/// Reads the stripe codes back: bit = pattern brighter than inverse. A coordinate is undecoded where the
/// pixel is unlit, where one of its bits is undecided, or where the code lies beyond the projector.
///
/// The noise is measured: pattern + inverse of every pair is the same light, so their differences are noise
/// alone. Throws procam::Error (kInput), naming the frame, if the number of captures, their sizes or channels
/// are wrong, or if white is darker than black. Remarks (low contrast, saturation, wrong projector size,
/// frames out of order) are in the result's diagnostics.
///
/// `reuse` is an unused map whose memory is used again: fresh memory costs as much time as the
/// decoding.
PROCAM_EXPORT DecodedMap decode(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                                const DecodeOptions& options = {}, DecodedMap reuse = {});

}  // namespace procam::pattern
