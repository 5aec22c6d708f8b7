/// A session's folder while it is captured: nothing half done has a view's name, and nothing is lost.
#include "procam/session/files.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "procam/io/image/images.hpp"
#include "procam/session/projected_board.hpp"
#include "support/expect_error.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

class SessionFolder : public ::testing::Test {
 protected:
  SessionFolder() {
    std::string name = (fs::temp_directory_path() / "procam_session_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~SessionFolder() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  static ImageU8 frame(int grey) { return ImageU8(9, 7, 1, std::uint8_t(grey)); }

  fs::path folder_;
};

TEST_F(SessionFolder, NamesAViewWhenItIsComplete) {
  ViewWriter view(folder_, 3);
  view.keep(frame(10));
  view.keep_rejected(frame(77), "torn");
  view.keep_rejected(frame(78), "torn");
  view.keep(frame(20));
  EXPECT_FALSE(is_complete(folder_, 3));
  EXPECT_THROW(io::list_views(folder_), Error) << "a partial view was listed";
  view.finish();
  EXPECT_TRUE(is_complete(folder_, 3));
  ASSERT_EQ(io::list_views(folder_).size(), 1u);
  EXPECT_EQ(io::load_capture_folder(folder_ / "view_03", 2).frames[1].at(0, 0), 20)
      << "refused frames are no frames";
  EXPECT_EQ(io::load_image(folder_ / "view_03/rejected/frame_01_torn_01.png").image.at(0, 0), 78);
}

TEST_F(SessionFolder, GoesOnWithAnEarlierRunsView) {
  {
    ViewWriter view(folder_, 0);
    for (int i = 0; i < 12; ++i) view.keep(frame(i));
  }
  ViewWriter view(folder_, 0);
  EXPECT_EQ(view.kept(), 12);
  EXPECT_EQ(io::load_image(view.frame_file(11)).image.at(0, 0), 11);
  view.keep(frame(12));
  view.finish();
  EXPECT_EQ(io::load_capture_folder(folder_ / "view_00", 13).frames[12].at(0, 0), 12);
}

TEST_F(SessionFolder, KeepsWhatIsSetAside) {
  ViewWriter view(folder_, 0);
  for (int round = 0; round < 2; ++round) {
    view.keep(frame(50 + round));
    view.set_aside();
    EXPECT_EQ(view.kept(), 0);
  }
  view.keep(frame(52));
  view.finish();
  for (int round = 0; round < 2; ++round)
    EXPECT_EQ(io::load_image(folder_ / (".view_00.set_aside_" + std::to_string(round)) / "frame_00.png")
                  .image.at(0, 0),
              50 + round);
  EXPECT_EQ(io::list_views(folder_).size(), 1u);
  EXPECT_NE(make_checks_folder(folder_), make_checks_folder(folder_));
}

TEST_F(SessionFolder, IsNotMixedWithAnotherSession) {
  const auto gray = make_pattern("gray", {100, 60}), phase = make_pattern("phase", {100, 60});
  const Board board = Chessboard{7, 5, 0.02}, other = Chessboard{7, 5, 0.03};
  require_same_session(folder_, describe_session(*gray, {100, 60}, board, 1));
  io::save_session(folder_, describe_session(*gray, {100, 60}, board, 1));
  require_same_session(folder_, describe_session(*gray, {100, 60}, board, 1));
  require_same_session(folder_, describe_session(*gray, {100, 60}, {}, 1));
  EXPECT_THROW(require_same_session(folder_, describe_session(*phase, {100, 60}, board, 1)), Error);
  EXPECT_THROW(require_same_session(folder_, describe_session(*gray, {100, 61}, board, 1)), Error);
  EXPECT_THROW(require_same_session(folder_, describe_session(*gray, {100, 60}, board, 2)), Error);
  EXPECT_THROW(require_same_session(folder_, describe_session(*gray, {100, 60}, other, 1)), Error);
}

TEST_F(SessionFolder, OfAProjectedBoardIsReadByItsPattern) {
  EXPECT_ERROR(read_projected_board(folder_, "", {64, 48}, {9, 7}), kInput, "says what was shown");
  EXPECT_ERROR(read_projected_board(folder_, "gray", {64, 48}, {9, 7}), kInput, "not a projected board");
  const std::string pattern = "charuco";
  const int frames = make_pattern(pattern, {640, 480})->frame_count();
  ViewWriter view(folder_, 0);
  for (int i = 0; i < frames; ++i) view.keep(frame(20));
  view.finish();
  EXPECT_ERROR(read_projected_board(folder_ / "view_00", pattern, {640, 480}, {8, 7}), kInput,
               "its pictures have 9x7");
  EXPECT_ERROR(read_projected_board(folder_ / "view_00", pattern, {640, 480}, {9, 7}), kInput,
               "both pictures show the same light");
}

}  // namespace
}  // namespace procam::session
