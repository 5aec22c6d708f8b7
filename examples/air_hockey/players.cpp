#include "players.hpp"

#include "procam/core/error.hpp"
#include "procam/core/se3.hpp"
#include "procam/track/interaction.hpp"
#include "procam/track/skeleton_source.hpp"

namespace hockey {
namespace {

using namespace procam;
using track::Joint;
using track::Side;

class Bots : public Players {
 public:
  explicit Bots(std::uint64_t seed) : left_(0, seed), right_(1, seed) {}
  Match::Hands hands(const Match& match, double) override { return {left_.hand(match), right_.hand(match)}; }
  bool is_bot() const override { return true; }

 private:
  Bot left_, right_;
};

/// A skeleton sensor above the table that looks at the people.
class SeenPlayers : public Players {
 public:
  explicit SeenPlayers(const Pose& world_from_table, const track::PeopleOptions& options)
      : people_(options),
        table_from_sensor_(so3_exp(Vec3(0, kPi, 0)) * so3_exp(Vec3(-0.2, 0.03, 0.01)),
                           Vec3(0.92, -0.35, -0.03)),
        world_from_sensor_(world_from_table * table_from_sensor_) {}
  const track::PeopleTrack* people() const override { return &people_; }
  Pose world_from_sensor() const override { return world_from_sensor_; }

 protected:
  /// A hand that has not been seen for a while moves nothing.
  std::optional<Vec2> hand(const track::TrackedPerson* person, Side side) const {
    if (person == nullptr || person->age > 0.25) return std::nullopt;
    const std::optional<Vec3> joint = track::hand_of(person->skeleton, side);
    if (!joint) return std::nullopt;
    return track::on_surface(*joint, table_from_sensor_).point;
  }

  track::PeopleTrack people_;
  Pose table_from_sensor_, world_from_sensor_;
};

/// Two bots, as a depth camera sees them: 30 skeletons a second, 6 mm of noise, 50 ms late.
class SimulatedPeople : public SeenPlayers {
 public:
  SimulatedPeople(const Pose& world_from_table, std::uint64_t seed)
      : SeenPlayers(world_from_table, options()), left_(0, seed), right_(1, seed), random_(seed) {}

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
      track::SkeletonFrame frame;
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
    const std::vector<track::TrackedPerson> now = people_.at(time);
    seats_ = track::seat_players(now, table_from_sensor_, seats_, {width / 2, 0.2, 3});
    return {hand(track::find_person(now, seats_.left), Side::kLeft),
            hand(track::find_person(now, seats_.right), Side::kRight)};
  }

 private:
  static constexpr double kDelay = 0.05;
  static track::PeopleOptions options() {
    track::PeopleOptions options;
    options.noise = 0.006;
    options.delay = kDelay;
    return options;
  }
  double noise() {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += double(random_() >> 11) * 0x1p-53;
    return 0.006 * (sum - 6);
  }
  track::Skeleton person(const Vec2& pelvis, const Vec2& hand, Side side) {
    track::Skeleton seen;
    const auto put = [&](Joint joint, double x, double y, double z) {
      const Vec3 in_sensor = table_from_sensor_.inverse() * Vec3(x, y, z) + Vec3(noise(), noise(), noise());
      seen[joint] = track::SeenJoint<Vec3>{in_sensor, 1};
    };
    put(Joint::kPelvis, pelvis.x(), pelvis.y(), -0.7);
    put(Joint::kNeck, pelvis.x(), pelvis.y() - 0.5, -0.65);
    put(Joint::kHead, pelvis.x(), pelvis.y() - 0.72, -0.62);
    put(track::of_side(Joint::kLeftHand, side), hand.x(), hand.y(), -0.06);
    return seen;
  }

  Bot left_, right_;
  std::mt19937_64 random_;
  Vec2 reached_[2] = {Vec2(0.2, 0.5), Vec2(1.6, 0.5)}, velocity_[2] = {Vec2(0, 0), Vec2(0, 0)};
  double time_ = 0, sent_ = -1;
  std::vector<track::SkeletonFrame> on_the_way_;
  track::Players seats_;
};

/// One person who is alone plays both sides; two have a side each.
class OneOrTwo : public SeenPlayers {
 public:
  using SeenPlayers::SeenPlayers;

 protected:
  Match::Hands hands_at(const Match& match, double time) {
    const std::vector<track::TrackedPerson> now = people_.at(time);
    if (now.size() == 1) return {hand(&now[0], Side::kLeft), hand(&now[0], Side::kRight)};
    seats_ = track::seat_players(now, table_from_sensor_, seats_, {match.table().length / 2, 0.2, 3});
    return {hand(track::find_person(now, seats_.left), Side::kLeft),
            hand(track::find_person(now, seats_.right), Side::kRight)};
  }

 private:
  track::Players seats_;
};

/// A recording; it begins anew at its end.
class RecordedPeople : public OneOrTwo {
 public:
  RecordedPeople(const std::string& file, const Pose& world_from_table)
      : OneOrTwo(world_from_table, {}), frames_(track::read_skeleton_log(file)) {}

  Match::Hands hands(const Match& match, double time) override {
    for (; next_ < frames_.size() && frames_[next_].arrival - frames_.front().arrival + begin_ <= time;
         ++next_) {
      track::SkeletonFrame frame = frames_[next_];
      frame.stamp = frame.arrival = frame.arrival - frames_.front().arrival + begin_;
      people_.add(frame);
    }
    if (next_ == frames_.size()) next_ = 0, begin_ = time + 0.1;
    return hands_at(match, time);
  }

 private:
  std::vector<track::SkeletonFrame> frames_;
  std::size_t next_ = 0;
  double begin_ = 0;
};

class LivePeople : public OneOrTwo {
 public:
  LivePeople(const std::string& source, const Pose& world_from_table)
      : OneOrTwo(world_from_table, {}), source_(track::open_skeleton_source(source)) {}
  bool is_live() const override { return true; }

  Match::Hands hands(const Match& match, double time) override {
    if (!begin_) begin_ = track::steady_now() - time;
    source_->poll(arrived_);
    for (track::SkeletonFrame& frame : arrived_) {
      frame.arrival -= *begin_;
      people_.add(frame);
    }
    return hands_at(match, time);
  }

 private:
  std::unique_ptr<track::SkeletonSource> source_;
  std::vector<track::SkeletonFrame> arrived_;
  std::optional<double> begin_;
};

}  // namespace

std::unique_ptr<Players> open_players(const std::string& text, const Pose& world_from_table,
                                      std::uint64_t seed) {
  if (text == "bots") return std::make_unique<Bots>(seed);
  if (text == "people") return std::make_unique<SimulatedPeople>(world_from_table, seed);
  if (text.rfind("log:", 0) == 0) return std::make_unique<RecordedPeople>(text.substr(4), world_from_table);
  throw Error(ErrorKind::kInput, "players '" + text + "'", "there is no such kind",
              "say bots, people or log:FILE");
}

}  // namespace hockey
