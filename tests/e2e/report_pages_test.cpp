/// Every page procam writes, in a browser: it says nothing on the console, shows something, prints, and stays
/// small. To add a page: one more call of expect_sound() with its file.
#include <gtest/gtest.h>

#include <algorithm>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;
constexpr std::uintmax_t kLargestPage = 1000000;  ///< bytes

/// What headless Chromium makes of a page.
struct Shown {
  std::string console;  ///< the lines that the page, or its scripts' errors, wrote there
  fs::path screenshot;
};

class ReportPages : public ::testing::Test {
 protected:
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// Runs Chromium on the page; its own complaints (no bus, no fonts) stay in the returned log.
  std::string chromium(const fs::path& page, const std::string& what) const {
    const std::string log = at("chromium.log");
    const std::string command =
        "timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
        "--user-data-dir=" +
        at("profile") + " --enable-logging=stderr --v=0 --window-size=1200,1600 " + what + " file://" +
        page.string() + " >" + log + " 2>&1 </dev/null";
    const int status = std::system(command.c_str());
    EXPECT_EQ(status, 0) << "chromium must be installed (scripts/common.sh names the package): "
                         << slurp(log).substr(0, 2000);
    return slurp(log);
  }
  Shown show(const fs::path& page) const {
    Shown shown;
    shown.screenshot = page.string() + ".png";
    // The virtual clock runs on until scripts have nothing left to do.
    std::stringstream log(
        chromium(page, "--virtual-time-budget=5000 --screenshot=" + shown.screenshot.string()));
    for (std::string line; std::getline(log, line);)
      if (line.find(":CONSOLE") != std::string::npos) shown.console += line + "\n";
    return shown;
  }
  /// The share of pixels that differ from the corner's.
  static double drawn_share(const fs::path& picture) {
    const ImageU8 image = io::load_image(picture).image;
    const std::ptrdiff_t size = std::ptrdiff_t(image.width()) * image.height() * image.channels();
    return 1 - double(std::count(image.data(), image.data() + size, *image.data())) / double(size);
  }
  void expect_sound(const fs::path& page) const {
    SCOPED_TRACE(page.filename().string());
    ASSERT_TRUE(fs::exists(page));
    EXPECT_LT(fs::file_size(page), kLargestPage);
    const Shown shown = show(page);
    EXPECT_EQ(shown.console, "");
    ASSERT_TRUE(fs::exists(shown.screenshot));
    EXPECT_GT(drawn_share(shown.screenshot), 0.02);
    const fs::path printed = page.string() + ".pdf";
    chromium(page, "--print-to-pdf=" + printed.string());
    EXPECT_EQ(slurp(printed).substr(0, 5), "%PDF-");
    EXPECT_GT(fs::file_size(printed), 5000u);
    if (const char* kept = std::getenv("PROCAM_KEEP_PAGES"))
      for (const fs::path& file : {page, shown.screenshot, printed})
        fs::copy_file(file, fs::path(kept) / file.filename(), fs::copy_options::overwrite_existing);
  }

  ScratchFolder folder_;
};

TEST_F(ReportPages, TheEyeSeesErrorsAndBlankPages) {
  const std::string start = "<!DOCTYPE html><html><body>", end = "</body></html>";
  EXPECT_NE(show(write("error.html", start + "<script>console.error('on purpose')</script>" + end))
                .console.find("on purpose"),
            std::string::npos);
  EXPECT_NE(
      show(write("script.html", start + "<script>nothing.there()</script>" + end)).console.find("Uncaught"),
      std::string::npos);
  const Shown blank = show(write("blank.html", start + end));
  EXPECT_EQ(blank.console, "");
  EXPECT_EQ(drawn_share(blank.screenshot), 0);
}

TEST_F(ReportPages, CalibrationEvaluationAndPrediction) {
  const ToolRun calibrated =
      run_tool("calibrate-projector", "--captures " + std::string(PROCAM_E2E_SESSION) + " -o " +
                                          at("rig.json") + " --report " + at("calibration.html"));
  ASSERT_EQ(calibrated.exit_code, 0) << calibrated.err;
  expect_sound(folder_ / "calibration.html");

#ifdef PROCAM_SECTION_V
  const ToolRun evaluated = run_program(std::string(PROCAM_SECTION_V) + "/section_v",
                                        "--original --truth " + std::string(PROCAM_E2E_SESSION) +
                                            "/truth.json --report " + at("evaluation.html"));
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  expect_sound(folder_ / "evaluation.html");
#endif

  PlanarSurface sheet;
  sheet.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  sheet.points = {{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}};
  sheet.frame = "projector";
  sheet.frame_from_surface =
      Pose(Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Vec3::UnitY())), Vec3(0.02, -0.3, 1.7));
  io::save_surfaces(folder_ / "surfaces.json", {{{"sheet", sheet, {}, ""}}});
  const ToolRun predicted =
      run_tool("predict-error", "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") +
                                    " --map-sigma 5mm,0.2deg --monte-carlo 2000 --report " +
                                    at("prediction.html") + " --data " + at("numbers"));
  ASSERT_EQ(predicted.exit_code, 0) << predicted.err;
  expect_sound(folder_ / "prediction.html");
  for (const char* table : {"points.csv", "causes.csv", "sweeps.csv"})
    EXPECT_EQ(slurp(folder_ / "numbers" / table).rfind("surface,", 0), 0u) << table;
}

TEST_F(ReportPages, Plan) {
  const ToolRun planned =
      run_tool("plan-projection",
               "--resolution 1280x801 --throw-ratio 0.83 --lens-shift -0.07,0.46 --f-number 1.9 "
               "--focal-length 13.7mm --distance 166cm -o " +
                   at("plan.svg"));
  ASSERT_EQ(planned.exit_code, 0) << planned.err;
  expect_sound(folder_ / "plan.svg");
}

}  // namespace
}  // namespace procam::test
