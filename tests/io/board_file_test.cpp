#include "procam/io/board_file.hpp"

#include <gtest/gtest.h>

#include "examples.hpp"
#include "procam/io/text.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

TEST(BoardFile, HoldsEveryKindToTheLastDigit) {
  const Scratch scratch;
  for (const Board& board : test::example_boards()) {
    save_board(scratch / "board.json", board);
    EXPECT_EQ(load_board(scratch / "board.json"), board) << format_board(board);
    EXPECT_EQ(read_board((scratch / "board.json").string()), board);
    EXPECT_EQ(read_board(format_board(board)), board);
  }
}

TEST(BoardFile, RefusesABoardThatNobodyCanPrint) {
  const Scratch scratch;
  const auto refuse = [&](const std::string& fields, const std::string& why) {
    scratch.write("board.json", R"({"format": "procam-board", "version": 1, )" + fields + "}");
    EXPECT_ERROR(load_board(scratch / "board.json"), kInput, why);
  };
  refuse(R"("kind": "chesboard", "columns": 7, "rows": 9, "square_size": 0.1)", "did you mean 'chessboard'");
  refuse(R"("kind": "chessboard", "columns": 7, "rows": 9, "square_size": -0.1)", "no positive size");
  refuse(R"("kind": "chessboard", "columns": 7, "rows": 0, "square_size": 0.1)", "rows: it is not a count");
  refuse(R"("kind": "chessboard", "columns": 7, "rows": 9, "square": 0.1)",
         "unknown field 'square'; known here");
  refuse(
      R"("kind": "circles", "columns": 7, "rows": 9, "spacing": 0.02, "diameter": 0.02, "asymmetric": false)",
      "overlap");
  EXPECT_ERROR(read_board((scratch / "none.json").string()), kIo, "none.json");
  EXPECT_THROW(save_board(scratch / "bad.json", Chessboard{1, 9, 0.1}), std::invalid_argument);
}

}  // namespace
}  // namespace procam::io
