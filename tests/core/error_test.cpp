#include "procam/core/base/error.hpp"

#include <gtest/gtest.h>

#include <set>

namespace procam {
namespace {

TEST(Error, HasThreePartsAndReadsAsOneSentence) {
  const Error error(ErrorKind::kNotEnoughData, "view 'pose_3'", "only 2 corners decoded",
                    "hold the board closer");
  EXPECT_STREQ(error.what(), "view 'pose_3': only 2 corners decoded; hold the board closer");
  EXPECT_EQ(error.subject(), "view 'pose_3'");
  EXPECT_EQ(error.why(), "only 2 corners decoded");
  EXPECT_EQ(error.next(), "hold the board closer");
  EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
}

TEST(Error, EveryKindHasItsOwnName) {
  std::set<std::string> names;
  for (const ErrorKind kind :
       {ErrorKind::kInput, ErrorKind::kNotEnoughData, ErrorKind::kDegenerate, ErrorKind::kNotConverged,
        ErrorKind::kUnsupported, ErrorKind::kIo, ErrorKind::kDevice})
    names.insert(to_string(kind));
  EXPECT_EQ(names.size(), 7u);
  EXPECT_EQ(names.count("unknown"), 0u);
}

TEST(Require, ThrowsInvalidArgumentWithTheMessage) {
  EXPECT_NO_THROW(require(true, "fine"));
  try {
    require(false, "frustum: near = -1");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "frustum: near = -1");
  }
}

TEST(Diagnostics, FailsOnlyOnAFailure) {
  Diagnostics diagnostics, more;
  diagnostics.note("board_flipped", "turned by 180 degrees");
  diagnostics.warn("few_views", "only four views");
  EXPECT_FALSE(diagnostics.failed());
  more.fail("rms", "2 px");
  diagnostics.append(more);
  EXPECT_TRUE(diagnostics.failed());
  ASSERT_NE(diagnostics.find("few_views"), nullptr);
  EXPECT_EQ(diagnostics.find("few_views")->severity, Severity::kWarning);
  EXPECT_EQ(diagnostics.find("rms")->message, "2 px");
  EXPECT_EQ(diagnostics.find("nothing"), nullptr);
}

}  // namespace
}  // namespace procam
