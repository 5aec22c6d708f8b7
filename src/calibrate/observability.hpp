#pragma once
/// Private to calibrate: which parameters these views say little about, and which motion of the board is
/// missing.
#include <string>
#include <vector>

#include "procam/core/geometry/covariance.hpp"
#include "solve.hpp"

namespace procam::calibrate {

/// A parameter whose sigma is not small against what is known of any lens beforehand.
struct WeaklyObservable {
  int device = 0;
  std::string parameter;  ///< "cy", "k1"
  bool distortion = false;
  double sigma = 0;       ///< from the views
  LensPrior beforehand;   ///< what any lens keeps to, about its start
  bool at_prior = false;  ///< that was put into the solve
  std::string motion;     ///< what is missing, and what to do: "..., tilt the board ... about its ..."
};

/// Beforehand, one sigma: focal length 5 %; a camera's principal point 5 % of its picture, a projector's 25
/// %; distortion that moves the picture's farthest corner by 15 % of its distance from the axis, term by
/// term; tangential terms 0.005. `covariance` has the names of a rig's or a bundle's.
std::vector<WeaklyObservable> weakly_observable(const Solution& solution, const Correspondences& data,
                                                const NamedCovariance& covariance);

/// "camera k1, k2 are poorly constrained (1 sigma = ...): its points reach 31 % of the way ...": one sentence a device and
/// motion.
std::vector<std::string> in_words(const std::vector<WeaklyObservable>& parameters,
                                  const Correspondences& data);

/// Of a projector whose points all lie in the first part of its frame: as when its pixels are those of a smaller frame. It
/// fits a lens that is shifted far, and no check sees it. "": none.
std::string in_first_part(const Correspondences& data, const UsedMask& used);

}  // namespace procam::calibrate
