#include "procam/report/verify.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "analyze/verify_world.hpp"

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
  const auto said = lines(result);
  EXPECT_EQ(said.front().rfind("ALARM: light on 'wall' lies ", 0), 0u) << said.front();
  EXPECT_EQ(said[1], "either " + description(result.projector_moved));
}

}  // namespace
}  // namespace procam::report
