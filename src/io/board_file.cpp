#include "procam/io/board_file.hpp"

#include <cmath>

#include "document/document.hpp"
#include "document/fields.hpp"
#include "document/value.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
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

void layout_fields(Fields& f, AprilGrid& board) {
  counts(f, board);
  f.field("tag_size", board.tag_size);
  f.field("spacing", board.spacing);
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
  const std::vector<std::string> kinds{"chessboard", "charuco", "markers", "circles", "aprilgrid"};
  static_assert(std::variant_size_v<Board> == 5);
  const std::size_t kind = f.choice("kind", kinds, file.board.index());
  if (f.reading()) file.board = board_of_kind(kind);
  std::visit([&](auto& layout) { layout_fields(f, layout); }, file.board);
  const std::string why = flaw(file.board);
  f.check(why.empty(), "kind", why, "measure the sheet, and see docs/boards.md");
}

/// A field of Kalibr's file.
Value member(const Value& root, const std::string& name) {
  for (const Value& value : root.members())
    if (value.node->name == name) return value;
  root.fail("its " + name + " is missing", "give the file that describes the target, as Kalibr reads it");
}

int count_of(const Value& value) {
  const double number = value.number();
  if (number != std::floor(number) || number < 1 || number > 1000)
    value.fail("it is not a count from 1 to 1000", "count what is printed");
  return int(number);
}

/// Kalibr's description of a target: aprilgrid, or a checkerboard by its inner corners.
Board load_kalibr_target(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, limits::kDocumentBytes), file = path.string();
  const Node document = parse_yaml(bytes, file);
  const Value root{&document, &file, ""};
  if (document.kind != Node::Kind::kObject)
    root.fail("it is no target", "give the file that describes the target, as Kalibr reads it");
  const Value type = member(root, "target_type");
  const std::string name = type.text();
  Board board;
  if (name == "aprilgrid") {
    for (const Value& value : root.members())
      if (value.node->name == "codeOffset" && value.number() != 0)
        value.fail("its ids do not begin at 0", "print and describe a target without codeOffset",
                   ErrorKind::kUnsupported);
    board = AprilGrid{count_of(member(root, "tagCols")), count_of(member(root, "tagRows")),
                      member(root, "tagSize").number(), member(root, "tagSpacing").number()};
  } else if (name == "checkerboard") {
    const Value height = member(root, "rowSpacingMeters");
    const double square = member(root, "colSpacingMeters").number();
    if (std::abs(height.number() - square) > 1e-9)
      height.fail("its squares are not square", "procam reads square ones", ErrorKind::kUnsupported);
    board = Chessboard{count_of(member(root, "targetCols")), count_of(member(root, "targetRows")), square};
  } else {
    type.fail("procam reads no target of type '" + name.substr(0, 40) + "' from here",
              "give it as text, e.g. circles:7x9:25mm:15mm", ErrorKind::kUnsupported);
  }
  if (const std::string why = flaw(board); !why.empty())
    type.fail(why, "measure the sheet, and see docs/boards.md");
  return board;
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
  if (path.extension() == ".json") return load_board(path);
  if (path.extension() == ".yaml" || path.extension() == ".yml") return load_kalibr_target(path);
  return parse_board(text_or_file);
}

}  // namespace procam::io
