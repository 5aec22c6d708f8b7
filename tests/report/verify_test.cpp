#include "procam/report/verify.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace procam::report
