#include "procam/report/verify.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analyze/verify_world.hpp"
#include "procam/core/base/words.hpp"

namespace procam::report {
namespace {

using analyze::Correct;
using analyze::VerifyResult;
using test::correcting;
using test::turned_by;

TEST(VerifyPicture, DrawsEveryMarkOnceAndIsStable) {
  test::VerifyWorld world;
  world.bump_projector(turned_by(0.2));
  const VerifyResult result = world.verified(correcting(Correct::kProjector));
  const std::string picture = verify_picture(result, {{0, 0}, {1, 0}, {1, 0.8}, {0, 0.8}});
  EXPECT_EQ(picture, verify_picture(result, {{0, 0}, {1, 0}, {1, 0.8}, {0, 0.8}}));
  std::size_t regions = 0;
  for (std::size_t at = picture.find("<ellipse"); at != std::string::npos;
       at = picture.find("<ellipse", at + 1))
    ++regions;
  EXPECT_EQ(regions, result.marks.size());
  EXPECT_EQ(picture.rfind("<svg xmlns", 0), 0u);
  EXPECT_EQ(picture.find("nan"), std::string::npos);
}

TEST(VerifyJson, HasEveryMarkAndBothMovements) {
  test::VerifyWorld world;
  world.bump_projector(turned_by(0.2));
  const VerifyResult result = world.verified(correcting(Correct::kProjector));
  const auto json = nlohmann::json::parse(to_json(result));
  EXPECT_EQ(json.at("alarm"), true);
  EXPECT_EQ(json.at("rms_mm"), 1e3 * result.rms);
  EXPECT_EQ(json.at("false_alarm_rate"), 1e-3);
  EXPECT_EQ(json.at("marks").size(), result.marks.size());
  EXPECT_EQ(json.at("marks")[3].at("error_mm")[1], 1e3 * result.marks[3].error.y());
  EXPECT_EQ(json.at("projector_moved").at("what"), "lamp");
  EXPECT_EQ(json.at("surface_moved").at("what"), "wall");
}

/// A person reads the verdict in a few lines; every mark is in the table.
TEST(VerifyLines, AreAFewAndTheTableHasEveryMark) {
  test::VerifyWorld world;
  world.bump_projector(turned_by(0.2));
  const VerifyResult result = world.verified(correcting(Correct::kProjector));
  const auto text = lines(result);
  ASSERT_LE(text.size(), 6u);
  EXPECT_EQ(text.front().rfind("ALARM      error on 'wall': ", 0), 0u) << text.front();
  EXPECT_EQ(text[1], "cause 1    " + description(result.projector_moved));
  EXPECT_EQ(text[3].rfind("odds       cause 1 is ", 0), 0u) << text[3];

  const auto tables = verify_tables(result);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].name, "marks.csv");
  const std::string& table = tables[0].text;
  EXPECT_EQ(std::size_t(std::count(table.begin(), table.end(), '\n')), result.marks.size() + 1);
  const std::size_t begin = table.find("\n3,") + 1;
  const std::string row = table.substr(begin, table.find('\n', begin) - begin);
  EXPECT_NE(row.find("," + shortest(1e3 * result.marks[3].error.y(), 12) + ","), std::string::npos) << row;
}

}  // namespace
}  // namespace procam::report
