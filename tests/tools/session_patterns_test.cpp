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
    for (const ImageU8& frame : frames) ASSERT_TRUE(frame.size() == kProjector && frame.channels() == 1);
    EXPECT_NE(pattern->describe().find(std::to_string(frames.size()) + " frames for 1024x768"),
              std::string::npos);
    EXPECT_NE(pattern_help().find(row.name), std::string::npos);
  }
}

TEST(PatternTable, TakesParametersAfterAColon) {
  EXPECT_EQ(make_pattern("phase:20px", kProjector)->text(), "phase:20px");
  EXPECT_EQ(make_pattern("chessboard:9x6:70px", kProjector)->text(), "chessboard:9x6:70px");
  EXPECT_EQ(make_pattern("gray", kProjector, 4)->frame_count(), 34);
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
  for (const char* text : {"gray:3", "phase:7px", "phase:16", "phase:900px", "gray+phase:16px2",
                           "chessboard:12", "chessboard:12x9:64mm", "chessboard:12x9:640px", ""})
    EXPECT_THROW(make_pattern(text, kProjector), Error) << text;
}

}  // namespace
}  // namespace procam::tools
