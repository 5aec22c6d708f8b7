#pragma once
/// The table and the scoreboard as pictures, RGB.
#include "match.hpp"
#include "procam/core/image.hpp"

namespace hockey {

using Picture = procam::ImageView<std::uint8_t>;

/// What does not move is drawn once; a frame is a copy of it and some discs.
class TableArtist {
 public:
  TableArtist(const Table& table, procam::ImageSize size);
  void draw(const Match& match, Picture picture);

 private:
  procam::ImageU8 felt_;
  std::array<Vec2, 24> trail_;  ///< of the puck, newest first
  double drawn_ = -1;
};

void draw_scoreboard(const Match& match, Picture picture);

}  // namespace hockey
