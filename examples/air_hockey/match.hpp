#pragma once
/// Air hockey as a simulation: a table, a puck, two paddles, a score. Metres and seconds in the table's own
/// plane, x from the left goal to the right one, y down, (0, 0) its top-left corner.
///
///   Match match(table, rules, seed);
///   match.step({left_hand, right_hand});        // every Match::kStep seconds; nullopt: nobody plays there
///
/// Collision is continuous: within a step the puck moves along a line, each paddle along its own, and the
/// earliest touch of all is found in closed form,
///   |p + v s - q| = r          puck and corner q, or paddle (v relative to it),
///   n . (p + v s - a) = r      puck and wall,
/// where only what approaches (v . n < 0) touches. So nothing is passed through at any speed, and what
/// already touches and parts does not stick. At a touch the speed along n, relative to what was hit, is
/// turned and multiplied by the restitution, which is at most 1: without a paddle energy never grows.
///
/// A puck between a paddle and a wall would be hit without end: after kMaxTouches the step ends there, and
/// the paddle has to wait. The same seed and hands give the same match.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "procam/core/base/types.hpp"

namespace hockey {

using procam::Vec2;

struct Segment {
  Vec2 a, b;
};

struct Table {
  double length = 1.8, width = 1.0;
  double goal = 0.36;  ///< width of its mouth, in the middle of the short sides
  double puck = 0.04;  ///< radii
  double paddle = 0.06;
  std::vector<Segment> obstacles;  ///< what hangs on the wall
};

struct Rules {
  int goals_to_win = 7;
  double restitution = 0.94;  ///< of walls
  double paddle_restitution = 0.8;
  double drag = 0.12;                               ///< share of its speed that the puck loses a second
  double fastest_puck = 4.5, fastest_paddle = 3.5;  ///< m/s
  double away = 0.4;                                ///< seconds without a hand after which the match pauses
  double ready = 1.0;                               ///< seconds with both hands until it goes on
  /// A puck that no paddle has met for as long is served again: it may lie where nobody reaches it.
  double forgotten = 8;
  /// So is one that players hold in a place for as long, say against a wall.
  double held = 2;
};

enum class Phase { kPaused, kPlaying, kOver };

/// For sparks and sounds.
struct Touch {
  Vec2 point = Vec2::Zero();
  double speed = 0;  ///< m/s, of the blow
  double time = -1;
  bool by_paddle = false;
};

class Match {
 public:
  static constexpr double kStep = 1.0 / 120;
  static constexpr int kMaxTouches = 24;
  using Hands = std::array<std::optional<Vec2>, 2>;

  explicit Match(Table table, Rules rules = {}, std::uint64_t seed = 1)
      : table_(std::move(table)), rules_(rules), random_(seed) {
    const double l = table_.length, w = table_.width, low = (w - table_.goal) / 2,
                 high = (w + table_.goal) / 2;
    walls_ = {{{0, 0}, {l, 0}},    {{0, w}, {l, w}},   {{0, 0}, {0, low}},
              {{0, high}, {0, w}}, {{l, 0}, {l, low}}, {{l, high}, {l, w}}};
    walls_.insert(walls_.end(), table_.obstacles.begin(), table_.obstacles.end());
    paddles_ = {Vec2(0.12 * l, w / 2), Vec2(0.88 * l, w / 2)};
    serve(uniform() < 0.5 ? 0 : 1);
  }

  void step(const Hands& hands) {
    time_ += kStep;
    if (phase_ == Phase::kOver) return;
    watch(hands);
    std::array<Vec2, 2> speeds;
    for (int i = 0; i < 2; ++i) speeds[i] = paddle_speed(i, hands[i]);
    if (phase_ == Phase::kPlaying) {
      speed_ *= std::exp(-rules_.drag * kStep);
      move(speeds);
      if ((puck_ - place_).norm() > 0.03) place_ = puck_, place_time_ = time_;
      const bool is_held = time_ - place_time_ > rules_.held && time_ - touched_ < rules_.held;
      if (is_held || time_ - touched_ > rules_.forgotten) {
        ++served_again_;
        serve(puck_.x() < table_.length / 2 ? 0 : 1);
      }
    } else {
      // Hands find their paddles; the puck waits. It is not to be crossed.
      for (int i = 0; i < 2; ++i) {
        const Vec2 next = paddles_[i] + kStep * speeds[i];
        if ((next - puck_).norm() > table_.puck + table_.paddle) paddles_[i] = next;
      }
    }
  }

  const Table& table() const { return table_; }
  const Rules& rules() const { return rules_; }
  const std::vector<Segment>& walls() const { return walls_; }
  double time() const { return time_; }
  Phase phase() const { return phase_; }
  const Vec2& puck() const { return puck_; }
  const Vec2& puck_speed() const { return speed_; }
  const Vec2& paddle(int side) const { return paddles_[std::size_t(side)]; }
  int score(int side) const { return score_[std::size_t(side)]; }
  double goal_time() const { return goal_time_; }  ///< of the last; negative before the first
  const Touch& last_touch() const { return touch_; }
  /// Seconds until it goes on; 0 unless both hands are there and it is paused.
  double countdown() const { return phase_ == Phase::kPaused && waited_ > 0 ? rules_.ready - waited_ : 0; }
  double met_paddle() const { return touched_; }  ///< when the puck last was hit by a player, or served
  int served_again() const { return served_again_; }
  int squeezes() const { return squeezes_; }

  /// For tests and for a serve by hand.
  void place_puck(const Vec2& where, const Vec2& speed) {
    puck_ = where;
    speed_ = speed;
    touched_ = place_time_ = time_;
    place_ = where;
  }
  void start() { phase_ = Phase::kPlaying; }

 private:
  double uniform() {
    return double(random_() >> 11) * 0x1p-53;
  }  // the same everywhere, unlike std's distributions

  /// From the middle towards whoever lost the point.
  void serve(int towards) {
    const double angle = (uniform() - 0.5) * 1.2;
    puck_ = clear_middle();
    speed_ = 0.7 * Vec2((towards == 0 ? -1 : 1) * std::cos(angle), std::sin(angle));
    touched_ = place_time_ = time_;
    place_ = puck_;
  }
  /// The middle, or the nearest place along the centre line that is free of obstacles and paddles.
  Vec2 clear_middle() const {
    for (double off = 0; off < table_.width / 2 - table_.puck; off += 0.01)
      for (const double sign : {-1.0, 1.0}) {
        const Vec2 at(table_.length / 2, table_.width / 2 + sign * off);
        bool is_free = true;
        for (const Segment& wall : walls_) is_free &= distance(wall, at) > table_.puck + 1e-3;
        for (const Vec2& paddle : paddles_)
          is_free &= (paddle - at).norm() > table_.puck + table_.paddle + 1e-3;
        if (is_free) return at;
      }
    return {table_.length / 2, table_.width / 2};
  }
  static double distance(const Segment& wall, const Vec2& point) {
    const Vec2 edge = wall.b - wall.a;
    const double s = std::clamp((point - wall.a).dot(edge) / std::max(edge.squaredNorm(), 1e-12), 0.0, 1.0);
    return (point - wall.a - s * edge).norm();
  }

  void watch(const Hands& hands) {
    const bool both = hands[0] && hands[1];
    away_ = both ? 0 : away_ + kStep;
    waited_ = both ? waited_ + kStep : 0;
    if (phase_ == Phase::kPlaying && away_ > rules_.away) phase_ = Phase::kPaused;
    if (phase_ == Phase::kPaused && waited_ >= rules_.ready) {
      phase_ = Phase::kPlaying;
      touched_ = place_time_ = time_;
    }
  }

  /// Towards the hand, no faster than a paddle may be, within its own half.
  Vec2 paddle_speed(int side, const std::optional<Vec2>& hand) const {
    if (!hand || !hand->allFinite()) return Vec2::Zero();
    const double r = table_.paddle, half = table_.length / 2;
    const Vec2 goal(std::clamp(hand->x(), side == 0 ? r : half + r, side == 0 ? half - r : table_.length - r),
                    std::clamp(hand->y(), r, table_.width - r));
    const Vec2 speed = (goal - paddles_[std::size_t(side)]) / kStep;
    return speed.norm() > rules_.fastest_paddle ? Vec2(speed.normalized() * rules_.fastest_paddle) : speed;
  }

  struct Hit {
    double time = std::numeric_limits<double>::infinity();
    Vec2 normal = Vec2::Zero();  ///< towards the puck
    int paddle = -1;
  };
  /// The puck, seen from `centre`, moves from `offset` by `v` a second: when does it come within r?
  static void meet_disc(const Vec2& offset, const Vec2& v, double r, double until, int paddle, Hit& first) {
    const double b = offset.dot(v), c = offset.squaredNorm() - r * r;
    if (b >= 0) return;  // it parts
    double s = 0;
    if (c > 0) {
      const double vv = v.squaredNorm(), d = b * b - vv * c;
      if (d < 0) return;
      s = c / (-b + std::sqrt(d));  // the smaller root, without cancellation
    }
    if (s > until || s >= first.time) return;
    const Vec2 away = offset + s * v;
    const double length = away.norm();
    first = {s, length > 1e-9 ? Vec2(away / length) : Vec2(-v.normalized()), paddle};
  }
  void meet_wall(const Segment& wall, double until, Hit& first) const {
    const Vec2 edge = wall.b - wall.a, offset = puck_ - wall.a;
    const double length = edge.norm();
    if (length > 1e-9) {
      const Vec2 along = edge / length;
      Vec2 n(-along.y(), along.x());
      double off = offset.dot(n);
      if (off < 0) n = -n, off = -off;
      const double closing = -speed_.dot(n);
      if (off - table_.puck > closing * until && off > table_.puck) return;  // neither the wall nor its ends
      if (closing > 0) {
        const double s = std::max(0.0, (off - table_.puck) / closing);
        const double at = (offset + s * speed_).dot(along);
        if (s <= until && s < first.time && at >= 0 && at <= length) first = {s, n, -1};
      }
    }
    meet_disc(offset, speed_, table_.puck, until, -1, first);
    meet_disc(puck_ - wall.b, speed_, table_.puck, until, -1, first);
  }

  void move(const std::array<Vec2, 2>& paddle_speeds) {
    double left = kStep;
    for (int touches = 0; left > 0; ++touches) {
      Hit hit;
      for (const Segment& wall : walls_) meet_wall(wall, left, hit);
      for (int i = 0; i < 2; ++i)
        meet_disc(puck_ - paddles_[std::size_t(i)], speed_ - paddle_speeds[std::size_t(i)],
                  table_.puck + table_.paddle, left, i, hit);
      const double go = std::min(left, hit.time);
      if (hit.time <= left && touches == kMaxTouches) {
        // Between a paddle and a wall: all wait for the next step, and the puck keeps no speed into either.
        ++squeezes_;
        speed_ *= 0.5;
        return;
      }
      puck_ += go * speed_;
      for (int i = 0; i < 2; ++i) paddles_[std::size_t(i)] += go * paddle_speeds[std::size_t(i)];
      left -= go;
      if (puck_.x() < -table_.puck || puck_.x() > table_.length + table_.puck)
        return score_goal(puck_.x() < 0 ? 1 : 0);
      if (hit.time > kStep) return;
      bounce(hit, hit.paddle < 0 ? Vec2(0, 0) : paddle_speeds[std::size_t(hit.paddle)]);
    }
  }

  void bounce(const Hit& hit, const Vec2& speed_of_other) {
    const double closing = -(speed_ - speed_of_other).dot(hit.normal);
    const double e = hit.paddle < 0 ? rules_.restitution : rules_.paddle_restitution;
    speed_ += (1 + e) * closing * hit.normal;
    if (hit.paddle >= 0) {
      touched_ = time_;
      if (speed_.norm() > rules_.fastest_puck) {
        speed_ = speed_.normalized() * rules_.fastest_puck;
        // Slower than the paddle behind it, it would be hit again at once.
        const double still = -(speed_ - speed_of_other).dot(hit.normal);
        if (still > 0) speed_ += still * hit.normal;
      }
    }
    touch_ = {puck_ - table_.puck * hit.normal, closing, time_, hit.paddle >= 0};
  }

  void score_goal(int side) {
    goal_time_ = time_;
    if (++score_[std::size_t(side)] >= rules_.goals_to_win) phase_ = Phase::kOver;
    serve(1 - side);
  }

  Table table_;
  Rules rules_;
  std::mt19937_64 random_;
  std::vector<Segment> walls_;
  Vec2 puck_ = Vec2::Zero(), speed_ = Vec2::Zero();
  std::array<Vec2, 2> paddles_;
  std::array<int, 2> score_ = {0, 0};
  Phase phase_ = Phase::kPaused;
  double time_ = 0, away_ = 0, waited_ = 0, touched_ = 0, goal_time_ = -1;
  Touch touch_;
  Vec2 place_ = Vec2::Zero();  ///< where the puck was when it last had moved on
  double place_time_ = 0;
  int served_again_ = 0, squeezes_ = 0;
};

/// Plays one side, neither well nor badly: it guards its goal, and goes for the puck in its own half.
class Bot {
 public:
  Bot(int side, std::uint64_t seed) : side_(side), random_(seed * 2 + std::uint64_t(side)) {}

  Vec2 hand(const Match& match) {
    const Table& table = match.table();
    const double l = table.length, w = table.width, sign = side_ == 0 ? 1 : -1;
    if (match.time() >= decide_) {  // a new idea every so often: its nerve, and its aim
      decide_ = match.time() + 0.3 + 0.4 * uniform();
      nerve_ = uniform();
      aim_ = Vec2(side_ == 0 ? l : 0, w / 2 + (uniform() - 0.5) * 1.4 * w);
    }
    const Vec2 &puck = match.puck(), &speed = match.puck_speed();
    // What cannot be pushed away, it lets go of, and tries another way.
    const bool is_near = (puck - match.paddle(side_)).norm() < table.puck + table.paddle + 0.01;
    pushed_ = is_near ? pushed_ + Match::kStep : 0;
    if (pushed_ > 0.25) retreat_ = match.time() + 0.5, decide_ = 0, pushed_ = 0;
    const double guard_x = side_ == 0 ? 0.1 * l : 0.9 * l;
    const double reach = (puck.x() - l / 2) * sign;  // negative: in its half
    if (match.time() > retreat_ && reach < 0.02 && speed.x() * sign > -1.2 && nerve_ > 0.15) {
      const Vec2 to_goal = (aim_ - puck).normalized();
      const Vec2 behind = puck - (table.puck + table.paddle + 0.02) * to_goal;
      // First behind the puck, then through it.
      const Vec2 here = match.paddle(side_);
      return (here - behind).norm() < 0.05 || (puck - here).dot(to_goal) > 0.8 * (puck - here).norm()
                 ? Vec2(puck + 0.15 * to_goal)
                 : behind;
    }
    const double y =
        w / 2 + std::clamp(puck.y() - w / 2, -table.goal / 2, table.goal / 2) + (nerve_ - 0.5) * 0.1;
    return {guard_x, y};
  }

 private:
  double uniform() { return double(random_() >> 11) * 0x1p-53; }

  int side_;
  std::mt19937_64 random_;
  double decide_ = 0, nerve_ = 0.5, pushed_ = 0, retreat_ = 0;
  Vec2 aim_ = Vec2::Zero();
};

}  // namespace hockey
