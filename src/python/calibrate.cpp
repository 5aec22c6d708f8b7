// procam.calibrate
#include "procam/calibrate.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

/// So that Ctrl-C ends a calibration.
calibrate::Options interruptible_options(const calibrate::Options& options) {
  calibrate::Options out = options;
  out.progress = interruptible(options.progress);
  return out;
}

void bind_lens_model(py::module_& m) {
  Record<calibrate::LensModel> lens_model(m, "LensModel",
                                          "A distortion, and which of its coefficients are estimated.");
  lens_model.fields_init()
      .field("name", &calibrate::LensModel::name,
             "\"none\", \"brown-conrady:k1,k2\", \"rational\", \"fisheye\"")
      .field("distortion", &calibrate::LensModel::distortion, "")
      .field("held", &calibrate::LensModel::held, "coefficients that stay zero")
      .method("terms", &calibrate::LensModel::terms, "Number of coefficients that are estimated.");

  function(m, "lens_model_named", &calibrate::lens_model_named,
           "The model of a name: a distortion's, with the estimated coefficients after a colon\n"
           "where not all of them are (\"brown-conrady:k1,k2\"). \"brown-conrady\" alone is\n"
           "k1,k2,p1,p2. Raises Error(kUnsupported) for another distortion, Error(kInput) for a\n"
           "coefficient that it lacks.",
           py::arg("name"));
}

void bind_calibration_options(py::module_& m) {
  Enum<calibrate::BoardShape>(
      m, "BoardShape",
      "Is the board as it was printed, and flat? A sheet on a clipboard is not: it bends by\n"
      "parts of a millimetre, which is more than its corners' noise.")
      .value("kFlat", calibrate::BoardShape::kFlat, "as printed")
      .value("kFree", calibrate::BoardShape::kFree,
             "every point may lie off its place by about 1 % of a square, the same in all views")
      .value("kAuto", calibrate::BoardShape::kAuto, "the one that predicts held-out views better");

  Record<calibrate::LensOptions> lens_options(
      m, "LensOptions",
      "One kind of device's lens: its model, and which of its parameters are fixed at zero.");
  lens_options.fields_init()
      .field("model", &calibrate::LensOptions::model, "")
      .field("held", &calibrate::LensOptions::held,
             "None by default: skew and k3 are estimated, within what is known of any lens\n"
             "(known_of_any_lens), and averaged over the case that they are zero or smaller than\n"
             "these views can tell (a mixture of priors). Fixed where they are not zero, the other\n"
             "parameters absorb them and end many sigmas off (measured: docs/calibration.md).")
      .field("choose", &calibrate::LensOptions::choose,
             "Choose from candidate_lens_models() by the prediction of held-out views. `model` and\n"
             "`held` must then have their defaults, with which the choice begins.")
      .field("priors", &calibrate::LensOptions::priors,
             "What is known beforehand: a data sheet's throw ratio, square pixels.")
      .method("use", &calibrate::LensOptions::use,
              "Estimates the lens in that model; skew stays fixed or free as it is.", py::arg("lens"));

  Record<calibrate::Options> options(m, "Options",
                                     "What calibrate_rig() and its like estimate, assume and check.");
  options.fields_init()
      .field("camera", &calibrate::Options::camera, "")
      .field("projector", &calibrate::Options::projector, "")
      .field("board_shape", &calibrate::Options::board_shape, "")
      .field("outlier_sigmas", &calibrate::Options::outlier_sigmas,
             "An observation further than this from its projection (in scaled sigmas, both axes\n"
             "together) is rejected, with its reason. Under Gaussian noise 5 happens once in 270\n"
             "000 observations. Zero keeps all.")
      .field("max_iterations", &calibrate::Options::max_iterations, "")
      .field("holdout", &calibrate::Options::holdout,
             "Leave each view out in turn, take its board pose from the camera alone, predict its\n"
             "projector pixels.");
  options.field("progress", &calibrate::Options::progress,
                "Called with the step's name and the share that is done, 0..1, or None. From within\n"
                "it, an exception ends the calibration.");
}

void bind_view_results(py::module_& m) {
  Record<calibrate::Residual> residual(
      m, "Residual", "One observation after the solve. Outliers stay in the list, with the reason.");
  residual.fields_init()
      .field("view", &calibrate::Residual::view, "index into CalibrationResult::views")
      .field("device", &calibrate::Residual::device, "index into Correspondences::devices")
      .field("point", &calibrate::Residual::point, "of the board; -1 for a light point")
      .field("pixel", &calibrate::Residual::pixel, "as observed, or as shown")
      .field("residual", &calibrate::Residual::residual, "projected - observed, pixels")
      .field("used", &calibrate::Residual::used, "")
      .field("reason", &calibrate::Residual::reason, "why it was rejected; empty when used")
      .field("whitened", &calibrate::Residual::whitened,
             "L^-1 residual, L L^T the covariance that the solve expects of it (detector and\n"
             "ResidualNoise): two normal numbers of variance 1. Zero where the device cannot see the\n"
             "point.");

  Record<calibrate::ViewResult> view_result(
      m, "ViewResult", "One view: the board's pose, its residuals, and why it was rejected.");
  view_result.fields_init()
      .field("name", &calibrate::ViewResult::name, "")
      .field("rig_from_board", &calibrate::ViewResult::rig_from_board, "")
      .field("rig_from_board_covariance", &calibrate::ViewResult::rig_from_board_covariance,
             "of the left increment: rotation (radians), translation (metres)")
      .field("rms_px", &calibrate::ViewResult::rms_px, "by device, over the used observations")
      .field("holdout_px", &calibrate::ViewResult::holdout_px,
             "By device, from a solve without this view; empty when not asked for. First over the\n"
             "used observations, then over every one, outliers included.")
      .field("holdout_all_px", &calibrate::ViewResult::holdout_all_px,
             "By device, from a solve without this view; empty when not asked for. First over the\n"
             "used observations, then over every one, outliers included.")
      .field("share", &calibrate::ViewResult::share,
             "Its share of what is known of the devices (BundleCovariance::share).")
      .field("note", &calibrate::ViewResult::note, "\"board order turned by 180 degrees\", \"rejected: ...\"")
      .field("used", &calibrate::ViewResult::used, "");
}

void bind_alternatives(py::module_& m) {
  Record<calibrate::ImageChange> image_change(
      m, "ImageChange",
      "What a camera's image changes by from view to view, RMS about its mean; zero: by nothing.");
  image_change.fields_init()
      .field("focus_rms", &calibrate::ImageChange::focus_rms, "of the focal length, share")
      .field("shift_rms_px", &calibrate::ImageChange::shift_rms_px, "of the principal point, an axis");

  Record<calibrate::EstimatedShape> estimated_shape(
      m, "EstimatedShape", "The board as the views see it, against the board as printed.");
  estimated_shape.fields_init()
      .field("free", &calibrate::EstimatedShape::free, "")
      .field("offsets", &calibrate::EstimatedShape::offsets,
             "By point, board frame, metres: estimated minus printed, no rotation or shift left in\n"
             "it.")
      .field("in_plane_rms", &calibrate::EstimatedShape::in_plane_rms, "metres")
      .field("out_of_plane_rms", &calibrate::EstimatedShape::out_of_plane_rms, "metres")
      .field("largest", &calibrate::EstimatedShape::largest, "metres")
      .field("sheet", &calibrate::EstimatedShape::sheet, "that the board was printed on")
      .field("flex_rms", &calibrate::EstimatedShape::flex_rms,
             "Of what the sheet bends anew in each view, over the points seen; 0: the same sheet in\n"
             "all. Metres.")
      .field("free_points", &calibrate::EstimatedShape::free_points,
             "every point has a place of its own; else all lie on the sheet")
      .field("largest_of_light", &calibrate::EstimatedShape::largest_of_light,
             "metres off the plane of the print's middle, of all light points; 0 without any")
      .field("stretch_x_over_y", &calibrate::EstimatedShape::stretch_x_over_y,
             "How much longer the print's x is than its y, beyond what was stated: 0.002 is 0.2 %.\n"
             "(A common scale cannot be seen by the views; measure a ruler's length on the sheet.)")
      .field("holdout_flat_px", &calibrate::EstimatedShape::holdout_flat_px,
             "RMS on held-out views (to first order), both ways; zero when only one was tried.")
      .field("holdout_free_px", &calibrate::EstimatedShape::holdout_free_px,
             "RMS on held-out views (to first order), both ways; zero when only one was tried.");

  Record<calibrate::LensAlternative> lens_alternative(
      m, "LensAlternative",
      "A lens model that was tried on one device, the others' as they were. All from the\n"
      "same measurements.");
  lens_alternative.fields_init()
      .field("device", &calibrate::LensAlternative::device, "index into CalibrationResult::devices")
      .field("model", &calibrate::LensAlternative::model, "LensModel::name")
      .field("terms", &calibrate::LensAlternative::terms, "distortion coefficients that it estimates")
      .field("holdout_px", &calibrate::LensAlternative::holdout_px,
             "The device's RMS on held-out views (to first order), their board poses taken from\n"
             "device 0 alone.")
      .field("by_view", &calibrate::LensAlternative::by_view,
             "Mean squared residual of each left-out view, all devices, each in units of what the\n"
             "usual model leaves of it on left-out views: by the mean of these the models are\n"
             "judged.")
      .field("ruled_out", &calibrate::LensAlternative::ruled_out,
             "why it cannot be taken: \"folds back within the picture\"; empty when it can")
      .field("chosen", &calibrate::LensAlternative::chosen, "")
      .field("rig", &calibrate::LensAlternative::rig,
             "what it would have given, with the covariance of the normal equations; empty when\n"
             "undetermined")
      .method("error", &calibrate::LensAlternative::error,
              "Root of the mean of by_view, 1 for the usual model; NaN when these views do not\n"
              "determine the model.");
}

void bind_calibration_result(py::module_& m) {
  Record<calibrate::SolvedBundle> solved_bundle(
      m, "SolvedBundle",
      "Where the solve ended, to go on from with bundle.hpp, uncertainty.hpp and\n"
      "next_view.hpp.");
  solved_bundle.fields_init()
      .field("data", &calibrate::SolvedBundle::data, "as given, the order of symmetric boards settled")
      .field("used", &calibrate::SolvedBundle::used, "")
      .field("state", &calibrate::SolvedBundle::state, "")
      .field("options", &calibrate::SolvedBundle::options, "");

  Record<calibrate::CalibrationResult> calibration_result(
      m, "CalibrationResult", "The rig with covariance, residuals, views and checks.");
  calibration_result.fields_init()
      .field("rig", &calibrate::CalibrationResult::rig, "")
      .field("solved", &calibrate::CalibrationResult::solved, "")
      .field("lens_alternatives", &calibrate::CalibrationResult::lens_alternatives,
             "Device by device, from the fewest terms to the most; empty when nothing was to be\n"
             "chosen.")
      .field("devices", &calibrate::CalibrationResult::devices, "")
      .field("views", &calibrate::CalibrationResult::views, "")
      .field("residuals", &calibrate::CalibrationResult::residuals, "")
      .field("rms_px", &calibrate::CalibrationResult::rms_px,
             "by device: sqrt(mean |residual|^2) over the used observations")
      .field("rms_all_px", &calibrate::CalibrationResult::rms_all_px,
             "the same over every observation, outliers included")
      .field("joint_rms_px", &calibrate::CalibrationResult::joint_rms_px,
             "over all devices, used observations")
      .field("joint_rms_all_px", &calibrate::CalibrationResult::joint_rms_all_px,
             "over all points of all devices, pixels")
      .field("holdout_px", &calibrate::CalibrationResult::holdout_px,
             "By device: mean over views of the held-out RMS, used and all; empty when not asked\n"
             "for.")
      .field("holdout_all_px", &calibrate::CalibrationResult::holdout_all_px,
             "By device: mean over views of the held-out RMS, used and all; empty when not asked\n"
             "for.")
      .field("noise", &calibrate::CalibrationResult::noise,
             "by device: what the residuals say of the detectors' covariances")
      .field("shape", &calibrate::CalibrationResult::shape, "")
      .field("image_changes", &calibrate::CalibrationResult::image_changes, "by device")
      .field("variance_ratio", &calibrate::CalibrationResult::variance_ratio,
             "Variance of the views over that of independent noise (jackknife); the rig's\n"
             "covariance allows for it when it is significant (see uncertainty.hpp).")
      .field("sigmas_from_views", &calibrate::CalibrationResult::sigmas_from_views,
             "the rig's covariance does")
      .field("iterations", &calibrate::CalibrationResult::iterations, "")
      .field("converged", &calibrate::CalibrationResult::converged, "")
      .field("size_to_measure", &calibrate::CalibrationResult::size_to_measure,
             "The measurement of the printed board that shows its scale, as a sentence: no image\n"
             "does.")
      .field("diagnostics", &calibrate::CalibrationResult::diagnostics, "");
}

void bind_gates(py::module_& m) {
  Record<calibrate::GateLimits> gate_limits(
      m, "GateLimits",
      "Limits with their reasons. Real devices lie well inside; a wrong solution rarely\n"
      "does.");
  gate_limits.fields_init()
      .field("max_rms_px", &calibrate::GateLimits::max_rms_px, "largest RMS of the residuals, pixels")
      .field("min_fov_deg", &calibrate::GateLimits::min_fov_deg,
             "across the picture; long-throw lenses end near 5 degrees")
      .field("max_fov_deg", &calibrate::GateLimits::max_fov_deg, "largest field of view, degrees")
      .field("max_aspect_error", &calibrate::GateLimits::max_aspect_error, "largest |fx / fy - 1|")
      .field("max_lens_shift", &calibrate::GateLimits::max_lens_shift,
             "principal point from the picture's centre, in picture widths / heights")
      .field("max_tangential", &calibrate::GateLimits::max_tangential,
             "|p1|, |p2|: a hundredth tilts the lens by half a degree")
      .field("max_camera_offset", &calibrate::GateLimits::max_camera_offset,
             "camera's principal point from its centre, in widths / heights")
      .field("max_relative_sigma", &calibrate::GateLimits::max_relative_sigma,
             "sigma of fx, fy over their value")
      .field("max_holdout_ratio", &calibrate::GateLimits::max_holdout_ratio,
             "held-out error over the fit's RMS: more is over-fitting ...")
      .field("max_holdout_sigmas", &calibrate::GateLimits::max_holdout_sigmas,
             "... unless the rig's sigmas explain it. Few views predict another one badly, and\n"
             "their sigmas are as large. Held-out error over the expected one: 0.8 to 1.35 in 68\n"
             "sound numeric sessions of 4 to 12 views, at most 1.9 in 84 with shifted views or a\n"
             "bent board (2 of them above 1.5), up to 3 where the lens has distortion that the\n"
             "model lacks.");

  function(m, "check_stored_rig", &calibrate::check_stored_rig,
           "The quality checks of a rig that was read from a file, and the checks in the file\n"
           "that only its calibration could make (views that disagree, broken captures): a rig\n"
           "that failed one of them stays marked. The check on the predicted error is not among\n"
           "them, since it depends on the wall and the accepted error.",
           py::arg("rig"), py::arg_v("limits", calibrate::GateLimits{}, "GateLimits()"));
}

void bind_mirror_view(py::module_& m) {
  Record<calibrate::MirrorView> mirror_view(m, "MirrorView", "What the camera itself saw of the mirror.");
  mirror_view.fields_init()
      .field("board", &calibrate::MirrorView::board, "that lies on the mirror")
      .field("detections", &calibrate::MirrorView::detections, "of it in the picture as taken, not turned")
      .field("depth", &calibrate::MirrorView::depth, "metres from the print down to the reflecting plane");

  Record<calibrate::MirrorSolution> mirror_solution(
      m, "MirrorSolution", "A projector that the camera sees in a mirror, calibrated.");
  mirror_solution.fields_init()
      .field("result", &calibrate::MirrorSolution::result, "the camera itself carries the rig's frame")
      .field("mirror_in_camera", &calibrate::MirrorSolution::mirror_in_camera, "")
      .field("rms_px", &calibrate::MirrorSolution::rms_px, "of the mirror's board");

  function(m, "through_mirror", &calibrate::through_mirror,
           "The mirrored rig, seen from the camera itself:\n"
           "  rig_from_projector = S F mirrored_from_projector\n"
           "The covariance holds the mirror's: the noise of its corners (their residual RMS, if\n"
           "that is larger than promised), and what the lens's own errors do to its pose, with\n"
           "their correlation. The check \"boards in the mirror\" fails for boards before the\n"
           "mirror's plane, which the camera cannot have seen in it.\n"
           "\n"
           "Raises Error(kNotEnoughData) for fewer than six points of the mirror's board,\n"
           "Error(kDegenerate) where they do not tell its plane, ValueError for a\n"
           "result of several cameras or another picture size.",
           py::arg("mirrored"), py::arg("view"));
}

void bind_next_view_advice(py::module_& m) {
  function(m, "covariance_with_view", &calibrate::covariance_with_view,
           "The rig's covariance (the rows of result.rig.covariance) with one more view at each\n"
           "of the poses. Where the residuals of the views exceed their noise\n"
           "(result.variance_ratio), the new one is assumed to as well. None for a pose that\n"
           "the session's devices could not use: no camera that sees every point of the board,\n"
           "no projector that lights nine tenths of them (or, where the light is projected\n"
           "corners, fewer of them on the sheet than two thirds of what a view has had so far),\n"
           "or seen more than 60 degrees from the side. All None when the rig has no\n"
           "covariance.",
           py::arg("result"), py::arg("rig_from_board"));
}

void bind_points(py::module_& m) {
  Record<calibrate::PointsOptions> points_options(m, "PointsOptions",
                                                  "What calibrate_from_points() estimates.");
  points_options.fields_init()
      .field("lens", &calibrate::PointsOptions::lens,
             "A few points say little about distortion: none unless the user knows better.")
      .field("sigma_px", &calibrate::PointsOptions::sigma_px,
             "One standard deviation of a pixel coordinate, room measurement included; used where\n"
             "the residuals cannot tell (fewer than three equations more than unknowns).")
      .field("outlier_sigmas", &calibrate::PointsOptions::outlier_sigmas,
             "Pairs further off than this many sigmas are rejected. Zero keeps all.");

  Record<calibrate::PairResidual> pair_residual(m, "PairResidual", "One pair after the solve.");
  pair_residual.fields_init()
      .field("residual", &calibrate::PairResidual::residual, "projected - stated, pixels")
      .field("used", &calibrate::PairResidual::used, "")
      .field("loo_residual", &calibrate::PairResidual::loo_residual,
             "What a solve without this pair (or without its board) misses it by; unset where the\n"
             "others do not determine the answer.");

  Record<calibrate::PointsResult> points_result(m, "PointsResult",
                                                "A device from points of known place, with its covariance.");
  points_result.fields_init()
      .field("rig", &calibrate::PointsResult::rig,
             "one device, in the room's frame; with covariance and quality checks")
      .field("pairs", &calibrate::PointsResult::pairs, "")
      .field("rms_px", &calibrate::PointsResult::rms_px, "sqrt(mean |residual|^2) over the pairs used")
      .field("loo_rms_px", &calibrate::PointsResult::loo_rms_px,
             "the same of PairResidual::loo_residual; zero when there is none")
      .field("sigma_px", &calibrate::PointsResult::sigma_px,
             "of one coordinate: as the residuals say, or as stated")
      .field("board_error", &calibrate::PointsResult::board_error,
             "Metres: rms displacement of a board's points by each of its motions, where three\n"
             "boards or more were found among the points and share errors; else 0.")
      .field("diagnostics", &calibrate::PointsResult::diagnostics, "");

  function(m, "calibrate_from_points", &calibrate::calibrate_from_points,
           "One device and its pose from pairs of points in the world (metres) and pixels.\n"
           "Raises Error of kind kNotEnoughData, kDegenerate or kNotConverged.",
           py::arg("device"), py::arg("pairs"),
           py::arg_v("options", calibrate::PointsOptions{}, "PointsOptions()"));
}

void bind_calibrate_functions(py::module_& m) {
  function(
      m, "calibrate_camera",
      [](const Correspondences& correspondences, const calibrate::Options& options) {
        return calibrate::calibrate_camera(correspondences, interruptible_options(options));
      },
      "A camera by itself, from its views of the board.", py::arg("correspondences"),
      py::arg_v("options", calibrate::Options{}, "Options()"));
  function(
      m, "calibrate_projector",
      [](const Correspondences& correspondences, const calibrate::KnownLens& known_camera,
         const calibrate::Options& options) {
        return calibrate::calibrate_projector(correspondences, known_camera, interruptible_options(options));
      },
      "Camera and projector, where the camera's lens is known.", py::arg("correspondences"),
      py::arg("known_camera"), py::arg_v("options", calibrate::Options{}, "Options()"));
  function(
      m, "calibrate_rig",
      [](const Correspondences& correspondences, const calibrate::Options& options) {
        return calibrate::calibrate_rig(correspondences, interruptible_options(options));
      },
      "Every device and every view in one solve.", py::arg("correspondences"),
      py::arg_v("options", calibrate::Options{}, "Options()"));
}

}  // namespace

void bind_calibrate(py::module_& m) {
  bind_lens_model(m);
  bind_calibration_options(m);
  bind_view_results(m);
  bind_alternatives(m);
  bind_calibration_result(m);
  bind_gates(m);
  bind_mirror_view(m);
  bind_next_view_advice(m);
  bind_points(m);
  bind_calibrate_functions(m);
}

}  // namespace procam::python
