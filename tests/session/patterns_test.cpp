#include "procam/session/patterns.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <random>

#include "pattern_table.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/sequence_check.hpp"
#include "procam/simulate/session.hpp"
#include "support/gray_code_world.hpp"
#include "support/test_data.hpp"

namespace procam::session {
namespace {

const ImageSize kProjector{1024, 768};

TEST(PatternTable, EachRowStatesItselfAndShowsAsManyFramesAsItSays) {
  for (const PatternRow& row : pattern_table()) {
    const auto pattern = make_pattern(row.name, kProjector);
    EXPECT_EQ(make_pattern(pattern->text(), kProjector)->text(), pattern->text());
    EXPECT_EQ(pattern->text().rfind(row.name, 0), 0u) << pattern->text();
    const std::vector<ImageU8> frames = pattern->frames();
    EXPECT_EQ(int(frames.size()), pattern->frame_count()) << row.name;
    for (const ImageU8& frame : frames)
      ASSERT_TRUE(frame.size() == kProjector && frame.channels() == pattern->channels());
    EXPECT_NE(pattern->describe().find(std::to_string(frames.size()) + " frames for 1024x768"),
              std::string::npos);
    EXPECT_NE(pattern_help().find(row.name), std::string::npos);
  }
}

TEST(PatternTable, TakesParametersAfterAColon) {
  EXPECT_EQ(make_pattern("phase:20px", kProjector)->text(), "phase:20px");
  EXPECT_EQ(make_pattern("chessboard:9x6:70px", kProjector)->text(), "chessboard:9x6:70px");
  for (const char* text :
       {"charuco:9x7:80px:56px:5x5_100", "markers:6x5:72px:30px:apriltag_36h11", "circles:5x7:80px:70.5px"})
    EXPECT_EQ(make_pattern(text, kProjector)->text(), text);
  EXPECT_EQ(make_pattern("gray", kProjector, 4)->frame_count(), 34);
}

TEST(PatternTable, ShowsBoardsOfLightInOneColourFrameWhenAsked) {
  for (const char* name : {"chessboard", "charuco", "markers", "circles"}) {
    const auto one = make_pattern(std::string(name) + ":colour", kProjector),
               pair = make_pattern(name, kProjector);
    EXPECT_EQ(one->text(), pair->text() + ":colour");
    EXPECT_EQ(make_pattern(one->text(), kProjector)->text(), one->text());
    EXPECT_EQ(one->frame_count(), 1);
    EXPECT_EQ(one->channels(), 3);
    EXPECT_EQ(pair->channels(), 1);
    EXPECT_NE(one->describe().find("1 frames for 1024x768"), std::string::npos);
  }
}

/// Both counts odd, or equal: only with the statement that settles the first corner.
TEST(PatternTable, TakesAmbiguousChessboardsThatAreUpright) {
  for (const char* text : {"chessboard:9x7:64px:upright", "chessboard:8x8:64px:upright:colour"})
    EXPECT_EQ(make_pattern(text, kProjector)->text(), text);
  try {
    make_pattern("chessboard:9x7:64px", kProjector);
    FAIL() << "a board without a first corner was taken";
  } catch (const Error& error) {
    EXPECT_NE(error.next().find("':upright'"), std::string::npos) << error.next();
  }
  EXPECT_THROW(make_pattern("circles:7x11:64px:56px:upright", kProjector), Error);
}

TEST(PatternTable, LetsBoardsWithMarkersLeaveThePaper) {
  const auto area = [](const char* text) {
    return make_pattern(text, kProjector)->on_blank_paper()->volume();
  };
  EXPECT_LT(area("markers"), 0.75 * 1024 * 768);
  EXPECT_LT(area("charuco"), 0.75 * 1024 * 768);
  EXPECT_GT(area("circles"), 0.75 * 1024 * 768);
  EXPECT_FALSE(make_pattern("gray", kProjector)->on_blank_paper());
}

TEST(PatternTable, NamesWhatItKnowsAndRefusesTheRest) {
  try {
    make_pattern("moire", kProjector);
    FAIL() << "an unknown pattern was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    for (const PatternRow& row : pattern_table())
      EXPECT_NE(error.next().find(row.name), std::string::npos) << row.name;
  }
  for (const char* text :
       {"gray:3", "phase:7px", "phase:16", "phase:900px", "gray+phase:16px2", "chessboard:12",
        "chessboard:12x9:64mm", "chessboard:12x9:640px", "chessboard:12x9:64px:red", "markers:10x7:64px:32px",
        "markers:10x7:0.1m:0.05m:4x4_250", "charuco:15x11:64px:49px:4x4_250", "charuco:9x7:80px:56m:5x5_100",
        "circles:7x10:64px:56px", "circles:7x11:64px:100px", ""})
    EXPECT_THROW(make_pattern(text, kProjector), Error) << text;
}

/// The corners of one simulated view, read as calibrate-projector reads it.
struct ReadView {
  session::BoardView view;
  std::vector<Observation> truth;  ///< in the camera, where the board is at the end
};

ReadView read_view(const SessionPattern& pattern, const std::function<void(simulate::Conditions&)>& spoil) {
  using namespace simulate;
  Conditions conditions = level_conditions(Level::kPaper);
  spoil(conditions);
  SimulatedSession session = make_session(Level::kPaper, 8, pattern.on_blank_paper(), {}, conditions);
  session.capture.samples_per_axis = 1;
  constexpr std::size_t kView = 3;
  const std::vector<ImageU8> captures = capture_view(session, kView, pattern.frames());
  World world = session.views[kView];
  if (session.defects[kView].moved)
    world.rig_from_board = world.rig_from_board * session.defects[kView].moved->board_from_moved;
  return {pattern.read("03", {captures.begin(), captures.end()}, session.stated_board),
          board_in_camera(world)};
}

/// Some 0.03 px of corners under noise; the smallest motion below is 2 px.
void expect_corners(const ReadView& read) {
  const std::vector<Observation>& corners = read.view.detections[0].observations;
  ASSERT_EQ(corners.size(), read.truth.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    EXPECT_LT((corners[i].pixel - read.truth[i].pixel).norm(), 0.3) << i;
}

/// The picture of decoded pixels agrees with the corners' light to a block of it and a stripe.
void expect_decoded(const session::BoardView& view) {
  const ImageF& decoded = view.decoded;
  ASSERT_EQ(decoded.channels(), 2);
  const double scale = std::ceil(view.detections[0].image_size.width / 480.0);
  int near = 0, read = 0;
  for (const Observation& light : view.detections[1].observations)
    for (const Observation& corner : view.detections[0].observations) {
      if (corner.point != light.point) continue;
      const Vec2 at = (corner.pixel.array() + 0.5) / scale;
      const int x = int(at.x()), y = int(at.y());
      if (decoded.at(x, y, 0) < 0) continue;
      ++read;
      near +=
          (Vec2(double(decoded.at(x, y, 0)), double(decoded.at(x, y, 1))) - light.pixel).norm() < 4 * scale;
    }
  EXPECT_GT(read, int(view.detections[1].observations.size()) / 2);
  EXPECT_EQ(near, read);
}

TEST(GrayPattern, KeepsTheCameraCornersOfAViewWhoseFramesDoNotFitTogether) {
  const auto pattern = make_pattern("gray", kProjector);
  const std::vector<std::pair<const char*, std::function<void(simulate::Conditions&)>>> kinds{
      {"stale_frame", [](simulate::Conditions& c) { c.stale_views = 99; }},
      {"torn_frame", [](simulate::Conditions& c) { c.torn_views = 99; }},
      {"board_moved",
       [](simulate::Conditions& c) {
         c.moved_views = 99, c.moved_by = {0.008, 0.008};
       }},
      {"", [](simulate::Conditions&) {}}};
  for (const auto& [code, spoil] : kinds) {
    SCOPED_TRACE(code);
    const ReadView read = read_view(*pattern, spoil);
    const Diagnostics& remarks = read.view.detections[0].diagnostics;
    expect_corners(read);
    const bool sound = std::string(code).empty();
    EXPECT_EQ(read.view.detections[1].observations.empty(), !sound);
    if (sound) expect_decoded(read.view);
    EXPECT_EQ(remarks.find("projector_rejected") == nullptr, sound);
    EXPECT_TRUE(sound || remarks.find(code) != nullptr);
    EXPECT_EQ(remarks.find("pair_not_complementary"), nullptr);
  }
}

/// Eight grey levels from black to white, one of noise: the edges stand out of it by less than 5 standard deviations. Seeds 1
/// to 8 give 0.90 to 0.92 and 1.08 to 1.13; with edges of 5 deviations alone, no pixel.
TEST(GrayPattern, ReadsDarkSurfacesToAPartOfAStripe) {
  const ImageSize projector{117, 93};
  test::GrayCodeWorld world;
  world.black_level = 3, world.white_level = 11;
  world.noise_at_black = 1;
  world.projector_blur = 0.8;
  const auto pattern = make_pattern("gray", projector);
  const std::vector<ImageU8> captures = test::capture_all(world, pattern->frames());
  const LightMap light = pattern->read_light_map(test::views_of(captures))->light;
  int inside = 0, known = 0;
  double sum = 0;
  for (int y = 0; y < light.pixel.height(); ++y)
    for (int x = 0; x < light.pixel.width(); ++x) {
      const Vec2 true_pixel = world.projector_pixel(Vec2(x, y));
      if (true_pixel.x() < 3 || true_pixel.y() < 3 || true_pixel.x() > projector.width - 4 ||
          true_pixel.y() > projector.height - 4)
        continue;
      ++inside;
      const double sigma = light.sigma.at(x, y, 0);
      if (!light.decoded(x, y) || !(sigma < 0.25)) continue;
      ++known;
      sum += std::pow((light.pixel.at(x, y, 0) - true_pixel.x()) / sigma, 2);
    }
  EXPECT_GT(known, 0.85 * inside);
  EXPECT_LT(std::sqrt(sum / known), 1.25);
}

TEST(PhasePattern, KeepsTheCameraCornersOfAMovedBoardAtItsLastPosition) {
  const auto pattern = make_pattern("phase", kProjector);
  const ReadView read = read_view(*pattern, [](simulate::Conditions& c) {
    c.moved_views = 99, c.moved_by = {0.012, 0.012};
  });
  EXPECT_NE(read.view.detections[0].diagnostics.find("board_moved"), nullptr);
  expect_corners(read);
  EXPECT_TRUE(read.view.detections[1].observations.empty());
}

TEST(ChessboardPattern, NamesWhatHappenedBetweenItsTwoCaptures) {
  const auto pattern = make_pattern("chessboard", kProjector);
  const std::vector<std::pair<const char*, std::function<void(simulate::Conditions&)>>> kinds{
      {"stale_frame", [](simulate::Conditions& c) { c.stale_views = 99; }},
      {"board_moved",
       [](simulate::Conditions& c) {
         c.moved_views = 99, c.moved_by = {0.012, 0.012};
       }},
      {"exposure_changes", [](simulate::Conditions& c) { c.auto_exposure = 0.8; }},
      {"", [](simulate::Conditions&) {}}};
  const std::vector<const char*> all{"stale_frame", "board_moved", "camera_moved", "overexposed",
                                     "exposure_changes"};
  for (const auto& [code, spoil] : kinds) {
    SCOPED_TRACE(code);
    const ReadView read = read_view(*pattern, spoil);
    const Diagnostics& remarks = read.view.detections[0].diagnostics;
    for (const char* possible : all)
      EXPECT_EQ(remarks.find(possible) != nullptr, std::string(possible) == code) << possible;
    if (std::string(code) == "stale_frame" || std::string(code) == "board_moved") {
      EXPECT_TRUE(read.view.light_points.empty());
      // "No board was found; check its counts" would be a second, wrong cause.
      EXPECT_TRUE(read.view.detections[1].diagnostics.items.empty());
    }
    if (std::string(code).empty()) {
      EXPECT_FALSE(read.view.light_points.empty());
    }
  }
}

/// Captures of one view at level paper, clean but for what `spoil` does to them.
BoardView read_spoiled(const SessionPattern& pattern,
                       const std::function<void(std::vector<ImageU8>&)>& spoil) {
  simulate::Conditions conditions = simulate::level_conditions(simulate::Level::kPaper);
  conditions.moved_views = conditions.stale_views = conditions.dark_views = conditions.overexposed_views = 0;
  simulate::SimulatedSession session =
      simulate::make_session(simulate::Level::kPaper, 3, pattern.on_blank_paper(), {}, conditions);
  session.capture.samples_per_axis = 1;
  std::vector<ImageU8> captures = simulate::capture_view(session, 0, pattern.frames());
  spoil(captures);
  return pattern.read("view_00", {captures.begin(), captures.end()}, session.board().layout);
}

void scale(double factor, std::vector<ImageU8>& captures) {
  for (ImageU8& image : captures)
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        image.at(x, y) = std::uint8_t(std::clamp(factor * image.at(x, y) + 0.5, 0.0, 255.0));
}

/// In all views it was 0.8 m of error with every check passed: the squares of light are dark ones, numbered from the other
/// end.
TEST(ChessboardPattern, NamesCapturesInTheOtherOrder) {
  for (const char* kind : {"chessboard", "charuco", "markers", "circles"}) {
    SCOPED_TRACE(kind);
    const auto pattern = make_pattern(kind, simulate::projector_size(simulate::Level::kPaper));
    const BoardView sound = read_spoiled(*pattern, [](std::vector<ImageU8>&) {});
    EXPECT_EQ(sound.detections[0].diagnostics.find("frames_exchanged"), nullptr);
    EXPECT_FALSE(sound.light_points.empty());
    const BoardView exchanged =
        read_spoiled(*pattern, [](std::vector<ImageU8>& captures) { std::swap(captures[0], captures[1]); });
    EXPECT_TRUE(exchanged.light_points.empty());
  }
  const auto pattern = make_pattern("chessboard", simulate::projector_size(simulate::Level::kPaper));
  const BoardView exchanged =
      read_spoiled(*pattern, [](std::vector<ImageU8>& captures) { std::swap(captures[0], captures[1]); });
  EXPECT_NE(exchanged.detections[0].diagnostics.find("frames_exchanged"), nullptr);
  EXPECT_FALSE(exchanged.detections[0].observations.empty());
}

/// Four of ten views were called stale ("white still shows ..."), with the advice to raise the exposure.
TEST(GrayPattern, NamesAnExposureThatIsTooLong) {
  const auto pattern = make_pattern("gray", simulate::projector_size(simulate::Level::kPaper));
  const BoardView view = read_spoiled(*pattern, [](std::vector<ImageU8>& captures) { scale(3, captures); });
  const Diagnostics& remarks = view.detections[0].diagnostics;
  EXPECT_NE(remarks.find("overexposed"), nullptr);
  for (const char* wrong : {"stale_frame", "low_contrast", "highlight", "lag", "torn_frame"})
    EXPECT_EQ(remarks.find(wrong), nullptr) << wrong;
}

/// "Is the projector larger?" was the answer, and of black before white "the camera's exposure follows the light".
TEST(GrayPattern, NamesAnotherOrderOfTheFrames) {
  const auto pattern = make_pattern("gray", simulate::projector_size(simulate::Level::kPaper));
  const std::vector<std::pair<const char*, std::function<void(std::vector<ImageU8>&)>>> orders{
      {"rows come before columns",
       [](std::vector<ImageU8>& c) { std::rotate(c.begin(), c.begin() + 20, c.begin() + 40); }},
      {"each inverse comes before its pattern",
       [](std::vector<ImageU8>& c) {
         for (std::size_t i = 0; i < 40; i += 2) std::swap(c[i], c[i + 1]);
       }},
      {"black comes before white", [](std::vector<ImageU8>& c) { std::swap(c[40], c[41]); }},
      {"the finest stripes come first", [](std::vector<ImageU8>& c) {
         for (const std::size_t axis : {0, 20})
           for (std::size_t bit = 0; bit < 5; ++bit)
             for (const std::size_t second : {0, 1})
               std::swap(c[axis + 2 * bit + second], c[axis + 2 * (9 - bit) + second]);
       }}};
  for (const auto& [words, reorder] : orders) try {
      read_spoiled(*pattern, reorder);
      ADD_FAILURE() << words;
    } catch (const Error& error) {
      EXPECT_NE(error.why().find(words), std::string::npos) << error.why();
    }
}

TEST(ChessboardPattern, TakesExposureForNoStaleFrame) {
  const auto pattern = make_pattern("chessboard", simulate::projector_size(simulate::Level::kPaper));
  const BoardView bright = read_spoiled(*pattern, [](std::vector<ImageU8>& captures) { scale(3, captures); });
  EXPECT_NE(bright.detections[0].diagnostics.find("overexposed"), nullptr);
  EXPECT_EQ(bright.detections[0].diagnostics.find("stale_frame"), nullptr);
  const BoardView dark = read_spoiled(*pattern, [](std::vector<ImageU8>& captures) { scale(0.1, captures); });
  EXPECT_NE(dark.detections[0].diagnostics.find("low_contrast"), nullptr);
  EXPECT_EQ(dark.detections[0].diagnostics.find("stale_frame"), nullptr);
}

/// A stale frame in one view (capture 22 of this one, the coarsest row bit) makes codes beyond the projector's height. They
/// say nothing about its size: the view is named and the session goes on.
TEST(GrayPattern, TakesTheCodesOfAStaleFrameForNoOtherProjectorSize) {
  simulate::SimulatedSession session = simulate::make_session(simulate::Level::kHard, 1);
  session.capture.samples_per_axis = 1;
  ASSERT_TRUE(session.defects[0].stale);
  const ImageSize size = session.rig().projector().projector.size();
  const auto pattern = make_pattern("gray", size);
  const std::vector<ImageU8> captures = simulate::capture_view(session, 0, pattern->frames());
  const std::vector<ViewU8> views(captures.begin(), captures.end());
  const DecodedMap decoded = pattern::decode(views, pattern::GrayCode{size});
  ASSERT_NE(decoded.diagnostics.find("projector_size"), nullptr) << "else this view tests nothing";
  const BoardView view = pattern->read("view_00", views, session.board().layout);
  EXPECT_NE(view.detections[0].diagnostics.find("stale_frame"), nullptr);
  EXPECT_GE(view.detections[0].observations.size(), 60u);  // of 63
  EXPECT_TRUE(view.detections[1].observations.empty());
}

/// Captures of an independent world on a wider image. Defocus leaves few pixels with every bit (0.6 % of the
/// image), and the light at half of the corners is read all the same: no reason to check "the order of the
/// frames". Where the board moved, that is the cause.
TEST(GrayPattern, DoesNotCallFewPixelsAFaultWhereTheBoardIsRead) {
  PROCAM_REQUIRE_TEST_DATA("worlds/gray_hard/capture_03");
  const auto pattern = make_pattern("gray", {1024, 768});
  std::mt19937 random(1);
  const auto read = [&](const char* name) {
    io::CaptureFolder captures =
        io::load_capture_folder(test::test_data() / "worlds/gray_hard" / name, pattern->frame_count());
    for (ImageU8& frame : captures.frames) {
      ImageU8 wide(ImageSize{1280, 960});
      for (int y = 0; y < wide.height(); ++y)
        for (int x = 0; x < wide.width(); ++x) wide.at(x, y) = std::uint8_t(5 + random() % 7);
      for (int y = 0; y < frame.height(); ++y)
        std::copy_n(frame.row(y), frame.width(), wide.row(y + 200) + 300);
      frame = std::move(wide);
    }
    const std::vector<ViewU8> views(captures.frames.begin(), captures.frames.end());
    return pattern->read(name, views, Chessboard{10, 7, 0.05});
  };
  const BoardView sound = read("capture_03"), moved = read("capture_00");
  EXPECT_GE(sound.detections[1].observations.size(), 35u);  // of 38 in the light
  EXPECT_NE(moved.detections[0].diagnostics.find("board_moved"), nullptr);
  for (const BoardView& view : {sound, moved}) {
    EXPECT_NE(view.detections[0].diagnostics.find("decoded_share"), nullptr) << view.name;
    EXPECT_EQ(view.detections[0].diagnostics.find("hardly_decoded"), nullptr) << view.name;
  }
}

/// Projected markers beside a printed ChArUco at level hard, every print in the room's light alone or partly so: noise
/// is a large part of the print's contrast.
simulate::SimulatedSession noisy_marker_session(const SessionPattern& pattern, std::uint64_t seed,
                                                std::optional<simulate::Range> moved_by = std::nullopt) {
  using namespace simulate;
  const Board board = CharucoBoard{6, 5, 0.06, 0.045, MarkerDictionary::k4x4_50};
  Conditions conditions = level_conditions(Level::kHard);
  conditions.overexposed_views = conditions.moved_views = conditions.stale_views = 0;
  if (moved_by) {
    conditions.dark_views = 0;
    conditions.moved_views = 99;
    conditions.moved_by = *moved_by;
  }
  SimulatedSession session = make_session(Level::kHard, seed, pattern.on_blank_paper(),
                                          BoardPrint{board, detect::board_artwork(board)}, conditions);
  session.capture.samples_per_axis = 1;
  return session;
}

/// The first remark of check_flat_and_board(), empty without one; `on_board`: where the board is at the end.
std::string cause_of_pair(const std::vector<ImageU8>& captures, const std::vector<Observation>& on_board) {
  Points2 pixels;
  for (const Observation& corner : on_board) pixels.push_back(corner.pixel);
  const pattern::SequenceCheck check = pattern::check_flat_and_board(captures[0], captures[1], pixels);
  return check.diagnostics.items.empty() ? "" : check.diagnostics.items.front().code;
}

/// Views that were rejected as "board moved by 1.1 to 1.6 px" while noise counted as motion (28 of 144 such views; 0 of
/// 144 now).
TEST(MarkersPattern, NoiseIsNoMotionOfTheBoard) {
  const auto pattern = make_pattern("markers", simulate::projector_size(simulate::Level::kHard));
  const simulate::SimulatedSession session = noisy_marker_session(*pattern, 2);
  for (const std::size_t view : {1, 4, 7})
    EXPECT_EQ(cause_of_pair(simulate::capture_view(session, view, pattern->frames()),
                            simulate::board_in_camera(session.views[view])),
              "")
        << view;
}

/// By 30, 10 and 14 px: a fit of small shifts explains part of the difference in each.
TEST(MarkersPattern, NamesABoardThatMovedFarUnderNoise) {
  const auto pattern = make_pattern("markers", simulate::projector_size(simulate::Level::kHard));
  const simulate::SimulatedSession session = noisy_marker_session(*pattern, 13, simulate::Range{0.01, 0.04});
  for (const std::size_t view : {1, 5, 9}) {
    simulate::World at_end = session.views[view];
    at_end.rig_from_board = at_end.rig_from_board * session.defects[view].moved->board_from_moved;
    EXPECT_EQ(cause_of_pair(simulate::capture_view(session, view, pattern->frames()),
                            simulate::board_in_camera(at_end)),
              "board_moved")
        << view;
  }
}

/// The noise breaks the outlines of all markers of these prints: none was found before markers were searched for in
/// smoothed images. Corners err by some 0.15 px an axis.
TEST(MarkersPattern, FindsAPrintWhoseMarkersNoiseBreaks) {
  const auto pattern = make_pattern("markers", simulate::projector_size(simulate::Level::kHard));
  const std::vector<ImageU8> flat{pattern->frames().front()};
  for (const auto& [seed, view] :
       {std::pair(std::uint64_t(2), std::size_t(7)), std::pair(std::uint64_t(3), std::size_t(1))}) {
    const simulate::SimulatedSession session = noisy_marker_session(*pattern, seed);
    const std::vector<Observation> truth = simulate::board_in_camera(session.views[view]);
    const Detections found =
        detect::detect_board(simulate::capture_view(session, view, flat).front(), session.board().layout);
    EXPECT_GE(2 * found.observations.size(), truth.size()) << seed;
    for (const Observation& corner : found.observations) {
      const auto at = std::find_if(truth.begin(), truth.end(),
                                   [&](const Observation& t) { return t.point == corner.point; });
      ASSERT_NE(at, truth.end());
      EXPECT_LT((corner.pixel - at->pixel).norm(), 0.8) << seed << ", " << corner.point;
    }
  }
}

}  // namespace
}  // namespace procam::session
