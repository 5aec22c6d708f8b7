#pragma once
/// FrameSequence: what a projector shows in a sequence of frames, each by its axis, kind and parameters, in
/// any order. The patterns of other programs are described so; frames and decoding are in
/// pattern/frame_sequence.hpp.
#include <array>
#include <vector>

#include "procam/core/rig/stripe_edge.hpp"

namespace procam {

struct SequenceFrame {
  enum class Kind {
    kGray,    ///< one bit of a Gray code, in black and white
    kPhase,   ///< one step of a cosine wave
    kWhite,   ///< full light
    kBlack,   ///< none
    kIgnored  ///< captured with the others, and not used
  };
  Kind kind = Kind::kIgnored;
  StripeAxis axis = StripeAxis::kColumn;  ///< of kGray and kPhase
  int bit = 0;                            ///< of kGray: significance, 0 is the finest
  bool inverse = false;                   ///< of kGray: black and white exchanged
  double period = 0;                      ///< of kPhase: projector pixels
  double phase = 0;                       ///< of kPhase: radians
};

/// With projector pixel x along the frame's axis (the centre of the first pixel is 0):
///   kGray   white where bit `bit` of g ^ (g >> 1) is set, g = floor(x / step) + offset of the axis
///   kPhase  1/2 + 1/2 cos(2 pi x / period - phase) of full light
struct FrameSequence {
  int step = 1;                        ///< projector pixels a Gray-code stripe
  std::array<int, 2> offset = {0, 0};  ///< of the Gray code's numbers, columns and rows
  std::vector<SequenceFrame> frames;   ///< in the order of capture
};

}  // namespace procam
