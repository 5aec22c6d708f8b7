#include "procam/io/text.hpp"

#include <gtest/gtest.h>

#include "scratch.hpp"

namespace procam::io {
namespace {

TEST(Text, ReadsSizesLengthsAnglesAndBoards) {
  EXPECT_EQ(parse_size("1024x768"), (ImageSize{1024, 768}));
  // Exactly the double that the metre literal is: no last digit is lost in the unit.
  EXPECT_EQ(parse_length("75mm"), 0.075);
  EXPECT_EQ(parse_length("35mm"), 0.035);
  EXPECT_EQ(parse_length("2.5cm"), 0.025);
  EXPECT_EQ(parse_length("-1e-1m"), -0.1);
  EXPECT_EQ(parse_length("1in"), 0.0254);
  EXPECT_DOUBLE_EQ(parse_angle("180deg"), 3.14159265358979323846);
  EXPECT_EQ(parse_angle("0.5rad"), 0.5);
  EXPECT_EQ(std::get<Chessboard>(parse_board("chessboard:7x9:75mm")), (Chessboard{7, 9, 0.075}));
}

TEST(Text, WritesWhatItReadsBack) {
  for (const double metres : {0.075, 0.0254, 1.0 / 3, 2.0, 1e-9, 12345.678, 0.1 + 0.2}) {
    EXPECT_EQ(parse_length(format_length(metres)), metres) << format_length(metres);
    const Board board = Chessboard{5, 8, metres};
    EXPECT_EQ(std::get<Chessboard>(parse_board(format_board(board))), std::get<Chessboard>(board));
  }
  EXPECT_EQ(format_board(Chessboard{7, 9, 0.075}), "chessboard:7x9:75mm");
  EXPECT_EQ(parse_size(format_size({640, 481})), (ImageSize{640, 481}));
}

TEST(Text, SaysWhatWasExpected) {
  EXPECT_ERROR(parse_length("25"), kInput,
               "length '25': the unit is missing; write a number and mm, cm, m or in");
  EXPECT_ERROR(parse_length("25 furlong"), kInput, "no unit ' furlong'");
  EXPECT_ERROR(parse_length("mm"), kInput, "does not begin with a number");
  EXPECT_ERROR(parse_length("nanmm"), kInput, "does not begin with a number");
  EXPECT_ERROR(parse_length("1e999m"), kInput, "does not begin with a number");
  EXPECT_ERROR(parse_angle("30"), kInput, "deg or rad");
  for (const char* text :
       {"", "1024", "1024x", "x768", "0x768", "-4x3", "1024x768x3", "1024 x768", "1e3x768"})
    EXPECT_ERROR(parse_size(text), kInput, "WIDTHxHEIGHT");
  EXPECT_ERROR(parse_board("chessboard:7x9:75"), kInput, "the unit is missing");
  EXPECT_ERROR(parse_board("chessboard:7x9"), kInput, "three parts");
  EXPECT_ERROR(parse_board("chesboard:7x9:75mm"), kInput, "no board of kind 'chesboard'");
  EXPECT_ERROR(parse_board("chessboard:7:75mm"), kInput, "counts");
  EXPECT_ERROR(parse_board("chessboard:1x9:75mm"), kInput, "at least 2");
  EXPECT_ERROR(parse_board("chessboard:7x9:0mm"), kInput, "no positive size");
}

}  // namespace
}  // namespace procam::io
