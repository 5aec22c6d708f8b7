#include "procam/detect/board_artwork.hpp"

#include <algorithm>

#include "markers.hpp"

namespace procam::detect {
namespace {

void add_rectangle(BoardArtwork& art, double left, double top, double right, double bottom) {
  art.rectangles.push_back({Vec2(left, top), Vec2(right, bottom)});
}

/// The border and the dark modules, as runs along rows.
void add_marker(BoardArtwork& art, const MarkerCodes& codes, int id, const Vec2& first, double size) {
  const int modules = codes.modules();
  const std::string& code = codes.codes[std::size_t(id)];
  const auto dark = [&](int x, int y) {
    const int column = x - codes.border, row = y - codes.border;
    if (column < 0 || row < 0 || column >= codes.bits || row >= codes.bits) return true;
    return code[std::size_t(row * codes.bits + column)] == '0';
  };
  // Edges by one formula, so that neighbours share theirs to the last bit.
  const auto edge = [&](int axis, int i) { return first[axis] + size * i / modules; };
  for (int y = 0; y < modules; ++y)
    for (int x = 0; x < modules; ++x) {
      if (!dark(x, y)) continue;
      const int begin = x;
      while (x + 1 < modules && dark(x + 1, y)) ++x;
      add_rectangle(art, edge(0, begin), edge(1, y), edge(0, x + 1), edge(1, y + 1));
    }
}

/// Dark squares of a field whose inner corner (0, 0) is the origin.
template <typename IsDark>
void add_squares(BoardArtwork& art, int columns, int rows, double s, const IsDark& is_dark) {
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      if (is_dark(column, row)) add_rectangle(art, (column - 1) * s, (row - 1) * s, column * s, row * s);
}

BoardArtwork draw(const Chessboard& board) {
  BoardArtwork art;
  const double s = board.square_size;
  add_squares(art, board.columns + 1, board.rows + 1, s,
              [](int column, int row) { return (column + row) % 2 == 0; });
  art.sheet = {Vec2(-2 * s, -2 * s), Vec2((board.columns + 1) * s, (board.rows + 1) * s)};
  return art;
}

BoardArtwork draw(const CharucoBoard& board) {
  BoardArtwork art;
  const double s = board.square_size;
  add_squares(art, board.columns, board.rows, s,
              [&](int column, int row) { return !board.is_light(column, row); });
  const MarkerCodes codes = marker_codes(board.dictionary);
  for (int id = 0; id < board.marker_count(); ++id)
    add_marker(art, codes, id, board.marker_in_board(id), board.marker_size);
  art.sheet = {Vec2(-1.5 * s, -1.5 * s), Vec2((board.columns - 0.5) * s, (board.rows - 0.5) * s)};
  return art;
}

BoardArtwork draw(const MarkerGrid& board) {
  BoardArtwork art;
  const MarkerCodes codes = marker_codes(board.dictionary);
  for (int id = 0; id < board.marker_count(); ++id)
    add_marker(art, codes, id, board.marker_in_board(id), board.marker_size);
  const double rim = std::max(board.gap, board.marker_size / codes.modules());
  const Vec2 last = board.marker_in_board(board.marker_count() - 1);
  art.sheet = {Vec2(-rim, -rim), last + (board.marker_size + rim) * Vec2::Ones()};
  return art;
}

BoardArtwork draw(const CircleGrid& board) {
  BoardArtwork art;
  Vec2 high = Vec2::Zero();
  for (const Vec3& centre : points_in_board(board)) {
    art.discs.push_back({centre.head<2>(), 0.5 * board.diameter});
    high = high.cwiseMax(centre.head<2>());
  }
  const double rim = 0.5 * board.diameter + 0.5 * board.spacing;
  art.sheet = {Vec2(-rim, -rim), high + rim * Vec2::Ones()};
  return art;
}

BoardArtwork draw(const AprilGrid& board) {
  BoardArtwork art;
  MarkerCodes codes = marker_codes(AprilGrid::kDictionary);
  codes.border = AprilGrid::kBorder;
  for (int id = 0; id < board.marker_count(); ++id)
    add_marker(art, codes, id, board.marker_in_board(id), board.tag_size);
  const double pitch = board.tag_size + board.gap();
  for (int row = 0; row <= board.rows; ++row)
    for (int column = 0; column <= board.columns; ++column) {
      const Vec2 corner = pitch * Vec2(column, row);
      add_rectangle(art, corner.x() - board.gap(), corner.y() - board.gap(), corner.x(), corner.y());
    }
  const ArtworkRectangle print = print_of(Board(board));
  const Vec2 rim = Vec2::Constant(board.gap());
  art.sheet = {print.low - rim, print.high + rim};
  return art;
}

}  // namespace

BoardArtwork board_artwork(const Board& board) {
  require(flaw(board).empty(), "board_artwork: " + flaw(board));
  return std::visit([](const auto& layout) { return draw(layout); }, board);
}

}  // namespace procam::detect
