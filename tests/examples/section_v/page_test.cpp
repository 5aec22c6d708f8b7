#include "section_v/evaluation_page.hpp"

#include <gtest/gtest.h>

#include "analyze/uncertain_rig.hpp"

namespace procam::section_v {
namespace {

TEST(EvaluationPage, TellsTheTableAndTheVerdict) {
  const Rig rig = test::uncertain_rig();
  const Projector lamp = rig.projector().projector;
  const std::vector<Sheet> sheets = original_sheets();
  std::vector<SheetPlacement> placements = original_placements(lamp, sheets, 2);
  draw_crude_landings(placements, sheets, lamp, {1, {0.005, 0.006}}, 3);
  Evaluation evaluation = evaluate(sheets, placements, lamp);
  evaluation.rig = rig;
  const std::string page = evaluation_report(evaluation, "A <b> title", {"First & foremost.", "Then this."});
  for (const char* words : {"A &lt;b&gt; title", "First &amp; foremost.", "Then this.", "47 degrees",
                            "60 degrees", "top left", "physical x, y, cm", "id=\"rig\"", "to scale"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_LT(page.size(), 1000000u);
}

}  // namespace
}  // namespace procam::section_v
