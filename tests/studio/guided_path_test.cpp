/// The whole path in a real browser, from an empty folder to content on a simulated wall whose true error is known.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <memory>

#include "io/scratch.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "projector_screens.hpp"
#include "running_studio.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct PathOptions {
  std::vector<std::string> tool;
  int views = 4;
  int patience_s = 200;  ///< without any progress; a busy machine takes many times as long for a step
  std::string screenshots;
  bool kill = false;  ///< kill -9 after each step and within a pose; then the page is opened anew
};

/// A picture with something to see, its colors rotated.
ImageU8 striped_content(int turn) {
  ImageU8 image(96, 60, 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      image.at(x, y, turn) = std::uint8_t(2 * x);
      image.at(x, y, (turn + 1) % 3) = (x / 12 + y / 12) % 2 == 0 ? 230 : 40;
      image.at(x, y, (turn + 2) % 3) = std::uint8_t(4 * y);
    }
  return image;
}

int run_command(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1 </dev/null").c_str());
}

class GuidedPath {
 public:
  GuidedPath(const fs::path& project, const PathOptions& options) : project_(project), options_(options) {}

  void display_and_camera(test::Person& person) {
    ASSERT_TRUE(person.choose("display", "simulated"));
    ASSERT_TRUE(person.wait("state.display.open"));
    picture(person, "1_display");
    ASSERT_TRUE(person.click("document.querySelector('[data-go=camera]')"));
    ASSERT_TRUE(person.wait("state.step === 'camera'"));
    ASSERT_TRUE(person.choose("camera", "simulated"));
    ASSERT_TRUE(person.wait("state.camera.open && state.camera.size[0] > 0 && $('image').naturalWidth > 0"));
    ASSERT_TRUE(person.click("$('check')"));
    finish(person, "state.steps[1].done && state.lit.length === 1 && state.lit[0]");
    picture(person, "2_camera");
  }
  void board(test::Person& person) {
    ASSERT_TRUE(person.click("document.querySelector('[data-go=board]')"));
    ASSERT_TRUE(person.wait("state.step === 'board'"));
    ASSERT_TRUE(person.choose("paper", "a3"));
    ASSERT_TRUE(person.wait("state.board.paper === 'a3'"));
    ASSERT_TRUE(person.choose("board", "chessboard:9x6:30mm"));
    ASSERT_TRUE(person.click("$('make_board')"));
    ASSERT_TRUE(person.wait("state.board.text === 'chessboard:9x6:30mm'")) << person.state("error");
    EXPECT_TRUE(fs::exists(project_ / "board.pdf"));
    picture(person, "3_board");
  }
  /// Until the first frames of the second pose are on disk.
  void begin_capture(test::Person& person) {
    ASSERT_TRUE(person.click("document.querySelector('[data-go=capture]')"));
    ASSERT_TRUE(person.wait("state.step === 'capture'"));
    ASSERT_TRUE(person.enter("views", std::to_string(options_.views)));
    ASSERT_TRUE(person.wait("state.capture.wanted === " + std::to_string(options_.views)));
    ASSERT_TRUE(person.click("$('capture')"));
    ASSERT_TRUE(person.wait("state.doing.startsWith('view_01') && state.done > 10", options_.patience_s));
  }
  void continue_capture(test::Person& person) {
    EXPECT_EQ(person.state("capture.views"), 1);
    ASSERT_TRUE(person.click("$('capture')"));
    finish(person, "state.steps[3].done");
    const std::string log = io::read_file(project_.string() + ".log");
    EXPECT_NE(log.find("frames of an earlier run: the board has not moved"), std::string::npos) << log;
  }
  void capture(test::Person& person) {
    ASSERT_TRUE(person.click("document.querySelector('[data-go=capture]')"));
    ASSERT_TRUE(person.wait("state.step === 'capture'"));
    ASSERT_TRUE(person.enter("views", std::to_string(options_.views)));
    ASSERT_TRUE(person.wait("state.capture.wanted === " + std::to_string(options_.views)));
    person.note("corners_and_outline", "state.capture.corners.length === 54 && !!state.capture.next");
    person.note("coverage_while_capturing",
                "state.job !== '' && state.capture.camera_coverage > 1 && "
                "state.capture.projector_coverage > 1");
    person.note(
        "outline_by_the_lit_box",
        "state.capture.views < 3 && !!state.capture.next && state.capture.next.in_frame.length === 4");
    person.note("outline_by_the_rig",
                "state.capture.views >= 3 && !!state.capture.next && "
                "state.capture.next.words.includes('predicted error') && "
                "state.capture.next.in_frame.length === 4");
    ASSERT_TRUE(person.click("$('capture')"));
    expect_outline_in_light(person);
    picture(person, "4_outline");
    ASSERT_TRUE(person.wait("window.corners_and_outline === true", options_.patience_s));
    picture(person, "4_capture");
    finish(person, "state.steps[3].done");
    EXPECT_TRUE(person.wait("window.coverage_while_capturing === true"));
    EXPECT_EQ(person.browser().evaluate("window.outline_by_the_lit_box === true"), "true");
    if (options_.views > 3)
      EXPECT_EQ(person.browser().evaluate("window.outline_by_the_rig === true"), "true");
  }
  void calibrate(test::Person& person) {
    ASSERT_TRUE(person.click("document.querySelector('[data-go=calibrate]')"));
    ASSERT_TRUE(person.click("$('calibrate')"));
    finish(person, "state.rig.there");
    picture(person, "5_calibrate");
  }
  void surfaces(test::Person& person) {
    ASSERT_TRUE(person.click("document.querySelector('[data-go=surfaces]')"));
    ASSERT_TRUE(person.wait("state.step === 'surfaces'"));
    ASSERT_TRUE(person.click("$('scan')"));
    finish(person, "state.surfaces.scanned");
    click_corners(person, {{0.08, 0.2}, {0.47, 0.25}, {0.48, 0.75}, {0.1, 0.8}});
    ASSERT_TRUE(person.wait("state.surfaces.list.length === 1")) << person.state("error");
    ASSERT_TRUE(person.choose("shape", "round"));
    ASSERT_TRUE(person.enter("name", "column"));
    click_corners(person, {{0.64, 0.2}, {0.9, 0.22}, {0.91, 0.8}, {0.65, 0.78}});
    ASSERT_TRUE(person.wait("state.surfaces.list.length === 2")) << person.state("error");
    EXPECT_EQ(person.state("surfaces.list[1].round"), true);
    drag_a_corner(person, "column", 1, -8, 6);
    drag_a_corner(person, "wall 1", 2, -15, 10);
    mask_a_part(person);
    picture(person, "6_surfaces");
    // The projector shows the outlines, and the page its frame.
    ASSERT_TRUE(person.click("$('in_frame')"));
    ASSERT_TRUE(
        person.wait("state.outlines && in_frame && !$('frame').hidden && $('frame').naturalWidth === 1024"));
    drag_a_corner(person, "column", 3, 9, -12, "in_frame");
    EXPECT_TRUE(person.wait("state.outlines && $('frame').complete"));
    picture(person, "6_frame");
    ASSERT_TRUE(person.click("$('in_camera')"));
    ASSERT_TRUE(person.wait("!state.outlines && !$('image').hidden"));
  }
  void content_and_show(test::Person& person) {
    ASSERT_TRUE(person.click("document.querySelector('[data-go=content]')"));
    ASSERT_TRUE(person.wait("state.step === 'content' && (state.contents || []).includes('picture.png')"));
    ASSERT_TRUE(person.choose("content_wall 1", "picture.png"));
    ASSERT_TRUE(person.wait("state.surfaces.list[0].content === 'picture.png'")) << person.state("error");
    ASSERT_TRUE(person.enter("live_column", "shm:game"));
    ASSERT_TRUE(person.wait(
        "state.surfaces.list[1].content === 'shm:game' && $('content_column').value === 'shm:game'"))
        << person.state("error");
    ASSERT_TRUE(person.choose("content_column", "second.png"));
    ASSERT_TRUE(person.wait("state.surfaces.list[1].content === 'second.png'")) << person.state("error");
    picture(person, "7_content");
    ASSERT_TRUE(person.click("document.querySelector('[data-go=show]')"));
    ASSERT_TRUE(person.click("$('start')"));
    ASSERT_TRUE(person.wait("state.job === 'show' && state.show.frames > 20 && state.show.url !== ''"))
        << person.state("error");
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    picture(person, "8_show");
  }

  /// Nothing has moved; a bump of 0.2 degrees is noticed and corrected; the show can start at login.
  void drift_and_autostart(test::Person& person) {
    ASSERT_TRUE(person.click("$('check_drift')"));
    finish(person, "state.drift.walls.length === 2");
    EXPECT_EQ(person.state("drift.walls[0].moved"), false) << person.state("drift");
    EXPECT_LT(person.state("drift.walls[0].rms_mm").get<double>(), 2) << person.state("drift");
    EXPECT_EQ(person.state("drift.walls[1].checked"), true) << person.state("drift");
    EXPECT_EQ(person.state("drift.walls[1].moved"), false) << person.state("drift");
    EXPECT_LT(person.state("drift.walls[1].rms_mm").get<double>(), 2) << person.state("drift");
    EXPECT_EQ(person.state("drift.can_correct"), false);
    ASSERT_TRUE(person.click("$('bump')"));
    const double content_mm = person.state("surfaces.list[0].true_mm");
    EXPECT_TRUE(person.wait("state.surfaces.list[0].true_mm > 3"));
    std::this_thread::sleep_for(std::chrono::seconds(1));  // the simulated view is drawn anew
    ASSERT_TRUE(person.click("$('check_drift')"));
    finish(person, "state.drift.walls.length === 2 && state.drift.can_correct");
    EXPECT_EQ(person.state("drift.walls[0].moved"), true) << person.state("drift");
    EXPECT_EQ(person.state("drift.walls[1].moved"), true) << person.state("drift");
    picture(person, "8_drift");
    ASSERT_TRUE(person.click("$('correct_rig')"));
    ASSERT_TRUE(person.wait("!state.drift.can_correct && !state.surfaces.scanned")) << person.state("error");
    // Two of three runs were below 0.7 mm: the camera has 640 x 360 pixels.
    EXPECT_LT(person.state("surfaces.list[0].true_mm").get<double>(), content_mm + 1);
    EXPECT_TRUE(fs::exists(project_ / "before_correction" / "rig.json"));
    ASSERT_TRUE(person.click("$('check_drift')"));
    finish(person, "state.drift.walls.length === 2");
    EXPECT_EQ(person.state("drift.walls[0].moved"), false) << person.state("drift");
    ASSERT_TRUE(person.click("$('autostart')"));
    ASSERT_TRUE(person.wait("!$('service').hidden")) << person.state("error");
    const std::string unit = io::read_file(project_ / "procam-show.service");
    EXPECT_NE(unit.find("WorkingDirectory=" + project_.string() + "\n"), std::string::npos) << unit;
    EXPECT_NE(unit.find("/project-live\" --rig rig.json --show show.json --autosave\n"), std::string::npos)
        << unit;
    picture(person, "8_autostart");
  }

 private:
  /// Between two poses the projector's frame has the outline's lines and the dimmer light round them, and nothing else.
  void expect_outline_in_light(test::Person& person) {
    const fs::path file = project_.string() + ".light.png";
    const std::string url = json::parse(person.browser().evaluate(
        "location.origin + '/projector.png?token=' + new URLSearchParams(location.search).get('token')"));
    for (int i = 0; i < 10 * options_.patience_s; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (run_command("curl -s -o " + file.string() + " '" + url + "'") != 0) continue;
      const ImageU8 frame = io::load_image(file).image;
      std::array<int, 256> counts{};
      for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) ++counts[frame.at(x, y)];
      const int all = frame.width() * frame.height(), lines = counts[kGuideLine];
      if (lines > all / 500 && lines < all / 10 && lines + counts[kGuideGround] == all) return;
    }
    FAIL() << "no outline in the projector's frame";
  }
  /// Four corners of a new surface, as shares of the light's box in the camera's image.
  void click_corners(test::Person& person, const std::vector<std::pair<double, double>>& shares) {
    ASSERT_TRUE(person.click("$('click')"));
    ASSERT_TRUE(person.wait("clicks !== null"));
    const json lit = person.state("lit[0]");
    const double left = lit[0][0], top = lit[0][1], right = lit[1][0], bottom = lit[1][1];
    for (const auto& [u, v] : shares) {
      const auto [x, y] = person.in_image(left + u * (right - left), top + v * (bottom - top));
      person.click_at(x, y);
    }
  }
  /// A triangle in the middle of the first surface stays dark; Escape leaves another one unfinished.
  void mask_a_part(test::Person& person) {
    const json corners = person.state("surfaces.list[0].corners");
    double u = 0, v = 0;
    for (const json& corner : corners) u += corner[0].get<double>() / 4, v += corner[1].get<double>() / 4;
    const std::vector<std::pair<double, double>> ring = {
        {u - 18, v - 12}, {u + 25, v - 8}, {u + 4, v + 19}, {u - 18, v - 12}};
    ASSERT_TRUE(person.click("$('mask_wall 1')"));
    person.click_at(person.in_image(u, v).first, person.in_image(u, v).second);
    person.browser().evaluate("dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }))");
    ASSERT_TRUE(person.wait("masking === null"));
    ASSERT_TRUE(person.click("$('mask_wall 1')"));
    for (const auto& [x, y] : ring) {
      const auto [at_x, at_y] = person.in_image(x, y);
      person.click_at(at_x, at_y);
    }
    ASSERT_TRUE(person.wait("state.surfaces.list[0].masks.length === 1")) << person.state("error");
    const json mask = person.state("surfaces.list[0].masks[0]");
    ASSERT_EQ(mask.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(mask[i][0].get<double>(), ring[i].first, 1.5);
      EXPECT_NEAR(mask[i][1].get<double>(), ring[i].second, 1.5);
    }
  }
  /// By so many pixels of the page; the server then has it there.
  void drag_a_corner(test::Person& person, const std::string& name, int corner, int right, int down,
                     const std::string& corners = "corners") {
    const std::string at = "state.surfaces.list.find(s => s.name === '" + name + "')." + corners + "[" +
                           std::to_string(corner) + "]";
    const json before = json::parse(person.browser().evaluate(at));
    const auto [x, y] = person.place("document.querySelector('.handle[data-name=\"" + name +
                                     "\"][data-index=\"" + std::to_string(corner) + "\"]')");
    const double scale = json::parse(person.browser().evaluate("layout()"));
    constexpr int kMoves = 5;
    person.browser().mouse("mousePressed", x, y);
    for (int i = 1; i <= kMoves; ++i)
      person.browser().mouse("mouseMoved", x + double(right) * i / kMoves, y + double(down) * i / kMoves);
    person.browser().mouse("mouseReleased", x + right, y + down);
    const double wanted_x = before[0].get<double>() + right / scale,
                 wanted_y = before[1].get<double>() + down / scale;
    EXPECT_TRUE(person.wait("Math.hypot(" + at + "[0] - " + std::to_string(wanted_x) + ", " + at + "[1] - " +
                            std::to_string(wanted_y) + ") < 0.6"))
        << name << " " << before << " to " << person.browser().evaluate(at) << " instead of " << wanted_x
        << " " << wanted_y;
  }
  /// Waits for the end of a step's work, and for its result.
  void finish(test::Person& person, const std::string& result) {
    ASSERT_TRUE(person.wait_while_it_goes_on("state.job === '' && !!(" + result + ") || state.error !== null",
                                             options_.patience_s))
        << result;
    ASSERT_TRUE(person.state("error").is_null()) << person.state("error");
  }
  void picture(test::Person& person, const std::string& name) {
    if (options_.screenshots.empty()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    person.browser().screenshot(fs::path(options_.screenshots) / (name + ".png"));
  }

  fs::path project_;
  PathOptions options_;
};

/// What a tool of the command line makes of the project's files is what the projector shows.
void expect_same_frame_by_tools(const fs::path& project, const fs::path& work, const ImageU8& shown) {
  const std::string tools = std::string(PROCAM_TOOLS) + "/", folder = project.string();
  ASSERT_EQ(run_command("cd " + folder + " && " + tools +
                        "project-live --rig rig.json --show show.json --control off "
                        "--duration 300ms --output frames:" +
                        (work / "live").string()),
            0);
  ASSERT_EQ(run_command("cd " + folder + " && " + tools +
                        "solve-surfaces --rig rig.json --surfaces surfaces.json -o " +
                        (work / "solved.json").string()),
            0);
  ASSERT_EQ(run_command("cd " + folder + " && " + tools + "render-to-image --rig rig.json --surfaces " +
                        (work / "solved.json").string() +
                        " --content wall\\ 1=picture.png --content column=second.png -o " +
                        (work / "frame.png").string()),
            0);
  const auto equal = [&](const ImageU8& other) {
    return other.size() == shown.size() && other.channels() == shown.channels() &&
           std::equal(shown.data(), shown.data() + shown.width() * shown.height() * shown.channels(),
                      other.data());
  };
  EXPECT_TRUE(equal(io::load_image(work / "live" / "frame_000000.png").image)) << "project-live";
  EXPECT_TRUE(equal(io::load_image(work / "frame.png").image)) << "render-to-image";
}

void walk(const PathOptions& options, double largest_rig_mm, double largest_content_mm) {
  test::Person person(1280, 800);
  if (!person.has_browser()) GTEST_SKIP() << "no Chromium";
  test::Scratch scratch;
  const fs::path project = scratch / "stage";
  fs::create_directory(project);
  io::save_image(project / "picture.png", striped_content(0));
  io::save_image(project / "second.png", striped_content(1));
  auto studio = std::make_unique<test::RunningStudio>(project, options.tool);
  ASSERT_TRUE(person.open(*studio));
  GuidedPath path(project, options);
  using Part = void (GuidedPath::*)(test::Person&);
  std::vector<Part> parts = {
      &GuidedPath::display_and_camera, &GuidedPath::board,    &GuidedPath::capture,
      &GuidedPath::calibrate,          &GuidedPath::surfaces, &GuidedPath::content_and_show};
  if (options.kill)
    parts = {&GuidedPath::display_and_camera, &GuidedPath::board,     &GuidedPath::begin_capture,
             &GuidedPath::continue_capture,   &GuidedPath::calibrate, &GuidedPath::surfaces,
             &GuidedPath::content_and_show};
  for (const Part part : parts) {
    (path.*part)(person);
    if (testing::Test::HasFatalFailure()) {
      std::printf("%s\n%s\n", person.browser().console().c_str(),
                  io::read_file(project.string() + ".log").c_str());
      return;
    }
    if (!options.kill || part == parts.back()) continue;
    studio->kill_now();
    studio = std::make_unique<test::RunningStudio>(project, options.tool);
    ASSERT_TRUE(person.open(*studio));
  }
  const double rig_mm = person.state("rig.true_mm"), predicted_mm = person.state("rig.predicted_mm");
  std::printf("true error of the rig on a wall at 2 m: %.2f mm rms (predicted %.2f mm)\n", rig_mm,
              predicted_mm);
  for (const json& one : person.state("surfaces.list")) {
    const std::string name = one["name"];
    std::printf("true error of the content on '%s': %.2f mm rms, %.2f mm at most\n", name.c_str(),
                one["true_mm"].get<double>(), one["true_worst_mm"].get<double>());
    EXPECT_LE(one["true_worst_mm"].get<double>(), largest_content_mm) << name;
  }
  EXPECT_EQ(person.state("surfaces.list").size(), 2u);
  EXPECT_LE(rig_mm, largest_rig_mm);
  EXPECT_LE(rig_mm, 3 * predicted_mm);
  // The projector's frame, as the page's server gives it.
  const fs::path shown = scratch / "shown.png";
  ASSERT_EQ(run_command("curl -s -o " + shown.string() + " '" +
                        "http://127.0.0.1:" + std::to_string(studio->port()) +
                        "/projector.png?token=" + test::RunningStudio::kToken + "'"),
            0);
  expect_same_frame_by_tools(project, scratch.path(), io::load_image(shown).image);
  ASSERT_TRUE(person.click("$('start')"));
  EXPECT_TRUE(person.wait("state.job === ''"));
  if (!options.kill) path.drift_and_autostart(person);
  // A killed server breaks the page's connection, which the browser reports.
  if (!options.kill) EXPECT_EQ(person.browser().console(), "");
}

/// A small camera keeps it short. After six poses the rig was right to 0.4 to 5.9 mm at 2 m in ten runs, and 3.2 to 5.8 mm were
/// predicted: poses and noise depend on the machine's pace, so the bound is 1.7 times the largest prediction. The content
/// is right to a tenth, since the camera that was calibrated with the projector has measured the wall.
TEST(GuidedPath, FromAnEmptyFolderToContentOnTheWall) {
  PathOptions options;
  options.tool = {"--camera-size", "640x360", "--camera-rate", "60", "--latency", "25ms"};
  options.views = 6;
  if (const char* folder = std::getenv("PROCAM_STUDIO_SCREENSHOTS")) options.screenshots = folder;
  walk(options, 10, 1);
}

TEST(GuidedPathLong, GoesOnAfterKillMinusNineAtEachStep) {
  PathOptions options;
  options.tool = {"--camera-size", "640x360", "--camera-rate", "60", "--latency", "25ms"};
  options.kill = true;
  options.views = 6;  // four leave up to 2.1 mm on the wall
  walk(options, 10, 1);
}

/// A camera of 1280x720. On busy cores a pose takes minutes; the error is the same.
TEST(GuidedPathLong, FromAnEmptyFolderToContentOnTheWall) {
  PathOptions options;
  options.views = 8;  // the page's default
  if (const char* folder = std::getenv("PROCAM_STUDIO_SCREENSHOTS")) options.screenshots = folder;
  walk(options, 1, 1);
}

}  // namespace
}  // namespace procam::studio
