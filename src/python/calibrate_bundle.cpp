// procam.calibrate: what is known of lenses, and bundle adjustment
#include "procam/calibrate.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_lens_prior(py::module_& m) {
  Record<calibrate::LensPrior> lens_prior(
      m, "LensPrior",
      "sum of weight * parameter = value, up to one standard deviation sigma: one more\n"
      "residual of the solve,\n"
      "  (sum w_i p_i - value) / sigma.\n"
      "Parameters by their names in files (\"fx\", \"cy\", \"k1\"); all in the parameters' units\n"
      "(pixels for fx .. skew).");
  lens_prior.fields_init()
      .field("terms", &calibrate::LensPrior::terms, "parameter names and their factors")
      .field("value", &calibrate::LensPrior::value,
             "of the sum of factor times parameter, in the parameters' unit")
      .field("sigma", &calibrate::LensPrior::sigma, "standard deviation of the value");

  Record<calibrate::KnownLens> known_lens(m, "KnownLens", "A lens that was calibrated before.");
  known_lens.fields_init()
      .field("lens", &calibrate::KnownLens::lens, "")
      .field("covariance", &calibrate::KnownLens::covariance,
             "Rows by parameter names (\"fx\", \"k1\"); a parameter without a row is taken as exact.\n"
             "Empty: all of them.");

  function(m, "square_pixels", &calibrate::square_pixels, "fx = fy, to a thousandth of a pixel.");
  function(m, "throw_ratio_prior", &calibrate::throw_ratio_prior,
           "Throw ratio of a data sheet, distance over picture width: fx = ratio * width.\n"
           "`sigma` is the ratio's own.",
           py::arg("ratio"), py::arg("sigma"), py::arg("picture"));
  function(m, "lens_shift_prior", &calibrate::lens_shift_prior,
           "Lens shift: how far the optical axis lies from the picture's centre, in picture\n"
           "widths and heights, x right, y down (Projector::lens_shift()); (0, 0.5) is the\n"
           "common table-top projector, whose axis passes the bottom edge. `sigma` in the same\n"
           "shares.",
           py::arg("shift"), py::arg("sigma"), py::arg("picture"));
}

void bind_bundle_types(py::module_& m) {
  Record<calibrate::BundleState> bundle_state(m, "BundleState", "All unknowns of a rig and its views.");
  bundle_state.fields_init()
      .field("lenses", &calibrate::BundleState::lenses, "by device; a projector's as an inverse camera")
      .field("device_from_rig", &calibrate::BundleState::device_from_rig,
             "by device; the first is the identity and stays so")
      .field("rig_from_board", &calibrate::BundleState::rig_from_board, "by view")
      .field("sheet", &calibrate::BundleState::sheet,
             "that the board is printed on and light points fall on; flat to begin with")
      .field("points_in_board", &calibrate::BundleState::points_in_board,
             "by point: where the board has it, metres; as printed to begin with")
      .field("flex", &calibrate::BundleState::flex,
             "By view: the curvature that the sheet has in this view alone, added to the sheet's;\n"
             "empty: the sheet is the same in all views.")
      .field("image_changes", &calibrate::BundleState::image_changes,
             "By view and device: the change (g, x, y) of a camera's interior orientation in this\n"
             "view alone, a projector's zero; empty: it is the same in all views. Focal lengths and\n"
             "skew are (1 + g) times the lens's, the principal point is (x, y) pixels beside it.")
      .method("lens_in", &calibrate::BundleState::lens_in, "A device's lens as it is in a view.",
              py::arg("view"), py::arg("device"))
      .method("sheet_in", &calibrate::BundleState::sheet_in, "The sheet as it is in a view.", py::arg("view"))
      .method("point_in", &calibrate::BundleState::point_in,
              "A board's point as it is in a view, in the board's frame, metres.", py::arg("view"),
              py::arg("point"));

  Record<calibrate::ResidualNoise> residual_noise(
      m, "ResidualNoise",
      "The covariance a residual is weighed with: scale^2 * detector's covariance +\n"
      "floor_px^2 * I. The floor holds what the detector cannot know: a bent board, a lens\n"
      "model that falls short. It adds instead of multiplying, so that points that were\n"
      "found precisely do not outvote the others by a precision that the model does not\n"
      "have.");
  residual_noise.fields_init()
      .field("scale", &calibrate::ResidualNoise::scale, "factor of the detector's standard deviations")
      .field("floor_px", &calibrate::ResidualNoise::floor_px,
             "standard deviation that every point has beside, pixels")
      .method("covariance", &calibrate::ResidualNoise::covariance,
              "Covariance (2, 2) of a residual, pixels squared, from that of the detector.",
              py::arg("of_detector"));

  Record<calibrate::ViewVariation> view_variation(
      m, "ViewVariation",
      "What differs from view to view beside the board's pose, as standard deviations: the\n"
      "prior of BundleState.flex and of BundleState.image_changes. Zero holds it.");
  view_variation.fields_init()
      .field("flex", &calibrate::ViewVariation::flex, "RMS of the sheet's curvature, 1/metre")
      .field("focus", &calibrate::ViewVariation::focus, "of the cameras' focal length, share")
      .field("shift_px", &calibrate::ViewVariation::shift_px, "of the cameras' principal point, an axis")
      .method("of_image", &calibrate::ViewVariation::of_image, "Do the cameras' images change?")
      .method("any", &calibrate::ViewVariation::any, "Does anything differ?");

  Record<calibrate::BundleOptions> bundle_options(m, "BundleOptions",
                                                  "How the bundle adjustment runs, and what it estimates.");
  bundle_options.fields_init()
      .field("held", &calibrate::BundleOptions::held,
             "By device: names of lens parameters held at their start (\"skew\", \"k3\"). All of them\n"
             "hold a known lens.")
      .field("noise", &calibrate::BundleOptions::noise, "by device")
      .field("priors", &calibrate::BundleOptions::priors, "by device; empty: none")
      .field("hold_pose", &calibrate::BundleOptions::hold_pose,
             "By device: hold device_from_rig as well (true for device 0, always).")
      .field("board_sigma", &calibrate::BundleOptions::board_sigma,
             "Metres by which a board point may lie off its printed place (one sigma an axis).\n"
             "Zero holds the points: the board is as printed, and flat. One shape for all views;\n"
             "the prior also carries the freedom that shape and poses share (six for the place,\n"
             "one for the scale).")
      .field("variation", &calibrate::BundleOptions::variation, "what differs from view to view")
      .field("pose_groups", &calibrate::BundleOptions::pose_groups,
             "By view: the number of its group. Views of a group repeat one pose of the board:\n"
             "what disturbs one of them (paper, light, the corner's place within a pixel) disturbs\n"
             "all alike, so that together they weigh as one view, 1 / (views of the group that\n"
             "take part) each. Views beyond the list are groups of their own.")
      .field("huber_sigmas", &calibrate::BundleOptions::huber_sigmas,
             "Beyond this many sigmas a residual's pull grows linearly only (Huber). Zero: plain\n"
             "least squares.")
      .field("max_iterations", &calibrate::BundleOptions::max_iterations, "")
      .field("tolerance", &calibrate::BundleOptions::tolerance,
             "Relative decrease of the cost below which the solve has converged.");

  Record<calibrate::BundleResult> bundle_result(
      m, "BundleResult", "All parameters and poses after the adjustment, with their covariance.");
  bundle_result.fields_init()
      .field("state", &calibrate::BundleResult::state, "")
      .field("iterations", &calibrate::BundleResult::iterations, "")
      .field("converged", &calibrate::BundleResult::converged, "")
      .field("report", &calibrate::BundleResult::report, "the solver's own one-line summary");
}

void bind_bundle(py::module_& m) {
  function(m, "use_all", &calibrate::use_all, "A mask that uses everything.", py::arg("correspondences"));
  function(m, "bundle_adjust", &calibrate::bundle_adjust,
           "Raises ValueError when sizes disagree, Error(kDegenerate) when a start\n"
           "cannot be projected at all.",
           py::arg("correspondences"), py::arg("used"), py::arg("start"),
           py::arg_v("options", calibrate::BundleOptions{}, "BundleOptions()"));
}

}  // namespace

void bind_calibrate_bundle(py::module_& m) {
  bind_lens_prior(m);
  bind_bundle_types(m);
  bind_bundle(m);
}

}  // namespace procam::python
