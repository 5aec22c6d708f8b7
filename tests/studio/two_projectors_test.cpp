/// Two projectors that light the same walls, from an empty folder to a blended show, as scripts at the page's door.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "io/scratch.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "running_studio.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class TwoProjectors : public testing::Test {
 protected:
  TwoProjectors() : project_(scratch_ / "stage") {
    fs::create_directory(project_);
    start();
  }
  void start() {
    studio_ = std::make_unique<test::RunningStudio>(
        project_, std::vector<std::string>{"--projectors", "2", "--camera-size", "640x360"});
    script_ = std::make_unique<test::Script>(*studio_);
    ASSERT_TRUE(script_->wait_for_start());
  }
  void command(const json& message) { script_->command(message); }
  json state() { return script_->state(); }
  bool wait(const std::function<bool(const json&)>& holds, int seconds = 60) {
    return script_->wait(holds, seconds);
  }
  void choose_displays() {
    command({{"do", "display"}, {"text", "simulated"}});
    command({{"do", "further_display"}, {"text", "simulated 2"}});
    command({{"do", "camera"}, {"text", "simulated"}});
    ASSERT_TRUE(wait([](const json& s) {
      return s["display"]["further"] == json({"simulated 2"}) && s["camera"]["size"][0] == 640;
    })) << state()["error"];
  }
  void go_to(const std::string& step) {
    command({{"do", "step"}, {"text", step}});
    ASSERT_TRUE(wait([&](const json& s) { return s["step"] == step; }));
  }
  /// Begins a job and waits for its end, while it makes progress.
  void finish(const std::string& verb, const std::string& job) {
    command({{"do", verb}});
    ASSERT_TRUE(wait([&](const json& s) { return s["job"] == job || !s["error"].is_null(); }));
    for (std::string last, now; state()["job"] != ""; last = now) {
      ASSERT_TRUE(wait(
          [&](const json& s) {
            now = s["doing"].dump() + s["done"].dump() + s["messages"].dump();
            return s["job"] == "" || now != last;
          },
          200))
          << last;
    }
    ASSERT_TRUE(state()["error"].is_null()) << state()["error"];
  }
  /// Corners as shares of the first projector's light in the camera's image.
  void click(const std::string& name, const std::string& shape, double left, double right) {
    const json lit = state()["lit"];
    const double x = lit[0][0][0], y = lit[0][0][1], width = lit[0][1][0].get<double>() - x,
                 height = lit[0][1][1].get<double>() - y;
    const double l = x + left * width, r = x + right * width, t = y + 0.15 * height, b = y + 0.85 * height;
    command({{"do", "surface"},
             {"name", name},
             {"text", shape},
             {"numbers", {l, t, r, t + 2, r - 1, b, l + 2, b - 3}}});
    ASSERT_TRUE(wait([&](const json& s) {
      for (const json& one : s["surfaces"]["list"])
        if (one["name"] == name) return true;
      return !s["error"].is_null();
    }));
    ASSERT_TRUE(state()["error"].is_null()) << state()["error"];
  }

  test::Scratch scratch_;
  fs::path project_;
  std::unique_ptr<test::RunningStudio> studio_;
  std::unique_ptr<test::Script> script_;
};

TEST_F(TwoProjectors, AreChosenOneByOne) {
  const auto refused = [&](const json& message) {
    command(message);
    const bool is = wait([](const json& s) { return !s["error"].is_null(); }, 20);
    command({{"do", "step"}, {"text", "display"}});
    return is && wait([](const json& s) { return s["error"].is_null(); }, 20);
  };
  EXPECT_TRUE(refused({{"do", "further_display"}, {"text", "simulated 2"}})) << "the first one comes first";
  choose_displays();
  EXPECT_EQ(script_->authorised("/projector.png"), 200);
  EXPECT_EQ(script_->authorised("/projector_2.png"), 200);
  EXPECT_EQ(script_->authorised("/projector_3.png"), 404);
  EXPECT_TRUE(refused({{"do", "further_display"}, {"text", "simulated 2"}}));
  EXPECT_TRUE(refused({{"do", "further_display"}, {"text", "simulated"}}));
  EXPECT_TRUE(refused({{"do", "remove_display"}, {"numbers", {2}}}));
  EXPECT_TRUE(refused({{"do", "frame_of"}, {"numbers", {2}}}));
  EXPECT_EQ(state()["display"]["further"], json({"simulated 2"}));
  studio_->kill_now();
  start();
  EXPECT_EQ(state()["display"]["further"], json({"simulated 2"}));
  command({{"do", "remove_display"}, {"numbers", {1}}});
  EXPECT_TRUE(wait([](const json& s) { return s["display"]["further"].empty(); }));
  // The cameras, each with its image.
  go_to("camera");
  command({{"do", "look_around"}});
  EXPECT_TRUE(wait([](const json& s) {
    return s["job"] == "look" && s["camera"]["list"][0].value("images", 0) >= 3;
  })) << state()["camera"];
  EXPECT_EQ(script_->authorised("/camera_1.jpg"), 200);
  EXPECT_EQ(script_->status("/camera_1.jpg"), 403);
  command({{"do", "stop"}});
  EXPECT_TRUE(wait([](const json& s) { return s["job"] == "" && s["camera"]["open"] == true; }));
}

TEST_F(TwoProjectors, LongFromAnEmptyFolderToABlendedShow) {
  choose_displays();
  finish("check_camera", "check");
  ASSERT_EQ(state()["lit"].size(), 2u);
  go_to("board");
  command({{"do", "paper"}, {"text", "a3"}});
  command({{"do", "board"}, {"text", "chessboard:9x6:30mm"}});
  ASSERT_TRUE(wait([](const json& s) { return s["board"]["text"] == "chessboard:9x6:30mm"; }));
  go_to("capture");
  command({{"do", "views"}, {"numbers", {8}}});
  finish("capture", "capture");
  go_to("calibrate");
  finish("calibrate", "calibrate");
  const Rig rig = io::load_rig(project_ / "rig.json");
  ASSERT_EQ(rig.projectors.size(), 2u);
  EXPECT_EQ(rig.projectors[0].name, "projector_1");
  EXPECT_EQ(rig.projectors[1].name, "projector_2");
  const double predicted = state()["rig"]["predicted_mm"], truth = state()["rig"]["true_mm"];
  // A camera of 640x360: below 10 mm in all of five runs, and within what is predicted.
  EXPECT_LT(truth, 20);
  EXPECT_LT(truth, 3 * predicted);
  studio_->kill_now();
  start();
  finish("check_camera", "check");
  go_to("surfaces");
  finish("scan", "scan");
  // By the first projector and little of the second, by both, and by the second alone.
  click("wall", "flat", 0.08, 0.5);
  click("column", "round", 0.66, 0.9);
  click("right wall", "flat", 1.02, 1.3);
  const json clicked = state()["surfaces"]["list"];
  ASSERT_EQ(clicked.size(), 3u);
  for (const json& one : clicked) {
    std::printf("%s: true error %.2f mm rms, %.2f mm max\n", one["name"].get<std::string>().c_str(),
                one["true_mm"].get<double>(), one["true_worst_mm"].get<double>());
    EXPECT_LT(one["true_mm"].get<double>(), 2) << one;
  }
  // A corner dragged in the frame of the second projector.
  command({{"do", "light"}, {"text", "outlines"}});
  command({{"do", "frame_of"}, {"numbers", {1}}});
  ASSERT_TRUE(wait([](const json& s) { return s["framed"] == 1 && s["outlines"] == true; }));
  const json before = state()["surfaces"]["list"][0]["in_frame"][1];
  const double x = before[0].get<double>() + 6, y = before[1].get<double>() - 4;
  command({{"do", "corner_in_frame"}, {"name", "wall"}, {"numbers", {1, x, y}}});
  EXPECT_TRUE(wait([&](const json& s) {
    const json now = s["surfaces"]["list"][0]["in_frame"][1];
    return std::hypot(now[0].get<double>() - x, now[1].get<double>() - y) < 0.1;
  })) << state()["surfaces"]["list"][0]["in_frame"];
  go_to("show");
  command({{"do", "show"}});
  ASSERT_TRUE(wait([](const json& s) { return s["show"]["frames"] > 20 && s["show"]["url"] != ""; }))
      << state()["error"];
  const std::string log = io::read_file(project_.string() + ".log");
  EXPECT_NE(log.find("blended with projector_2"), std::string::npos) << log;
  command({{"do", "stop"}});
  ASSERT_TRUE(wait([](const json& s) { return s["job"] == ""; }));
  const std::string show = io::read_file(project_ / "show.json");
  EXPECT_NE(show.find("\"projector_2\""), std::string::npos) << show;
  // The bump moves the first projector alone.
  const double content_mm = state()["surfaces"]["list"][0]["true_mm"];
  command({{"do", "bump"}});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  finish("check_drift", "drift");
  int moved_first = 0, moved_second = 0;
  const json walls = state()["drift"]["walls"];
  for (const json& wall : walls)
    (wall["projector"] == "projector_1" ? moved_first : moved_second) += wall["moved"] == true;
  EXPECT_GE(moved_first, 1) << state()["drift"];
  EXPECT_EQ(moved_second, 0) << state()["drift"];
  command({{"do", "correct_rig"}});
  ASSERT_TRUE(wait([](const json& s) { return s["drift"]["can_correct"] == false; })) << state()["error"];
  const double corrected_mm = state()["surfaces"]["list"][0]["true_mm"];
  std::printf("content on the wall: %.2f mm rms, %.2f after a bump and its correction\n", content_mm,
              corrected_mm);
  EXPECT_LT(corrected_mm, content_mm + 2);
}

}  // namespace
}  // namespace procam::studio
