/// Broken sequences and sound ones: does check_sequence() name the cause?
#include "procam/pattern/sequence_check.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <map>

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
      {"spot", "highlight", [](Conditions& c) { c.spot = 3; }},
      {"glare", "scattered_light", [](Conditions& c) { c.glare = 0.4; }},
      {"noise", "noisy", [](Conditions& c) { c.noise_factor = 5; }},
  };
}

/// What is said of a view: the first remark's code.
std::string cause(const Session& session, std::size_t view) {
  const pattern::GrayCode gray_code{session.rig().projector().projector.size()};
  const std::vector<ImageU8> captures = capture_view(session, view, pattern::frames(gray_code));
  Points2 corners;
  for (const Observation& corner : board_in_camera(session.views[view])) corners.push_back(corner.pixel);
  const pattern::SequenceCheck check =
      pattern::check_sequence({captures.begin(), captures.end()}, gray_code, corners);
  if (check.diagnostics.items.empty()) return "";
  return check.diagnostics.items.front().code;
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
      Conditions conditions = level_conditions(GetParam().level);
      conditions.dark_views = conditions.overexposed_views = conditions.moved_views = conditions.stale_views =
          0;
      kind.spoil(conditions);
      Session session = make_session(GetParam().level, seed, {}, {}, conditions);
      session.capture.samples_per_axis = 1;
      for (std::size_t view = 0; view < GetParam().views; ++view, ++all) {
        const std::string found = cause(session, view);
        ++counts[found];
        right += found == kind.code;
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

INSTANTIATE_TEST_SUITE_P(OneView, BrokenSequences, testing::Values(KindCase{Level::kPaper, 3, 3, 1}));
INSTANTIATE_TEST_SUITE_P(ManySeeds, BrokenSequences,
                         testing::Values(KindCase{Level::kEasy, 11, 15, 2},
                                         KindCase{Level::kPaper, 11, 15, 4},
                                         KindCase{Level::kHard, 11, 15, 4}));

}  // namespace
}  // namespace procam::simulate
