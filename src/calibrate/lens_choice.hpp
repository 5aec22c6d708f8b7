#pragma once
/// Private to calibrate: which distortion, by what it predicts of held-out views.
#include "procam/calibrate/options.hpp"
#include "procam/calibrate/result.hpp"
#include "solve.hpp"
#include "start.hpp"

namespace procam::calibrate {

/// What is held of a lens in that model: of what the user holds, all but coefficients of distortions; and the
/// model's own.
std::vector<std::string> held_in(const LensModel& model, const std::vector<std::string>& by_user);

/// Tries the ladder on every device that is to choose (Options::camera.choose, .projector.choose) and whose
/// lens is not known, from a solution in the models that the options name. Where another than those is taken,
/// `next` gets its lens and what it holds. `all` is everything that may be judged (Start::used).
std::vector<LensAlternative> choose_lenses(const Correspondences& data, const UsedMask& all,
                                           const Solution& solution, const Options& options,
                                           bool camera_known, Solution& next);

}  // namespace procam::calibrate
