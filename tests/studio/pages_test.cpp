/// The studio's server before strangers, two pages at once, and what is left after kill -9.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "io/scratch.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/surface_file.hpp"
#include "running_studio.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::vector<std::string> kSmall = {"--camera-size", "320x180", "--camera-rate", "20"};

using test::Script;

TEST(StudioServer, RefusesStrangers) {
  test::Scratch scratch;
  const test::RunningStudio studio(scratch / "stage", kSmall);
  const Script script(studio);
  ASSERT_TRUE(script.wait_for_start());
  const std::string here = "http://127.0.0.1:" + std::to_string(studio.port());
  EXPECT_EQ(script.authorised("/"), 200);
  EXPECT_EQ(script.authorised("/", "-H 'Origin: " + here + "'"), 200);
  for (const char* path : {"/", "/status", "/frame.jpg", "/ws", "/report", "/board.pdf", "/projector.png"}) {
    EXPECT_EQ(script.status(path), 403) << path;
    EXPECT_EQ(script.status(path, "-H 'Authorization: Bearer studio-test-tokem'"), 403) << path;
    EXPECT_EQ(script.authorised(path, "-H 'Origin: http://elsewhere.example'"), 403) << path;
    EXPECT_EQ(script.authorised(path, "-H 'Host: elsewhere.example'"), 403) << path;
  }
  EXPECT_EQ(script.status("/command", "-d '{\"do\":\"step\",\"text\":\"show\"}'"), 403);
  EXPECT_EQ(
      script.authorised("/command", "-d '{\"do\":\"step\",\"text\":\"" + std::string(17000, 'x') + "\"}'"),
      413);
  for (const char* invalid :
       {"{}", "[]", "{\"do\":1}", "{\"do\":\"step\",\"other\":1}", "{\"do\":\"views\",\"numbers\":[null]}"})
    EXPECT_EQ(script.authorised("/command", std::string("-d '") + invalid + "'"), 400) << invalid;
  EXPECT_EQ(script.state()["step"], "display");
}

/// Every choice is on disk when the page shows it.
TEST(StudioProject, ChoicesSurviveKillMinusNine) {
  test::Scratch scratch;
  const fs::path project = scratch / "stage";
  struct Act {
    json command;
    std::function<bool(const json&)> result;
  };
  const std::vector<Act> acts = {
      {{{"do", "display"}, {"text", "simulated"}},
       [](const json& s) { return s["display"]["open"] == true; }},
      {{{"do", "step"}, {"text", "camera"}}, [](const json& s) { return s["step"] == "camera"; }},
      {{{"do", "camera"}, {"text", "simulated"}}, [](const json& s) { return s["camera"]["open"] == true; }},
      {{{"do", "step"}, {"text", "board"}}, [](const json& s) { return s["step"] == "board"; }},
      {{{"do", "paper"}, {"text", "a3"}}, [](const json& s) { return s["board"]["paper"] == "a3"; }},
      {{{"do", "board"}, {"text", "chessboard:9x6:30mm"}},
       [](const json& s) {
         return s["board"]["text"] == "chessboard:9x6:30mm" && s["steps"][2]["done"] == true;
       }},
      {{{"do", "measured"}, {"text", "99mm"}},
       [](const json& s) { return s["board"]["text"] == "chessboard:9x6:29.7mm"; }},
      {{{"do", "views"}, {"numbers", {5}}}, [](const json& s) { return s["capture"]["wanted"] == 5; }},
      {{{"do", "accept"}, {"numbers", {2.5}}}, [](const json& s) { return s["rig"]["accept_mm"] == 2.5; }}};
  for (std::size_t i = 0; i < acts.size(); ++i) {
    test::RunningStudio studio(project, kSmall);
    const Script script(studio);
    ASSERT_TRUE(script.wait_for_start());
    for (std::size_t k = 0; k < i; ++k) {
      if (k + 1 < i && (acts[k].command["do"] == "step" || acts[k].command["do"] == "board"))
        continue;  // changed since
      EXPECT_TRUE(script.wait(acts[k].result, 10)) << "after kill -9: " << acts[k].command << "\n"
                                                   << script.state();
    }
    script.command(acts[i].command);
    ASSERT_TRUE(script.wait(acts[i].result, 20)) << acts[i].command << "\n" << script.state();
    studio.kill_now();
  }
  EXPECT_EQ(std::get<Chessboard>(io::load_board(project / "board.json")).square_size, 0.0297);
}

TEST(StudioDisplay, ShowsItsNumberAndThenTheTestCardAgain) {
  test::Scratch scratch;
  const test::RunningStudio studio(scratch / "stage", kSmall);
  const Script script(studio);
  ASSERT_TRUE(script.wait_for_start());
  script.command({{"do", "display"}, {"text", "simulated"}});
  ASSERT_TRUE(script.wait([](const json& s) { return s["display"]["open"] == true; }));
  const std::string test_card = script.projector_frame();
  ASSERT_GT(test_card.size(), 1000u);
  script.command({{"do", "identify"}});
  ASSERT_TRUE(script.wait([](const json& s) { return s["job"] == "identify"; }, 5));
  std::string number = script.projector_frame();
  EXPECT_NE(number, test_card);
  EXPECT_GT(number.size(), 1000u);
  ASSERT_TRUE(script.wait([](const json& s) { return s["job"] == ""; }, 20));
  EXPECT_EQ(script.projector_frame(), test_card);
}

/// No board, no camera, no rig: a corner is moved, and the file has it after kill -9.
TEST(StudioMapping, CornersByHandNeedNoCalibration) {
  test::Scratch scratch;
  const fs::path project = scratch / "stage";
  test::RunningStudio studio(project, kSmall);
  const Script script(studio);
  ASSERT_TRUE(script.wait_for_start());
  script.command({{"do", "display"}, {"text", "simulated"}});
  ASSERT_TRUE(script.wait([](const json& s) { return s["display"]["open"] == true; }));
  script.command({{"do", "map"}});
  ASSERT_TRUE(script.wait([](const json& s) {
    return s["job"] == "map" && s["show"]["url"] != "" && s["show"]["frames"] > 2;
  })) << script.state();
  script.command(
      {{"do", "show_command"}, {"text", R"({"do":"move","surface":"wall","point":2,"pixels":[812.5,640]})"}});
  const auto corner = [&] {
    const SurfaceSet set = io::load_surfaces(project / "mapping.json");
    return set.surfaces.size() == 1 ? std::get<PixelSurface>(set.surfaces[0].geometry).pixels.at(2)
                                    : Vec2(0, 0);
  };
  for (int i = 0; i < 100 && corner() != Vec2(812.5, 640); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(corner(), Vec2(812.5, 640));
  studio.kill_now();
  EXPECT_EQ(corner(), Vec2(812.5, 640));
  EXPECT_FALSE(fs::exists(project / "rig.json"));
}

/// What cannot be done says why on the page, and changes nothing.
TEST(StudioProject, ErrorsHaveThreePartsAndChangeNothing) {
  test::Scratch scratch;
  const test::RunningStudio studio(scratch / "stage", kSmall);
  const Script script(studio);
  ASSERT_TRUE(script.wait_for_start());
  for (const json& message :
       {json{{"do", "capture"}}, json{{"do", "scan"}}, json{{"do", "show"}}, json{{"do", "calibrate"}},
        json{{"do", "check_drift"}}, json{{"do", "correct_rig"}}, json{{"do", "autostart"}},
        json{{"do", "mask"}, {"name", "a"}, {"numbers", {1, 1, 9, 1, 5, 9}}},
        json{{"do", "step"}, {"text", "nowhere"}}, json{{"do", "board"}, {"text", "chessboard:9x6:90mm"}},
        json{{"do", "measured"}, {"text", "50mm"}}, json{{"do", "views"}, {"numbers", {1}}},
        json{{"do", "surface"}, {"name", "a"}, {"numbers", {1, 2, 3}}},
        json{{"do", "content"}, {"name", "a"}, {"text", "/etc/passwd"}}, json{{"do", "nonsense"}}}) {
    script.command(message);
    EXPECT_TRUE(script.wait(
        [&](const json& s) {
          return s["job"] == "" && s["error"].is_object() && s["error"]["what"] != "" &&
                 s["error"]["why"] != "" && s["error"]["next"] != "";
        },
        10))
        << message << "\n"
        << script.state();
    script.command({{"do", "step"}, {"text", "display"}});
    EXPECT_TRUE(script.wait([](const json& s) { return s["error"].is_null(); }, 10));
  }
  EXPECT_EQ(script.state()["step"], "display");
  EXPECT_FALSE(fs::exists(scratch / "stage" / "board.json"));
}

TEST(StudioProject, AWrongStudioFileIsRefusedByName) {
  test::Scratch scratch;
  for (const char* text : {"{", "{\"format\":\"other\"}", "{\"format\":\"procam-studio\",\"version\":2}",
                           "{\"format\":\"procam-studio\",\"version\":1,\"views\":-1}",
                           "{\"format\":\"procam-studio\",\"version\":1,\"veiws\":5}"}) {
    scratch.write("stage/studio.json", text);
    test::RunningStudio studio(scratch / "stage", kSmall);
    for (int i = 0; i < 100 && studio.is_running(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(studio.is_running()) << text;
    const std::string log = io::read_file(scratch / "stage.log");
    EXPECT_NE(log.find("studio.json"), std::string::npos) << log;
    EXPECT_NE(log.find("next:"), std::string::npos) << log;
    fs::remove(scratch / "stage.log");
  }
}

TEST(StudioPages, TwoSeeEachOthersChanges) {
  test::Person one(1280, 800), other(1280, 800);
  if (!one.has_browser() || !other.has_browser()) GTEST_SKIP() << "no Chromium";
  test::Scratch scratch;
  const test::RunningStudio studio(scratch / "stage", kSmall);
  ASSERT_TRUE(one.open(studio) && other.open(studio));
  ASSERT_TRUE(one.choose("display", "simulated"));
  EXPECT_TRUE(other.wait("state.display.chosen === 'simulated' && $('display').value === 'simulated'"));
  ASSERT_TRUE(other.click("document.querySelector('[data-step=capture]')"));
  EXPECT_TRUE(
      one.wait("state.step === 'capture' && !document.querySelector('section[data-step=capture]').hidden"));
  ASSERT_TRUE(one.enter("views", "9"));
  EXPECT_TRUE(other.wait("$('views').value === '9'"));
  // A reload loses nothing.
  ASSERT_TRUE(one.open(studio));
  EXPECT_TRUE(one.wait("state.step === 'capture' && $('views').value === '9'"));
  EXPECT_EQ(one.browser().console() + other.browser().console(), "");
}

/// Both go into the same field; the second one's change waits for a choice, and the first one is informed of it.
TEST(StudioPages, NeitherOverwritesTheOtherUnseen) {
  test::Person one(1280, 800), other(1280, 800);
  if (!one.has_browser() || !other.has_browser()) GTEST_SKIP() << "no Chromium";
  test::Scratch scratch;
  const test::RunningStudio studio(scratch / "stage", kSmall);
  ASSERT_TRUE(one.open(studio) && other.open(studio));
  ASSERT_TRUE(one.click("document.querySelector('[data-step=capture]')"));
  ASSERT_TRUE(
      other.wait("state.step === 'capture' && !document.querySelector('[data-step=capture]').hidden"));
  const auto type = [](test::Person& person, const std::string& text) {
    person.browser().evaluate("$('views').select()");
    person.browser().type(text);
    person.browser().press("Tab");
    person.browser().evaluate("$('views').blur()");
  };
  const auto both_change = [&](const std::string& others, const std::string& ones) {
    ASSERT_TRUE(one.click("$('views')"));
    ASSERT_TRUE(other.enter("views", others));
    ASSERT_TRUE(one.wait("state.capture.wanted === " + others));
    type(one, ones);
    ASSERT_TRUE(one.wait("!$('held').hidden && $('held_words').textContent.includes('the number of poses')"));
    EXPECT_EQ(one.state("capture.wanted").dump(), others);
    EXPECT_EQ(other.browser().evaluate("$('held').hidden"), "true");
  };
  both_change("9", "12");
  if (const char* folder = std::getenv("PROCAM_STUDIO_SCREENSHOTS"))
    one.browser().screenshot(fs::path(folder) / "two_pages.png");
  ASSERT_TRUE(one.click("$('use_mine')"));
  EXPECT_TRUE(other.wait("state.capture.wanted === 12 && $('views').value === '12'"));
  EXPECT_TRUE(other.wait("$('other').textContent === 'Another page has changed the number of poses.'"));
  EXPECT_TRUE(one.wait("$('held').hidden"));
  both_change("8", "15");
  ASSERT_TRUE(one.click("$('keep_theirs')"));
  EXPECT_TRUE(one.wait("$('held').hidden && $('views').value === '8'"));
  EXPECT_EQ(other.state("capture.wanted"), 8);
  // One after the other is no conflict.
  ASSERT_TRUE(one.enter("views", "7"));
  EXPECT_TRUE(other.wait("$('views').value === '7'"));
  ASSERT_TRUE(other.enter("views", "6"));
  EXPECT_TRUE(one.wait("$('views').value === '6' && $('held').hidden"));
  EXPECT_EQ(other.browser().evaluate("$('held').hidden"), "true");
  EXPECT_EQ(one.browser().console() + other.browser().console(), "");
}

/// Before the first state and without a connection, a click would be lost; the page takes none.
TEST(StudioPages, TakesNoClickWithoutAState) {
  test::Person person(1280, 800);
  if (!person.has_browser()) GTEST_SKIP() << "no Chromium";
  test::Scratch scratch;
  test::RunningStudio studio(scratch / "stage", kSmall);
  ASSERT_TRUE(person.open(studio));
  EXPECT_FALSE(person.is_inert());
  EXPECT_TRUE(person.wait("document.querySelectorAll('section:not([hidden])').length === 1"));
  EXPECT_EQ(person.browser().console(), "");
  const std::string html = Script(studio).page();
  studio.kill_now();
  EXPECT_TRUE(person.wait("$('link').className === 'lost'"));
  EXPECT_TRUE(person.is_inert());
  // The same page where no server answers.
  person.browser().open("file://" + scratch.write("page.html", html).string());
  ASSERT_TRUE(person.wait("document.readyState === 'complete' && state === null"));
  EXPECT_EQ(person.browser().evaluate("document.querySelectorAll('section:not([hidden])').length"), "0");
  EXPECT_TRUE(person.is_inert());
}

}  // namespace
}  // namespace procam::studio
