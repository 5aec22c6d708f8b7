#include "section_v/evaluation_page.hpp"

#include <gtest/gtest.h>

#include "analyze/uncertain_rig.hpp"

namespace procam::section_v {
namespace {

TEST(EvaluationPage, TellsTheTableAndTheVerdict) {
  const Rig rig = test::uncertain_rig();
  const Projector lamp = rig.projector().projector;
  const std::vector<Sheet> sheets = original_sheets();
  std::vector<SheetPlacement> placements = draw_placements(lamp, {}, 2);
  draw_crude_landings(placements, sheets, lamp, {1, {0.005, 0.006}}, 3);
  Evaluation evaluation = evaluate(sheets, placements, lamp);
  evaluation.rig = rig;
  Outcome outcome;
  outcome.evaluation = evaluation;
  outcome.verdict = {"First & foremost.", "Then this."};
  const std::string page = evaluation_report(outcome, "A <b> title");
  for (const char* words :
       {"A &lt;b&gt; title", "First &amp; foremost.", "Then this.", "47 degrees", "60 degrees", "top left",
        "physical x, y, mm", "id=\"rig\"", "enlarged", "1.60 m"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_LT(page.size(), 1000000u);
}

}  // namespace
}  // namespace procam::section_v
