/// Of two pages neither overwrites the other's change without noticing.
#include "edit_log.hpp"

#include <gtest/gtest.h>

namespace procam::studio {
namespace {

StudioCommand corner(const std::string& page, int number, std::optional<double> seen) {
  StudioCommand command{"corner", "wall 1", "", {double(number), 300, 200}};
  command.page = page;
  command.seen = seen;
  return command;
}
StudioCommand of_page(StudioCommand command, const std::string& page, std::optional<double> seen) {
  command.page = page;
  command.seen = seen;
  return command;
}

TEST(EditLog, AnotherPagesNewerChangeIsAConflict) {
  EditLog log;
  const double before = double(log.revision());
  log.record(corner("b", 2, before));
  EXPECT_EQ(log.conflict(corner("a", 2, before)).value_or(""), "corner 3 of 'wall 1'");
  EXPECT_FALSE(log.conflict(corner("a", 2, double(log.revision()))));
  // The same corner by its light.
  EXPECT_TRUE(log.conflict(of_page({"corner_in_frame", "wall 1", "", {2, 300, 200}}, "a", before)));
  // Other corners, other surfaces, one's own changes and scripts.
  EXPECT_FALSE(log.conflict(corner("a", 1, before)));
  EXPECT_FALSE(log.conflict(corner("b", 2, before)));
  EXPECT_FALSE(log.conflict(corner("a", 2, std::nullopt)));
  EXPECT_FALSE(log.conflict(of_page({"corner", "wall 2", "", {2, 300, 200}}, "a", before)));
  EXPECT_FALSE(log.conflict(of_page({"content", "wall 1", "#ff0000", {}}, "a", before)));
}

/// b's own later change does not hide the one of c.
TEST(EditLog, AThirdPageCountsToo) {
  EditLog log;
  const double before = double(log.revision());
  log.record(corner("c", 0, before));
  log.record(corner("b", 0, double(log.revision())));
  EXPECT_TRUE(log.conflict(corner("a", 0, before)));
  EXPECT_TRUE(log.conflict(corner("b", 0, before)));
}

TEST(EditLog, ARemovedSurfaceConflictsWithEveryEditOfIt) {
  EditLog log;
  const double before = double(log.revision());
  log.record(of_page({"remove", "wall 1", "", {}}, "b", before));
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(log.conflict(corner("a", i, before))) << i;
  EXPECT_TRUE(log.conflict(of_page({"content", "wall 1", "#ff0000", {}}, "a", before)));
  EXPECT_EQ(log.newest().thing, "'wall 1'");
  // And the other way round: what b removes, a has just moved.
  EditLog other;
  other.record(corner("a", 3, before));
  EXPECT_TRUE(other.conflict(of_page({"remove", "wall 1", "", {}}, "b", before)));
}

TEST(EditLog, EverySettingIsAnEditAndNavigationIsNone) {
  for (const char* verb : {"display", "camera", "camera_size", "exposure", "board", "paper", "measured",
                           "views", "accept", "measure_by", "depth", "marker"}) {
    EditLog log;
    const double before = double(log.revision());
    log.record(of_page({verb, "", "1", {1}}, "b", before));
    EXPECT_TRUE(log.conflict(of_page({verb, "", "2", {2}}, "a", before))) << verb;
  }
  EditLog log;
  const auto before = log.revision();
  for (const char* verb : {"step", "capture", "stop", "show", "light"})
    log.record(of_page({verb, "", "", {}}, "b", 1));
  EXPECT_EQ(log.revision(), before);
}

/// What is held is kept until its page decides; other pages cannot take it.
TEST(EditLog, HoldsUntilThePageDecides) {
  EditLog log;
  log.hold(corner("a", 2, 1), "corner 3 of 'wall 1'");
  EXPECT_FALSE(log.take_held("b"));
  const auto held = log.take_held("a");
  ASSERT_TRUE(held);
  EXPECT_EQ(held->command.numbers, (std::vector<double>{2, 300, 200}));
  EXPECT_FALSE(log.take_held("a"));
  for (int i = 0; i < 1000; ++i) log.hold(corner("page" + std::to_string(i), 0, 1), "x");
  EXPECT_LT(log.held().size(), 100u);
}

TEST(StudioCommand, NamesItsPageAndWhatItSaw) {
  const auto command = to_studio_command(R"({"do":"views","numbers":[5],"page":"k3x","seen":7})");
  ASSERT_TRUE(command);
  EXPECT_EQ(command->page, "k3x");
  EXPECT_EQ(command->seen, 7);
  EXPECT_FALSE(to_studio_command(R"({"do":"views","seen":"7"})"));
  EXPECT_FALSE(to_studio_command(R"({"do":"views","page":")" + std::string(33, 'x') + "\"}"));
}

}  // namespace
}  // namespace procam::studio
