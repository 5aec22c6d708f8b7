#pragma once
/// The motion of print and surroundings over a sequence, from the edges in its pair sums.
#include <optional>
#include <vector>

#include "sequence.hpp"

namespace procam::pattern::internal {

/// A pixel of a strong gradient: R, its derivatives, all of 3 x 3 means.
struct EdgePixel {
  Pixel at;
  double level;
  Vec2 gradient;
  double laplacian;
};

/// Of the print (all of the image where the board is unknown), at most 1500.
std::vector<EdgePixel> print_edges(const Sequence& sequence);
/// Off the board what rests when the board moves: the border of the projected frame, and print or furniture
/// beside. Not the border of the board's shadow, which goes with the board: inside the lit area an edge
/// beyond which almost no light arrives.
std::vector<EdgePixel> background_edges(const Sequence& sequence);

/// Less of the print's gradients than this in place: it has moved, whatever a fit of small shifts says.
constexpr double kInPlace = 0.5;

/// How a pair's sum differs from white and black: S = gain R(p - shift) + blur laplace R + offset.
struct PairFit {
  Vec2 shift = Vec2::Zero();
  double blur = 0;
  double rotation = 0;  ///< about the edges' centre, pixels at their rms distance from it
  double sigma = 0;     ///< standard deviation of |(shift, rotation)|, from the residuals
  double residual = 0;  ///< mean square of the edges
  /// The sum differs at the edges, noise excluded, as after a motion of this many pixels across them, without any fit.
  double unfitted = 0;
  /// Of the print's gradients, where the reference has them: 1 where it rests, 0 where it is elsewhere.
  double in_place = 1;
  bool lost = false;  ///< no shift explains the difference
};

/// Pair sums' fits over the sequence; the reference is its end.
struct Series {
  std::vector<int> pair;
  std::vector<PairFit> fit;

  bool known() const { return pair.size() >= 6; }
  std::size_t size() const { return pair.size(); }
  /// Shift and rotation; where some are lost, of every pair how far the sum differs (the first component).
  Points3 motion() const;
  /// One odd pair in the middle is a frame's own fault: the second largest, or the first pair's.
  double largest() const;
};

/// `gains`: of each pair, 1 where unknown.
Series follow(const Sequence& sequence, const std::vector<EdgePixel>& edges,
              const std::vector<double>& gains);

/// Does the background rest while the print moves, or does the print's motion explain the background's? A
/// camera moves all.
enum class Background { kUnknown, kRests, kMoves };
Background background(const Sequence& sequence, const std::vector<EdgePixel>& edges, const Series& print,
                      const std::vector<double>& gains);

enum class Course { kStep, kDrift, kShake };

/// Which of one step, a straight line and neither describes the motion; `at`: the first pair after a step.
Course course(const Series& series, int& at);

}  // namespace procam::pattern::internal
