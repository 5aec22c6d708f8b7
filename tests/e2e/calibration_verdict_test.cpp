/// Exit code, console, --json, rig file and report page of one calibration say the same.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {
namespace {

std::size_t count(const std::string& text, const std::string& words) {
  std::size_t found = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++found;
  return found;
}

/// "all 16 quality checks passed" in any spelling.
bool says_all_passed(const std::string& text) {
  for (const char* all : {"all ", "All "})
    for (std::size_t at = text.find(all); at != std::string::npos; at = text.find(all, at + 1)) {
      const std::size_t end = text.find_first_of(".\n", at);
      if (text.substr(at, end - at).find("passed") != std::string::npos) return true;
    }
  return false;
}

/// `run` printed JSON on stdout and its sentences on stderr; `page` is the report, empty for none.
void expect_consistent(const ToolRun& run, const std::string& page) {
  ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 5) << run.err;
  const bool passed = run.exit_code == 0;
  const auto summary = run.json();
  EXPECT_EQ(summary.at("result") == "passed", passed) << run.out;
  EXPECT_EQ(summary.at("gates").at("failed") == 0, passed);
  EXPECT_EQ(says_all_passed(run.err), passed) << run.err;
  EXPECT_EQ(count(run.err, "check FAILED"), summary.at("gates").at("failed").get<std::size_t>());
  EXPECT_EQ(run.err.find("result     passed") != std::string::npos, passed) << run.err;
  if (page.empty()) return;
  EXPECT_EQ(says_all_passed(page), passed);
  EXPECT_EQ(page.find(">Passed.<") != std::string::npos, passed);
}

struct Case {
  const char* name;
  std::string options;
  double scale = 1;  ///< of the projector's rows: a frame that is scaled before it is shown
  int exit_code = 0;
};

TEST(CalibrationVerdict, IsTheSameEverywhere) {
  const ScratchFolder folder;
  const NumericWorld world = NumericWorld::make(12, 3, 0.03, 0.03);
  for (const Case& one : {Case{"good", "", 1, 0}, Case{"imprecise", " --accept 0.001mm", 1, 5},
                          Case{"squeezed", " --holdout", 0.92, 5}}) {
    SCOPED_TRACE(one.name);
    Correspondences data = world.correspondences(5);
    for (View& view : data.views)
      for (Observation& o : view.observations[1]) o.pixel.y() *= one.scale;
    const std::string stem = (folder / one.name).string();
    io::save_observations(stem + ".csv", data);
    const ToolRun run =
        run_tool("calibrate-projector", "--observations " + stem + ".csv --json --board-shape flat -o " +
                                            stem + ".json --report " + stem + ".html" + one.options);
    EXPECT_EQ(run.exit_code, one.exit_code) << run.err;
    const std::string page = slurp(stem + ".html");
    expect_consistent(run, page);
    EXPECT_EQ(io::load_rig(stem + ".json").quality.passed(), run.exit_code == 0);
    // What no image shows is stated once on each.
    EXPECT_EQ(count(run.err, "printed size"), 1u) << run.err;
    // The page also carries the result as a block of JSON, which nobody sees.
    const std::size_t json = page.find("<script type=\"application/json\""),
                      json_end = page.find("</script>", json);
    ASSERT_NE(json_end, std::string::npos);
    EXPECT_EQ(count(page.substr(0, json) + page.substr(json_end), "printed size"), 1u);
    EXPECT_EQ(count(page.substr(json, json_end - json), "printed size"), 1u);
    const ToolRun check =
        run_tool("calibrate-projector",
                 "--check " + stem + ".json --json" + (one.options == " --holdout" ? "" : one.options));
    EXPECT_EQ(check.exit_code, one.exit_code) << check.err;
    expect_consistent(check, "");
  }
}

/// Too few views are left since others were lost in the reading: they are named, with the cause, before the error.
TEST(CalibrationVerdict, NamesTheViewsThatWereLostBeforeAnError) {
  const ScratchFolder folder;
  Correspondences data = NumericWorld::make(5, 3, 0.03, 0.03).correspondences(5);
  for (std::size_t v = 2; v < 5; ++v)
    for (auto& observations : data.views[v].observations) observations.resize(3);
  const std::string table = (folder / "t.csv").string();
  io::save_observations(table, data);
  for (const char* tool : {"calibrate-projector", "calibrate-camera"}) {
    const ToolRun run =
        run_tool(tool, "--observations " + table + " --json -o " + (folder / "rig.json").string());
    EXPECT_EQ(run.exit_code, 4) << run.err;
    for (std::size_t v = 2; v < 5; ++v)
      EXPECT_NE(run.err.find(data.views[v].name), std::string::npos) << tool << ": " << run.err;
    EXPECT_LT(run.err.find("warning: "), run.err.find("views are usable")) << run.err;
    EXPECT_GE(run.json().at("diagnostics").size(), 3u) << run.out;
  }
}

/// A failure that only the calibration could see stays with the file: --check does not pass it.
TEST(CalibrationVerdict, OfAStoredRigKeepsItsFailures) {
  const ScratchFolder folder;
  const std::string table = (folder / "t.csv").string(), file = (folder / "rig.json").string();
  io::save_observations(table, NumericWorld::make(12, 3, 0.03, 0.03).correspondences(5));
  ASSERT_EQ(run_tool("calibrate-projector", "--observations " + table + " -o " + file).exit_code, 0);
  Rig rig = io::load_rig(file);
  for (Gate& gate : rig.quality.gates)
    if (gate.name == "views agree") gate = {gate.name, false, "7 of 12 views disagree about projector"};
  io::save_rig(file, rig);
  const ToolRun check = run_tool("calibrate-projector", "--check " + file + " --json");
  EXPECT_EQ(check.exit_code, 5);
  expect_consistent(check, "");
}

/// The captures of two plain boards look the same in a mirror: said once, and for no pattern that shows it.
TEST(CalibrationVerdict, SaysThatPlainBoardsHideAMirror) {
  const ScratchFolder folder;
  const auto calibrated = [&](const std::string& pattern) {
    const std::string session = (folder / pattern).string();
    EXPECT_EQ(run_tool("simulate-captures",
                       "--seed 5 --level easy --views 4 --pattern " + pattern + " -o " + session)
                  .exit_code,
              0);
    return run_tool("calibrate-projector",
                    "--accept 50mm --json --captures " + session + " -o " + session + ".json");
  };
  const ToolRun plain = calibrated("chessboard");
  EXPECT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_EQ(count(plain.err, "look the same in a mirror"), 1u) << plain.err;
  const ToolRun coded = calibrated("markers");
  EXPECT_EQ(coded.exit_code, 0) << coded.err;
  EXPECT_EQ(count(coded.err, "mirror"), 0u) << coded.err;
}

}  // namespace
}  // namespace procam::test
