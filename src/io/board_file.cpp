#include "procam/io/board_file.hpp"

#include "fields.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

void dictionary(Fields& f, MarkerDictionary& value) {
  std::vector<std::string> names;
  for (const MarkerDictionaryInfo& info : kMarkerDictionaries) names.emplace_back(info.name);
  value = MarkerDictionary(f.choice("dictionary", names, std::size_t(value)));
}

template <typename Layout>
void counts(Fields& f, Layout& board) {
  f.field("columns", board.columns);
  f.field("rows", board.rows);
  for (const int count : {board.columns, board.rows})
    f.check(count >= 1 && count <= 1000, count == board.columns ? "columns" : "rows",
            "it is not a count from 1 to 1000", "count what is printed");
}

void layout_fields(Fields& f, Chessboard& board) {
  counts(f, board);
  f.field("square_size", board.square_size);
}

void layout_fields(Fields& f, CharucoBoard& board) {
  counts(f, board);
  f.field("square_size", board.square_size);
  f.field("marker_size", board.marker_size);
  dictionary(f, board.dictionary);
  f.field("marker_first", board.marker_first);
}

void layout_fields(Fields& f, MarkerGrid& board) {
  counts(f, board);
  f.field("marker_size", board.marker_size);
  f.field("gap", board.gap);
  dictionary(f, board.dictionary);
}

void layout_fields(Fields& f, CircleGrid& board) {
  counts(f, board);
  f.field("spacing", board.spacing);
  f.field("diameter", board.diameter);
  f.field("asymmetric", board.asymmetric);
}

/// The variant's alternative at a position that is known only while running.
template <std::size_t I = 0>
Board board_of_kind(std::size_t kind) {
  if constexpr (I + 1 < std::variant_size_v<Board>)
    if (kind != I) return board_of_kind<I + 1>(kind);
  return Board(std::in_place_index<I>);
}

/// A type of its own, so that fields() is found by its name.
struct BoardFile {
  Board board;
};

void fields(Fields& f, BoardFile& file) {
  header(f, "procam-board", 1);
  const std::vector<std::string> kinds{"chessboard", "charuco", "markers", "circles"};
  static_assert(std::variant_size_v<Board> == 4);
  const std::size_t kind = f.choice("kind", kinds, file.board.index());
  if (f.reading()) file.board = board_of_kind(kind);
  std::visit([&](auto& layout) { layout_fields(f, layout); }, file.board);
  const std::string why = flaw(file.board);
  f.check(why.empty(), "kind", why, "measure the sheet, and see docs/boards.md");
}

}  // namespace

Board load_board(const std::filesystem::path& path) {
  return load_noun<BoardFile>(path, Syntax::kJson).board;
}

void save_board(const std::filesystem::path& path, const Board& board) {
  save_noun(path, Syntax::kJson, BoardFile{board});
}

Board read_board(const std::string& text_or_file) {
  const std::filesystem::path path(text_or_file);
  return path.extension() == ".json" ? load_board(path) : parse_board(text_or_file);
}

}  // namespace procam::io
