/// A real window under Xvfb: are its pixels those that were given?
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "procam/device/frame_sink.hpp"
#include "support/virtual_screen.hpp"
#ifdef PROCAM_TEST_SCREEN
#include "support/screen_pixels.hpp"
#endif

namespace procam::device {
namespace {

#ifdef PROCAM_TEST_SCREEN

/// One for all tests of this program: GLFW stays connected to the first. Odd sizes, since rows of textures
/// are often padded.
constexpr ImageSize kScreen{323, 241};
const test::VirtualScreen& virtual_screen() {
  static const test::VirtualScreen screen("323x241");
  setenv("DISPLAY", screen.name().c_str(), 1);
  return screen;
}

/// What is pressed arrives within some events; a second is for a slow server.
WindowEvent wish_after(const std::string& key, const test::ScreenPixels& screen, FrameSink& window) {
  screen.press(key);
  for (int i = 0; i < 100; ++i) {
    const WindowEvent wish = window.poll();
    if (wish != WindowEvent::kNone) return wish;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return WindowEvent::kNone;
}

/// Every grey level; each picture replaces the one
/// before.
TEST(Window, ShowsEveryPixelAsItIs) {
  const test::VirtualScreen& screen = virtual_screen();
  if (!screen.is_running()) GTEST_SKIP() << "no Xvfb here";
  std::vector<Display> list;
  try {
    list = displays();
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].size, kScreen);
  const auto window = open_window(0);
  ASSERT_EQ(window->size(), kScreen);
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
    EXPECT_EQ(window->poll(), WindowEvent::kNone);
  }
  // A moving picture in colour, frame by frame.
  for (int round = 0; round < 4; ++round) {
    ImageU8 colour(kScreen, 3);
    for (int i = 0; i < 323 * 241 * 3; ++i) colour.data()[i] = std::uint8_t(random() & 0xff);
    window->show_next(colour);
    const ImageU8 seen = test::ScreenPixels(screen.name()).read(window->size());
    int different = 0;
    for (int y = 0; y < 241; ++y)
      for (int x = 0; x < 323; ++x)
        for (int c = 0; c < 3; ++c) different += seen.at(x, y, c) != colour.at(x, y, c);
    EXPECT_EQ(different, 0) << "colour, round " << round;
  }
  EXPECT_THROW(window->show(ImageU8(322, 241)), std::invalid_argument);
  EXPECT_THROW(window->show(ImageU8(323, 241, 4)), std::invalid_argument);
  EXPECT_THROW(open_window(1), Error);
}

TEST(Window, HearsWhatIsTyped) {
  const test::VirtualScreen& screen = virtual_screen();
  if (!screen.is_running()) GTEST_SKIP() << "no Xvfb here";
  std::unique_ptr<FrameSink> window;
  try {
    window = open_window(0);
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  window->show(ImageU8(kScreen));
  const test::ScreenPixels keyboard(screen.name());
  const std::pair<const char*, WindowEvent> keys[] = {
      {"Return", WindowEvent::kGoOn}, {"space", WindowEvent::kGoOn}, {"n", WindowEvent::kGoOn},
      {"h", WindowEvent::kHelp},      {"g", WindowEvent::kGrid},     {"m", WindowEvent::kMask},
      {"f", WindowEvent::kFreeze}};
  for (const auto& [key, wish] : keys) {
    EXPECT_EQ(wish_after(key, keyboard, *window), wish) << key;
    EXPECT_EQ(window->poll(), WindowEvent::kNone) << key << " was told twice";
  }
  // Keys that are held are no wishes, and several may be down at once.
  const std::pair<const char*, Key> held[] = {{"w", Key::kW},   {"a", Key::kA},       {"s", Key::kS},
                                              {"d", Key::kD},   {"Left", Key::kLeft}, {"Right", Key::kRight},
                                              {"Up", Key::kUp}, {"Down", Key::kDown}};
  const auto until = [&](Key key, bool is_down) {
    for (int i = 0; i < 100 && window->is_down(key) != is_down; ++i) {
      EXPECT_EQ(window->poll(), WindowEvent::kNone);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return window->is_down(key) == is_down;
  };
  for (const auto& [name, key] : held) {
    EXPECT_FALSE(window->is_down(key)) << name;
    keyboard.press(name);
    EXPECT_TRUE(until(key, true)) << name;
  }
  EXPECT_TRUE(window->is_down(Key::kW));
  for (const auto& [name, key] : held) {
    keyboard.release(name);
    EXPECT_TRUE(until(key, false)) << name;
  }
  EXPECT_EQ(wish_after("Escape", keyboard, *window), WindowEvent::kClose);
  EXPECT_EQ(window->poll(), WindowEvent::kClose);
}

#else

TEST(Window, ShowsEveryPixelAsItIs) {
  GTEST_SKIP() << "built without X11's headers, with which the screen is read back";
}

#endif

}  // namespace
}  // namespace procam::device
