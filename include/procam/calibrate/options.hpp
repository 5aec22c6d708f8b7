#pragma once
/// What a user may decide about a calibration.
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "procam/calibrate/lens_model.hpp"
#include "procam/calibrate/lens_prior.hpp"
#include "procam/core/lens/distortion.hpp"

namespace procam::calibrate {

/// One kind of device's lens: its model, and which of its parameters are fixed at zero.
struct LensOptions {
  Distortion model = BrownConrady{};
  /// None by default: skew and k3 are estimated, within what is known of any lens (known_of_any_lens), and
  /// averaged over the case that they are zero or smaller than these views can tell (a mixture of priors).
  /// Fixed where they are not zero, the other parameters absorb them and end many sigmas off (measured:
  /// docs/calibration.md).
  std::vector<std::string> held = {};
  /// Choose from candidate_lens_models() by the prediction of held-out views. `model` and `held` must then
  /// have their defaults, with which the choice begins.
  bool choose = false;
  /// What is known beforehand: a data sheet's throw ratio, square pixels.
  std::vector<LensPrior> priors = {};

  /// Estimates the lens in that model; skew stays fixed or free as it is.
  void use(const LensModel& lens) {
    choose = false;
    model = lens.distortion;
    const bool skew_held = std::count(held.begin(), held.end(), "skew") > 0;
    held = lens.held;
    if (skew_held) held.push_back("skew");
  }
};

/// Is the board as it was printed, and flat? A sheet on a clipboard is not: it bends by parts of a
/// millimetre, which is more than its corners' noise.
enum class BoardShape {
  kFlat,  ///< as printed
  kFree,  ///< a bent sheet, and every point may lie off it by about 1 % of a square, the same in all views
  /// Of flat, bent like a sheet (core/geometry/bent_sheet.hpp) and free the simplest that predicts held-out views well. If the
  /// views show it, with a bend of its own in each view as well (costs/flexed.hpp).
  kAuto,
};

struct Options {
  LensOptions camera;
  LensOptions projector;
  BoardShape board_shape = BoardShape::kAuto;
  /// An observation further than this from its projection (in scaled sigmas, both axes together) is rejected,
  /// with its reason. Under Gaussian noise 5 happens once in 270 000 observations. Zero keeps all.
  double outlier_sigmas = 5;
  int max_iterations = 200;
  /// Leave each view out in turn, take its board pose from the camera alone, predict its projector pixels.
  bool holdout = false;
  /// Called with a short phrase and a share of the work, 0..1; may be empty.
  std::function<void(const std::string& step, double share)> progress;
};

}  // namespace procam::calibrate
