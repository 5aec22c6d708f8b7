/// A corpus of sessions that went wrong, a file each in broken/: what happened, how to do it to a good
/// session in numbers, and what calibration must say. None may come back as a success whose light lands
/// further off than three times the predicted error, and none may bring NaN.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "broken_session.hpp"

namespace procam::calibrate {
namespace {

namespace fs = std::filesystem;

fs::path corpus() {
  return fs::path(PROCAM_SOURCE_DIR) / "tests/calibrate/broken";
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(corpus())) all.push_back(entry.path().stem().string());
  std::sort(all.begin(), all.end());
  return all;
}

class BrokenSession : public ::testing::TestWithParam<std::string> {};

TEST_P(BrokenSession, IsRefusedOrRepairedWithItsCause) {
  const json recipe = json::parse(std::ifstream(corpus() / (GetParam() + ".json")));
  SCOPED_TRACE(recipe.at("cause").get<std::string>());
  Session session;
  session.world = test::NumericWorld::make(recipe.value("views", 8), recipe.value("seed", 1u), 0.07, 0.09);
  if (recipe.contains("board")) {
    const json& b = recipe.at("board");
    session.world.board = Chessboard{b[0], b[1], 0.032};
  }
  session.data = session.world.correspondences(2);
  for (const json& step : recipe.at("break")) apply(session, step);
  Options options;
  options.holdout = recipe.value("holdout", false);

  const std::string expected = recipe.at("expect");
  std::string words;
  try {
    const CalibrationResult result = calibrate_rig(session.data, options);
    words = words_of(result);
    expect_finite(result);
    const bool passed = result.rig.quality.passed();
    EXPECT_EQ(expected, passed ? "repaired" : "gate") << words;
    if (passed) {
      const LightErrors light = light_errors(session, result);
      EXPECT_LT(light.actual, 3 * light.predicted) << words;
    }
  } catch (const Error& error) {
    words = error.what();
    EXPECT_EQ(expected, "refused") << words;
  }
  for (const json& says : recipe.at("says"))
    EXPECT_NE(words.find(says.get<std::string>()), std::string::npos) << says << " is not in:\n" << words;
}

INSTANTIATE_TEST_SUITE_P(Corpus, BrokenSession, ::testing::ValuesIn(names()),
                         [](const auto& instance) { return instance.param; });

TEST(BrokenSessions, AreAtLeastForty) {
  EXPECT_GE(names().size(), 40u);
}

}  // namespace
}  // namespace procam::calibrate
