#include "procam/io/text.hpp"

#include <gtest/gtest.h>

#include "examples.hpp"
#include "procam/core/base/limits.hpp"
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
}

TEST(Text, WritesWhatItReadsBack) {
  for (const double metres : {0.075, 0.0254, 1.0 / 3, 2.0, 1e-9, 12345.678, 0.1 + 0.2}) {
    EXPECT_EQ(parse_length(format_length(metres)), metres) << format_length(metres);
    for (const Board& board : test::example_boards())
      EXPECT_EQ(parse_board(format_board(scaled(board, metres))), scaled(board, metres));
  }
  EXPECT_EQ(parse_size(format_size({640, 481})), (ImageSize{640, 481}));
}

TEST(Text, SpellsEachBoardOneWay) {
  const std::vector<std::pair<std::string, Board>> boards{
      {"chessboard:7x9:75mm", Chessboard{7, 9, 0.075}},
      {"charuco:5x7:40mm:30mm:5x5_100", CharucoBoard{5, 7, 0.04, 0.03, MarkerDictionary::k5x5_100}},
      {"charuco:5x6:40mm:30mm:4x4_50:marker-first",
       CharucoBoard{5, 6, 0.04, 0.03, MarkerDictionary::k4x4_50, true}},
      {"markers:4x5:30mm:8mm:apriltag_36h11",
       MarkerGrid{4, 5, 0.03, 0.008, MarkerDictionary::kAprilTag36h11}},
      {"circles:7x9:25mm:15mm", CircleGrid{7, 9, 0.025, 0.015, false}},
      {"asymmetric-circles:4x11:20mm:12mm", CircleGrid{4, 11, 0.02, 0.012, true}}};
  for (const auto& [text, board] : boards) {
    EXPECT_EQ(parse_board(text), board) << text;
    EXPECT_EQ(format_board(board), text);
  }
}

TEST(Text, SpellsBoardsOfLightInPixels) {
  const CharucoBoard board{15, 11, 64, 48.5, MarkerDictionary::k4x4_250, true};
  EXPECT_EQ(format_board(board, BoardUnit::kPixel), "charuco:15x11:64px:48.5px:4x4_250:marker-first");
  for (const Board& light : test::example_boards())
    EXPECT_EQ(parse_board(format_board(scaled(light, 1000), BoardUnit::kPixel), BoardUnit::kPixel),
              scaled(light, 1000));
  EXPECT_ERROR(parse_board("chessboard:12x9:64mm", BoardUnit::kPixel), kInput, "there is no unit 'mm' here");
  EXPECT_ERROR(parse_board("chessboard:12x9:64px"), kInput, "there is no unit 'px' here");
}

TEST(Text, ReadsDurationsSigmasAndSpeeds) {
  EXPECT_EQ(parse_duration("50ms"), 0.05);
  EXPECT_EQ(parse_duration("0.25s"), 0.25);
  EXPECT_ERROR(parse_duration("50"), kInput, "the unit is missing");
  EXPECT_EQ(parse_duration("1e9s"), limits::kDurationS);
  EXPECT_ERROR(parse_duration("1000000001s"), kInput, "beyond 31 years");
  EXPECT_EQ(parse_delay("10s"), limits::kDelayS);
  EXPECT_ERROR(parse_delay("10001ms"), kInput, "no device is later than 10 s");
  EXPECT_EQ(parse_length("-1000000m"), -limits::kLengthM);
  EXPECT_ERROR(parse_length("1000001m"), kInput, "beyond 1000 km");
  for (const char* number : {"-1", "nan", "inf", "-inf", "1e308", "1e309"}) {
    EXPECT_ERROR(parse_duration(std::string(number) + "s"), kInput, "duration '");
    EXPECT_ERROR(parse_delay(std::string(number) + "ms"), kInput, "duration '");
    if (std::string(number) != "-1")
      EXPECT_ERROR(parse_length(std::string(number) + "m"), kInput, "length '");
  }
  const LengthAndAngle sigmas = parse_length_and_angle("10mm,0.5deg");
  EXPECT_DOUBLE_EQ(sigmas.length, 0.01);
  EXPECT_DOUBLE_EQ(sigmas.angle, parse_angle("0.5deg"));
  EXPECT_EQ(parse_length_and_angle("2rad").angle, 2);
  EXPECT_EQ(parse_length_and_angle("5cm").angle, 0);
  EXPECT_DOUBLE_EQ(parse_speed("30deg/s,0.5m/s").length, 0.5);
  for (const char* text : {"10mm,5mm", "10mm,,1deg", "-10mm", "1deg,-2mm", "10", "10mm,0.5", ""})
    EXPECT_ERROR(parse_length_and_angle(text), kInput, ";");
  EXPECT_ERROR(parse_speed("0.5m"), kInput, "does not end with '/s'");
}

TEST(Text, RefusesBoardsThatNobodyCanPrint) {
  EXPECT_ERROR(parse_board("charuco:5x7:40mm:40mm:5x5_100"), kInput, "not smaller than its squares");
  EXPECT_ERROR(parse_board("charuco:12x12:40mm:30mm:5x5_50"), kInput, "too few markers");
  EXPECT_ERROR(parse_board("charuco:5x7:40mm:30mm:5x5_99"), kInput, "no dictionary '5x5_99'");
  EXPECT_ERROR(parse_board("charuco:5x7:40mm:30mm:5x5_50:first"), kInput, "not 'marker-first'");
  EXPECT_ERROR(parse_board("charuco:5x7:40mm:30mm"), kInput, "5 parts");
  EXPECT_ERROR(parse_board("markers:8x8:30mm:8mm:apriltag_25h9"), kInput, "too few markers");
  EXPECT_ERROR(parse_board("markers:4x5:30mm:0mm:4x4_50"), kInput, "no positive size");
  EXPECT_ERROR(parse_board("markers:4x5:30mm:8:4x4_50"), kInput, "its gap is no length: the unit is missing");
  EXPECT_ERROR(parse_board("circles:7x9:25mm:25mm"), kInput, "overlap");
  EXPECT_ERROR(parse_board("circles:7x1:25mm:15mm"), kInput, "at least 2 circles");
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
  EXPECT_EQ(parse_size("16384x8192"), (ImageSize{16384, 8192}));
  EXPECT_ERROR(parse_size("16384x8193"), kInput, "16384 x 8193 pixels are more than 134217728");
  EXPECT_ERROR(parse_size("100000x100000"), kInput, "more than");
  EXPECT_ERROR(parse_board("chessboard:7x9:75"), kInput, "the unit is missing");
  EXPECT_ERROR(parse_board("chessboard:7x9"), kInput, "3 parts");
  EXPECT_ERROR(parse_board("chesboard:7x9:75mm"), kInput, "no board of kind 'chesboard'");
  EXPECT_ERROR(parse_board("chessboard:7:75mm"), kInput, "counts");
  EXPECT_ERROR(parse_board("chessboard:1x9:75mm"), kInput, "at least 2");
  EXPECT_ERROR(parse_board("chessboard:7x9:0mm"), kInput, "no positive size");
}

}  // namespace
}  // namespace procam::io
