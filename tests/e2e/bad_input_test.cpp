/// What goes wrong at a user's desk: each case refused with its reason, the right exit code and no output
/// file.
#include <gtest/gtest.h>

#include <fstream>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// One small simulated session for all cases, made by the build; each case spoils a copy of its own.
class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    session_ = folder_ / "session";
    fs::copy(PROCAM_E2E_SESSION, session_, fs::copy_options::recursive);
  }

  fs::path view(int index) const { return session_ / ("view_0" + std::to_string(index)); }
  static std::vector<fs::path> frames_of(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const fs::path& file : fs::directory_iterator(folder))
      if (file.extension() == ".png") files.push_back(file);
    std::sort(files.begin(), files.end());
    return files;
  }
  static void replace(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
  }

  ToolRun calibrate(const std::string& more = "") {
    return run_tool("calibrate-projector",
                    "--captures " + session_.string() + " -o " + rig().string() + " " + more);
  }
  fs::path rig() const { return folder_ / "rig.json"; }

  void expect_refused(const ToolRun& run, int exit_code, const std::vector<std::string>& words) {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    for (const std::string& word : words)
      EXPECT_NE(run.err.find(word), std::string::npos) << "no '" << word << "' in: " << run.err;
    EXPECT_FALSE(fs::exists(rig()));
  }

  ScratchFolder folder_;
  fs::path session_;
};

TEST_F(BadInput, NoneAtAllCalibrates) {  // the fixture itself is good
  const ToolRun run = calibrate("--truth " + (session_ / "truth.json").string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(rig()));
}

TEST_F(BadInput, EmptyFolder) {
  fs::remove_all(session_);
  fs::create_directory(session_);
  expect_refused(calibrate("--projector-size 1024x768 --board chessboard:10x7:35mm"), 3, {"session"});
}

TEST_F(BadInput, EmptyView) {
  for (const fs::path& file : frames_of(view(1))) fs::remove(file);
  const ToolRun run = calibrate();  // a folder without images is no view: three are left, and that is enough
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(BadInput, MissingFrame) {
  const fs::path gone = frames_of(view(2))[17];
  fs::remove(gone);
  expect_refused(calibrate(), 3, {"view_02", gone.filename().string()});
}

TEST_F(BadInput, MissingLastFrame) {
  fs::remove(frames_of(view(2)).back());
  expect_refused(calibrate(), 3, {"view_02", "42"});
}

/// The image is rejected by name, and its view with it; the others calibrate.
TEST_F(BadInput, FramesOfTwoSizes) {
  const fs::path file = frames_of(view(0))[5];
  fs::remove(file);
  io::save_image(file, ImageU8(320, 200, 1, 90));
  const ToolRun run = calibrate();
  EXPECT_TRUE(fs::exists(rig())) << run.err;
  EXPECT_NE(run.err.find("rejected for their size: frame_05.png (320x200)"), std::string::npos) << run.err;
  EXPECT_NE((run.out + run.err).find("3 of 4"), std::string::npos) << run.out;
}

TEST_F(BadInput, TruncatedPng) {
  const fs::path file = frames_of(view(3))[11];
  const std::string bytes = slurp(file);
  replace(file, bytes.substr(0, bytes.size() * 2 / 3));
  expect_refused(calibrate(), 3, {"view_03", file.filename().string()});
}

TEST_F(BadInput, WrongProjectorSize) {
  expect_refused(calibrate("--projector-size 1280x800"), 3, {"42 frames", "44", "projector size"});
}

TEST_F(BadInput, ProjectorWidthAndHeightSwapped) {
  expect_refused(calibrate("--projector-size 768x1024"), 3, {"768x1024"});
}

TEST_F(BadInput, KnownCameraOfAnotherSize) {
  Rig rig;
  rig.cameras.push_back({"camera", Camera{{640, 480}, {800, 802, 322, 244, 0}, BrownConrady{}}, Pose()});
  io::save_rig(session_ / "camera.json", rig);
  expect_refused(calibrate("--known-camera " + (session_ / "camera.json").string()), 3, {"640x480", "mode"});
}

TEST_F(BadInput, WrongBoardCounts) {
  expect_refused(calibrate("--board chessboard:9x7:35mm"), 3, {"9x7", "10x7"});
}

TEST_F(BadInput, BoardCountsSwapped) {
  // A 10x7 board turned by a quarter is a 7x10 board: a legitimate description of the same sheet.
  const ToolRun run = calibrate("--board chessboard:7x10:35mm");
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.exit_code << run.err;
}

TEST_F(BadInput, LengthWithoutUnit) {
  expect_refused(calibrate("--board chessboard:10x7:35"), 2, {"--board", "mm"});
}

TEST_F(BadInput, TooFewViews) {
  fs::remove_all(view(2));
  fs::remove_all(view(3));
  expect_refused(calibrate(), 4, {"at least three"});
}

TEST_F(BadInput, UnwritableOutput) {
  const ToolRun run = run_tool("calibrate-projector", "--captures " + session_.string() + " -o " +
                                                          (session_ / "session.json").string() + "/rig.json");
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.err.find("rig.json"), std::string::npos) << run.err;
}

class BadRigFile : public BadInput {
 protected:
  void SetUp() override {
    BadInput::SetUp();
    text_ = slurp(session_ / "truth.json");
    ASSERT_FALSE(text_.empty());
  }
  ToolRun check(const std::string& text) {
    replace(folder_ / "bad.json", text);
    return run_tool("calibrate-projector", "--check " + (folder_ / "bad.json").string());
  }
  std::string text_;
};

TEST_F(BadRigFile, GoodOnePasses) {
  EXPECT_EQ(check(text_).exit_code, 0);
}

TEST_F(BadRigFile, NaN) {
  std::string text = text_;
  const std::size_t at = text.find("\"fx\": ");
  ASSERT_NE(at, std::string::npos);
  text.replace(at + 6, text.find_first_of(",\n}", at + 6) - at - 6, "NaN");
  const ToolRun run = check(text);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("bad.json"), std::string::npos) << run.err;
}

TEST_F(BadRigFile, UnknownField) {
  std::string text = text_;
  text.replace(text.find("\"fx\": "), 6, "\"fxx\": ");
  const ToolRun run = check(text);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("fxx"), std::string::npos) << run.err;
}

TEST_F(BadRigFile, FutureVersion) {
  std::string text = text_;
  const std::size_t at = text.find("\"version\": 1");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 12, "\"version\": 99");
  const ToolRun run = check(text);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("99"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace procam::test
