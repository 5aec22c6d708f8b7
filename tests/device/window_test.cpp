/// A real window under Xvfb: are its pixels those that were given?
#include <gtest/gtest.h>

#include <random>

#include "procam/device/frame_sink.hpp"
#include "support/virtual_screen.hpp"
#ifdef PROCAM_TEST_SCREEN
#include "support/screen_pixels.hpp"
#endif

namespace procam::device {
namespace {

#ifdef PROCAM_TEST_SCREEN

/// Odd sizes, since rows of textures are often padded; every grey level; each picture replaces the one
/// before.
TEST(Window, ShowsEveryPixelAsItIs) {
  const test::VirtualScreen screen("323x241");
  if (!screen.is_running()) GTEST_SKIP() << "no Xvfb here";
  setenv("DISPLAY", screen.name().c_str(), 1);
  std::vector<Display> list;
  try {
    list = displays();
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].size, (ImageSize{323, 241}));
  const auto window = open_window(0);
  ASSERT_EQ(window->size(), (ImageSize{323, 241}));
  std::mt19937 random(5);
  for (int round = 0; round < 3; ++round) {
    // Rows of a larger picture: the view's stride is not its width.
    ImageU8 large(330, 241);
    for (int y = 0; y < large.height(); ++y)
      for (int x = 0; x < large.width(); ++x) large.at(x, y) = std::uint8_t(random() & 0xff);
    const double before = now_s();
    const double shown = window->show(ViewU8(large.data(), 323, 241, 1, 330));
    EXPECT_GE(shown, before);
    EXPECT_LE(shown, now_s());
    const ImageU8 seen = test::ScreenPixels(screen.name()).read(window->size());
    int different = 0;
    for (int y = 0; y < 241; ++y)
      for (int x = 0; x < 323; ++x)
        for (int c = 0; c < 3; ++c) different += seen.at(x, y, c) != large.at(x, y);
    EXPECT_EQ(different, 0) << "round " << round;
    EXPECT_TRUE(window->is_open());
  }
  EXPECT_THROW(window->show(ImageU8(322, 241)), std::invalid_argument);
  EXPECT_THROW(window->show(ImageU8(323, 241, 3)), std::invalid_argument);
  EXPECT_THROW(open_window(1), Error);
}

#else

TEST(Window, ShowsEveryPixelAsItIs) {
  GTEST_SKIP() << "built without X11's headers, with which the screen is read back";
}

#endif

}  // namespace
}  // namespace procam::device
