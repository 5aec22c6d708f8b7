#include "common/session_patterns.hpp"

#include <gtest/gtest.h>

namespace procam::tools {
namespace {

const ImageSize kProjector{1024, 768};

TEST(PatternTable, EachRowStatesItselfAndShowsAsManyFramesAsItSays) {
  for (const PatternRow& row : pattern_table()) {
    const auto pattern = make_pattern(row.name, kProjector);
    EXPECT_EQ(make_pattern(pattern->text(), kProjector)->text(), pattern->text());
    EXPECT_EQ(pattern->text().rfind(row.name, 0), 0u) << pattern->text();
    const std::vector<ImageU8> frames = pattern->frames();
    EXPECT_EQ(int(frames.size()), pattern->frame_count()) << row.name;
    for (const ImageU8& frame : frames)
      ASSERT_TRUE(frame.size() == kProjector && frame.channels() == pattern->channels());
    EXPECT_NE(pattern->describe().find(std::to_string(frames.size()) + " frames for 1024x768"),
              std::string::npos);
    EXPECT_NE(pattern_help().find(row.name), std::string::npos);
  }
}

TEST(PatternTable, TakesParametersAfterAColon) {
  EXPECT_EQ(make_pattern("phase:20px", kProjector)->text(), "phase:20px");
  EXPECT_EQ(make_pattern("chessboard:9x6:70px", kProjector)->text(), "chessboard:9x6:70px");
  for (const char* text :
       {"charuco:9x7:80px:56px:5x5_100", "markers:6x5:72px:30px:apriltag_36h11", "circles:5x7:80px:70.5px"})
    EXPECT_EQ(make_pattern(text, kProjector)->text(), text);
  EXPECT_EQ(make_pattern("gray", kProjector, 4)->frame_count(), 34);
}

TEST(PatternTable, ShowsBoardsOfLightInOneColourFrameWhenAsked) {
  for (const char* name : {"chessboard", "charuco", "markers", "circles"}) {
    const auto one = make_pattern(std::string(name) + ":colour", kProjector),
               pair = make_pattern(name, kProjector);
    EXPECT_EQ(one->text(), pair->text() + ":colour");
    EXPECT_EQ(make_pattern(one->text(), kProjector)->text(), one->text());
    EXPECT_EQ(one->frame_count(), 1);
    EXPECT_EQ(one->channels(), 3);
    EXPECT_EQ(pair->channels(), 1);
    EXPECT_NE(one->describe().find("1 frames for 1024x768"), std::string::npos);
  }
}

TEST(PatternTable, LetsBoardsWithMarkersLeaveThePaper) {
  const auto area = [](const char* text) {
    return make_pattern(text, kProjector)->on_blank_paper()->volume();
  };
  EXPECT_LT(area("markers"), 0.75 * 1024 * 768);
  EXPECT_LT(area("charuco"), 0.75 * 1024 * 768);
  EXPECT_GT(area("circles"), 0.75 * 1024 * 768);
  EXPECT_FALSE(make_pattern("gray", kProjector)->on_blank_paper());
}

TEST(PatternTable, NamesWhatItKnowsAndRefusesTheRest) {
  try {
    make_pattern("moire", kProjector);
    FAIL() << "an unknown pattern was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    for (const PatternRow& row : pattern_table())
      EXPECT_NE(error.next().find(row.name), std::string::npos) << row.name;
  }
  for (const char* text :
       {"gray:3", "phase:7px", "phase:16", "phase:900px", "gray+phase:16px2", "chessboard:12",
        "chessboard:12x9:64mm", "chessboard:12x9:640px", "chessboard:12x9:64px:red", "markers:10x7:64px:32px",
        "markers:10x7:0.1m:0.05m:4x4_250", "charuco:15x11:64px:49px:4x4_250", "charuco:9x7:80px:56m:5x5_100",
        "circles:7x10:64px:56px", "circles:7x11:64px:100px", ""})
    EXPECT_THROW(make_pattern(text, kProjector), Error) << text;
}

}  // namespace
}  // namespace procam::tools
