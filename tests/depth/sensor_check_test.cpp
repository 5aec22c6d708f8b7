// What a depth camera's intrinsics show about the stream that they are of.
#include "procam/depth/sensor_check.hpp"

#include <gtest/gtest.h>

namespace procam::depth {
namespace {

TEST(CheckIntrinsics, NamesThoseOfAnotherStream) {
  const auto found = [](ImageSize size, double cx, double cy) {
    return check_intrinsics({size, {585, 580, cx, cy, 0}, NoDistortion{}});
  };
  EXPECT_TRUE(found({640, 480}, 313.2, 244.9).items.empty());
  EXPECT_TRUE(found({640, 480}, 251.3, 301.8).items.empty()) << "a sensor that is shifted";
  // Of the 1280x960 colour image, of a quarter of the size, and with one coordinate off.
  for (const auto& [cx, cy] : {std::pair(639.5, 479.5), std::pair(78.1, 61.0), std::pair(319.5, 479.5)}) {
    const Diagnostics diagnostics = found({640, 480}, cx, cy);
    const Diagnostic* warning = diagnostics.find("principal_point");
    ASSERT_TRUE(warning) << cx;
    EXPECT_NE(warning->message.find("colour camera"), std::string::npos);
    EXPECT_NE(warning->message.find("640x480"), std::string::npos);
  }
}

}  // namespace
}  // namespace procam::depth
