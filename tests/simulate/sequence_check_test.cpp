/// Broken sequences and sound ones: does check_sequence() name the cause?
#include "procam/pattern/sequence_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>

#include "procam/pattern/phase_shift.hpp"
#include "procam/simulate/session.hpp"

namespace procam::simulate {
namespace {

struct Broken {
  const char* name;
  const char* code;  ///< empty: sound
  std::function<void(Conditions&)> spoil;
};

std::vector<Broken> all_kinds() {
  return {
      {"sound", "", [](Conditions&) {}},
      {"gamma", "",
       [](Conditions& c) {
         c.gamma = {2.6, 2.6};
       }},
      {"dark", "",
       [](Conditions& c) {
         c.dark_views = 99, c.white = {0.22, 0.22};
       }},
      {"moved", "board_moved", [](Conditions& c) { c.moved_views = 99; }},
      {"stale", "stale_frame", [](Conditions& c) { c.stale_views = 99; }},
      {"missing", "frame_missing", [](Conditions& c) { c.missing_views = 99; }},
      {"torn", "torn_frame", [](Conditions& c) { c.torn_views = 99; }},
      {"saturated", "overexposed", [](Conditions& c) { c.overexposed_views = 99; }},
      {"auto_exposure", "exposure_changes", [](Conditions& c) { c.auto_exposure = 0.3; }},
      {"flicker", "flicker", [](Conditions& c) { c.flicker = 0.08; }},
      {"shake", "camera_shake", [](Conditions& c) { c.shake_px = 1; }},
      {"stabiliser", "camera_drift", [](Conditions& c) { c.drift_px = 4; }},
      {"projector_drift", "projector_moved", [](Conditions& c) { c.projector_drift_px = 4; }},
      {"focus_drift", "focus_drift", [](Conditions& c) { c.focus_drift_px = 2; }},
      {"lag", "lag", [](Conditions& c) { c.lag = 0.1; }},
      {"iris", "exposure_changes", [](Conditions& c) { c.iris = 0.5; }},
      {"spot", "highlight", [](Conditions& c) { c.spot = 3; }},
      {"glare", "scattered_light", [](Conditions& c) { c.glare = 0.4; }},
      {"noise", "noisy",
       [](Conditions& c) {
         c.noise = NoiseModel{400, 0};
       }},
  };
}

/// Without mistakes in single views.
Conditions sound_conditions(Level level) {
  Conditions conditions = level_conditions(level);
  conditions.dark_views = conditions.overexposed_views = conditions.moved_views = conditions.stale_views = 0;
  return conditions;
}

/// Where the board is in the last captures, as a detector finds it.
Points2 corners_at_end(const SimulatedSession& session, std::size_t view) {
  World world = session.views[view];
  if (!session.defects.empty() && session.defects[view].moved)
    world.rig_from_board = world.rig_from_board * session.defects[view].moved->board_from_moved;
  Points2 corners;
  for (const Observation& corner : board_in_camera(world)) corners.push_back(corner.pixel);
  return corners;
}

pattern::SequenceCheck check(const SimulatedSession& session, std::size_t view) {
  const pattern::GrayCode gray_code{session.rig().projector().projector.size()};
  const std::vector<ImageU8> captures = capture_view(session, view, pattern::frames(gray_code));
  return pattern::check_sequence({captures.begin(), captures.end()}, gray_code,
                                 corners_at_end(session, view));
}

/// The first remark's code; empty without remarks.
std::string cause(const pattern::SequenceCheck& check) {
  return check.diagnostics.items.empty() ? "" : check.diagnostics.items.front().code;
}

/// Does the row of this code in the table of docs/troubleshooting.md quote the message? "..." in the quote
/// stands for any text.
bool is_quoted(const std::string& code, const std::string& message) {
  std::ifstream page(std::string(PROCAM_SOURCE_DIR) + "/docs/troubleshooting.md");
  for (std::string row; std::getline(page, row);) {
    if (row.rfind("|", 0) != 0 || row.find("`" + code + "`") == std::string::npos) continue;
    const std::size_t begin = row.find('"') + 1, end = row.find('"', begin);
    std::string quote = row.substr(begin, end - begin);
    std::size_t at = 0;
    for (std::size_t part = 0; part != std::string::npos;) {
      const std::size_t next = quote.find("...", part);
      const std::string text = quote.substr(part, next == std::string::npos ? next : next - part);
      at = message.find(text, at);
      if (at == std::string::npos) return false;
      part = next == std::string::npos ? next : next + 3;
    }
    return true;
  }
  return false;
}

struct KindCase {
  Level level;
  std::uint64_t first_seed, last_seed;
  std::size_t views;
};

class BrokenSequences : public testing::TestWithParam<KindCase> {};

TEST_P(BrokenSequences, AreNamedByTheirCause) {
  for (const Broken& kind : all_kinds()) {
    std::map<std::string, int> counts;  // by code
    int right = 0, all = 0;
    for (std::uint64_t seed = GetParam().first_seed; seed <= GetParam().last_seed; ++seed) {
      Conditions conditions = sound_conditions(GetParam().level);
      kind.spoil(conditions);
      SimulatedSession session = make_session(GetParam().level, seed, {}, {}, conditions);
      session.capture.samples_per_axis = 1;
      for (std::size_t view = 0; view < GetParam().views; ++view, ++all) {
        const pattern::SequenceCheck found = check(session, view);
        ++counts[cause(found)];
        right += cause(found) == kind.code;
        for (const Diagnostic& remark : found.diagnostics.items)
          EXPECT_TRUE(is_quoted(remark.code, remark.message)) << remark.code << ": " << remark.message;
      }
    }
    std::string text;
    for (const auto& [code, count] : counts)
      text += " " + (code.empty() ? "none" : code) + ": " + std::to_string(count);
    std::printf("%-6s %-16s %d of %d right; %s\n", to_string(GetParam().level), kind.name, right, all,
                text.c_str());
    std::fflush(stdout);
    EXPECT_GE(right, 0.8 * all) << kind.name;
  }
}

/// Every bit can be read then, and the codes are those of other stripes. Nothing named the cause before: the view was "of
/// another board", or failed a check. The coarsest bit's frames mirror the picture, and are not looked for.
TEST(ExchangedFrames, AreNamed) {
  for (const auto& [level, seed] : {std::pair(Level::kPaper, 4), std::pair(Level::kHard, 12)}) {
    SimulatedSession session = make_session(level, std::uint64_t(seed), {}, {}, sound_conditions(level));
    session.capture.samples_per_axis = 1;
    const pattern::GrayCode gray_code{session.rig().projector().projector.size()};
    std::vector<ImageU8> captures = capture_view(session, 1, pattern::frames(gray_code));
    const Points2 corners = corners_at_end(session, 1);
    const auto check_again = [&] {
      return pattern::check_sequence({captures.begin(), captures.end()}, gray_code, corners);
    };
    const auto expect_named = [&](const std::string& names) {
      const pattern::SequenceCheck found = check_again();
      ASSERT_EQ(cause(found), "frames_exchanged") << names;
      const std::string& message = found.diagnostics.items.front().message;
      EXPECT_NE(message.find(names), std::string::npos) << message;
      EXPECT_TRUE(is_quoted("frames_exchanged", message)) << message;
      EXPECT_TRUE(found.decoding_is_wrong);
    };
    ASSERT_NE(cause(check_again()), "frames_exchanged");
    const int row_pairs = int(captures.size() - 2) / 4;  // as many as of columns
    for (int pair = 1; pair < 2 * row_pairs - 3; ++pair) {
      if (pair >= row_pairs - 3 && pair <= row_pairs)
        continue;  // stripes that level hard blurs; rows mirrored
      const auto at = std::size_t(2 * pair);
      std::swap(captures[at], captures[at + 1]);
      expect_named(pattern::frame_name(gray_code, int(at)) + " and " +
                   pattern::frame_name(gray_code, int(at + 1)) + " are");
      std::swap(captures[at], captures[at + 1]);
    }
    for (const auto& [a, b] : {std::pair(0, 4), std::pair(3, 6), std::pair(2, row_pairs + 3),
                               std::pair(row_pairs + 1, row_pairs + 2)}) {
      const auto exchange = [&, i = std::size_t(2 * a), j = std::size_t(2 * b)] {
        std::swap(captures[i], captures[j]);
        std::swap(captures[i + 1], captures[j + 1]);
      };
      exchange();
      expect_named(pattern::frame_name(gray_code, 2 * a) + " and " + pattern::frame_name(gray_code, 2 * b) +
                   ", each with its inverse, are");
      exchange();
    }
  }
}

/// Each image's contrast as a camera program stretches it: minimum to 0, 99 % to 255.
std::vector<ImageU8> contrast_stretched(std::vector<ImageU8> captures) {
  for (ImageU8& image : captures) {
    std::vector<std::uint8_t> levels(image.data(), image.data() + image.width() * image.height());
    std::sort(levels.begin(), levels.end());
    const double low = levels.front(), high = levels[levels.size() * 99 / 100];
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        image.row(y)[x] =
            std::uint8_t(std::lround(std::clamp((image.row(y)[x] - low) / (high - low), 0.0, 1.0) * 255));
  }
  return captures;
}

/// Stripes: the white and the black capture are stretched differently from the others.
TEST(StretchedContrast, OfStripesIsNamed) {
  SimulatedSession session = make_session(Level::kPaper, 3, {}, {}, sound_conditions(Level::kPaper));
  session.capture.samples_per_axis = 1;
  const pattern::GrayCode gray_code{session.rig().projector().projector.size()};
  const std::vector<ImageU8> stretched =
      contrast_stretched(capture_view(session, 0, pattern::frames(gray_code)));
  const pattern::SequenceCheck found =
      pattern::check_sequence({stretched.begin(), stretched.end()}, gray_code, corners_at_end(session, 0));
  EXPECT_EQ(cause(found), "exposure_changes");
  for (const Diagnostic& remark : found.diagnostics.items)
    EXPECT_TRUE(is_quoted(remark.code, remark.message)) << remark.message;
}

/// Waves: only long ones change an image's range of grey levels. Called a torn frame, overexposed or flicker before every image's
/// range was looked at.
TEST(StretchedContrast, OfWavesIsNamed) {
  for (const std::size_t view : {1, 4}) {
    SimulatedSession session = make_session(Level::kPaper, 5, {}, {}, sound_conditions(Level::kPaper));
    session.capture.samples_per_axis = 1;
    const pattern::PhaseShift waves{session.rig().projector().projector.size()};
    const std::vector<ImageU8> frames = pattern::frames(waves);
    const std::vector<ImageU8> stretched = contrast_stretched(capture_view(session, view, frames));
    const pattern::SequenceCheck found =
        pattern::check_sequence({stretched.begin(), stretched.end()}, pattern::complementary_frames(frames),
                                corners_at_end(session, view));
    EXPECT_EQ(cause(found), "exposure_changes") << view;
    for (const Diagnostic& remark : found.diagnostics.items)
      EXPECT_TRUE(is_quoted(remark.code, remark.message)) << remark.message;
  }
}

INSTANTIATE_TEST_SUITE_P(OneView, BrokenSequences, testing::Values(KindCase{Level::kPaper, 3, 3, 1}));
INSTANTIATE_TEST_SUITE_P(ManySeeds, BrokenSequences,
                         testing::Values(KindCase{Level::kEasy, 11, 15, 2},
                                         KindCase{Level::kPaper, 11, 15, 4},
                                         KindCase{Level::kHard, 11, 15, 4}));

/// The room's lamps at 100 Hz over a readout of 28 ms: the light changes over the rows of every frame, white and black too,
/// and so do stripes that the projector leaves dark. Neither an exposure that follows the light nor a torn frame does that.
TEST(LampsThatFlicker, AreNamedAndNotTheExposure) {
  constexpr double kTurns = 2.8;  // over the rows
  for (const double share : {0.5, 0.8}) {
    Conditions conditions = sound_conditions(Level::kPaper);
    conditions.gamma = {1, 1};
    SimulatedSession session = make_session(Level::kPaper, 5, {}, {}, conditions);
    session.capture.samples_per_axis = 1;
    const pattern::GrayCode gray_code{session.rig().projector().projector.size()};
    std::vector<ImageU8> captures = capture_view(session, 0, pattern::frames(gray_code));
    const ImageU8 white = captures[captures.size() - 2];
    for (std::size_t i = 0; i < captures.size(); ++i) {
      const double phase = std::fmod(0.13 * double(i * i), 1.0);
      for (int y = 0; y < white.height(); ++y) {
        const double lamp =
            0.25 * (1 + share * std::sin(2 * 3.14159265 * (phase + kTurns * y / white.height())));
        for (int x = 0; x < white.width(); ++x) {
          const double grey = 0.75 * captures[i].at(x, y) + lamp * std::max<int>(white.at(x, y), 20);
          captures[i].at(x, y) = std::uint8_t(std::lround(std::min(grey, 255.0)));
        }
      }
    }
    const pattern::SequenceCheck found =
        pattern::check_sequence({captures.begin(), captures.end()}, gray_code, corners_at_end(session, 0));
    ASSERT_EQ(cause(found), "flicker") << share;
    const std::string& message = found.diagnostics.items.front().message;
    EXPECT_NE(message.find("lamps flicker, as dark stripes change too"), std::string::npos) << message;
    EXPECT_FALSE(found.decoding_is_wrong);
  }
}

/// A print that is elsewhere changes the brightness of its pixels too: neither flicker nor an exposure that follows the
/// light. The two views were called so before steps of the print were looked for first.
TEST(BoardRotatedBetweenFrames, IsAMovedBoard) {
  for (const auto& [level, view] :
       {std::pair(Level::kPaper, std::size_t(3)), std::pair(Level::kHard, std::size_t(2))}) {
    Conditions conditions = sound_conditions(level);
    conditions.moved_views = 99;
    SimulatedSession session = make_session(level, 201, {}, {}, conditions);
    session.capture.samples_per_axis = 1;
    session.defects[view].moved->board_from_moved.rotation =
        Eigen::AngleAxisd(15 * kDegree, Vec3(0.05, -0.08, 1).normalized());
    const pattern::SequenceCheck found = check(session, view);
    EXPECT_EQ(cause(found), "board_moved") << to_string(level);
    EXPECT_TRUE(found.decoding_is_wrong);
  }
}

TEST(ComplementaryFrames, AreFoundInAnyPattern) {
  const auto gray = pattern::complementary_frames(pattern::frames(pattern::GrayCode{{200, 120}}));
  EXPECT_EQ(gray.frames, 32);
  ASSERT_EQ(gray.pairs.size(), 15u);
  EXPECT_EQ(gray.pairs[4], (std::array<int, 2>{8, 9}));
  EXPECT_EQ(gray.white, 30);
  EXPECT_EQ(gray.black, 31);
  const auto waves = pattern::complementary_frames(pattern::frames(pattern::PhaseShift{{200, 120}}));
  EXPECT_EQ(2 * waves.pairs.size(), std::size_t(waves.frames));
  EXPECT_EQ(waves.pairs[1], (std::array<int, 2>{1, 5}));   // of eight steps
  EXPECT_EQ(waves.pairs[4], (std::array<int, 2>{8, 10}));  // of four
  EXPECT_FALSE(waves.white || waves.black);
}

TEST(PhaseShiftSequence, IsCheckedAsGrayCodeIs) {
  const std::vector<Broken> kinds{
      {"sound", "", [](Conditions&) {}},
      {"moved", "board_moved",
       [](Conditions& c) {
         c.moved_views = 99, c.moved_by = {0.01, 0.01};
       }},
      {"stale", "stale_frame", [](Conditions& c) { c.stale_views = 99; }},
      {"saturated", "overexposed", [](Conditions& c) { c.overexposed_views = 99; }},
      {"flicker", "flicker", [](Conditions& c) { c.flicker = 0.12; }},
      {"lag", "lag", [](Conditions& c) { c.lag = 0.1; }},
      {"projector gamma", "", [](Conditions& c) { c.projector_gamma = 2.2; }},
      {"projector gamma, linear camera", "",
       [](Conditions& c) {
         c.projector_gamma = 2.2, c.gamma = {1, 1};
       }},
  };
  for (const Broken& kind : kinds) {
    Conditions conditions = sound_conditions(Level::kPaper);
    kind.spoil(conditions);
    SimulatedSession session = make_session(Level::kPaper, 5, {}, {}, conditions);
    session.capture.samples_per_axis = 1;
    const pattern::PhaseShift waves{session.rig().projector().projector.size()};
    const std::vector<ImageU8> frames = pattern::frames(waves), captures = capture_view(session, 1, frames);
    const pattern::SequenceCheck found =
        pattern::check_sequence({captures.begin(), captures.end()}, pattern::complementary_frames(frames),
                                corners_at_end(session, 1));
    EXPECT_EQ(cause(found), kind.code) << kind.name;
    EXPECT_EQ(found.decoding_is_wrong,
              cause(found) == "board_moved" || cause(found) == "stale_frame" || cause(found) == "lag");
  }
}

}  // namespace
}  // namespace procam::simulate
