#include "procam/io/session/captures.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/pattern_file.hpp"
#include "procam/io/session/shown_file.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

/// Frame `value` is filled with its number.
void save_frame(const Scratch& scratch, const std::string& name, int value, ImageSize size = {6, 4},
                int channels = 1) {
  std::filesystem::create_directories((scratch / name).parent_path());
  save_image(scratch / name, ImageU8(size, channels, std::uint8_t(value)));
}

TEST(CaptureFolder, ReadsFramesInTheOrderOfTheirNumbers) {
  const Scratch scratch;
  for (int i = 1; i <= 12; ++i) save_frame(scratch, "frame_" + std::to_string(i) + ".png", i);
  scratch.write("notes.txt", "left alone");
  scratch.write(".hidden_3.png", "left alone");
  const CaptureFolder captures = load_capture_folder(scratch.path(), 12);
  ASSERT_EQ(captures.frames.size(), 12u);
  for (int i = 1; i <= 12; ++i) EXPECT_EQ(captures.frames[std::size_t(i - 1)].at(5, 3), i);
  EXPECT_EQ(captures.files[9].filename(), "frame_10.png");
  EXPECT_TRUE(captures.diagnostics.items.empty());
}

TEST(CaptureFolder, KeepsColourWhereItIsAskedFor) {
  const Scratch scratch;
  ImageU8 colour(5, 7, 4, 200);
  colour.at(2, 3, 0) = 11, colour.at(2, 3, 1) = 22, colour.at(2, 3, 2) = 33;
  std::filesystem::create_directories(scratch / "view");
  save_image(scratch / "view/frame_0.png", colour);
  const CaptureFolder captures = load_capture_folder(scratch / "view", 1, 3);
  ASSERT_EQ(captures.frames.front().channels(), 3);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(captures.frames.front().at(2, 3, c), 11 * (c + 1));
  EXPECT_TRUE(captures.diagnostics.items.empty());
  save_frame(scratch, "grey/frame_0.png", 9);
  EXPECT_NE(test::error_of([&] { load_capture_folder(scratch / "grey", 1, 3); }).why().find("grey"),
            std::string::npos);
}

TEST(CaptureFolder, TakesTheLastNumberOfANameAndGreyFromColour) {
  const Scratch scratch;
  for (int i = 98; i <= 101; ++i) save_frame(scratch, "cam2_" + std::to_string(i) + "_raw.png", i, {5, 7}, 3);
  const CaptureFolder captures = load_capture_folder(scratch.path(), 4);
  EXPECT_EQ(captures.frames[2].channels(), 1);
  EXPECT_EQ(captures.frames[2].at(4, 6), 100);
  EXPECT_NE(captures.diagnostics.find("reduced_to_gray"), nullptr);
}

TEST(CaptureFolder, MeasuresTheGreenChannelOfColour) {
  const Scratch scratch;
  ImageU8 colour(5, 7, 3, 90);
  colour.at(2, 3, 0) = 11, colour.at(2, 3, 1) = 22, colour.at(2, 3, 2) = 33;
  std::filesystem::create_directories(scratch / "view");
  save_image(scratch / "view/frame_0.png", colour);
  EXPECT_EQ(load_capture_folder(scratch / "view", 1).frames.front().at(2, 3), 22);
}

/// A camera of 12 bits, whose driver writes them into the lower part of 16.
TEST(CaptureFolder, WarnsOfBitsThatAreNotUsed) {
  const Scratch scratch;
  const auto remark_of = [&](int factor) {
    cv::Mat frame(7, 5, CV_16UC1, cv::Scalar(90 * factor));
    frame.at<std::uint16_t>(3, 2) = std::uint16_t(255 * factor);
    cv::imwrite((scratch / "frame_0.png").string(), frame);
    return load_capture_folder(scratch.path(), 1).diagnostics;
  };
  EXPECT_NE(remark_of(16).find("bits_unused"), nullptr);
  EXPECT_EQ(remark_of(257).find("bits_unused"), nullptr);
}

TEST(CaptureFolder, RefusesAnEmptyOrAbsentFolder) {
  const Scratch scratch;
  scratch.write("notes.txt", "no image");
  EXPECT_ERROR(load_capture_folder(scratch.path(), 42), kInput, "there is no image in the folder");
  EXPECT_ERROR(load_capture_folder(scratch / "absent", 42), kIo, "cannot read the folder");
}

TEST(CaptureFolder, NamesTheMissingFrame) {
  const Scratch scratch;
  for (const int i : {8, 9, 11})
    save_frame(scratch, "graycode_" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png", i);
  EXPECT_ERROR(load_capture_folder(scratch.path(), 4), kInput,
               "frame graycode_10.png is missing: graycode_09.png is followed by graycode_11.png");
  save_frame(scratch, "graycode_10.png", 10);
  EXPECT_ERROR(load_capture_folder(scratch.path(), 5), kInput,
               "4 frames where the pattern has 5 (graycode_08.png to graycode_11.png)");
  EXPECT_ERROR(load_capture_folder(scratch.path(), 3), kInput, "4 frames where the pattern has 3");
}

TEST(CaptureFolder, RefusesFramesThatDoNotBelongTogether) {
  const Scratch sizes;
  save_frame(sizes, "f1.png", 1);
  save_frame(sizes, "f2.png", 2, {4, 6});
  EXPECT_ERROR(load_capture_folder(sizes.path(), 2), kInput, "two sizes: f1.png is 6x4 and f2.png is 4x6");
  const Scratch series;
  save_frame(series, "left1.png", 1);
  save_frame(series, "right1.png", 1);
  EXPECT_ERROR(load_capture_folder(series.path(), 2), kInput, "two series: left1.png and right1.png");
  const Scratch twice;
  save_frame(twice, "f1.png", 1);
  save_frame(twice, "f01.png", 1);
  EXPECT_ERROR(load_capture_folder(twice.path(), 2), kInput, "two files have number 1: f01.png and f1.png");
  const Scratch unnumbered;
  save_frame(unnumbered, "f1.png", 1);
  save_frame(unnumbered, "white.png", 1);
  EXPECT_ERROR(load_capture_folder(unnumbered.path(), 2), kInput, "white.png: the image has no number");
}

TEST(CaptureFolder, RejectsImagesOfAnotherSizeByName) {
  const Scratch scratch;
  for (const int i : {1, 2, 3}) save_frame(scratch, "f" + std::to_string(i) + ".png", i);
  save_frame(scratch, "thumbnail.png", 4, {3, 2});
  const CaptureFolder captures = load_capture_folder(scratch.path(), 3, 1, ImageSize{6, 4});
  EXPECT_EQ(captures.frames.size(), 3u);
  ASSERT_NE(captures.diagnostics.find("image_size_differs"), nullptr);
  EXPECT_NE(captures.diagnostics.find("image_size_differs")->message.find("thumbnail.png (3x2)"),
            std::string::npos);
  save_frame(scratch, "f2.png", 2, {4, 6});
  const CaptureFolder short_of_one = load_capture_folder(scratch.path(), 3, 1, ImageSize{6, 4});
  EXPECT_TRUE(short_of_one.frames.empty());
  EXPECT_NE(short_of_one.diagnostics.items.front().message.find("f2.png (4x6), thumbnail.png"),
            std::string::npos);

  const Scratch other;
  for (const int i : {1, 2, 3, 4}) save_frame(other, "f" + std::to_string(i) + ".png", i, {8, 5});
  EXPECT_EQ(common_image_size({scratch.path(), other.path()}), (ImageSize{8, 5}));
  EXPECT_EQ(common_image_size({scratch.path()}), (ImageSize{6, 4}));
  other.write("broken.png", "no image");
  const Scratch empty;
  EXPECT_EQ(common_image_size({empty.path()}), std::nullopt);
}

TEST(CaptureFolder, RefusesATruncatedFrameByName) {
  const Scratch scratch;
  save_frame(scratch, "f1.png", 1);
  save_frame(scratch, "f2.png", 2);
  const std::string whole = read_file(scratch / "f2.png");
  scratch.write("f2.png", whole.substr(0, whole.size() - 5));
  EXPECT_ERROR(load_capture_folder(scratch.path(), 2), kInput, "f2.png: the file is cut short");
}

TEST(Session, ListsTheViewsInNaturalOrder) {
  const Scratch scratch;
  EXPECT_ERROR(list_views(scratch.path()), kInput, "none of its sub-folders holds images");
  EXPECT_ERROR(list_views(scratch / "absent"), kIo, "absent");
  for (const char* view : {"pose_10", "pose_2", "pose_1"})
    save_frame(scratch, std::string(view) + "/f1.png", 1);
  scratch.write("logs/log.txt", "no image");
  const auto views = list_views(scratch.path());
  ASSERT_EQ(views.size(), 3u);
  EXPECT_EQ(views[1].filename(), "pose_2");
  EXPECT_EQ(views[2].filename(), "pose_10");
}

TEST(Session, ListsTheStacksOfProjectorsAndCameras) {
  const Scratch scratch;
  for (const char* file :
       {"a/beamer/right/f0.png", "a/beamer/left/f0.png", "a/lamp/left/f0.png", "a/lamp/left/rejected/f0.png",
        "b/left/f0.png", "c/lamp/f0.png", "d/f0.png", "d/rejected/f0.png"})
    save_frame(scratch, file, 1);
  scratch.write("a/notes/text.txt", "no image");
  EXPECT_EQ(list_views(scratch.path()).size(), 4u);
  const auto names = [&](const char* view) {
    std::string all;
    for (const Stack& stack : list_stacks(scratch / view, {"lamp", "beamer"}))
      all += stack.projector + "/" + stack.camera + " ";
    return all;
  };
  EXPECT_EQ(names("a"), "beamer/left beamer/right lamp/left ");
  EXPECT_EQ(names("b"), "/left ");
  EXPECT_EQ(names("c"), "lamp/ ");
  EXPECT_EQ(names("d"), "/ ");
  save_frame(scratch, "c/lamp/left/f0.png", 1);
  EXPECT_ERROR(list_stacks(scratch / "c", {"lamp"}), kInput, "images beside folders of images (left)");
}

TEST(Session, StatesSeveralProjectorsByName) {
  const Scratch scratch;
  save_session(scratch.path(), {"gray", {}, {}, {}, {{"left", {1024, 768}}, {"right", {1280, 800}}}});
  const std::optional<SessionInfo> session = load_session(scratch.path());
  EXPECT_FALSE(session->projector_size.has_value());
  EXPECT_EQ(session->projectors.at("right"), (ImageSize{1280, 800}));
  scratch.write("session.json", R"({"format": "procam-session", "version": 1, "projector_size": [8, 6],
 "projectors": {"left": [1024, 768]}})");
  EXPECT_ERROR(load_session(scratch.path()), kInput, "session.json:2: projectors: there is a projector_size");
}

TEST(Shown, ReadsBackAndNamesWhatContradicts) {
  const Scratch scratch;
  const ShownInViews shown{true,
                           {{"view_00.png", "left"}, {"view_01", "frame.png"}},
                           {},
                           {{"left", {7, 5, Vec2(31.5, 20.25), 44}}}};
  save_shown(scratch / "shown.json", shown);
  const ShownInViews read = load_shown(scratch / "shown.json");
  EXPECT_TRUE(read.upright);
  EXPECT_EQ(read.views, shown.views);
  EXPECT_EQ(read.boards.at("left").first_corner, Vec2(31.5, 20.25));
  EXPECT_EQ(read.boards.at("left").rows, 5);
  EXPECT_ERROR(load_shown(scratch.write("a.json", R"({"format": "procam-shown", "version": 1})")), kInput,
               "neither views nor all_views");
  EXPECT_ERROR(load_shown(scratch.write("b.json", R"({"format": "procam-shown", "version": 1,
"all_views": "f.png", "boards": {"x": {"columns": 7, "rows": 5, "first_corner": [1, 2], "step": 0}}})")),
               kInput, "b.json:2: boards.x.step: it is not positive");
}

TEST(PatternFile, ReadsBackAndNamesTheFrameThatIsWrong) {
  using Kind = SequenceFrame::Kind;
  const Scratch scratch;
  save_pattern(scratch / "pattern.json", {4,
                                          {0, 128},
                                          {{Kind::kGray, StripeAxis::kRow, 3, true},
                                           {Kind::kPhase, StripeAxis::kColumn, 0, false, 18.5, 2},
                                           {Kind::kWhite}}});
  const FrameSequence read = load_pattern(scratch / "pattern.json");
  EXPECT_EQ(read.step, 4);
  EXPECT_EQ(read.offset[1], 128);
  ASSERT_EQ(read.frames.size(), 3u);
  EXPECT_EQ(read.frames[0].axis, StripeAxis::kRow);
  EXPECT_TRUE(read.frames[0].bit == 3 && read.frames[0].inverse);
  EXPECT_EQ(read.frames[1].kind, Kind::kPhase);
  EXPECT_EQ(read.frames[1].period, 18.5);
  EXPECT_NEAR(read.frames[1].phase, 2, 1e-15);
  EXPECT_EQ(read.frames[2].kind, Kind::kWhite);

  const auto refused = [&](const std::string& fields, const std::string& part) {
    const std::string start = R"({"format": "procam-pattern", "version": 1,)";
    EXPECT_ERROR(load_pattern(scratch.write("bad.json", start + "\n" + fields + "}")), kInput, part);
  };
  refused(R"("frames": [{"kind": "white"}, {"kind": "grey"}])", "frames[1].kind: there is no 'grey' here");
  refused(R"("frames": [{"kind": "gray", "axis": "columns"}])",
          "bad.json:2: frames[0]: the field 'bit' is missing");
  refused(R"("frames": [{"kind": "gray", "axis": "columns", "bit": 0, "period": 3}])",
          "unknown field 'period'");
  refused(R"("frames": [{"kind": "phase", "axis": "rows", "period": 16, "phase": 0}])",
          "did you mean 'phase_deg'");
  refused(R"("frames": [{"kind": "phase", "axis": "rows", "period": 1, "phase_deg": 0}])", "it is below 2");
  refused(R"("offset": [0, 0.5], "frames": [{"kind": "white"}])", "offset: it is not two whole numbers");
  refused(R"("frames": [])", "frames: there is none");
}

TEST(Session, ReadsBackAndMayBeAbsentOrPartial) {
  const Scratch scratch;
  EXPECT_FALSE(load_session(scratch.path()).has_value());
  save_session(scratch.path(), {"gray", ImageSize{1024, 768}, Board(Chessboard{7, 9, 0.075}), 2});
  const std::optional<SessionInfo> session = load_session(scratch.path());
  ASSERT_TRUE(session.has_value());
  EXPECT_EQ(session->pattern, "gray");
  EXPECT_EQ(*session->projector_size, (ImageSize{1024, 768}));
  EXPECT_EQ(std::get<Chessboard>(*session->board), (Chessboard{7, 9, 0.075}));
  EXPECT_EQ(*session->step, 2);
  scratch.write("session.json", R"({"format": "procam-session", "version": 1})");
  EXPECT_FALSE(load_session(scratch.path())->board.has_value());
  scratch.write("session.json",
                "{\"format\": \"procam-session\", \"version\": 1,\n\"board\": \"chessboard:7x9:75\"}");
  EXPECT_ERROR(load_session(scratch.path()), kInput, "session.json:2: board: board 'chessboard:7x9:75'");
}

}  // namespace
}  // namespace procam::io
