#include "players.hpp"

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/people/interaction.hpp"

namespace hockey {
namespace {

using namespace procam;
using people::Joint;
using people::Side;

class Bots : public Players {
 public:
  explicit Bots(std::uint64_t seed) : left_(0, seed), right_(1, seed) {}
  Match::Hands hands(const Match& match, double) override { return {left_.hand(match), right_.hand(match)}; }
  bool is_bot() const override { return true; }

 private:
  Bot left_, right_;
};

/// A skeleton sensor that looks at the people, or a program that tells of them in the table's own metres.
class SeenPlayers : public Players {
 public:
  explicit SeenPlayers(const Seat& seat) : people_(seat.people), world_from_sensor_(seat.world_from_table) {
    if (!seat.world_from_sensor) return;
    table_from_sensor_ = seat.world_from_table.inverse() * *seat.world_from_sensor;
    world_from_sensor_ = *seat.world_from_sensor;
  }
  const people::PeopleTrack* people() const override { return &people_; }
  Pose world_from_sensor() const override { return world_from_sensor_; }

 protected:
  /// A hand that has not been seen for a while moves nothing.
  std::optional<Vec2> hand(const people::TrackedPerson* person, Side side) const {
    if (person == nullptr || person->age > 0.25) return std::nullopt;
    const std::optional<Vec3> joint = people::hand_of(person->skeleton, side);
    if (!joint) return std::nullopt;
    return people::on_surface(*joint, table_from_sensor_).point;
  }

  people::PeopleTrack people_;
  Pose table_from_sensor_;
  Pose world_from_sensor_;
};

/// Two bots, as a depth camera sees them: 30 skeletons a second, 6 mm of noise, 50 ms late.
class SimulatedPeople : public SeenPlayers {
 public:
  SimulatedPeople(const Pose& world_from_table, std::uint64_t seed)
      : SeenPlayers({world_from_table, example_world_from_sensor(world_from_table), options()}),
        left_(0, seed),
        right_(1, seed),
        random_(seed) {}

  Match::Hands hands(const Match& match, double time) override {
    // People are no faster than their arms.
    const double dt = std::max(0.0, time - time_);
    time_ = time;
    const Vec2 wanted[2] = {left_.hand(match), right_.hand(match)};
    for (int i = 0; i < 2; ++i) {
      Vec2 speed = 8 * (wanted[i] - reached_[i]);
      if (speed.norm() > 1.5) speed = speed.normalized() * 1.5;
      velocity_[i] += std::min(1.0, 12 * dt) * (speed - velocity_[i]);
      reached_[i] += dt * velocity_[i];
    }
    const double width = match.table().length;
    if (time - sent_ >= 1 / 30.0) {
      sent_ = time;
      people::SkeletonFrame frame;
      frame.stamp = time;
      frame.arrival = time + kDelay;
      // A body beside each end of the table, reaching in.
      for (int i = 0; i < 2; ++i)
        frame.people.push_back(person(Vec2(i == 0 ? -0.15 : width + 0.15, 0.95), reached_[i],
                                      i == 0 ? Side::kLeft : Side::kRight));
      on_the_way_.push_back(frame);
    }
    while (!on_the_way_.empty() && on_the_way_.front().arrival <= time) {
      people_.add(on_the_way_.front());
      on_the_way_.erase(on_the_way_.begin());
    }
    const std::vector<people::TrackedPerson> now = people_.at(time);
    seats_ = people::seat_players(now, table_from_sensor_, seats_, {width / 2, 0.2, 3});
    return {hand(people::find_person(now, seats_.left), Side::kLeft),
            hand(people::find_person(now, seats_.right), Side::kRight)};
  }

 private:
  static constexpr double kDelay = 0.05;
  static people::PeopleOptions options() {
    people::PeopleOptions options;
    options.noise = 0.006;
    options.delay = kDelay;
    return options;
  }
  double noise() {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += double(random_() >> 11) * 0x1p-53;
    return 0.006 * (sum - 6);
  }
  people::Skeleton person(const Vec2& pelvis, const Vec2& hand, Side side) {
    people::Skeleton seen;
    const auto put = [&](Joint joint, double x, double y, double z) {
      const Vec3 in_sensor = table_from_sensor_.inverse() * Vec3(x, y, z) + Vec3(noise(), noise(), noise());
      seen[joint] = people::SeenJoint<Vec3>{in_sensor, 1};
    };
    put(Joint::kPelvis, pelvis.x(), pelvis.y(), -0.7);
    put(Joint::kNeck, pelvis.x(), pelvis.y() - 0.5, -0.65);
    put(Joint::kHead, pelvis.x(), pelvis.y() - 0.72, -0.62);
    put(people::of_side(Joint::kLeftHand, side), hand.x(), hand.y(), -0.06);
    return seen;
  }

  Bot left_, right_;
  std::mt19937_64 random_;
  Vec2 reached_[2] = {Vec2(0.2, 0.5), Vec2(1.6, 0.5)}, velocity_[2] = {Vec2(0, 0), Vec2(0, 0)};
  double time_ = 0, sent_ = -1;
  std::vector<people::SkeletonFrame> on_the_way_;
  people::Players seats_;
};

/// One person who is alone plays both sides; two have a side each.
class OneOrTwo : public SeenPlayers {
 public:
  using SeenPlayers::SeenPlayers;

 protected:
  Match::Hands hands_at(const Match& match, double time) {
    const std::vector<people::TrackedPerson> now = people_.at(time);
    if (now.size() == 1) return {hand(&now[0], Side::kLeft), hand(&now[0], Side::kRight)};
    seats_ = people::seat_players(now, table_from_sensor_, seats_, {match.table().length / 2, 0.2, 3});
    return {hand(people::find_person(now, seats_.left), Side::kLeft),
            hand(people::find_person(now, seats_.right), Side::kRight)};
  }

 private:
  people::Players seats_;
};

/// A recording; it begins anew at its end.
class RecordedPeople : public OneOrTwo {
 public:
  RecordedPeople(const std::string& file, const Seat& seat)
      : OneOrTwo(seat), frames_(people::read_skeleton_log(file)) {}

  Match::Hands hands(const Match& match, double time) override {
    for (; next_ < frames_.size() && frames_[next_].arrival - frames_.front().arrival + begin_ <= time;
         ++next_) {
      people::SkeletonFrame frame = frames_[next_];
      frame.stamp = frame.arrival = frame.arrival - frames_.front().arrival + begin_;
      people_.add(frame);
    }
    if (next_ == frames_.size()) next_ = 0, begin_ = time + 0.1;
    return hands_at(match, time);
  }

 private:
  std::vector<people::SkeletonFrame> frames_;
  std::size_t next_ = 0;
  double begin_ = 0;
};

class LivePeople : public OneOrTwo {
 public:
  LivePeople(std::unique_ptr<people::SkeletonSource> source, const Seat& seat, double begin)
      : OneOrTwo(seat), source_(std::move(source)), begin_(begin) {}
  bool is_live() const override { return true; }

  Match::Hands hands(const Match& match, double time) override {
    source_->poll(arrived_);
    for (people::SkeletonFrame& frame : arrived_) {
      frame.arrival -= begin_;
      people_.add(frame);
    }
    return hands_at(match, time);
  }

 private:
  std::unique_ptr<people::SkeletonSource> source_;
  double begin_;
  std::vector<people::SkeletonFrame> arrived_;
};

class Keyboard : public Players {
 public:
  explicit Keyboard(KeyIsDown is_down) : is_down_(std::move(is_down)) {}
  bool is_live() const override { return true; }

  Match::Hands hands(const Match& match, double time) override {
    using device::Key;
    static constexpr Key kKeys[2][4] = {{Key::kA, Key::kD, Key::kW, Key::kS},
                                        {Key::kLeft, Key::kRight, Key::kUp, Key::kDown}};
    constexpr double kSpeed = 1.4;  // m/s: quick enough to defend, slow enough to aim
    const double dt = std::clamp(time - time_, 0.0, 0.1), half = match.table().length / 2;
    time_ = time;
    for (int side = 0; side < 2; ++side) {
      const auto& keys = kKeys[side];
      const auto down = [&](int key) { return is_down_(keys[key]) ? 1.0 : 0.0; };
      const Vec2 way(down(1) - down(0), down(3) - down(2));
      std::optional<Vec2>& hand = hands_[std::size_t(side)];
      if (!hand && way != Vec2(0, 0)) hand = match.paddle(side);
      if (!hand || way == Vec2(0, 0)) continue;
      *hand += kSpeed * dt * way.normalized();
      // It stays where its paddle can follow, so that turning round is felt at once.
      const double r = match.table().paddle;
      hand->x() = std::clamp(hand->x(), side == 0 ? r : half + r, side == 0 ? half - r : 2 * half - r);
      hand->y() = std::clamp(hand->y(), r, match.table().width - r);
    }
    return hands_;
  }

 private:
  KeyIsDown is_down_;
  Match::Hands hands_;
  double time_ = 0;
};

}  // namespace

Pose example_world_from_sensor(const Pose& world_from_table) {
  return world_from_table *
         Pose(so3_exp(Vec3(0, kPi, 0)) * so3_exp(Vec3(-0.2, 0.03, 0.01)), Vec3(0.92, -0.35, -0.03));
}

std::unique_ptr<Players> bots(std::uint64_t seed) {
  return std::make_unique<Bots>(seed);
}
std::unique_ptr<Players> simulated_people(const Pose& world_from_table, std::uint64_t seed) {
  return std::make_unique<SimulatedPeople>(world_from_table, seed);
}
std::unique_ptr<Players> keyboard(KeyIsDown is_down) {
  return std::make_unique<Keyboard>(std::move(is_down));
}
std::unique_ptr<Players> recorded_people(const std::string& file, const Seat& seat) {
  return std::make_unique<RecordedPeople>(file, seat);
}
std::unique_ptr<Players> live_people(std::unique_ptr<people::SkeletonSource> source, const Seat& seat,
                                     double begin) {
  return std::make_unique<LivePeople>(std::move(source), seat, begin);
}

}  // namespace hockey
