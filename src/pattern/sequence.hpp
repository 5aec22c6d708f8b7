#pragma once
/// The captures of one view in linear light: a sparse grid of pixels that the projector lights directly, and
/// what they show of exposure, noise and scattered light (sequence_check.hpp has the model).
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::pattern::internal {

/// Bands of rows in which frames are compared.
inline constexpr int kBands = 16;

/// Two captures that together show what the white and the black capture show.
struct FramePair {
  int first = 0, second = 0;
};

/// What a view's captures are. White and black are captures, or made of them.
struct SequenceFrames {
  std::vector<ViewU8> captures;  ///< in the order of time
  std::vector<FramePair> pairs;  ///< in the order of time
  ViewU8 white, black;
  bool stripes = true;  ///< of full light and none: their brightness is white's
};

struct Pixel {
  int x, y;
};

/// The mean of the values about the densest 40 %, and its standard error: the usual value where up to half of
/// them are others.
struct Usual {
  double value = 0, error = 0;
};
Usual usual(std::vector<double> values);

/// Convex, counter-clockwise in image axes; grown about the points' mean. Empty below three points.
Points2 hull(Points2 points, double growth);
bool contains(const Points2& chain, double x, double y);
/// Distance to the chain's sides.
double distance_to(const Points2& chain, double x, double y);

class Sequence {
 public:
  Sequence(SequenceFrames frames, const Points2& on_board);

  int pairs() const { return int(frames_.pairs.size()); }
  const FramePair& pair(int index) const { return frames_.pairs[std::size_t(index)]; }
  bool has_stripes() const { return frames_.stripes; }
  int captures() const { return int(frames_.captures.size()); }
  const std::vector<ViewU8>& frames() const { return frames_.captures; }
  ImageSize size() const { return frames_.white.size(); }
  bool has_board() const { return !board_.empty(); }
  bool on_board(int x, int y) const { return contains(board_, x, y); }
  bool near_board(int x, int y) const { return contains(around_, x, y); }

  /// Linear light of a capture, of white, of black.
  double at(int capture, int x, int y) const {
    return linear_[frames_.captures[std::size_t(capture)].at(x, y)];
  }
  double white(int x, int y) const { return linear_[frames_.white.at(x, y)]; }
  double black(int x, int y) const { return linear_[frames_.black.at(x, y)]; }
  double sum(int pair, int x, int y) const {
    const FramePair& of = frames_.pairs[std::size_t(pair)];
    return at(of.first, x, y) + at(of.second, x, y);
  }
  double reference(int x, int y) const { return white(x, y) + black(x, y); }
  const ViewU8& white_grey() const { return frames_.white; }

  /// On a grid, those whose white is brighter than their black: of the board where it is known.
  const std::vector<Pixel>& lit() const { return lit_; }
  /// On the grid over the whole image, those that the projector lights directly and that are not at full
  /// scale. Light that surfaces or the lens scatter follows no stripe.
  const std::vector<Pixel>& shown() const { return shown_; }
  int band(const Pixel& pixel) const {
    return (pixel.y - first_row_) * kBands / (last_row_ - first_row_ + 1);
  }

  /// The camera's response from pixels that see a frame and its inverse alike; 1 if unknown.
  double estimate_gamma();

  /// Mean grey value of a capture.
  double mean(int capture) const;
  /// Share of the image in which two captures differ by more than `grey`.
  double differing(int a, int b, int grey) const;

  /// Pair sums by white and black: over all rows (nullopt without pixels), and by band with its standard
  /// error (the former and 0 without).
  struct Gain {
    double all = 1;
    bool is_coarse = false;  ///< most pixels see one stripe in each frame, and only these count
    std::array<double, kBands> band{}, error{};
    /// Of the white stripes of each of the two captures by themselves.
    std::optional<double> first, second;
  };
  std::optional<Gain> gain(int pair) const;

  /// By how much the darker and the brighter stripes of light paper change over the coarse frames, linear light: standard
  /// deviation from frame to frame, median over the bands. 0, 0 where no stripes are coarse.
  std::array<double, 2> unsteadiness() const;

  /// The captures of the pair are not at full scale there.
  bool is_below_full_scale(const FramePair& pair, const Pixel& pixel) const;

  /// Black stripes of the coarsest pair less the black capture, by their difference from white stripes, grey
  /// values. Scattered light makes it positive; only an exposure that follows the light makes it negative.
  double black_stripes() const;
  /// Share of its own white that a black stripe of the coarse pairs receives, light paper only: twice the
  /// scattered part, as half of the frame is white.
  double scattered() const;
  /// Noise of white stripes by the contrast, both in linear light: from two coarse pairs of one axis.
  double noise() const;
  /// Share of the light before that a capture still shows, the usual one of the sequence; 0 if unknown.
  double lag() const;
  /// White minus black of light paper, grey levels.
  double contrast() const;

  struct Clipping {
    double share = 0;       ///< of the board's pixels, at full scale in white
    double lamp = 0;        ///< of the board's pixels, those of them that are bright in black too
    double white_grey = 0;  ///< of light paper that is not at full scale

    /// More than a lamp's reflection covers.
    bool is_everywhere() const { return share > 0.3; }
  };
  Clipping clipping() const;
  /// Every capture has pixels at zero and at full scale, and most of the latter are not at full scale in all captures: no
  /// lamp, and no camera of fixed exposure, as the light differs.
  bool spans_all_greys() const;

 private:
  SequenceFrames frames_;
  Points2 board_, around_;
  std::array<double, 256> linear_;
  std::vector<Pixel> lit_, shown_;
  int first_row_ = 0, last_row_ = 0;

  int grid_step() const;
  bool is_direct(int x, int y) const;
  std::optional<double> lag_of_stripes(int pair) const;
  std::optional<double> lag_of_waves(const FramePair& first, const FramePair& quarter) const;
  void find_shown();
};

}  // namespace procam::pattern::internal
