#pragma once
/// A stream of noisy, late skeletons -> who is where at any moment, above all at the moment of light.
///
///   PeopleTrack track(options);
///   for (const SkeletonFrame& frame : arrived) track.add(frame);
///   for (const TrackedPerson& person : track.at(now + output_delay)) ...
///
/// Each joint has a Kalman filter of its own, one for its three axes: position x, velocity v and an
/// acceleration a that fades within tau (R. A. Singer, "Estimating optimal tracking filter performance for
/// manned maneuvering targets", IEEE AES 6(4), 1970),
///   x' = v,   v' = a,   a' = -a / tau + w,   E[w w'] = (2 sigma_a^2 / tau) delta.
/// It smooths like the One-Euro filter (G. Casiez, N. Roussel, D. Vogel, CHI 2012), but predicts without its
/// lag, and states how sure it is, which the eye-safe mask needs.
///
/// A measurement that the joint could not have reached is a teleport: refused and counted, until `confirm` of
/// them in a row agree with each other.
///
/// People keep their number from frame to frame by nearness: the assignment of seen to predicted people with
/// the smallest sum of distances, each the mean over the joints that both have. The sender's ids are not
/// used: trackers swap them when people pass each other.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/people/skeleton.hpp"
#include "procam/track/clock.hpp"

namespace procam::people {

struct PeopleOptions {
  /// Of a joint along each axis, metres. Depth cameras: 5 to 15 mm at 2 m, feet worse.
  double noise = 0.01;
  double acceleration_sigma = 1.5;  ///< sigma_a, m/s^2: a hand at play; less is smoother and later
  double acceleration_tau = 0.3;    ///< tau, seconds
  double max_speed = 8;             ///< m/s: no hand of a player is faster; a throw is
  int confirm = 4;                  ///< teleports in a row that agree are believed
  double longest_step = 0.15;       ///< seconds that a joint is predicted for; beyond, it stands still
  double forget_joint = 0.3;   ///< seconds after which a joint is absent that is not seen while others are
  double forget_person = 1.0;  ///< and a person gone, who stands still until then (see TrackedPerson::age)
  double gate = 0.5;           ///< metres that a person may be from where it was predicted
  track::ClockOptions clock;
  double delay = 0;  ///< seconds from the moment that a frame speaks of to its fastest arrival
};

struct TrackedPerson {
  int number = 0;                              ///< given here, never given again
  Skeleton skeleton;                           ///< at the time asked for
  std::array<double, kJointCount> sigma = {};  ///< of each joint that is there, metres an axis
  double age = 0;                              ///< seconds since it was seen
  std::uint64_t sightings = 0;                 ///< frames that saw it; one may be a phantom
};

struct PeopleFaults {
  std::uint64_t refused = 0;   ///< frames (why_refused)
  std::uint64_t repeated = 0;  ///< frames with a repeated stamp
  std::uint64_t late = 0;  ///< frames older than one that was taken, or whose stamp contradicts the others
  std::uint64_t teleports = 0;  ///< joints refused
  std::string why;              ///< of the last refused frame
};

class PROCAM_EXPORT PeopleTrack {
 public:
  /// Throws std::invalid_argument for options that are not positive.
  explicit PeopleTrack(const PeopleOptions& options = {});

  /// Returns whether the frame was taken. Its arrival must be finite (std::invalid_argument).
  bool add(const SkeletonFrame& frame);
  /// Everybody at a moment of the local clock, by number.
  std::vector<TrackedPerson> at(double time) const;
  /// The moment that the newest frame speaks of; nullopt before the first.
  std::optional<double> newest() const { return newest_; }
  const PeopleFaults& faults() const { return faults_; }

 private:
  struct JointFilter {
    bool is_known = false;
    double time = 0;
    Mat3 state = Mat3::Zero();       ///< rows: position, velocity, acceleration
    Mat3 covariance = Mat3::Zero();  ///< of the three, the same for each axis
    double confidence = 1;
    int teleports = 0;  ///< in a row
    Vec3 teleported = Vec3::Zero();
    double teleport_time = 0;

    Vec3 position() const { return state.row(0); }
  };
  struct Person {
    int number = 0;
    std::array<JointFilter, kJointCount> joints;
    double seen = 0;
    std::uint64_t sightings = 0;
  };

  JointFilter predicted(JointFilter joint, double time) const;
  void measure(JointFilter& joint, const SeenJoint<Vec3>& seen, double time);
  double distance(const Person& person, const Skeleton& seen, double time) const;
  std::vector<int> assign(const std::vector<Skeleton>& seen, double time) const;

  PeopleOptions options_;
  track::Clock clock_;
  std::vector<Person> people_;
  int last_number_ = 0;
  std::optional<double> newest_, newest_stamp_;
  PeopleFaults faults_;
};

/// Who plays on which side of a surface; by its x, as the content is read: people who face it have their left
/// there.
struct Players {
  std::optional<int> left, right;  ///< TrackedPerson::number
};
struct SeatOptions {
  double middle = 0;            ///< x on the surface between the sides, metres
  double cross = 0.2;           ///< metres beyond the middle at which a player has left the side
  std::uint64_t sightings = 3;  ///< a person seen less often takes no seat
};
/// Whoever has a seat keeps it until gone or across; a free seat goes to the person on its side nearest the
/// middle.
PROCAM_EXPORT Players seat_players(const std::vector<TrackedPerson>& people, const Pose& surface_from_sensor,
                                   const Players& before, const SeatOptions& options = {});
/// nullptr when nobody has that number.
PROCAM_EXPORT const TrackedPerson* find_person(const std::vector<TrackedPerson>& people,
                                               std::optional<int> number);

}  // namespace procam::people
