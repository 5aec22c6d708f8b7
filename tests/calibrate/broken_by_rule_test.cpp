/// Sessions broken by rules of random strength, from faults that nobody can see to faults that nobody can miss. Two
/// figures judge them all: the share that comes back as a success though its light lands further off than three times
/// the predicted error, and the share of noticed faults whose cause is named.
#include <cstdlib>
#include <functional>
#include <iostream>

#include "broken_session.hpp"

namespace procam::calibrate {
namespace {

/// Random numbers of a rule, and steps made of them.
struct Dice {
  std::mt19937_64 random;
  int views = 8;

  double within(double low, double high) { return test::uniform(random, low, high); }
  /// Evenly on a logarithmic scale: weak faults are as frequent as strong ones.
  double strength(double low, double high) { return std::exp(within(std::log(low), std::log(high))); }
  double either_sign(double value) { return within(-1, 1) < 0 ? -value : value; }
  int view() { return std::min(int(within(0, views)), views - 1); }
  int other_than(int view) { return (view + 1 + std::min(int(within(0, views - 1)), views - 2)) % views; }
  /// The first of the last views, which are fewer than half.
  int of_last() { return views - 1 - std::min(int(within(0, (views - 1) / 2)), (views - 3) / 2); }
  json direction(double length) {
    const Vec3 way = length * test::random_vec3(random, 1).normalized();
    return {way.x(), way.y(), way.z()};
  }
  const char* device() { return within(-1, 1) < 0 ? "camera" : "projector"; }
};

struct Rule {
  const char* name;
  std::function<json(Dice&)> steps;
  /// One of them has to be in what a person reads of a fault that was noticed.
  std::vector<const char*> causes;
};

const std::vector<Rule>& rules() {
  static const std::vector<Rule> all = {
      {"board_moved",
       [](Dice& d) {
         return json{{{"op", "move_board"}, {"view", d.view()}, {"mm", d.direction(d.strength(0.3, 40))}}};
       },
       {"moved"}},
      {"board_turned",
       [](Dice& d) {
         return json{{{"op", "move_board"}, {"view", d.view()}, {"deg", d.direction(d.strength(0.1, 8))}}};
       },
       {"moved"}},
      {"board_moved_in_two_views",
       [](Dice& d) {
         const int one = d.view();
         return json{
             {{"op", "move_board"}, {"view", one}, {"mm", d.direction(d.strength(2, 30))}},
             {{"op", "move_board"}, {"view", d.other_than(one)}, {"mm", d.direction(d.strength(2, 30))}}};
       },
       {"moved"}},
      {"projector_knocked",
       [](Dice& d) {
         return json{{{"op", "move_projector"},
                      {"from", d.of_last()},
                      {"mm", d.direction(d.strength(1, 40))},
                      {"deg", d.direction(d.strength(0.05, 3))}}};
       },
       {"stands elsewhere", "projector, moved"}},  // one view alone does not separate the two
      {"projector_knocked_in_one_view",
       [](Dice& d) {
         return json{
             {{"op", "move_projector"}, {"view", d.view()}, {"deg", d.direction(d.strength(0.1, 3))}}};
       },
       {"stands elsewhere", "moved"}},
      {"projector_drifts",
       [](Dice& d) {
         return json{{{"op", "drift_projector"}, {"deg", d.direction(d.strength(0.05, 2))}}};
       },
       {"stands elsewhere", "moved", "disagree", "RMS"}},
      {"zoomed",
       [](Dice& d) {
         return json{{{"op", "zoom"},
                      {"device", d.device()},
                      {"from", d.of_last()},
                      {"factor", 1 + d.either_sign(d.strength(0.003, 0.1))}}};
       },
       {"zoomed", "refocused", "moved"}},
      {"refocused_in_one_view",
       [](Dice& d) {
         return json{{{"op", "zoom"},
                      {"device", d.device()},
                      {"view", d.view()},
                      {"factor", 1 + d.either_sign(d.strength(0.002, 0.05))}}};
       },
       {"zoomed", "refocused", "moved"}},
      {"zoom_drifts",
       [](Dice& d) {
         return json{{{"op", "drift_zoom"},
                      {"device", d.device()},
                      {"factor", 1 + d.either_sign(d.strength(0.002, 0.05))}}};
       },
       {"zoomed", "refocused", "disagree", "RMS"}},
      {"keystone",
       [](Dice& d) {
         return json{{{"op", "keystone"}, {"device", "projector"}, {"strength", d.strength(0.02, 0.5)}}};
       },
       {"keystone", "lens shift"}},
      {"squeezed",
       [](Dice& d) {
         return json{
             {{"op", "scale_pixels"}, {"device", d.device()}, {"x", d.strength(0.6, 0.97)}, {"y", 1}}};
       },
       {"aspect"}},
      {"stale",
       [](Dice& d) {
         const int view = d.view();
         return json{{{"op", "stale"}, {"view", view}, {"of", d.other_than(view)}}};
       },
       {"stale"}},
      {"swapped",
       [](Dice& d) {
         const int view = d.view();
         return json{{{"op", "swap"}, {"device", d.device()}, {"view", view}, {"with", d.other_than(view)}}};
       },
       {"exchanged"}},
      {"turned",
       [](Dice& d) {
         return json{{{"op", "turn"}, {"device", d.device()}, {"view", d.view()}}};
       },
       {"turned by 180"}},
      {"rows_backwards",
       [](Dice& d) {
         return json{{{"op", "mirror_order"}, {"device", d.device()}, {"view", d.view()}}};
       },
       {"mirrored"}},
      {"column_missed",
       [](Dice& d) {
         return json{{{"op", "shift_order"}, {"device", d.device()}, {"view", d.view()}}};
       },
       {"order", "shifted", "column", "moved"}},
      {"outliers",
       [](Dice& d) {
         return json{{{"op", "outliers"},
                      {"device", d.device()},
                      {"share", d.strength(0.01, 0.8)},
                      {"px", d.strength(2, 80)}}};
       },
       {"outlier", "RMS"}},
      {"one_view_wrong",
       [](Dice& d) {
         return json{{{"op", "outliers"},
                      {"device", d.device()},
                      {"view", d.view()},
                      {"share", 1.0},
                      {"px", d.strength(2, 80)}}};
       },
       {"rejected"}},
      {"noise",
       [](Dice& d) {
         return json{{{"op", "noise"}, {"device", d.device()}, {"px", d.strength(0.2, 4)}}};
       },
       {"RMS"}},
      {"resampled",
       [](Dice& d) {
         return json{{{"op", "resampled"}, {"device", "projector"}, {"factor", d.strength(0.15, 0.9)}}};
       },
       {"native resolution", "RMS"}},
      {"another_print",
       [](Dice& d) {
         return json{{{"op", "rescaled_board"},
                      {"view", d.view()},
                      {"factor", 1 + d.either_sign(d.strength(0.003, 0.2))}}};
       },
       {"print", "size", "moved"}},
      {"bent",
       [](Dice& d) {
         return json{{{"op", "bend"}, {"mm", d.strength(0.1, 10)}}};
       },
       {"not flat", "board's shape", "bent"}},
      {"flutters",
       [](Dice& d) {
         return json{{{"op", "flutter"}, {"mm", d.strength(0.1, 3)}}};
       },
       {"disagree", "flat", "bent", "RMS"}},
      {"few_views",
       [](Dice& d) {
         return json{{{"op", "keep_views"}, {"count", 1 + int(d.within(0, 4))}}};
       },
       {"three", "view"}},
      {"few_points",
       [](Dice& d) {
         return json{{{"op", "keep_points"}, {"device", d.device()}, {"count", int(d.within(0, 14))}}};
       },
       {"of the board", "inside the projector", "line", "points"}},
      {"barely_tilted",
       [](Dice& d) {
         return json{{{"op", "scale_tilts"}, {"factor", d.strength(0.002, 0.5)}}};
       },
       {"tilt", "determine"}},
      {"barely_moved",
       [](Dice& d) {
         return json{{{"op", "scale_motions"}, {"factor", d.strength(0.002, 0.5)}}};
       },
       {"tilt", "determine", "edges", "distance"}},
      {"far_and_central",
       [](Dice& d) {
         return json{{{"op", "far_and_central"}, {"metres", d.strength(1.5, 12)}}};
       },
       {"focal length", "edges", "determine", "tilt"}},
      {"small_in_the_centre",
       [](Dice& d) {
         return json{{{"op", "small_in_the_centre"}, {"metres", {0.03, -0.02, d.strength(1, 8)}}}};
       },
       {"edges", "focal length", "determine", "cannot be told"}},
      {"tilted_about_one_axis",
       [](Dice& d) {
         const bool x = d.within(-1, 1) < 0;
         return json{{{"op", "tilt_about"}, {"axis", {x ? 1 : 0, x ? 0 : 1, 0}}},
                     {{"op", "small_in_the_centre"}, {"metres", {0.03, -0.02, d.strength(1.2, 4)}}}};
       },
       {"tilt", "edges"}},
      {"mirrored",
       [](Dice& d) {
         return json{{{"op", "mirror_pixels"}, {"device", d.device()}}};
       },
       {"mirrored"}},
      {"axes_swapped",
       [](Dice& d) {
         return json{{{"op", "swap_axes"}, {"device", d.device()}}};
       },
       {"mirrored", "swapped"}},
      {"moved_and_outliers",
       [](Dice& d) {
         return json{{{"op", "move_board"}, {"view", d.view()}, {"mm", d.direction(d.strength(1, 30))}},
                     {{"op", "outliers"},
                      {"device", d.device()},
                      {"share", d.strength(0.01, 0.3)},
                      {"px", d.strength(3, 60)}}};
       },
       {"moved", "outlier"}},
      {"knocked_and_bent",
       [](Dice& d) {
         return json{
             {{"op", "bend"}, {"mm", d.strength(0.2, 3)}},
             {{"op", "move_projector"}, {"from", d.of_last()}, {"deg", d.direction(d.strength(0.1, 3))}}};
       },
       {"stands elsewhere", "flat", "moved against"}},
      {"zoomed_and_noisy",
       [](Dice& d) {
         return json{{{"op", "zoom"},
                      {"device", d.device()},
                      {"from", d.of_last()},
                      {"factor", d.within(1.01, 1.08)}},
                     {{"op", "noise"}, {"device", d.device()}, {"px", d.strength(0.1, 1)}}};
       },
       {"zoomed", "refocused", "moved", "RMS"}},
      {"stale_and_turned",
       [](Dice& d) {
         const int view = d.view();
         return json{{{"op", "stale"}, {"view", view}, {"of", d.other_than(view)}},
                     {{"op", "turn"}, {"device", "projector"}, {"view", d.other_than(view)}}};
       },
       {"stale", "turned by 180"}},
  };
  return all;
}

enum class Outcome { kHarmless, kRepaired, kFailed, kRefused, kSilentlyWrong };

struct Judged {
  Outcome outcome = Outcome::kHarmless;
  bool cause_named = false;
  std::string words;
  LightErrors light;
};

Judged judge(const Rule& rule, std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed * 1000003 + std::uint64_t(&rule - rules().data()))};
  dice.views = 6 + int(dice.within(0, 6));
  Session session;
  session.world =
      test::NumericWorld::make_rig(dice.views, seed + 1, dice.within(0.02, 0.12), dice.within(0.03, 0.15));
  session.random.seed(seed);
  session.data = session.world.correspondences(2 * seed + 1);
  const json steps = rule.steps(dice);
  for (const json& step : steps) apply(session, step);
  Judged judged;
  bool noticed = false, passed = false;
  try {
    const CalibrationResult result = calibrate_rig(session.data, {});
    expect_finite(result);
    judged.words = words_of(result);
    passed = result.rig.quality.passed();
    judged.light = light_errors(session, result);
    noticed = !passed || judged.words.find("rejected") != std::string::npos;
  } catch (const Error& error) {
    judged.words = error.what();
    judged.outcome = Outcome::kRefused;
    noticed = true;
  }
  for (const char* cause : rule.causes)
    judged.cause_named = judged.cause_named || judged.words.find(cause) != std::string::npos;
  if (judged.outcome == Outcome::kRefused) return judged;
  if (!passed)
    judged.outcome = Outcome::kFailed;
  else if (judged.light.actual > 3 * judged.light.predicted)
    judged.outcome = Outcome::kSilentlyWrong;
  else if (noticed || judged.cause_named)
    judged.outcome = Outcome::kRepaired;
  if (std::getenv("PROCAM_SHOW_BROKEN") != nullptr || judged.outcome == Outcome::kSilentlyWrong)
    std::cout << "  " << rule.name << " " << seed << " " << steps.dump() << "\n    outcome "
              << int(judged.outcome) << ", " << judged.light.actual << " mm, predicted "
              << judged.light.predicted << " mm\n    " << judged.words.substr(0, 600) << "\n";
  return judged;
}

struct Counts {
  int sessions = 0, by_outcome[5] = {}, noticed = 0, named = 0;
  void add(const Judged& judged) {
    ++sessions;
    ++by_outcome[int(judged.outcome)];
    if (judged.outcome == Outcome::kHarmless || judged.outcome == Outcome::kSilentlyWrong) return;
    ++noticed;
    named += judged.cause_named;
  }
};

Counts count(std::uint64_t first_seed, int seeds) {
  Counts all;
  std::cout << "rule: harmless, repaired, failed a check, refused, silently wrong; cause named of noticed\n";
  for (const Rule& rule : rules()) {
    Counts of_rule;
    for (int i = 0; i < seeds; ++i) {
      const Judged judged = judge(rule, first_seed + std::uint64_t(i));
      of_rule.add(judged);
      all.add(judged);
      if (!judged.cause_named && judged.outcome != Outcome::kHarmless &&
          std::getenv("PROCAM_SHOW_BROKEN") != nullptr)
        std::cout << "    NOT NAMED " << rule.name << " " << first_seed + std::uint64_t(i) << ": "
                  << judged.words.substr(0, 400) << "\n";
    }
    std::cout << rule.name << ":";
    for (const int n : of_rule.by_outcome) std::cout << ' ' << n;
    std::cout << "; " << of_rule.named << " of " << of_rule.noticed << "\n";
  }
  std::cout << all.sessions << " sessions:";
  for (const int n : all.by_outcome) std::cout << ' ' << n;
  std::cout << "; cause named in " << all.named << " of " << all.noticed << "\n";
  return all;
}

void expect_honest(const Counts& counts) {
  EXPECT_LE(counts.by_outcome[int(Outcome::kSilentlyWrong)], 0.005 * counts.sessions);
  EXPECT_GE(counts.named, 0.85 * counts.noticed);
}

TEST(BrokenByRule, OneOfEach) {
  const Counts counts = count(1, 1);
  EXPECT_GE(counts.sessions, 30);
  expect_honest(counts);
}

TEST(BrokenByRule, ThirtyOfEach) {
  expect_honest(count(200, 30));
}

}  // namespace
}  // namespace procam::calibrate
