// The game's physics: what a player would call broken.
#include <gtest/gtest.h>

#include "air_hockey/match.hpp"

namespace hockey {
namespace {

/// Something hangs on the wall: a frame askew, and a nail.
Table table_with_obstacles() {
  Table table;
  table.obstacles = {{{0.82, 0.22}, {0.97, 0.18}},
                     {{0.97, 0.18}, {1.0, 0.3}},
                     {{1.0, 0.3}, {0.85, 0.34}},
                     {{0.85, 0.34}, {0.82, 0.22}},
                     {{0.6, 0.8}, {0.6, 0.8}}};
  return table;
}

/// Metres by which the puck is where it cannot be: inside a wall, an obstacle or a paddle, or off the table.
double trespass(const Match& match) {
  const Table& t = match.table();
  const Vec2& p = match.puck();
  double worst = 0;
  const bool is_in_goal = std::abs(p.y() - t.width / 2) < t.goal / 2;
  worst = std::max({worst, t.puck - p.y(), p.y() + t.puck - t.width});
  if (!is_in_goal) worst = std::max({worst, t.puck - p.x(), p.x() + t.puck - t.length});
  for (const Segment& wall : match.walls()) {
    const Vec2 edge = wall.b - wall.a;
    const double s = std::clamp((p - wall.a).dot(edge) / std::max(edge.squaredNorm(), 1e-12), 0.0, 1.0);
    worst = std::max(worst, t.puck - (p - wall.a - s * edge).norm());
  }
  for (int side = 0; side < 2; ++side)
    worst = std::max(worst, t.puck + t.paddle - (p - match.paddle(side)).norm());
  return worst;
}

/// Inside the ring of the obstacle's edges: only a puck that tunnelled gets there.
bool is_inside_obstacle(const Vec2& p) {
  const std::vector<Segment> edges = table_with_obstacles().obstacles;
  bool is_inside = false;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 &a = edges[i].a, &b = edges[i].b;
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      is_inside = !is_inside;
  }
  return is_inside;
}

struct Played {
  Vec2 puck = Vec2::Zero();
  int goals = 0, served_again = 0, squeezes = 0, longest_stuck = 0;
  double worst = 0;
};

Played play(std::uint64_t seed, double seconds) {
  Match match(table_with_obstacles(), Rules(), seed);
  match.start();
  Bot left(0, seed), right(1, seed);
  Played played;
  Vec2 place = match.puck();
  int stuck = 0;
  for (int i = 0; i < int(seconds / Match::kStep) && match.phase() == Phase::kPlaying; ++i) {
    const double energy = match.puck_speed().squaredNorm();
    const int goals = match.score(0) + match.score(1), again = match.served_again();
    match.step({left.hand(match), right.hand(match)});
    const bool is_served = match.score(0) + match.score(1) != goals || match.served_again() != again;
    const bool is_hit = match.met_paddle() == match.time();
    played.worst = std::max(played.worst, trespass(match));
    EXPECT_FALSE(is_inside_obstacle(match.puck())) << "seed " << seed;
    EXPECT_TRUE(match.puck().allFinite());
    if (!is_served && !is_hit) {
      EXPECT_LE(match.puck_speed().squaredNorm(), energy * (1 + 1e-12)) << "seed " << seed;
    }
    // Stuck: it stays within a centimetre although it was hit within the last second.
    if (is_served || (match.puck() - place).norm() > 0.01 || match.time() - match.met_paddle() > 1)
      place = match.puck(), stuck = 0;
    else
      ++stuck;
    played.longest_stuck = std::max(played.longest_stuck, stuck);
  }
  played.puck = match.puck();
  played.goals = match.score(0) + match.score(1);
  played.served_again = match.served_again();
  played.squeezes = match.squeezes();
  return played;
}

void play_many(int matches) {
  double worst = 0;
  int goals = 0, again = 0, squeezes = 0, stuck = 0;
  for (int seed = 1; seed <= matches && !testing::Test::HasFailure(); ++seed) {
    const Played played = play(std::uint64_t(seed), 10);
    worst = std::max(worst, played.worst);
    goals += played.goals;
    again += played.served_again;
    squeezes += played.squeezes;
    stuck = std::max(stuck, played.longest_stuck);
  }
  testing::Test::RecordProperty("goals", goals);
  testing::Test::RecordProperty("served_again", again);
  testing::Test::RecordProperty("squeezes", squeezes);
  testing::Test::RecordProperty("longest_stuck_steps", stuck);
  testing::Test::RecordProperty("worst_um", std::to_string(1e6 * worst));
  // Rounding alone: nothing ever goes in by a thousandth of a millimetre.
  EXPECT_LT(worst, 1e-6);
  EXPECT_LE(stuck, int(Rules().held / Match::kStep) + 2) << "held by players";
  EXPECT_LT(again, matches / 100 + 1) << "lay where nobody reaches it";
  EXPECT_GT(goals, matches / 10) << "the bots play";
}

TEST(AirHockey, NothingTunnelsOrSticks) {
  play_many(300);
}
TEST(AirHockeyLong, NothingTunnelsOrSticksInTenThousandMatches) {
  play_many(10000);
}

TEST(AirHockey, SameSeedSameMatch) {
  const Played a = play(77, 20), b = play(77, 20), c = play(78, 20);
  EXPECT_EQ(a.puck, b.puck);
  EXPECT_EQ(a.goals, b.goals);
  EXPECT_NE(a.puck, c.puck);
}

/// Faster than the table is long a step: it bounces to and fro, and energy is what the walls left of it.
TEST(AirHockey, AnySpeedStaysOnTheTable) {
  Rules rules;
  rules.restitution = 1;
  rules.drag = 0;
  Match match(table_with_obstacles(), rules);
  match.start();
  match.place_puck(Vec2(0.5, 0.31), Vec2(170, 133));
  for (int i = 0; i < 500; ++i) {
    const int goals = match.score(0) + match.score(1);
    match.step({Vec2(0.2, 0.5), Vec2(1.6, 0.5)});
    if (match.score(0) + match.score(1) != goals || match.squeezes() > 0) break;
    ASSERT_LT(trespass(match), 1e-9) << i;
    if (!match.last_touch().by_paddle) {
      ASSERT_NEAR(match.puck_speed().norm(), Vec2(170, 133).norm(), 1e-6);
    }
  }
}

TEST(AirHockey, SlowPucksLeaveWallsAndCorners) {
  for (const double speed : {1e-6, 1e-3, 0.02}) {
    Match match(Table{}, Rules());
    match.start();
    // Into the corner, touching already.
    match.place_puck(Vec2(0.04, 0.04), Vec2(-speed, -0.7 * speed));
    match.step({Vec2(0.5, 0.8), Vec2(1.6, 0.5)});
    EXPECT_GT(match.puck_speed().x(), 0.9 * speed);
    EXPECT_GT(match.puck_speed().y(), 0.6 * speed);
    EXPECT_LT(trespass(match), 1e-12);
  }
}

TEST(AirHockey, APuckHeldAgainstTheWallGetsOutWhenItIsLet) {
  Match match(Table{}, Rules());
  match.start();
  match.place_puck(Vec2(0.3, 0.04), Vec2(0, 0));
  for (int i = 0; i < 240; ++i) {
    match.step({Vec2(0.3, 0.0), Vec2(1.6, 0.5)});  // presses with all its might
    ASSERT_LT(trespass(match), 1e-6) << i;
    ASSERT_LE(match.puck_speed().norm(), match.rules().fastest_puck + match.rules().fastest_paddle);
  }
  for (int i = 0; i < 60; ++i) match.step({Vec2(0.3, 0.9), Vec2(1.6, 0.5)});
  EXPECT_GT((match.puck() - Vec2(0.3, 0.04)).norm(), 0.02);
}

TEST(AirHockey, PausesWhenAPlayerLeavesAndGoesOn) {
  Match match(Table{}, Rules());
  const Match::Hands both = {Vec2(0.2, 0.5), Vec2(1.6, 0.5)}, one = {Vec2(0.2, 0.5), std::nullopt};
  const auto run = [&](const Match::Hands& hands, double seconds) {
    for (int i = 0; i < int(std::lround(seconds / Match::kStep)); ++i) match.step(hands);
  };
  run(one, 2);
  EXPECT_EQ(match.phase(), Phase::kPaused);
  run(both, 1.1);
  EXPECT_EQ(match.phase(), Phase::kPlaying);
  run(one, 0.2);
  EXPECT_EQ(match.phase(), Phase::kPlaying) << "hidden for a moment";
  run(both, 0.1);
  run(one, 0.5);
  EXPECT_EQ(match.phase(), Phase::kPaused);
  const Vec2 puck = match.puck();
  run(one, 3);
  EXPECT_EQ(match.puck(), puck);
  match.step({Vec2(std::nan(""), 1e300), std::nullopt});
  EXPECT_TRUE(match.paddle(0).allFinite());
}

TEST(AirHockey, GoalsCountForTheOtherSide) {
  Rules rules;
  rules.goals_to_win = 1;
  Match match(Table{}, rules);
  match.start();
  match.place_puck(Vec2(1.5, 0.62), Vec2(3, 0));
  for (int i = 0; i < 60; ++i) match.step({Vec2(0.2, 0.5), Vec2(1.3, 0.2)});
  EXPECT_EQ(match.score(0), 1);
  EXPECT_EQ(match.score(1), 0);
  EXPECT_EQ(match.phase(), Phase::kOver);
}

}  // namespace
}  // namespace hockey
