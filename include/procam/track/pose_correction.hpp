#pragma once
/// Poses of a localiser, corrected by what a camera of the rig sees on known surfaces.
///
///   PoseCorrection correction(options);
///   if (auto pose = correction.add(message)) track.add(*pose);       // the localiser's, as they come
///   if (auto pose = correction.add(sight)) track.add(*pose);         // an image's, later than its exposure
///
/// The error of the localiser changes slowly against its own messages: a particle filter, or a map that is matched, is wrong by
/// about the same for seconds. With the localiser's pose L(t), as a PoseTrack filters it, the true one is
///
///   world_from_child(t) = [exp(w) R_L, p_L + d],   e = (w, d), both in the axes of the world,
///
/// and each component of e is a Gauss-Markov process of standard deviation s and correlation time tau:
///
///   e(t + h) = phi e(t) + noise,   phi = exp(-h / tau),   variance of the noise (1 - phi^2) s^2.
///
/// An image gives, for an increment x of rig_from_world about the place that it was compared with, the information matrix A
/// and the score b = A x. It may say nothing of some directions: A is singular then, and e stays there what the localiser says.
/// With x(e) = x_0 + J (e - e^), to first order, the update is that of an information filter,
///
///   P^-1 += J^T A J,   e^ += P J^T (b - A x_0).
///
/// Messages that state a twist are odometry. It carries a pose X from message to message with the mean twist v, and the error
/// q = (w, d) of X, true pose [exp(w) R_X, p_X + d], is estimated together with e:
///
///   X <- X exp(hat(h v)),   w <- w,   d <- d + w x (p_X' - p_X),   with the noise of the twists.
///
/// A localised pose measures q - e, an image q. Where images show nothing, the pose follows the wheels, and only slowly the
/// localiser. The twist is used while its way over a second agrees with that of the localised poses: some drivers state zeros.
/// While images come, a message is handed on with its twist and a covariance that says that the pose is not known
/// (kUnknownPoseVariance). A PoseTrack then takes poses from images, and the movement from both.
///
/// An image belongs to the moment of exposure, at which L or X is asked for: images may be late. An image that is less
/// probable than `max_chi2` allows is refused. After `believe_after` refused ones in a row the variances are those without any
/// image.
///
/// Sources: Gauss-Markov errors as states of a filter, and odometry with an aiding sensor: P. Maybeck, "Stochastic models,
/// estimation, and control", volume 1, 1979, sections 4.11 and 6.5. Information form of an update: Barfoot, "State Estimation
/// for Robotics", 2017, section 3.3.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/pose_track.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

struct PoseCorrectionOptions {
  TrackOptions track;   ///< of the localiser's messages; `delay` also of those that are returned
  Pose child_from_rig;  ///< the rig's place on what the poses tell of
  /// Standard deviation of the localiser's error, metres and radians: along the floor (x, y of the world) and about its z
  /// axis; and what the floor leaves, in z and about x and y.
  double position_sigma = 0.02, rotation_sigma = 0.0175;
  double height_sigma = 0.002, tilt_sigma = 0.002;
  double correlation = 3;    ///< tau, seconds
  double max_chi2 = 30;      ///< of an image, 6 degrees of freedom at most: 1 in 25 000 by chance
  int believe_after = 5;     ///< refused images
  double alone_after = 0.3;  ///< seconds without an image, after which the localiser's messages are handed on
};

/// One image's evidence: for rig_from_world = exp(x) * world_from_rig^-1, information A and score A x.
struct PoseSight {
  double time = 0;      ///< of exposure, local clock
  Pose world_from_rig;  ///< the place that the image was compared with
  Mat6 information = Mat6::Zero();
  Vec6 score = Vec6::Zero();
};

struct PoseCorrectionStatus {
  Vec6 error =
      Vec6::Zero();  ///< of the true pose by the localised one at the last image: [w, d], axes of the world
  Vec6 sigma = Vec6::Zero();  ///< its standard deviations
  double time = 0;            ///< of that image; 0: none yet
  double chi2 = 0;            ///< of the last image
  std::uint64_t taken = 0, refused = 0;
};

class PROCAM_EXPORT PoseCorrection {
 public:
  /// Throws std::invalid_argument for sigmas and times that are not positive.
  explicit PoseCorrection(const PoseCorrectionOptions& options = {});
  ~PoseCorrection();
  PoseCorrection(PoseCorrection&&) noexcept;
  PoseCorrection& operator=(PoseCorrection&&) noexcept;

  /// A localiser's message. Gives the corrected pose of its moment; while images come, its twist alone, if it states one. What
  /// is returned has no stamp, and `arrival` is its moment and TrackOptions::delay.
  std::optional<StampedPose> add(const StampedPose& message);
  /// An image's evidence. Gives the corrected pose at its exposure; nullopt: refused, or no message has come yet.
  /// It states no twist: that of the messages is of other moments, and they are handed on with it.
  std::optional<StampedPose> add(const PoseSight& sight);
  /// All of an image, or of several, oldest first: one pose, of the last exposure. Poses of one moment are not independent.
  std::optional<StampedPose> add(const std::vector<PoseSight>& sights);

  PoseCorrectionStatus status() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::track
