/// Several projectors of one rig in one process: the same show in all frames, blended.
#include "side_screens.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "corner_world.hpp"
#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/run.hpp"
#include "support/expect_error.hpp"

namespace procam::show {
namespace {

/// Keeps all of them, and counts those for which no refresh was awaited.
class AllFrames : public KeptFrames {
 public:
  using KeptFrames::KeptFrames;
  double show(ViewU8 picture) override {
    const double time = KeptFrames::show(picture);
    frames.push_back(last());
    return time;
  }
  double show_soon(ViewU8 picture) override {
    ++soon;
    return show(picture);
  }
  std::vector<ImageU8> frames;
  int soon = 0;
};

int differences(const ImageU8& a, const ImageU8& b) {
  if (a.size() != b.size() || a.channels() != b.channels()) return -1;
  int different = 0;
  for (int i = 0; i < a.width() * a.height() * a.channels(); ++i) different += a.data()[i] != b.data()[i];
  return different;
}

/// Gives commands after a number of frames.
struct Script : ShowListener {
  explicit Script(std::map<std::uint64_t, std::string> by_frame) : by_frame_(std::move(by_frame)) {}
  void on_frame(const ShowReport& report) override {
    last = report.metrics;
    if (after_frame) after_frame(last);
  }
  void on_event(const std::string& sentence) override { events.push_back(sentence); }
  std::vector<std::string> commands() override {
    const auto due = by_frame_.find(last.frames);
    if (due == by_frame_.end()) return {};
    const std::string text = due->second;
    by_frame_.erase(due);
    return {text};
  }
  std::function<void(const Metrics&)> after_frame;
  Metrics last;
  std::vector<std::string> events;

 private:
  std::map<std::uint64_t, std::string> by_frame_;
};

class SideScreensTest : public testing::Test {
 protected:
  SideScreensTest() {
    io::save_image(folder_ / "picture.png", colourful(61, 47, 2));
    for (Surface& surface : corner_.surfaces.surfaces) surface.content = "picture.png";
    io::save_surfaces(folder_ / "surfaces.json", corner_.surfaces);
    io::save_pose(folder_ / "pose.json", {"rig", "world", {corner_.rig_from_world, Mat6::Zero()}});
    options_.surfaces = folder_ / "surfaces.json";
    options_.pose = folder_ / "pose.json";
    options_.control = "off";
    options_.fps = 40;
    options_.duration_s = 0.5;
  }
  ShowReport show(ShowListener* listener = nullptr) {
    left_.emplace(corner_.rig.projector("left").projector.size());
    right_.emplace(corner_.rig.projector("right").projector.size());
    return run(corner_.rig, options_, {{"left", *left_}, {"right", *right_}}, listener);
  }

  test::Scratch folder_;
  Corner corner_;
  ShowOptions options_;
  std::optional<AllFrames> left_, right_;
};

TEST_F(SideScreensTest, EachFrameIsThatOfAShowOfItsProjectorAlone) {
  const ShowReport report = show();
  EXPECT_GE(report.metrics.frames, 3u);
  ASSERT_EQ(left_->frames.size(), report.metrics.frames);
  ASSERT_EQ(right_->frames.size(), report.metrics.frames);
  EXPECT_EQ(std::size_t(right_->soon), right_->frames.size()) << "only the first one waits for its display";
  EXPECT_EQ(left_->soon, 0);
  ASSERT_TRUE(report.metrics.blend);
  EXPECT_EQ(report.metrics.blend->projectors, (ProjectorNames{"left", "right"}));
  const ImageU8 content = colourful(61, 47, 2);
  EXPECT_EQ(differences(left_->frames.back(), corner_.frame("left", {"left", "right"}, content)), 0);
  EXPECT_EQ(differences(right_->frames.back(), corner_.frame("right", {"left", "right"}, content)), 0);
  options_.blend.emplace().projectors = {"off"};
  EXPECT_FALSE(show().metrics.blend);
  EXPECT_GT(differences(right_->frames.back(), corner_.frame("right", {"left", "right"}, content)), 1000);
  options_.blend->projectors = {"far"};
  show();
  EXPECT_EQ(differences(left_->frames.back(), corner_.frame("left", {"far", "left", "right"}, content)), 0);
}

TEST_F(SideScreensTest, EditsAndPicturesReachAllInOneFrame) {
  options_.duration_s = 60;
  Script script({{3, R"({"do":"screen","text":"right"})"},
                 {4, R"({"do":"nudge","surface":"left wall","point":1,"pixels":[25,-14]})"},
                 {12, R"({"do":"screen","text":"middle"})"},
                 {14, R"({"do":"picture","text":"mask"})"}});
  // The map after the edit is made in the background.
  script.after_frame = [&](const Metrics& metrics) {
    if (metrics.frames >= 20 && metrics.blend && metrics.blend->changes >= 2)
      left_->wish(device::WindowEvent::kClose);
  };
  const ShowReport report = show(&script);
  ASSERT_GE(report.metrics.frames, 20u);
  const auto drawn = [&](const AllFrames& screen, std::size_t i) { return screen.frames.at(i); };
  for (const AllFrames* screen : {&*left_, &*right_}) {
    EXPECT_EQ(differences(drawn(*screen, 0), drawn(*screen, 3)), 0);
    EXPECT_GT(differences(drawn(*screen, 3), drawn(*screen, 5)), 200);
  }
  // Test patterns are blended as well, so that the map's turn to the edited corner changes frames of the mask.
  std::size_t first_mask[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    const AllFrames& screen = k == 0 ? *left_ : *right_;
    while (first_mask[k] < screen.frames.size() &&
           differences(screen.frames[first_mask[k]], screen.frames.back()) != 0)
      ++first_mask[k];
  }
  EXPECT_EQ(first_mask[0], first_mask[1]) << "both turn in the same frame";
  EXPECT_GE(first_mask[0], 14u);
  ASSERT_FALSE(script.events.empty());
  EXPECT_TRUE(std::any_of(script.events.begin(), script.events.end(), [](const std::string& sentence) {
    return sentence.find("screen 'middle'") != std::string::npos;
  }));
  EXPECT_GE(report.metrics.blend->changes, 2u) << "the first one, and after the edit";
}

/// A camera's newest picture may change between two frames of one moment.
TEST_F(SideScreensTest, LivePicturesAreTheSameInAllFrames) {
  int drawn = 0;
  const auto counting = [&] {
    return device::drawn_content({8, 8}, 3, [&](double, ImageView<std::uint8_t> picture) {
      const auto value = std::uint8_t(40 + 10 * (++drawn % 20));
      for (int y = 0; y < 8; ++y) std::fill_n(picture.row(y), 24, value);
      return true;
    });
  };
  const auto projection_of = [&](const std::string& name) {
    ProjectionOptions options;
    options.projector = name;
    options.projector_from_world = corner_.projector_from_world(name);
    return Projection(corner_.rig, options);
  };
  Projection first = projection_of("left"), second = projection_of("right");
  Show live;
  live.surfaces = corner_.surfaces;
  live.contents = {counting(), nullptr};
  first.set_show(live);
  AllFrames sink(second.frame_size());
  SideScreens sides(first, {{"right", second, sink}});
  ImageU8 frame(first.frame_size(), 3);
  for (int i = 0; i < 3; ++i) {
    first.draw(0, i, frame);
    sides.draw(0, [](const std::string& sentence) { ADD_FAILURE() << sentence; });
    sides.show();
    const auto brightest = [](const ImageU8& image) {
      return *std::max_element(image.data(), image.data() + image.width() * image.height() * 3);
    };
    EXPECT_EQ(drawn, i + 1) << "the second projector asks for no other picture";
    EXPECT_EQ(brightest(frame), brightest(sink.frames.back()));
  }
  // A surface that cannot be shown leaves the show from before in all.
  Show wrong = live;
  wrong.surfaces.surfaces[0].name.clear();
  EXPECT_THROW(first.set_show(wrong), std::exception);
}

TEST_F(SideScreensTest, AKeyInAnyWindowCounts) {
  Script script({});
  script.after_frame = [&](const Metrics& metrics) {
    if (metrics.frames == 5) right_->wish(device::WindowEvent::kClose);
  };
  options_.duration_s = 20;
  EXPECT_LE(show(&script).metrics.frames, 8u);
}

TEST_F(SideScreensTest, WhatOneProcessCannotDoIsRefused) {
  KeptFrames left({320, 240}), right({400, 250});
  EXPECT_ERROR(run(corner_.rig, options_, {{"left", left}}), kInput, "there is only one");
  EXPECT_ERROR(run(corner_.rig, options_, {{"left", left}, {"left", right}}), kInput, "'left' has two");
  EXPECT_ERROR(run(corner_.rig, options_, {{"left", left}, {"middle", right}}), kInput, "middle");
  EXPECT_THROW(run(corner_.rig, options_, {{"left", right}, {"right", left}}), std::invalid_argument);
  ShowOptions options = options_;
  options.screens = {{"left", std::nullopt, "none"}, {"right", std::nullopt, "none"}};
  options.record = folder_ / "run.log";
  EXPECT_ERROR(run(corner_.rig, options), kInput, "record");
  options.record.clear();
  options.output = "none";
  EXPECT_ERROR(run(corner_.rig, options), kInput, "leave them out");
  EXPECT_ERROR(run(options), kInput, "screens");
}

TEST(ParseScreen, ADisplayOrAnOutput) {
  EXPECT_EQ(parse_screen("left=1").display, "1");
  EXPECT_EQ(parse_screen("left=1,920").display, "1,920");
  const ScreenOutput file = parse_screen("the left=frames:out/left");
  EXPECT_EQ(file.projector, "the left");
  EXPECT_FALSE(file.display);
  EXPECT_EQ(file.output, "frames:out/left");
  for (const char* wrong : {"", "left", "left=", "=1"}) EXPECT_ERROR(parse_screen(wrong), kInput, "left=1");
}

}  // namespace
}  // namespace procam::show
