#include "procam/track/pose_track.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dead_reckoning.hpp"
#include "history.hpp"
#include "motion_bank.hpp"
#include "procam/core/base/error.hpp"
#include "procam/track/detail/message_check.hpp"
#include "scatter.hpp"

namespace procam::track {
namespace {

using internal::History;
using internal::Kept;
using internal::Measured;
using internal::Mixed;

constexpr std::size_t kSeen = 128;  ///< stamps in which duplicates are looked for
constexpr double kLatest = 1;       ///< seconds behind the newest message: older ones say nothing of now

/// chi-square of 6 degrees of freedom: 1 in 2 * 10^8 messages of Gaussian noise.
constexpr double kGate = 50;
/// Floor of the outlier check: closer than this (metres, radians) is never an outlier, even if the predicted
/// covariance is tiny.
constexpr double kNearPosition = 0.03, kNearRotation = 0.03;

/// Nearest positive semidefinite matrix: negative eigenvalues set to zero.
Mat6 positive_part(const Mat6& m) {
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(m);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
         solver.eigenvectors().transpose();
}

double smooth_step(double x) {
  return x * x * (3 - 2 * x);
}

/// A localiser may be off by some 20 mm and a degree, for seconds: that is not a wrong twist.
internal::ReckoningNoise twist_noise(const TrackOptions& options) {
  Vec6 sigma;
  sigma << Vec3::Constant(0.0175), Vec3::Constant(0.02);
  return internal::reckoning_noise(sigma, 3, options.turn_sigma, options.speed_sigma);
}

}  // namespace

Prediction parse_prediction(const std::string& text) {
  for (const Prediction p :
       {Prediction::kAuto, Prediction::kConstantTwist, Prediction::kConstantAcceleration, Prediction::kNone})
    if (text == to_string(p)) return p;
  throw Error(ErrorKind::kInput, "'" + text + "'", "no way to predict is called so",
              "use auto, twist, acceleration or none");
}
const char* to_string(Prediction prediction) {
  switch (prediction) {
    case Prediction::kAuto:
      return "auto";
    case Prediction::kConstantTwist:
      return "twist";
    case Prediction::kConstantAcceleration:
      return "acceleration";
    case Prediction::kNone:
      return "none";
  }
  return "unknown";
}
const char* to_string(TrackState state) {
  switch (state) {
    case TrackState::kNone:
      return "none";
    case TrackState::kFresh:
      return "fresh";
    case TrackState::kStale:
      return "stale";
  }
  return "unknown";
}

std::vector<std::pair<const char*, std::uint64_t>> named_counts(const Faults& f) {
  return {{"taken", f.taken},
          {"reordered", f.reordered},
          {"late", f.late},
          {"duplicated", f.duplicated},
          {"outliers", f.outliers},
          {"doubtful", f.doubtful},
          {"invalid", f.invalid},
          {"foreign", f.foreign},
          {"lost", f.lost},
          {"stale", f.stale},
          {"map_jumps", f.map_jumps},
          {"clock_jumps", f.clock_jumps},
          {"twists_ignored", f.twists_ignored}};
}

struct PoseTrack::Impl {
  explicit Impl(const TrackOptions& chosen)
      : options(chosen), bank(chosen), clock(chosen.clock), twist_check(twist_noise(chosen)) {
    for (const double positive : {options.position_sigma, options.rotation_sigma, options.speed_sigma,
                                  options.turn_sigma, options.acceleration, options.turn_acceleration,
                                  options.max_speed, options.max_turn, options.stale_after})
      require(positive > 0 && std::isfinite(positive),
              "PoseTrack: sigmas, accelerations, speeds and stale_after must be positive");
    require(std::isfinite(options.delay) && options.blend >= 0 && options.confirm >= 1,
            "PoseTrack: the delay must be finite, the blend not negative, confirm at least 1");
  }

  TrackOptions options;
  internal::MotionBank bank;
  Clock clock;
  Faults faults;
  History history;
  internal::Scatter scatter;
  internal::TwistCheck twist_check;
  double asked = -1e300;  ///< the latest time that at() was asked for

  /// Another place that messages agree on, not believed yet.
  Kept other;
  int other_count = 0;

  /// What is handed out moves from where it was to where the messages say.
  Pose blend_offset;  ///< new^-1 * old at blend_start
  double blend_start = -1e300;

  struct Seen {
    std::optional<double> stamp;
    std::optional<std::uint32_t> sequence;
  };
  std::array<Seen, kSeen> seen;
  std::size_t seen_next = 0;
  std::optional<std::uint32_t> last_sequence;
  std::optional<double> last_stamp;  ///< of the message with that number
  double last_arrival = 0;

  void add(const StampedPose& message);
  bool is_duplicate(const StampedPose& message);
  void count_lost(const StampedPose& message);
  void state_noise(const StampedPose& message, Measured& m) const;
  Measured measured(const StampedPose& message, double time) const;
  void check_twist(const StampedPose& message, const Measured& m);
  void place(const Measured& m, double arrival);
  void place_reordered(const Measured& m);
  void consider_other(const Measured& m, double arrival);
  void drop_other();
  void follow(const Kept& start, double arrival);
  bool fits(const Kept& before, const Measured& m) const;
  Mixed at_kept(double time) const;
  double blend_left(double time) const;
  Pose shown(const Pose& pose, double time) const;
};

/// The same message again: both numbers where both have them.
bool PoseTrack::Impl::is_duplicate(const StampedPose& message) {
  if (!message.stamp && !message.sequence) return false;
  for (const Seen& s : seen) {
    if (!s.stamp && !s.sequence) continue;
    if (s.stamp == message.stamp && s.sequence == message.sequence) return true;
  }
  seen[seen_next] = {message.stamp, message.sequence};
  seen_next = (seen_next + 1) % kSeen;
  return false;
}

void PoseTrack::Impl::count_lost(const StampedPose& message) {
  if (!message.sequence) return;
  if (last_sequence) {
    const auto ahead = std::int32_t(*message.sequence - *last_sequence);
    const bool newer = message.stamp && last_stamp && *message.stamp > *last_stamp;
    constexpr std::int32_t kMaxLost =
        1000;  // more at once: the sender counts anew, as it does when it restarts
    if (ahead < 0 && ahead > -kMaxLost && !newer) {
      if (faults.lost > 0) --faults.lost;  // it was counted when it was overtaken
      return;
    }
    if (ahead > 1 && ahead < kMaxLost) faults.lost += std::uint64_t(ahead - 1);
  }
  last_sequence = message.sequence;
  last_stamp = message.stamp;
}

/// Does the message state that it does not know the pose? Conversions, as to ROS and back, round the variances.
bool knows_pose(const StampedPose& message) {
  constexpr double kRounded = 1 - 1e-6;
  return !message.covariance || message.covariance->diagonal().minCoeff() < kRounded * kUnknownPoseVariance;
}

/// What the pose of a message may be off, from what is stated and from its scatter.
void PoseTrack::Impl::state_noise(const StampedPose& message, Measured& m) const {
  Vec6 usual;
  usual << Vec3::Constant(options.rotation_sigma), Vec3::Constant(options.position_sigma);
  Mat6 stated = Mat6(usual.cwiseAbs2().asDiagonal());
  if (message.covariance) {
    const Mat6 ad = adjoint(m.pose.inverse());
    stated = ad * *message.covariance * ad.transpose();
  }
  // A planar localiser states no variance of height or tilt: it knows them, and the filter needs a number.
  stated.diagonal().array() += 1e-8;
  m.noise = stated;
  if (!scatter.known()) return;
  const Vec6 scale = scatter.ratio().cwiseSqrt();
  m.noise = scale.asDiagonal() * stated * scale.asDiagonal();
  m.noise.diagonal().array() += 1e-10;
  if (message.covariance) m.common = positive_part(stated - m.noise);
}

Measured PoseTrack::Impl::measured(const StampedPose& message, double time) const {
  Measured m;
  m.time = time;
  m.has_pose = knows_pose(message);
  m.pose = message.frame_from_child.normalized();
  m.common.setZero();
  if (m.has_pose) state_noise(message, m);
  const bool has_twist = message.twist && !(m.has_pose && twist_check.is_contradicted());
  if (has_twist || message.angular_rate) {
    constexpr double kUnmeasured = 1e6;
    Vec6 twist = Vec6::Zero();
    m.twist_variance.setConstant(kUnmeasured);
    if (has_twist) {
      twist = *message.twist;
      m.twist_variance << Vec3::Constant(options.turn_sigma), Vec3::Constant(options.speed_sigma);
      m.twist_variance = m.twist_variance.cwiseAbs2().eval();
    }
    if (message.angular_rate) {
      twist.head<3>() = *message.angular_rate;
      m.twist_variance.head<3>().setConstant(options.turn_sigma * options.turn_sigma);
    }
    m.twist = twist;
  }
  return m;
}

bool PoseTrack::Impl::fits(const Kept& before, const Measured& m) const {
  if (!m.has_pose) return true;
  const double h = m.time - before.measured.time;
  const Vec6 moved = se3_log(before.measured.pose.inverse() * m.pose);
  const double noise_turn = std::sqrt(m.noise.diagonal().head<3>().sum());
  const double noise_move = std::sqrt(m.noise.diagonal().tail<3>().sum());
  if (moved.head<3>().norm() > options.max_turn * h + kNearRotation + 8 * noise_turn) return false;
  if (moved.tail<3>().norm() > options.max_speed * h + kNearPosition + 8 * noise_move) return false;
  return bank.expects(before, m, kGate, kNearRotation, kNearPosition);
}

void PoseTrack::Impl::drop_other() {
  faults.outliers += std::uint64_t(other_count);
  faults.pending -= std::uint64_t(other_count);
  other_count = 0;
}

void PoseTrack::Impl::follow(const Kept& from, double arrival) {
  const double when = std::max(arrival, asked);
  const Pose old = history.empty() ? from.measured.pose : shown(at_kept(when).pose, when);
  const bool moves = !history.empty() && options.blend > 0;
  history.clear();
  history[history.insert(0)] = from;
  scatter.forget_row();
  blend_start = -1e300;
  if (!moves) return;
  blend_offset = at_kept(when).pose.inverse() * old;
  blend_start = when;
}

void PoseTrack::Impl::consider_other(const Measured& m, double arrival) {
  if (other_count > 0 && m.time >= other.measured.time && fits(other, m)) {
    other = bank.next(other, m);
  } else {
    drop_other();
    const Mixed last = bank.after(history.newest(), 0);
    Vec6 unsure;
    unsure << Vec3::Constant(1), Vec3::Constant(1);
    other = bank.start(m, last.twist, Mat6(unsure.asDiagonal()));
  }
  ++other_count;
  ++faults.pending;
  if (other_count < options.confirm) return;
  faults.pending -= std::uint64_t(other_count);
  faults.taken += std::uint64_t(other_count);
  other_count = 0;
  ++faults.map_jumps;
  twist_check.restart();
  follow(other, arrival);
}

void PoseTrack::Impl::place_reordered(const Measured& m) {
  std::size_t at = history.size();
  while (at > 0 && history[at - 1].measured.time > m.time) --at;
  if (at == 0 || history.newest().measured.time - m.time > kLatest) {
    ++faults.late;
    return;
  }
  if (!fits(history[at - 1], m)) {
    ++faults.outliers;
    return;
  }
  at = history.insert(at);
  history[at] = bank.next(history[at - 1], m);
  for (std::size_t i = at + 1; i < history.size(); ++i)
    history[i] = bank.next(history[i - 1], Measured(history[i].measured));
  scatter.forget_row();
  ++faults.reordered;
}

void PoseTrack::Impl::place(const Measured& m, double arrival) {
  const double gap = history.empty() ? 0 : m.time - history.newest().measured.time;
  const bool begins = history.empty() || gap > std::max(2 * options.stale_after, 1.0);
  if (!m.has_pose && (begins || !m.twist || options.prediction == Prediction::kNone)) {
    ++faults.invalid;
    return;
  }
  if (begins) {
    // After a long silence the child may be anywhere.
    drop_other();
    Vec6 unsure;
    unsure << Vec3::Constant(0.5), Vec3::Constant(0.5);
    follow(bank.start(m, Vec6::Zero(), Mat6(unsure.asDiagonal())), arrival);
    ++faults.taken;
    return;
  }
  if (gap < 0) return place_reordered(m);
  if (!fits(history.newest(), m)) return consider_other(m, arrival);
  if (m.has_pose) drop_other();
  const Kept after = bank.next(history.newest(), m);
  history[history.insert(history.size())] = after;
  ++faults.taken;
}

void PoseTrack::Impl::check_twist(const StampedPose& message, const Measured& m) {
  internal::ReckonedMessage news{m.time, m.pose, *message.twist, m.noise.diagonal()};
  if (message.angular_rate) news.twist.head<3>() = *message.angular_rate;
  twist_check.add(news);
}

void PoseTrack::Impl::add(const StampedPose& message) {
  if (internal::why_malformed(message) != nullptr || !std::isfinite(message.arrival)) {
    ++faults.invalid;
    return;
  }
  if (options.frame.empty()) options.frame = message.frame;
  if (options.child.empty()) options.child = message.child;
  if (options.frame != message.frame || options.child != message.child) {
    ++faults.foreign;
    return;
  }
  if (is_duplicate(message)) {
    ++faults.duplicated;
    return;
  }
  count_lost(message);

  double time = message.arrival - options.delay;
  if (message.stamp) {
    const ClockVerdict verdict = clock.observe(*message.stamp, message.arrival);
    faults.clock_jumps = clock.estimate().jumps;
    time = clock.time(*message.stamp) - options.delay;
    // A known clock cannot be set: only the stamp can be wrong.
    const bool impossible = options.clock.known_offset && std::abs(message.arrival - time) > 10;
    if (verdict == ClockVerdict::kDoubtful || impossible) {
      ++faults.doubtful;
      return;
    }
  }
  const std::uint64_t believed = faults.taken + faults.reordered;
  const bool first = history.empty();
  const Measured m = measured(message, time);
  place(m, message.arrival);
  if (faults.taken + faults.reordered == believed) return;
  if (!first && message.arrival - last_arrival > options.stale_after) ++faults.stale;
  last_arrival = message.arrival;
  if (m.has_pose && message.twist) {
    faults.twists_ignored += twist_check.is_contradicted();
    if (history.newest().measured.time == m.time) check_twist(message, m);
  }
  if (m.has_pose && history.newest().measured.time == m.time) {
    Vec6 usual;
    usual << Vec3::Constant(options.rotation_sigma), Vec3::Constant(options.position_sigma);
    Vec6 stated = usual.cwiseAbs2();
    if (message.covariance) {
      const Mat6 ad = adjoint(m.pose.inverse());
      stated = (ad * *message.covariance * ad.transpose()).diagonal();
    }
    scatter.add(m.time, m.pose, stated.array() + 1e-8);
  }
}

double PoseTrack::Impl::blend_left(double time) const {
  if (!(options.blend > 0)) return 0;
  const double x = (time - blend_start) / options.blend;
  return x >= 1 ? 0 : 1 - smooth_step(std::max(x, 0.0));
}

Pose PoseTrack::Impl::shown(const Pose& pose, double time) const {
  const double left = blend_left(time);
  return left > 0 ? pose * se3_exp(Vec6(left * se3_log(blend_offset))) : pose;
}

/// At a time that some message is not newer than; history is not empty.
Mixed PoseTrack::Impl::at_kept(double time) const {
  const Kept& newest = history.newest();
  const double age = time - newest.measured.time;
  if (age >= 0) {
    const double h = std::min(age, options.stale_after);
    Mixed result = bank.after(newest, h);
    if (options.prediction == Prediction::kNone) {
      // What stands still here moves there: the whole way is uncertain.
      const Vec6 way = se3_log(newest.measured.pose.inverse() * result.pose);
      result.pose = newest.measured.pose;
      result.covariance += way * way.transpose();
      result.twist.setZero();
    }
    if (age > h) {
      const double frozen = age - h;
      result.covariance +=
          frozen * frozen * (result.twist * result.twist.transpose() + result.twist_covariance);
      result.twist.setZero();
    }
    result.covariance += newest.measured.common;
    return result;
  }
  std::size_t after = history.size() - 1;
  while (after > 0 && history[after - 1].measured.time > time) --after;
  const Mixed to = bank.after(history[after], 0);
  if (after == 0) return to;
  const Kept& before = history[after - 1];
  const Mixed from = bank.after(before, 0);
  const double h = history[after].measured.time - before.measured.time;
  const double x = (time - before.measured.time) / h;
  // A cubic in the tangent space of the first, with both twists at its ends.
  const Vec6 way = se3_log(from.pose.inverse() * to.pose);
  const double x2 = x * x, x3 = x2 * x;
  const Vec6 xi = (3 * x2 - 2 * x3) * way + h * ((x - 2 * x2 + x3) * from.twist + (x3 - x2) * to.twist);
  Mixed result;
  result.pose = from.pose * se3_exp(xi);
  result.twist = (1 - x) * from.twist + x * to.twist;
  result.covariance = (1 - x) * from.covariance + x * to.covariance + (1 - x) * before.measured.common +
                      x * history[after].measured.common;
  return result;
}

PoseTrack::PoseTrack(const TrackOptions& options) : impl_(std::make_unique<Impl>(options)) {}
PoseTrack::~PoseTrack() = default;
PoseTrack::PoseTrack(PoseTrack&&) noexcept = default;
PoseTrack& PoseTrack::operator=(PoseTrack&&) noexcept = default;

void PoseTrack::add(const StampedPose& message) {
  impl_->add(message);
}

TrackedPose PoseTrack::at(double time) const {
  TrackedPose result;
  if (impl_->history.empty() || !std::isfinite(time)) return result;
  impl_->asked = std::max(impl_->asked, time);
  const Mixed mixed = impl_->at_kept(time);
  result.age = time - newest_time();
  result.state = result.age > impl_->options.stale_after ? TrackState::kStale : TrackState::kFresh;
  result.frame_from_child = impl_->shown(mixed.pose, time).normalized();
  const Mat6 ad = adjoint(result.frame_from_child);
  result.covariance = ad * mixed.covariance * ad.transpose();
  result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
  result.twist = mixed.twist;
  result.blend_left = impl_->blend_left(time);
  return result;
}

const Faults& PoseTrack::faults() const {
  return impl_->faults;
}
Clock::Estimate PoseTrack::clock() const {
  return impl_->clock.estimate();
}
const std::string& PoseTrack::frame() const {
  return impl_->options.frame;
}
const std::string& PoseTrack::child() const {
  return impl_->options.child;
}
Vec6 PoseTrack::noise() const {
  Vec6 usual;
  usual << Vec3::Constant(impl_->options.rotation_sigma), Vec3::Constant(impl_->options.position_sigma);
  return impl_->history.empty() ? usual : Vec6(impl_->history.newest().measured.noise.diagonal().cwiseSqrt());
}
double PoseTrack::newest_time() const {
  return impl_->history.empty() ? 0 : impl_->history.newest().measured.time;
}

}  // namespace procam::track
