// procam.analyze
#include "procam/analyze.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_light_error(py::module_& m) {
  Enum<analyze::SurfaceLocated>(m, "SurfaceLocated", "How the user of the rig knows where a surface is.")
      .value("kExternally", analyze::SurfaceLocated::kExternally,
             "in the rig's frame, by other means than the rig")
      .value("kByCamera", analyze::SurfaceLocated::kByCamera,
             "by a camera of the rig, from points of known geometry on the surface");

  Record<analyze::LightError> light_error(m, "LightError",
                                          "The error of the projected light on a wall, millimetres.");
  light_error.fields_init()
      .field("distance", &analyze::LightError::distance, "metres from the lens to the wall")
      .field("mean_mm", &analyze::LightError::mean_mm,
             "mean distance between true and estimated light; not set for a prediction")
      .field("rms_mm", &analyze::LightError::rms_mm,
             "root of the mean squared distance; NaN when no light reaches the wall")
      .field("worst_mm", &analyze::LightError::worst_mm,
             "largest on the grid (predicted: root of the largest trace)")
      .field("projector", &analyze::LightError::projector, "whose light")
      .field("located", &analyze::LightError::located, "")
      .field("camera", &analyze::LightError::camera, "that located the surface")
      .field("share", &analyze::LightError::share, "of the grid that counts: what the camera sees of it")
      .field("rms95_mm", &analyze::LightError::rms95_mm,
             "predictions only: 95 of 100 such calibrations have a smaller RMS error");

  Record<analyze::LightErrors> light_errors(m, "LightErrors", "Both errors of one projector.");
  light_errors.fields_init()
      .field("externally", &analyze::LightErrors::externally, "")
      .field("by_camera", &analyze::LightErrors::by_camera,
             "Missing when no camera of the rig sees a tenth of the grid on the wall.")
      .method("of", &analyze::LightErrors::of,
              "The error of that kind; externally where the camera cannot locate the wall.",
              py::arg("located"));

  Record<analyze::LightErrorMap> light_error_map(
      m, "LightErrorMap", "An error pixel by pixel of the projector's picture: what LightError summarises.");
  light_error_map.fields_init()
      .field("error", &analyze::LightErrorMap::error,
             "rms_mm is the root mean square of the list below, worst_mm its maximum")
      .field("columns", &analyze::LightErrorMap::columns,
             "of the grid, which reaches from the picture's first pixel to its last")
      .field("rows", &analyze::LightErrorMap::rows, "")
      .field("pixels", &analyze::LightErrorMap::pixels,
             "of the grid that count: on the wall and, by camera, seen by it")
      .field("rms_mm", &analyze::LightErrorMap::rms_mm,
             "by pixel: the distance on the wall; predicted: its root mean square");

  Record<analyze::WithinTruth> within_truth(
      m, "WithinTruth",
      "How many parameters of the rig's covariance differ from the true rig's by three\n"
      "sigmas or less.");
  within_truth.fields_init()
      .field("inside_3_sigma", &analyze::WithinTruth::inside_3_sigma, "")
      .field("parameters", &analyze::WithinTruth::parameters, "");

  function(m, "to_string", &analyze::to_string, "\"externally\", \"by camera\"", py::arg("located"));
  function(m, "predicted_light_errors", &analyze::predicted_light_errors,
           "What the rig's covariance means on the wall. Parameters without a covariance (a\n"
           "camera whose lens was given) are taken as exact. Raises Error(kInput) when the rig\n"
           "carries no covariance of that projector, ValueError unless distance > 0.",
           py::arg("rig"), py::arg("distance"), py::arg("projector") = "");
  function(m, "true_light_errors", &analyze::true_light_errors,
           "The errors of an estimated rig against the true one, without approximation. The\n"
           "first kind needs both rigs in the same rig frame. Raises Error(kInput) when the two\n"
           "have different devices.",
           py::arg("estimated"), py::arg("truth"), py::arg("distance"), py::arg("projector") = "");
  function(m, "parameters_within_truth", &analyze::parameters_within_truth,
           "How many parameters are within three standard deviations of the true rig's.",
           py::arg("estimated"), py::arg("truth"));
  function(m, "predicted_light_error", &analyze::predicted_light_error,
           "Of a surface that is located externally.", py::arg("rig"), py::arg("distance"),
           py::arg("projector") = "");
  function(m, "predicted_error_map", &analyze::predicted_error_map,
           "The map of one kind of predicted error; None when no camera can locate the wall. Raises as\n"
           "predicted_light_errors().",
           py::arg("rig"), py::arg("distance"), py::arg("projector") = "",
           py::arg("located") = analyze::SurfaceLocated::kExternally);
  function(m, "true_error_map", &analyze::true_error_map,
           "The map of true_light_errors(), surface located externally: also of two rigs of which\n"
           "neither is true.",
           py::arg("estimated"), py::arg("truth"), py::arg("distance"), py::arg("projector") = "");
  function(m, "true_light_error", &analyze::true_light_error,
           "The true error of the light on a wall at `distance` metres; millimetres.", py::arg("estimated"),
           py::arg("truth"), py::arg("distance"), py::arg("projector") = "");
}

void bind_accepted_error(py::module_& m) {
  Record<analyze::AcceptedError> accepted_error(m, "AcceptedError",
                                                "The largest predicted error that the user accepts.");
  accepted_error.fields_init()
      .field("rms_mm", &analyze::AcceptedError::rms_mm,
             "RMS, millimetres. Markers, localisers and hand-measured maps place a surface to some\n"
             "5 to 10 mm: below 5 mm the calibration is not the largest error.")
      .field("located", &analyze::AcceptedError::located,
             "Externally is the larger of the two errors in nearly all rigs, so it is the safe one\n"
             "to check.");

  function(m, "predicted_error_check", &analyze::predicted_error_check,
           "Whether the rig's predicted error (RMS) is accepted. Both errors are in its detail.\n"
           "Named \"predicted error\", after the projector where the rig has several.",
           py::arg("rig"), py::arg("predicted"), py::arg("accepted"));
  function(m, "predicted_errors", &analyze::predicted_errors,
           "The predicted errors of every projector, in the rig's order, on a wall `wall` metres\n"
           "from each; none where the rig has no covariance.",
           py::arg("rig"), py::arg("wall"));
  function(m, "check_predicted_errors",
           py::overload_cast<calibrate::CalibrationResult&, double, const analyze::AcceptedError&>(
               &analyze::check_predicted_errors),
           "The same for a calibration: predicts, adds the checks to its rig's quality and its\n"
           "diagnostics, and returns what was predicted.",
           py::arg("result"), py::arg("wall") = 2,
           py::arg_v("accepted", analyze::AcceptedError{}, "AcceptedError()"));
  function(m, "only_predicted_error_failed", &analyze::only_predicted_error_failed,
           "Does the rig fail for its predicted error alone? Then its numbers are sound, and\n"
           "more views make it good.",
           py::arg("quality"));
  function(m, "in_words", &analyze::in_words,
           "\"29 mm RMS at 2 m, surface located externally\"; of a camera that does not see all of\n"
           "the frame its share.",
           py::arg("error"));
}

void bind_next_view(py::module_& m) {
  Record<analyze::NextView> next_view(m, "NextView", "Where to hold the board next.");
  next_view.fields_init()
      .field("rig_from_board", &analyze::NextView::rig_from_board, "")
      .field("board_distance", &analyze::NextView::board_distance,
             "metres from the rig's origin to the board's middle")
      .field("words", &analyze::NextView::words,
             "\"0.90 m away, in the lower left of projector's frame, tilted 35 degrees ...\"")
      .field("now", &analyze::NextView::now, "predicted, as things are")
      .field("then", &analyze::NextView::then, "predicted, with that view");

  function(m, "advise_next_view", &analyze::advise_next_view,
           "Of some four hundred poses (five distances from 0.7 times the nearest so far to 1.3\n"
           "times the farthest, nine positions in the projector's frame, untilted and tilted 35\n"
           "degrees in eight directions) that all devices can use, the one with the smallest\n"
           "predicted error of the given kind on a wall at `wall` metres\n"
           "(calibrate/next_view.hpp). None when none can be used or none reduces the error.",
           py::arg("result"), py::arg("wall"), py::arg("projector") = "",
           py::arg_v("located", analyze::SurfaceLocated::kExternally, "SurfaceLocated.kExternally"));
  function(m, "view_verdicts", &analyze::view_verdicts,
           "A line a view: \"fine\", or what is wrong with it: few points, all points near the\n"
           "image centre, parallel to another view, contributes little.",
           py::arg("result"));
}

void bind_error_sources(py::module_& m) {
  Record<analyze::RobotMotion> robot_motion(m, "RobotMotion",
                                            "The rig moves while its pose travels to the light.");
  robot_motion.fields_init()
      .field("twist", &analyze::RobotMotion::twist, "of the rig in its own frame, rad/s and m/s")
      .field("twist_sigma", &analyze::RobotMotion::twist_sigma,
             "how well it is known where it is used to predict")
      .field("acceleration", &analyze::RobotMotion::acceleration,
             "the change of the twist, which constant-twist prediction misses")
      .field("delay", &analyze::RobotMotion::delay, "seconds from the pose's stamp to the light")
      .field("delay_sigma", &analyze::RobotMotion::delay_sigma, "standard deviation, seconds")
      .field("predicted", &analyze::RobotMotion::predicted,
             "the pose is moved on by twist * delay before it is used");

  Record<analyze::PoseThroughCamera> pose_through_camera(
      m, "PoseThroughCamera",
      "The rig's pose was measured through its own camera (a marker): what the calibration\n"
      "has wrong of that camera moves the pose, and the light with it. One error, two ways.");
  pose_through_camera.fields_init()
      .field("names", &analyze::PoseThroughCamera::names,
             "parameters of the calibration: \"camera.fx\", \"rig_from_camera.rx\", ...")
      .field("by_parameters", &analyze::PoseThroughCamera::by_parameters,
             "d xi / d parameter, 6 x names: of world_from_rig's right increment.");

  Record<analyze::ErrorSources> error_sources(
      m, "ErrorSources", "What makes the light miss its place: rig, pose, map, delay, pixels.");
  error_sources.fields_init()
      .field("calibration", &analyze::ErrorSources::calibration,
             "rig.covariance; empty: the rig is taken as exact")
      .field("rig_pose", &analyze::ErrorSources::rig_pose, "of world_from_rig, right increment")
      .field("map", &analyze::ErrorSources::map, "of the surface's pose, right increment")
      .field("motion", &analyze::ErrorSources::motion, "")
      .field("pixel_sigma", &analyze::ErrorSources::pixel_sigma,
             "Half a pixel at most in either direction, all offsets alike: 1 / sqrt(12). 0 where\n"
             "content is drawn between pixels (procam's renderer does).")
      .field("through_camera", &analyze::ErrorSources::through_camera,
             "Beside rig_pose, which then holds the image's and the marker map's share alone.");

  function(m, "isotropic_pose_covariance", &analyze::isotropic_pose_covariance,
           "Position and rotation each alike in all directions and independent: sigma_position\n"
           "metres, sigma_rotation radians, about the thing's own origin. Raises\n"
           "ValueError for a negative sigma or NaN.",
           py::arg("sigma_position"), py::arg("sigma_rotation"));
  function(m, "own_frame_covariance", &analyze::own_frame_covariance,
           "Of the right increment, in the thing's own frame: Ad(T^-1) C Ad(T^-1)^T, from core's\n"
           "left increments.",
           py::arg("parent_from_thing"));
  function(m, "set_measured_pose", &analyze::set_measured_pose,
           "Sets `rig_pose` and `through_camera` from where the camera saw its markers:\n"
           "`covariance` of camera_from_world's left increment as image and map leave it,\n"
           "`by_lens` its derivative by the camera's parameters (columns as parameter_names()).\n"
           "track::LocateResult holds all three. With d the true minus the believed parameters,\n"
           "\n"
           "  xi = -(d rig_from_camera + Ad(rig_from_camera) (by_lens d + noise)).",
           py::arg("sources"), py::arg("camera"), py::arg("covariance"), py::arg("by_lens"));
}

void bind_light_path(py::module_& m) {
  Record<analyze::LightPath> light_path(
      m, "LightPath", "The links between one projector's pixel and one surface, as they are believed to be.");
  light_path.fields_init()
      .field("projector", &analyze::LightPath::projector, "")
      .field("rig_from_surface", &analyze::LightPath::rig_from_surface, "")
      .field("through_pose", &analyze::LightPath::through_pose,
             "the surface stands in the world: the rig's pose and motion take part")
      .field("through_mount", &analyze::LightPath::through_mount, "");

  function(
      m, "light_path",
      py::overload_cast<const RigProjector&, const std::string&, const Pose&, const std::optional<Pose>&>(
          &analyze::light_path),
      "`frame` is the surface's: \"world\", \"rig\" or \"projector\" (core/surface/surface.hpp).\n"
      "Raises Error(kInput) for another frame, or \"world\" without the rig's pose.",
      py::arg("projector"), py::arg("frame"), py::arg("frame_from_surface"),
      py::arg("world_from_rig") = py::none());
  function(m, "light_path", py::overload_cast<const RigProjector&, const Plane&>(&analyze::light_path),
           "A wall in the rig's frame. The surface's origin is the wall's point nearest to the\n"
           "rig's; its axes lie in the wall, z into it.",
           py::arg("projector"), py::arg("wall_in_rig"));
  function(m, "landing_place", &analyze::landing_place,
           "Where the light of a pixel lands on the surface, metres along its x and y; None\n"
           "when it misses.",
           py::arg("path"), py::arg("pixel"));
}

void bind_landing_error(py::module_& m) {
  Record<analyze::LandingError> landing_error(
      m, "LandingError", "The error of one projected point on its surface, metres, by its causes.");
  Record<analyze::LandingError::SourceError> source_error(
      landing_error.type, "SourceError",
      "One cause's share. Offsets on the surface, along its x and y, metres.");
  landing_error.fields_init()
      .field("on_surface", &analyze::LandingError::on_surface,
             "the intended place, metres along the surface's x and y")
      .field("pixel", &analyze::LandingError::pixel, "that is to light it")
      .field("incidence_deg", &analyze::LandingError::incidence_deg,
             "angle of the light to the surface's normal")
      .field("sources", &analyze::LandingError::sources, "those that take part, independent of each other")
      .field("total", &analyze::LandingError::total, "\"total\": their sum")
      .field("second_order", &analyze::LandingError::second_order,
             "shift of the mean of higher orders, metres")
      .method("first_order_holds", &analyze::LandingError::first_order_holds,
              "Is first order good enough here: incidence at most 75 degrees and the second-order\n"
              "shift at most a tenth of total.rms()?");
  source_error.fields_init()
      .field("name", &analyze::LandingError::SourceError::name,
             "\"calibration\", \"rig pose\", \"map\", \"delay\", \"pixels\"")
      .field("bias", &analyze::LandingError::SourceError::bias, "on the surface, along its x and y, metres")
      .field("covariance", &analyze::LandingError::SourceError::covariance, "on the surface, square metres")
      .field("parts", &analyze::LandingError::SourceError::parts,
             "The same cause taken apart: \"lens\", \"mount\" and \"camera\" (through which the pose was\n"
             "measured); \"position\", \"rotation\". What correlates between parts is in the whole\n"
             "only, so parts need not add up.")
      .method("rms", &analyze::LandingError::SourceError::rms,
              "Root of the mean squared distance between true and intended place.");

  Record<analyze::Ellipse> ellipse(
      m, "Ellipse",
      "A 95 % region's half axes and the angle of the longer one to the surface's x axis:\n"
      "chi-square of two degrees of freedom, 5.99.");
  ellipse.fields_init()
      .field("semi_major", &analyze::Ellipse::semi_major, "in the square root of the covariance's unit")
      .field("semi_minor", &analyze::Ellipse::semi_minor, "in the square root of the covariance's unit")
      .field("angle", &analyze::Ellipse::angle, "of the longer axis from x to y, radians");

  function(m, "landing_error", &analyze::landing_error,
           "None where no light of the projector can reach the point, or the drive takes it\n"
           "away from the surface. Raises Error(kInput) when the calibration's covariance lacks\n"
           "the projector, ValueError for covariances that are not symmetric,\n"
           "positive semidefinite and finite, or a negative sigma.",
           py::arg("path"), py::arg("sources"), py::arg("on_surface"));
  function(m, "region95", &analyze::region95,
           "The ellipse that holds 95 of 100 points of this covariance (2, 2).", py::arg("covariance"));
}

void bind_monte_carlo(py::module_& m) {
  Record<analyze::MonteCarloOptions> monte_carlo_options(m, "MonteCarloOptions",
                                                         "Number of samples, and the seed.");
  monte_carlo_options.fields_init()
      .field("draws", &analyze::MonteCarloOptions::draws, "relative error of a sigma: 1 / sqrt(2 draws)")
      .field("seed", &analyze::MonteCarloOptions::seed, "")
      .field("threads", &analyze::MonteCarloOptions::threads,
             "0: as many as the machine has. The numbers do not depend on it")
      .field("shard", &analyze::MonteCarloOptions::shard,
             "The part that is drawn here: of the draws, in pieces of 2048, every `shards`-th piece\n"
             "from this number on, 0 <= shard < shards. merged() joins the parts.")
      .field("shards", &analyze::MonteCarloOptions::shards, "");

  Record<analyze::LandingSpread> landing_spread(
      m, "LandingSpread",
      "Where the light for one point lands, over all draws. Offsets from the intended\n"
      "place, on the surface along its x and y, metres.");
  landing_spread.fields_init()
      .field("mean", &analyze::LandingSpread::mean, "on the surface, along its x and y, metres")
      .field("covariance", &analyze::LandingSpread::covariance, "on the surface, square metres")
      .field("worst", &analyze::LandingSpread::worst, "the largest distance drawn, metres")
      .field("draws", &analyze::LandingSpread::draws, "how many were made")
      .field("missed", &analyze::LandingSpread::missed,
             "draws in which the light never meets the surface; not in the numbers above")
      .method("rms", &analyze::LandingSpread::rms,
              "Root of the mean squared distance to the intended place, metres.");

  function(m, "merged", &analyze::merged,
           "The spread over the draws of all parts (MonteCarloOptions.shard); at least one part.",
           py::arg("parts"));
  function(m, "monte_carlo_landing", &analyze::monte_carlo_landing,
           "One spread a point of the surface, from the same draws: they correlate as they do in\n"
           "the room. None for a point that no light reaches in the chain as it is believed\n"
           "to be. Raises as landing_error() does, and ValueError unless draws >= 2.",
           py::arg("path"), py::arg("sources"), py::arg("on_surface"),
           py::arg_v("options", analyze::MonteCarloOptions{}, "MonteCarloOptions()"));
}

void bind_causes(py::module_& m) {
  Record<analyze::Cause> cause(m, "Cause", "One cause over the whole surface.");
  cause.fields_init()
      .field("name", &analyze::Cause::name, "\"rig pose: rotation\", \"delay\", \"calibration\", ...")
      .field("rms_mm", &analyze::Cause::rms_mm, "of this cause alone, over the lit points")
      .field("without_mm", &analyze::Cause::without_mm, "what the surface's rms would be without it");

  function(
      m, "rank_causes",
      [](const std::vector<analyze::LandingError>& points) {
        std::vector<const analyze::LandingError*> pointers;
        for (const analyze::LandingError& point : points) pointers.push_back(&point);
        return analyze::rank_causes(pointers);
      },
      "Every source, or its parts, over the points: largest first. Raises\n"
      "ValueError without points, and for points of different sources.",
      py::arg("points"));
}

void bind_prediction(py::module_& m) {
  Record<analyze::Sweep> sweep(
      m, "Sweep",
      "A number of the sources or the placement turned up and down, the rest as it is: the\n"
      "error at the content's middle.");
  sweep.fields_init()
      .field("name", &analyze::Sweep::name, "\"distance\", \"m\"")
      .field("unit", &analyze::Sweep::unit, "\"distance\", \"m\"")
      .field("here", &analyze::Sweep::here, "the value as it is")
      .field("values", &analyze::Sweep::values, "a curve; points without light are omitted")
      .field("rms_mm", &analyze::Sweep::rms_mm, "a curve; points without light are omitted");

  Record<analyze::SurfacePrediction> surface_prediction(
      m, "SurfacePrediction", "The predicted error on a surface: at its corners and on a grid.");
  surface_prediction.fields_init()
      .field("surface", &analyze::SurfacePrediction::surface, "")
      .field("size", &analyze::SurfacePrediction::size,
             "of the content on the surface, along its middle lines, metres")
      .field("corners_in_rig", &analyze::SurfacePrediction::corners_in_rig,
             "of the content, in the order of `corners`")
      .field("columns", &analyze::SurfacePrediction::columns, "")
      .field("rows", &analyze::SurfacePrediction::rows, "")
      .field("content", &analyze::SurfacePrediction::content,
             "of the grid's points, row by row: fractions (u, v)")
      .field("grid", &analyze::SurfacePrediction::grid, "None: not lit by the projector's picture")
      .field("corners", &analyze::SurfacePrediction::corners, "(0,0) (1,0) (1,1) (0,1); None: not lit")
      .field("lit_share", &analyze::SurfacePrediction::lit_share, "of the grid")
      .field("rms_mm", &analyze::SurfacePrediction::rms_mm, "over the lit points")
      .field("worst_mm", &analyze::SurfacePrediction::worst_mm,
             "rms of the worst lit point, corners included")
      .field("worst_content", &analyze::SurfacePrediction::worst_content, "where that is")
      .field("incidence_deg", &analyze::SurfacePrediction::incidence_deg, "largest over the lit points")
      .field("causes", &analyze::SurfacePrediction::causes, "parts where a source has them, largest first")
      .field("advice", &analyze::SurfacePrediction::advice, "the one change that helps most, and how much")
      .field("sweeps", &analyze::SurfacePrediction::sweeps, "")
      .field("drawn", &analyze::SurfacePrediction::drawn,
             "Monte Carlo on the grid's points; empty: not asked for")
      .field("drawn_rms_mm", &analyze::SurfacePrediction::drawn_rms_mm, "millimetres")
      .field("diagnostics", &analyze::SurfacePrediction::diagnostics,
             "\"grazing\", \"not_lit\", \"first_order\"");

  function(
      m, "merge_draws",
      [](const std::vector<std::vector<std::optional<analyze::LandingSpread>>>& parts,
         analyze::SurfacePrediction prediction) {
        analyze::merge_draws(parts, prediction);
        return prediction;
      },
      "The prediction with the draws of all parts, each `drawn` of this surface by another shard.",
      py::arg("parts"), py::arg("prediction"));
  function(m, "predict_surface", &analyze::predict_surface,
           "`plane_from_content` takes (u, v, 1) to metres on the surface (PlacedPlane). `draws`\n"
           "> 0 asks for Monte Carlo beside the closed form. Raises as landing_error() does, and\n"
           "Error(kDegenerate) when the projector's picture lights no point of the content.",
           py::arg("name"), py::arg("path"), py::arg("plane_from_content"), py::arg("sources"),
           py::arg("draws") = py::none());
}

}  // namespace

void bind_analyze(py::module_& m) {
  bind_light_error(m);
  bind_accepted_error(m);
  bind_next_view(m);
  bind_error_sources(m);
  bind_light_path(m);
  bind_landing_error(m);
  bind_monte_carlo(m);
  bind_causes(m);
  bind_prediction(m);
}

}  // namespace procam::python
