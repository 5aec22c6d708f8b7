#pragma once
/// The table and the scoreboard as pictures, RGB.
#include "match.hpp"
#include "procam/core/base/image.hpp"

namespace hockey {

using Picture = procam::ImageView<std::uint8_t>;

/// Of the table at so many pixels a metre.
procam::ImageSize table_size(const Table& table, double pixels_per_metre);
inline constexpr procam::ImageSize kScoreboard{600, 160};

/// What does not move is drawn once. A frame restores what the one before has drawn over, and draws what
/// moves: it is always given the same picture.
class TableArtist {
 public:
  TableArtist(const Table& table, procam::ImageSize size);
  void draw(const Match& match, Picture picture);

 private:
  void draw_felt(const Match& match);

  procam::ImageU8 bare_;                 ///< felt and lines
  procam::ImageU8 felt_;                 ///< with the score on it
  std::array<Vec2, 24> trail_;           ///< of the puck, newest first
  std::array<int, 2> score_ = {-1, -1};  ///< that is drawn on the felt
  double drawn_ = -1;
  /// What to restore before the next frame: empty, a part, or all of it.
  const std::uint8_t* picture_ = nullptr;
  std::vector<std::array<int, 4>> touched_;  ///< x, y, width, height
};

/// Draws when what it shows has changed, and says whether.
class ScoreboardArtist {
 public:
  bool draw(const Match& match, Picture picture);

 private:
  long shown_ = -1;
};

}  // namespace hockey
