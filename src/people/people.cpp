#include "procam/people/people.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::people {
namespace {

/// Of a velocity that nothing is known about: a walking person's hand.
constexpr double kFirstSpeed = 1;
/// A single joint that is far off does not make a person somebody else.
constexpr double kFarJoint = 1;
constexpr double kTeleportSigmas = 5;

}  // namespace

PeopleTrack::PeopleTrack(const PeopleOptions& options) : options_(options), clock_(options.clock) {
  require(options.noise > 0 && options.acceleration_sigma > 0 && options.max_speed > 0 &&
              options.confirm > 0 && options.longest_step > 0 && options.forget_joint > 0 &&
              options.forget_person > 0 && options.gate > 0,
          "PeopleOptions: noise, acceleration_sigma, speed, gate and times must be positive");
}

PeopleTrack::JointFilter PeopleTrack::predicted(JointFilter joint, double time) const {
  const double h = std::clamp(time - joint.time, 0.0, options_.longest_step);
  const double tau = options_.acceleration_tau, e = std::exp(-h / tau);
  Mat3 later_from_now;
  later_from_now << 1, h, tau * tau * (h / tau - 1 + e),  //
      0, 1, tau * (1 - e),                                //
      0, 0, e;
  // Singer's integrals for h << tau, where they are those of white jerk.
  const double q = 2 * options_.acceleration_sigma * options_.acceleration_sigma / tau, h2 = h * h,
               h3 = h2 * h;
  Mat3 noise;
  noise << h3 * h2 / 20, h2 * h2 / 8, h3 / 6,  //
      h2 * h2 / 8, h3 / 3, h2 / 2,             //
      h3 / 6, h2 / 2, h;
  joint.state = later_from_now * joint.state;
  joint.covariance = later_from_now * joint.covariance * later_from_now.transpose() + q * noise;
  joint.time = time;
  return joint;
}

void PeopleTrack::measure(JointFilter& joint, const SeenJoint<Vec3>& seen, double time) {
  const double r = options_.noise * options_.noise;
  const auto start = [&] {
    joint = JointFilter();
    joint.is_known = true;
    joint.time = time;
    joint.state.row(0) = seen.position;
    joint.covariance.diagonal() << r, kFirstSpeed * kFirstSpeed,
        options_.acceleration_sigma * options_.acceleration_sigma;
    joint.confidence = seen.confidence;
  };
  if (!joint.is_known || time - joint.time > options_.forget_joint) return start();
  const JointFilter before = predicted(joint, time);
  const Vec3 innovation = seen.position - before.position();
  const double s = before.covariance(0, 0) + r;
  const double slack = kTeleportSigmas * std::sqrt(s);
  if (!(innovation.norm() <= options_.max_speed * (time - joint.time) + slack)) {
    ++faults_.teleports;
    const bool agrees = joint.teleports > 0 && (seen.position - joint.teleported).norm() <=
                                                   options_.max_speed * (time - joint.teleport_time) + slack;
    joint.teleports = agrees ? joint.teleports + 1 : 1;
    joint.teleported = seen.position;
    joint.teleport_time = time;
    if (joint.teleports >= options_.confirm) start();
    return;
  }
  const Vec3 gain = before.covariance.col(0) / s;
  joint.time = time;
  joint.state = before.state + gain * innovation.transpose();
  const Mat3 covariance = before.covariance - gain * before.covariance.row(0);
  joint.covariance = (covariance + covariance.transpose()) / 2;
  joint.confidence = seen.confidence;
  joint.teleports = 0;
}

double PeopleTrack::distance(const Person& person, const Skeleton& seen, double time) const {
  double sum = 0;
  int count = 0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!seen.joints[j] || !person.joints[j].is_known) continue;
    sum +=
        std::min(kFarJoint, (predicted(person.joints[j], time).position() - seen.joints[j]->position).norm());
    ++count;
  }
  return count == 0 ? std::numeric_limits<double>::infinity() : sum / count;
}

/// For each person seen, the index of the one known, or -1.
std::vector<int> PeopleTrack::assign(const std::vector<Skeleton>& seen, double time) const {
  // Square, so that being new and being gone are choices as well; a pair beyond the gate costs as much as
  // both.
  constexpr double kApart = 1e3;
  const std::size_t n = std::max(seen.size(), people_.size());
  std::vector<double> costs(n * n, kApart);
  const auto cost = [&](std::size_t i, std::size_t k) -> double& { return costs[i * n + k]; };
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t k = 0; k < people_.size(); ++k) {
      const double d = distance(people_[k], seen[i], time);
      // Out of sight one may walk on, at 1 m/s.
      if (d <= options_.gate + (time - people_[k].seen)) cost(i, k) = d;
    }
  std::vector<std::size_t> match(n);
  for (std::size_t i = 0; i < n; ++i) match[i] = i;
  // Exchanges until none helps; for two people that is the smallest sum. Each makes the sum smaller, so it
  // ends.
  for (bool is_better = true; is_better;) {
    is_better = false;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        if (cost(i, match[j]) + cost(j, match[i]) + 1e-9 >= cost(i, match[i]) + cost(j, match[j])) continue;
        std::swap(match[i], match[j]);
        is_better = true;
      }
  }
  std::vector<int> result(seen.size(), -1);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (cost(i, match[i]) < kApart) result[i] = int(match[i]);
  return result;
}

bool PeopleTrack::add(const SkeletonFrame& frame) {
  require(std::isfinite(frame.arrival), "PeopleTrack::add: the arrival is not finite");
  if (const char* why = why_refused(frame)) {
    ++faults_.refused;
    faults_.why = why;
    return false;
  }
  double time = frame.arrival;
  if (frame.stamp) {
    const track::ClockVerdict verdict = clock_.observe(*frame.stamp, frame.arrival);
    if (verdict == track::ClockVerdict::kDoubtful) {
      ++faults_.late;
      return false;
    }
    if (verdict == track::ClockVerdict::kJumped) {  // what was before is of another clock
      newest_.reset();
      newest_stamp_.reset();
      people_.clear();
    }
    time = clock_.time(*frame.stamp);
  }
  time -= options_.delay;
  const bool is_repeated =
      frame.stamp ? newest_stamp_ && *frame.stamp == *newest_stamp_ : newest_ && time == *newest_;
  if (is_repeated || (newest_ && time <= *newest_)) {
    ++(is_repeated ? faults_.repeated : faults_.late);
    return false;
  }
  newest_ = time;
  newest_stamp_ = frame.stamp;

  people_.erase(std::remove_if(people_.begin(), people_.end(),
                               [&](const Person& p) { return time - p.seen > options_.forget_person; }),
                people_.end());
  const std::vector<int> match = assign(frame.people, time);
  for (std::size_t i = 0; i < frame.people.size(); ++i) {
    Person* person = match[i] >= 0 ? &people_[std::size_t(match[i])] : nullptr;
    if (person == nullptr) {
      if (!body_of(frame.people[i]) || people_.size() >= 2 * limits::kPeople) continue;
      people_.emplace_back();
      person = &people_.back();
      person->number = ++last_number_;
    }
    person->seen = time;
    ++person->sightings;
    for (std::size_t j = 0; j < kJointCount; ++j)
      if (frame.people[i].joints[j]) measure(person->joints[j], *frame.people[i].joints[j], time);
  }
  return true;
}

std::vector<TrackedPerson> PeopleTrack::at(double time) const {
  std::vector<TrackedPerson> result;
  for (const Person& person : people_) {
    if (time - person.seen > options_.forget_person) continue;
    TrackedPerson now;
    now.number = person.number;
    now.age = std::max(0.0, time - person.seen);
    now.sightings = person.sightings;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      // Unseen while the rest is seen: hidden. When nobody is seen, where all was is the best there is.
      if (!person.joints[j].is_known || person.seen - person.joints[j].time > options_.forget_joint) continue;
      const JointFilter joint = predicted(person.joints[j], time);
      now.skeleton.joints[j] = SeenJoint<Vec3>{joint.position(), joint.confidence};
      now.sigma[j] = std::sqrt(joint.covariance(0, 0));
    }
    result.push_back(std::move(now));
  }
  return result;
}

const TrackedPerson* find_person(const std::vector<TrackedPerson>& people, std::optional<int> number) {
  for (const TrackedPerson& person : people)
    if (number && person.number == *number) return &person;
  return nullptr;
}

Players seat_players(const std::vector<TrackedPerson>& people, const Pose& surface_from_sensor,
                     const Players& before, const SeatOptions& options) {
  // Metres right of the middle.
  const auto place = [&](const TrackedPerson& person) -> std::optional<double> {
    const std::optional<Vec3> body = body_of(person.skeleton);
    if (!body) return std::nullopt;
    return (surface_from_sensor * *body).x() - options.middle;
  };
  Players now;
  for (const int sign : {-1, 1}) {
    std::optional<int>& seat = sign < 0 ? now.left : now.right;
    if (const TrackedPerson* holder = find_person(people, sign < 0 ? before.left : before.right)) {
      const std::optional<double> x = place(*holder);
      // One whose body is hidden for a moment stays.
      if (!x || sign * *x > -options.cross) seat = holder->number;
    }
  }
  for (const int sign : {-1, 1}) {
    std::optional<int>& seat = sign < 0 ? now.left : now.right;
    const std::optional<int>& other = sign < 0 ? now.right : now.left;
    double nearest = std::numeric_limits<double>::infinity();
    if (seat) continue;
    for (const TrackedPerson& person : people) {
      const std::optional<double> x = place(person);
      if (!x || person.sightings < options.sightings || person.number == other) continue;
      if (sign * *x > 0 && sign * *x < nearest) nearest = sign * *x, seat = person.number;
    }
  }
  return now;
}

}  // namespace procam::people
