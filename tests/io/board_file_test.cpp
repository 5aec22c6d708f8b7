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

/// As Kalibr's own examples are written.
TEST(BoardFile, ReadsTheTargetsOfKalibr) {
  const Scratch scratch;
  const auto read = [&](const std::string& text) {
    return read_board(scratch.write("target.yaml", text).string());
  };
  const std::string grid =
      "target_type: 'aprilgrid' #gridtype\n"
      "tagCols: 6               #number of apriltags\n"
      "tagRows: 5               #number of apriltags\n"
      "tagSize: 0.088           #size of apriltag, edge to edge [m]\n"
      "tagSpacing: 0.3          #ratio of space between tags to tagSize\n";
  EXPECT_EQ(read(grid), Board(AprilGrid{6, 5, 0.088, 0.3}));
  EXPECT_EQ(format_board(read(grid)), "aprilgrid:6x5:88mm:0.3");
  EXPECT_EQ(read(grid + "codeOffset: 0\n"), read(grid));
  EXPECT_ERROR(read(grid + "codeOffset: 30\n"), kUnsupported, "codeOffset");
  EXPECT_EQ(read("target_type: 'checkerboard'\ntargetCols: 6\ntargetRows: 7\nrowSpacingMeters: 0.06\n"
                 "colSpacingMeters: 0.06\n"),
            Board(Chessboard{6, 7, 0.06}));
  EXPECT_ERROR(read("target_type: 'circlegrid'\n"), kUnsupported, "no target of type 'circlegrid'");
  EXPECT_ERROR(read("target_type: 'aprilgrid'\ntagCols: 6\n"), kInput, "its tagRows is missing");
  EXPECT_ERROR(read("tagCols: 6\n"), kInput, "its target_type is missing");
  EXPECT_ERROR(parse_board("aprilgrid:6x5:88mm:26mm"), kInput, "its spacing is no number");
  EXPECT_ERROR(parse_board("aprilgrid:6x5:88mm:3"), kInput, "its spacing is not a share of the tag");
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
