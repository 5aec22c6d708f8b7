#pragma once
/// Square markers (ArUco, AprilTag) in one image: ids, and corners from the four edges of the black border.
///
/// Each edge is fitted to the pixels round it as a blurred straight edge (or one with a given bend), and a
/// corner is where two of them cross: pixel centres at integers, whatever the detector that found the
/// marker believes. The covariance is that of the two edges at the crossing. Lens distortion bends the
/// edges of one marker too little to be measured from it alone: 0.15 px in the middle of a side of 100 px
/// near the rim of a wide lens. Boards with several markers know better (detect_marker_grid).
#include <array>
#include <string>
#include <vector>
#include "procam/detect/detect_board.hpp"

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/board/marker_dictionary.hpp"

namespace procam::detect {

/// What a dictionary's markers look like: for each id its code, row by row from the top left, '1' light.
struct MarkerCodes {
  int bits = 0;  ///< a side
  /// How many wrong bits may be corrected.
  int correctable_bits = 0;
  std::vector<std::string> codes;
  int border = 1;  ///< dark modules round the code
  /// Other dark squares touch the markers' corners (AprilGrid).
  bool corners_touched = false;

  int modules() const { return bits + 2 * border; }
};

/// ArUco's as OpenCV draws them; AprilTags as their authors' pictures stand, which is half a turn from
/// OpenCV's.
MarkerCodes marker_codes(MarkerDictionary dictionary);

struct Marker {
  int id = 0;
  std::array<Vec2, 4> corners;     ///< clockwise from the marker's own top left
  std::array<Mat2, 4> covariance;  ///< pixel^2
};

using MarkerOptions = BoardOptions::Markers;

/// All markers of the dictionary whose four edges are clear. Throws std::invalid_argument for an empty or
/// multi-channel image, or codes that are no squares of bits.
std::vector<Marker> detect_markers(const ViewU8& image, const MarkerCodes& codes,
                                   const MarkerOptions& options = {});
std::vector<Marker> detect_markers(const ViewU8& image, MarkerDictionary dictionary,
                                   const MarkerOptions& options = {});

}  // namespace procam::detect
