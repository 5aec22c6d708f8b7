#pragma once
/// Which of two similar poses of a plane is the true one, from a sequence of images.
///
///   PoseChooser chooser;
///   const ChosenPose chosen = chooser.choose(time, candidates);     // image by image
///   if (chosen.odds < 0.05) use(candidates[chosen.index]);
///
/// One image of a small marker leaves two poses, tilted one way and the other (locate.hpp). Each possible history of the plane
/// is a hypothesis h with a weight w_h and a state: pose, twist and covariance of a filter whose twist walks at random
/// (pose_track.hpp). An image at time t with candidates c gives
///
///   w_hc = w_h exp(-d_c / 2) sqrt(det C_c / det(P_h + C_c)) exp(-y_hc^T (P_h + C_c)^-1 y_hc / 2),
///
/// d_c: chi-square of the candidate above that of the best one, C_c its covariance, P_h the covariance of the pose that h
/// predicts, y_hc the increment between both. The first factor is the image's own evidence, the others how well the candidate
/// continues the motion. Hypotheses that end in the same candidate with the same twist are joined; four remain. Errors of
/// images that follow each other closely are alike: blur, light on the marker. So d_c counts by the share of
/// `independent_after` that has passed since the image before, and no image counts more than `max_evidence`.
///
/// This is a Gaussian sum filter (D. Alspach, H. Sorenson, "Nonlinear Bayesian estimation using Gaussian sum
/// approximations", IEEE TAC 17(4), 1972).
#include <cstddef>
#include <memory>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"

namespace procam::track {

struct PoseCandidate {
  PoseWithCovariance pose;
  double chi2 = 0;  ///< above that of the best candidate
};

struct ChosenPose {
  std::size_t index = 0;  ///< of the candidate
  double odds = 0;        ///< that another one is the true one, 0 .. 1
};

struct PoseChooserOptions {
  double forget_after = 0.5;       ///< seconds without an image, after which all is open again
  double independent_after = 0.1;  ///< seconds between images whose errors are independent
  double max_evidence = 8;         ///< largest chi-square of one image
  /// What the plane can do, one sigma: m/s^2, rad/s^2.
  double acceleration = 0.5, turn_acceleration = 1.0;
};

class PROCAM_EXPORT PoseChooser {
 public:
  /// Throws std::invalid_argument for options that are not positive.
  explicit PoseChooser(const PoseChooserOptions& options = {});
  ~PoseChooser();
  PoseChooser(PoseChooser&&) noexcept;
  PoseChooser& operator=(PoseChooser&&) noexcept;

  /// The most probable of an image's candidates. `time` in seconds; an image before the last one begins anew. Throws
  /// std::invalid_argument without a candidate.
  ChosenPose choose(double time, const std::vector<PoseCandidate>& candidates);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::track
