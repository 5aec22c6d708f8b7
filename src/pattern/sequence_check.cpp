#include "procam/pattern/sequence_check.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "sequence.hpp"
#include "sequence_causes.hpp"
#include "survey.hpp"
#include "wrong_frame.hpp"

namespace procam::pattern {
namespace {

using namespace internal;

constexpr int kFewPairs = 6;

}  // namespace

SequenceCheck check_sequence(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                             const Points2& on_board) {
  check_captures(captures, gray_code);
  SequenceCheck check;
  SequenceFrames frames{captures, {}, captures[captures.size() - 2], captures.back()};
  for (int i = 0; i + 3 < int(captures.size()); i += 2) frames.pairs.push_back({i, i + 1});
  Sequence sequence(std::move(frames), on_board);
  if (sequence.pairs() < kFewPairs) return check;
  const FrameName name = [&](int capture) { return frame_name(gray_code, capture); };
  const auto warn_wrong = [&](const char* code, const std::string& message) {
    check.diagnostics.warn(code, message);
    check.decoding_is_wrong = true;
  };
  const EndFault fault = sequence.clipping().is_everywhere() ? EndFault::kNone : end_fault(sequence);
  const int black = int(captures.size()) - 1;
  if (fault == EndFault::kNoWhite)
    warn_wrong("frame_missing",
               "A frame is missing: the last two captures are both black; capture this view again, waiting "
               "longer for each frame");
  else if (fault != EndFault::kNone)
    warn_wrong("stale_frame", fault == EndFault::kStaleBlack ? stale_message(name, black, black - 1)
                                                             : stale_message(name, black - 1, black - 2));
  else
    find_cause(sequence, &gray_code, name, check);
  return check;
}

SequenceCheck check_sequence(const std::vector<ViewU8>& captures, const ComplementaryFrames& shown,
                             const Points2& on_board) {
  require(int(captures.size()) == shown.frames, "check_sequence: another number of captures than of frames");
  for (const ViewU8& capture : captures)
    require(!capture.empty() && capture.channels == 1 && capture.size() == captures.front().size(),
            "check_sequence: a capture is empty, has several channels or another size than the first");
  SequenceCheck check;
  if (int(shown.pairs.size()) < kFewPairs) return check;
  SequenceFrames frames;
  frames.captures = captures;
  for (const auto& [first, second] : shown.pairs) frames.pairs.push_back({first, second});
  ImageU8 white, black;
  if (shown.white && shown.black) {
    frames.white = captures[std::size_t(*shown.white)];
    frames.black = captures[std::size_t(*shown.black)];
  } else {
    // Of the last two pairs, a quarter of a wave apart, the one that differs more.
    const FramePair a = frames.pairs[frames.pairs.size() - 2], b = frames.pairs.back();
    white = black = ImageU8(captures.front().size());
    for (int y = 0; y < white.height(); ++y)
      for (int x = 0; x < white.width(); ++x) {
        const auto grey = [&](int capture) { return captures[std::size_t(capture)].at(x, y); };
        const bool is_a = std::abs(grey(a.first) - grey(a.second)) > std::abs(grey(b.first) - grey(b.second));
        const FramePair& pair = is_a ? a : b;
        white.at(x, y) = std::max(grey(pair.first), grey(pair.second));
        black.at(x, y) = std::min(grey(pair.first), grey(pair.second));
      }
    frames.white = white;
    frames.black = black;
    frames.stripes = false;
  }
  Sequence sequence(std::move(frames), on_board);
  find_cause(
      sequence, nullptr, [](int capture) { return "frame " + std::to_string(capture); }, check);
  return check;
}

ComplementaryFrames complementary_frames(const std::vector<ImageU8>& frames) {
  ComplementaryFrames found;
  found.frames = int(frames.size());
  constexpr int kStep = 5;      // prime to stripes and waves
  constexpr int kRounding = 2;  // grey levels
  std::vector<std::vector<int>> samples;
  for (const ImageU8& frame : frames) {
    require(frame.channels() == 1 && frame.size() == frames.front().size(),
            "complementary_frames: frames of several channels or of different sizes");
    samples.emplace_back();
    for (int y = 0; y < frame.height(); y += kStep)
      for (int x = 0; x < frame.width(); x += kStep) samples.back().push_back(frame.at(x, y));
  }
  const auto is_all = [&](std::size_t i, int grey) {
    return std::all_of(samples[i].begin(), samples[i].end(), [&](int g) { return g == grey; });
  };
  std::vector<bool> used(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (is_all(i, 255)) found.white = int(i), used[i] = true;
    if (is_all(i, 0)) found.black = int(i), used[i] = true;
  }
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (std::size_t j = i + 1; j < frames.size() && !used[i]; ++j) {
      if (used[j]) continue;
      const bool sum_to_full = std::equal(samples[i].begin(), samples[i].end(), samples[j].begin(),
                                          [](int a, int b) { return std::abs(a + b - 255) <= kRounding; });
      if (sum_to_full) used[i] = used[j] = true, found.pairs.push_back({int(i), int(j)});
    }
  return found;
}

SequenceCheck check_flat_and_board(const ViewU8& flat_lit, const ViewU8& board_lit, const Points2& on_board) {
  require(!flat_lit.empty() && flat_lit.channels == 1 && board_lit.channels == 1 &&
              flat_lit.size() == board_lit.size(),
          "check_flat_and_board: two captures of one channel and one size are needed");
  const ImageU8 dark(flat_lit.size());
  const Sequence sequence(SequenceFrames{{flat_lit, board_lit, dark}, {{1, 2}}, flat_lit, dark}, on_board);
  SequenceCheck check;
  constexpr int kChange = 12;  // grey levels, well above a camera's noise
  constexpr double kMinShare = 1e-3;
  // At full scale everything is alike; half of a printed chessboard is paper.
  constexpr double kMuchClipped = 0.1, kDarkPaper = 40;
  const bool is_clipped = sequence.clipping().share > kMuchClipped;
  if (!is_clipped && sequence.differing(0, 1, kChange) < kMinShare) {
    const double paper = sequence.contrast();
    if (sequence.has_board() && paper < kDarkPaper)
      check.diagnostics.warn("low_contrast",
                             "The board's paper has only " + std::to_string(std::lround(paper)) +
                                 " grey levels under flat light, too few to see the projected board; "
                                 "raise the exposure");
    else
      check.diagnostics.warn(
          "stale_frame",
          "Both captures show the same light: the camera was faster than the projector, or the "
          "projector shows none of the pattern; capture this view again, waiting longer after "
          "each frame");
    check.decoding_is_wrong = true;
    return check;
  }
  find_cause_of_pair(sequence, check);
  return check;
}

SequenceCheck check_photograph(const ViewU8& photograph, const Points2& on_boards) {
  require(!photograph.empty() && photograph.channels == 1,
          "check_photograph: a photograph of one channel is needed");
  const ImageU8 dark(photograph.size());
  const Sequence sequence(SequenceFrames{{photograph}, {}, photograph, dark}, on_boards);
  SequenceCheck check;
  check.has_lit_board = sequence.has_board();
  warn_if_overexposed(sequence, check);
  return check;
}

}  // namespace procam::pattern
