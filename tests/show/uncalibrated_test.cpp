/// Shows without a calibrated rig: two commands to a first picture on a wall.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "io/scratch.hpp"
#include "kept_page.hpp"
#include "live_world.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/run.hpp"
#include "support/browser.hpp"
#include "support/expect_error.hpp"

namespace procam::show {
namespace {

ShowOptions without_rig(const test::Scratch& folder) {
  ShowOptions options;
  options.surfaces = (folder / "wall.json").string();
  options.output = "frames:" + (folder / "frames").string();
  options.size = ImageSize{320, 200};
  options.control = "off";
  options.fps = 50;
  options.duration_s = 0.2;
  return options;
}

ImageU8 first_frame(const test::Scratch& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "frames"))
    files.push_back(entry.path());
  EXPECT_FALSE(files.empty());
  std::sort(files.begin(), files.end());
  return io::load_image(files.front()).image;
}

std::array<int, 3> color(const ImageU8& frame, int x, int y) {
  return {frame.at(x, y, 0), frame.at(x, y, 1), frame.at(x, y, 2)};
}

TEST(RunWithoutRig, ANewFileGetsASurfaceForEachContent) {
  test::Scratch folder;
  ImageU8 picture(7, 5, 3);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) picture.at(x, y, 1) = 255;
  io::save_image(folder / "green.png", picture);
  ShowOptions options = without_rig(folder);
  options.contents = {{"door", (folder / "green.png").string()}, {"wall", "#ff0000"}};
  struct Sentences : ShowListener {
    std::string all;
    void on_start(const std::string& sentence) override { all += sentence + "\n"; }
  } sentences;
  const ShowReport report = run(options, &sentences);
  EXPECT_GT(report.metrics.frames, 0u);
  EXPECT_NE(sentences.all.find("is new, with 2 surfaces"), std::string::npos) << sentences.all;
  const ImageU8 frame = first_frame(folder);
  ASSERT_EQ(frame.size(), (ImageSize{320, 200}));
  using Color = std::array<int, 3>;
  EXPECT_EQ(color(frame, 80, 100), (Color{0, 255, 0}));
  EXPECT_EQ(color(frame, 240, 100), (Color{255, 0, 0}));
  for (const auto& [x, y] : {std::pair{5, 5}, {160, 100}, {315, 100}, {80, 195}})
    EXPECT_EQ(color(frame, x, y), (Color{0, 0, 0})) << x << ", " << y;
  const SurfaceSet saved = io::load_surfaces(options.surfaces);
  ASSERT_EQ(saved.surfaces.size(), 2u);
  EXPECT_EQ(saved.surfaces[0].content, "green.png") << "not the name on this computer";
}

TEST(RunWithoutRig, NineContentsHavePlaceSideBySide) {
  test::Scratch folder;
  ShowOptions options = without_rig(folder);
  for (int i = 0; i < 9; ++i) options.contents["s" + std::to_string(i)] = "#ffffff";
  run(options);
  double end = 0;
  for (const Surface& surface : io::load_surfaces(options.surfaces).surfaces) {
    const Points2& pixels = std::get<PixelSurface>(surface.geometry).pixels;
    EXPECT_GT(pixels[0].x(), end + 3) << surface.name;
    EXPECT_GT(pixels[1].x(), pixels[0].x() + 15) << surface.name;
    end = pixels[1].x();
  }
  EXPECT_LT(end, 320);
}

/// What a person does at the page, in a real browser: a corner is dragged and saved, and the next show begins with it.
class PageVisitor : public ShowListener {
 public:
  using Part = std::function<void(PageVisitor&, test::Browser&)>;
  explicit PageVisitor(Part part) : part_(std::move(part)) {}
  void on_start(const std::string& sentence) override {
    const std::string begin = "control page: ";
    if (sentence.rfind(begin, 0) == 0)
      person_ = std::thread([this, url = sentence.substr(begin.size())] { visit(url); });
  }
  void on_frame(const ShowReport&) override {
    if (left_) throw Left();
  }
  ~PageVisitor() override {
    if (person_.joinable()) person_.join();
  }
  struct Left {};
  std::string failed;

  void step(test::Browser& browser, const std::string& condition) {
    if (failed.empty() && !browser.wait_for(condition)) failed = condition + "\n" + browser.console();
  }
  /// The middle of a circle, in the page's pixels.
  static Vec2 circle(test::Browser& browser, int number) {
    const auto at = nlohmann::json::parse(
        browser.evaluate("(() => { const b = document.querySelectorAll('circle')[" + std::to_string(number) +
                         "].getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()"));
    return {at[0].get<double>(), at[1].get<double>()};
  }
  static void drag(test::Browser& browser, int number, double right, double down) {
    const Vec2 at = circle(browser, number);
    browser.mouse("mousePressed", at.x(), at.y());
    for (int i = 1; i <= 5; ++i) browser.mouse("mouseMoved", at.x() + right * i / 5, at.y() + down * i / 5);
    browser.mouse("mouseReleased", at.x() + right, at.y() + down);
  }
  static void click_in_frame(test::Browser& browser, double x, double y) {
    const auto box = nlohmann::json::parse(browser.evaluate(
        "(() => { const b = $('marks').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()"));
    const double at_x = box[0].get<double>() + (x + 0.5) / 320 * box[2].get<double>(),
                 at_y = box[1].get<double>() + (y + 0.5) / 200 * box[3].get<double>();
    browser.mouse("mousePressed", at_x, at_y);
    browser.mouse("mouseReleased", at_x, at_y);
  }

 private:
  void visit(const std::string& url) {
    test::Browser browser(1100, 760);
    browser.open(url);
    step(browser, "document.querySelectorAll('circle').length === 4 && $('frame').naturalWidth === 320");
    step(browser, "[...document.querySelectorAll('.moving')].every(item => item.hidden)");
    if (failed.empty()) part_(*this, browser);
    if (failed.empty()) {
      step(browser, "status.unsaved");
      browser.evaluate("$('save').click()");
      step(browser, "!status.unsaved");
    }
    left_ = true;
  }
  const Part part_;
  std::atomic<bool> left_{false};
  std::thread person_;
};

TEST(RunWithoutRig, ACornerDraggedAtThePageIsKept) {
  test::Scratch folder;
  ShowOptions options = without_rig(folder);
  options.output = "none";
  options.control = "0";
  options.duration_s = 120;
  {
    PageVisitor visitor([](PageVisitor&, test::Browser& browser) { PageVisitor::drag(browser, 0, 60, 45); });
    EXPECT_THROW(run(options, &visitor), PageVisitor::Left);
    EXPECT_EQ(visitor.failed, "");
  }
  const SurfaceSet saved = io::load_surfaces(options.surfaces);
  ASSERT_EQ(saved.surfaces.size(), 1u);
  const Points2 pixels = std::get<PixelSurface>(saved.surfaces[0].geometry).pixels;
  EXPECT_GT(pixels[0].x(), 40);  // from 32, 20
  EXPECT_GT(pixels[0].y(), 26);
  EXPECT_EQ(pixels[2], Vec2(288, 180));
  run(without_rig(folder));
  const ImageU8 frame = first_frame(folder);
  EXPECT_EQ(color(frame, 36, 24), (std::array<int, 3>{0, 0, 0}));
  EXPECT_EQ(color(frame, 200, 150), (std::array<int, 3>{255, 255, 255}));
}

/// A grid whose middle is dragged, and a part that stays dark, without rig and camera.
TEST(RunWithoutRig, ASurfaceIsBentAndMaskedAtThePage) {
  test::Scratch folder;
  ShowOptions options = without_rig(folder);
  options.output = "none";
  options.control = "0";
  options.duration_s = 120;
  {
    PageVisitor visitor([](PageVisitor& person, test::Browser& browser) {
      browser.evaluate("$('shape').value = 'grid 3x3'; $('shape').onchange()");
      person.step(
          browser,
          "status.surfaces[0].shape === 'grid 3x3' && document.querySelectorAll('circle').length === 9");
      person.step(browser, "document.querySelectorAll('polyline.net').length === 6");
      if (!person.failed.empty()) return;
      PageVisitor::drag(browser, 1, 15, 60);  // the upper edge's middle
      person.step(browser, "drag === null && $('place').textContent.includes('point 2')");
      browser.evaluate("$('mask').click()");
      for (const auto& [x, y] : {std::pair(200, 110), {240, 115}, {230, 160}, {195, 150}, {200, 110}})
        PageVisitor::click_in_frame(browser, x, y);
      person.step(browser,
                  "status.surfaces[0].masks.length === 1 && masking === null && !$('unmask').hidden");
      person.step(browser, "document.querySelectorAll('polygon.mask').length === 1");
      keep_page(browser, "control_grid_and_mask.png");
      // One that is not finished leaves nothing.
      browser.evaluate("$('mask').click()");
      PageVisitor::click_in_frame(browser, 100, 100);
      person.step(browser, "masking !== null && masking.length === 1");
      browser.press("Escape");
      person.step(browser, "masking === null && document.querySelectorAll('circle').length === 9");
      if (person.failed.empty()) person.failed = browser.console();
    });
    EXPECT_THROW(run(options, &visitor), PageVisitor::Left);
    EXPECT_EQ(visitor.failed, "");
  }
  const SurfaceSet saved = io::load_surfaces(options.surfaces);
  const auto& bent = std::get<PixelSurface>(saved.surfaces.at(0).geometry);
  EXPECT_EQ(bent.shape, PixelShape::kGrid);
  EXPECT_GT(bent.pixels.at(1).y(), 35) << "from 20";
  ASSERT_EQ(saved.surfaces[0].shape.holes.size(), 1u);
  run(without_rig(folder));
  const ImageU8 frame = first_frame(folder);
  const std::array<int, 3> black = {0, 0, 0}, white = {255, 255, 255};
  EXPECT_EQ(color(frame, 215, 130), black) << "the mask";
  EXPECT_EQ(color(frame, 160, 24), black) << "above the edge that was dragged";
  EXPECT_EQ(color(frame, 40, 24), white) << "at the corner";
  EXPECT_EQ(color(frame, 100, 150), white);
}

TEST(RunWithoutRig, CornersOfTheFileAreUsed) {
  test::Scratch folder;
  ShowOptions options = without_rig(folder);
  PixelSurface corner;
  corner.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  corner.pixels = {{200, 20}, {310, 30}, {300, 90}, {205, 95}};
  io::save_surfaces(options.surfaces, {{{"wall", corner, {}, "#0000ff"}}});
  run(options);
  const ImageU8 frame = first_frame(folder);
  EXPECT_EQ(frame.at(250, 60, 2), 255);
  EXPECT_EQ(frame.at(195, 60, 2), 0);
  EXPECT_EQ(frame.at(250, 100, 2), 0);
}

TEST(RunWithoutRig, WhatNeedsARigIsRefused) {
  test::Scratch folder;
  const auto refused = [&](const std::function<void(ShowOptions&)>& change, const char* what) {
    ShowOptions options = without_rig(folder);
    change(options);
    EXPECT_ERROR(run(options), kInput, what);
  };
  refused([](ShowOptions& o) { o.poses = {"udp:0"}; }, "pose source");
  refused([](ShowOptions& o) { o.pose = "pose.json"; }, "pose");
  refused([](ShowOptions& o) { o.surfaces = "depth:watch:folder"; }, "depth camera");
  refused([](ShowOptions& o) { o.record = "run.log"; }, "record");
  refused([](ShowOptions& o) { o.size.reset(); }, "size");
  EXPECT_FALSE(std::filesystem::exists(folder / "wall.json"));
  io::save_surfaces(folder / "wall.json", small_show().surfaces);
  refused([](ShowOptions&) {}, "placed in metres");
}

}  // namespace
}  // namespace procam::show
