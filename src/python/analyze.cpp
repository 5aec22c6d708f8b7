// procam.analyze
#include "procam/analyze.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

void bind_analyze(py::module_& m) {
  Enum<analyze::SurfaceLocated>(m, "SurfaceLocated", "How the user of the rig knows where a surface is.")
      .value("kExternally", analyze::SurfaceLocated::kExternally,
             "in the rig's frame, by other means than the rig")
      .value("kByCamera", analyze::SurfaceLocated::kByCamera,
             "by a camera of the rig, from points of known geometry on the surface");
  Enum<analyze::Correct>(m, "Correct", "")
      .value("kNothing", analyze::Correct::kNothing)
      .value("kProjector", analyze::Correct::kProjector)
      .value("kSurface", analyze::Correct::kSurface);
  Record<analyze::LightError> light_error(m, "LightError", "");
  Record<analyze::LightErrors> light_errors(m, "LightErrors", "Both errors of one projector.");
  Record<analyze::WithinTruth> within_truth(
      m, "WithinTruth",
      "How many parameters of the rig's covariance differ from the true rig's by three\n"
      "sigmas or less.");
  Record<analyze::AcceptedError> accepted_error(m, "AcceptedError",
                                                "The largest predicted error that the user accepts.");
  Record<analyze::NextView> next_view(m, "NextView", "Where to hold the board next.");
  Record<analyze::RobotMotion> robot_motion(m, "RobotMotion",
                                            "The rig moves while its pose travels to the light.");
  Record<analyze::PoseThroughCamera> pose_through_camera(
      m, "PoseThroughCamera",
      "The rig's pose was measured through its own camera (a marker): what the calibration\n"
      "has wrong of that camera moves the pose, and the light with it. One error, two ways.");
  Record<analyze::ErrorSources> error_sources(m, "ErrorSources", "");
  Record<analyze::LightPath> light_path(
      m, "LightPath", "The links between one projector's pixel and one surface, as they are believed to be.");
  Record<analyze::LandingError> landing_error(m, "LandingError", "");
  Record<analyze::LandingError::SourceError> source_error(
      landing_error.type, "SourceError",
      "One cause's share. Offsets on the surface, along its x and y, metres.");
  Record<analyze::Ellipse> ellipse(
      m, "Ellipse",
      "A 95 % region's half axes and the angle of the longer one to the surface's x axis:\n"
      "chi-square of two degrees of freedom, 5.99.");
  Record<analyze::MonteCarloOptions> monte_carlo_options(m, "MonteCarloOptions", "");
  Record<analyze::LandingSpread> landing_spread(
      m, "LandingSpread",
      "Where the light for one point lands, over all draws. Offsets from the intended\n"
      "place, on the surface along its x and y, metres.");
  Record<analyze::DataSheet> data_sheet(
      m, "DataSheet", "As printed by the maker; of a zoom lens, the values at the zoom that is meant.");
  Record<analyze::WallRectangle> wall_rectangle(m, "WallRectangle",
                                                "A rectangle parallel to the wall's axes.");
  Record<analyze::WallTarget> wall_target(m, "WallTarget", "What shall be covered.");
  Record<analyze::Site> site(m, "Site", "Where the projector stands, and what for.");
  Record<analyze::LightOnWall> light_on_wall(m, "LightOnWall", "Where one pixel's light lands, and how.");
  Record<analyze::DepthOfField> depth_of_field(
      m, "DepthOfField",
      "The lens focused on the middle of the picture. That is the best place: 1 / depth\n"
      "changes evenly over the picture, so the nearest and the farthest corner are blurred\n"
      "alike. Depths along the optical axis, metres.");
  Record<analyze::ProjectionPlan> projection_plan(m, "ProjectionPlan", "");
  Record<analyze::ProjectionPlan::TargetCoverage> target_coverage(projection_plan.type, "TargetCoverage", "");
  Record<analyze::ProjectionPlan::Illuminance> illuminance(
      projection_plan.type, "Illuminance", "Lux, on the wall. The extremes lie at corners of the picture.");
  Record<analyze::PlanFigure> plan_figure(
      m, "PlanFigure", "The figures as people read them: a name and a value a line, ASCII.");
  Record<analyze::Cause> cause(m, "Cause", "One cause over the whole surface.");
  Record<analyze::Sweep> sweep(
      m, "Sweep",
      "A number of the sources or the placement turned up and down, the rest as it is: the\n"
      "error at the content's middle.");
  Record<analyze::SurfacePrediction> surface_prediction(m, "SurfacePrediction", "");
  Record<analyze::StatedSurface> stated_surface(
      m, "StatedSurface",
      "Where the surface stands (x, y on it, z into the wall) and how well that is known.");
  Record<analyze::VerifyOptions> verify_options(m, "VerifyOptions", "");
  Record<analyze::VerifiedMark> verified_mark(m, "VerifiedMark", "");
  Record<analyze::Movement> movement(m, "Movement", "One explanation: this thing alone has moved.");
  Record<analyze::VerifyResult> verify_result(m, "VerifyResult", "");

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
  light_errors.fields_init()
      .field("externally", &analyze::LightErrors::externally, "")
      .field("by_camera", &analyze::LightErrors::by_camera,
             "Missing when no camera of the rig sees a tenth of the grid on the wall.")
      .method("of", &analyze::LightErrors::of,
              "The error of that kind; externally where the camera cannot locate the wall.",
              py::arg("located"));
  within_truth.fields_init()
      .field("inside_3_sigma", &analyze::WithinTruth::inside_3_sigma, "")
      .field("parameters", &analyze::WithinTruth::parameters, "");
  accepted_error.fields_init()
      .field("rms_mm", &analyze::AcceptedError::rms_mm,
             "RMS, millimetres. Markers, localisers and hand-measured maps place a surface to some\n"
             "5 to 10 mm: below 5 mm the calibration is not the largest error.")
      .field("located", &analyze::AcceptedError::located,
             "Externally is the larger of the two errors in nearly all rigs, so it is the safe one\n"
             "to check.");
  next_view.fields_init()
      .field("rig_from_board", &analyze::NextView::rig_from_board, "")
      .field("board_distance", &analyze::NextView::board_distance,
             "metres from the rig's origin to the board's middle")
      .field("words", &analyze::NextView::words,
             "\"0.90 m away, in the lower left of projector's frame, tilted 35 degrees ...\"")
      .field("now", &analyze::NextView::now, "predicted, as things are")
      .field("then", &analyze::NextView::then, "predicted, with that view");
  robot_motion.fields_init()
      .field("twist", &analyze::RobotMotion::twist, "of the rig in its own frame, rad/s and m/s")
      .field("twist_sigma", &analyze::RobotMotion::twist_sigma,
             "how well it is known where it is used to predict")
      .field("acceleration", &analyze::RobotMotion::acceleration,
             "the change of the twist, which constant-twist prediction misses")
      .field("delay", &analyze::RobotMotion::delay, "seconds from the pose's stamp to the light")
      .field("delay_sigma", &analyze::RobotMotion::delay_sigma, "")
      .field("predicted", &analyze::RobotMotion::predicted,
             "the pose is moved on by twist * delay before it is used");
  pose_through_camera.fields_init()
      .field("names", &analyze::PoseThroughCamera::names,
             "parameters of the calibration: \"camera.fx\", \"rig_from_camera.rx\", ...")
      .field("by_parameters", &analyze::PoseThroughCamera::by_parameters,
             "d xi / d parameter, 6 x names: of world_from_rig's right increment.");
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
  light_path.fields_init()
      .field("projector", &analyze::LightPath::projector, "")
      .field("rig_from_surface", &analyze::LightPath::rig_from_surface, "")
      .field("through_pose", &analyze::LightPath::through_pose,
             "the surface stands in the world: the rig's pose and motion take part")
      .field("through_mount", &analyze::LightPath::through_mount, "");
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
      .field("bias", &analyze::LandingError::SourceError::bias, "")
      .field("covariance", &analyze::LandingError::SourceError::covariance, "")
      .field("parts", &analyze::LandingError::SourceError::parts,
             "The same cause taken apart: \"lens\", \"mount\" and \"camera\" (through which the pose was\n"
             "measured); \"position\", \"rotation\". What correlates between parts is in the whole\n"
             "only, so parts need not add up.")
      .method("rms", &analyze::LandingError::SourceError::rms,
              "Root of the mean squared distance between true and intended place.");
  ellipse.fields_init()
      .field("semi_major", &analyze::Ellipse::semi_major, "")
      .field("semi_minor", &analyze::Ellipse::semi_minor, "")
      .field("angle", &analyze::Ellipse::angle, "");
  monte_carlo_options.fields_init()
      .field("draws", &analyze::MonteCarloOptions::draws, "relative error of a sigma: 1 / sqrt(2 draws)")
      .field("seed", &analyze::MonteCarloOptions::seed, "")
      .field("threads", &analyze::MonteCarloOptions::threads,
             "0: as many as the machine has. The numbers do not depend on it");
  landing_spread.fields_init()
      .field("mean", &analyze::LandingSpread::mean, "")
      .field("covariance", &analyze::LandingSpread::covariance, "")
      .field("worst", &analyze::LandingSpread::worst, "the largest distance drawn, metres")
      .field("missed", &analyze::LandingSpread::missed,
             "draws in which the light never meets the surface; not in the numbers above")
      .method("rms", &analyze::LandingSpread::rms, "");
  data_sheet.fields_init()
      .field("resolution", &analyze::DataSheet::resolution, "")
      .field("throw_ratio", &analyze::DataSheet::throw_ratio, "distance over picture width")
      .field("lens_shift", &analyze::DataSheet::lens_shift,
             "as Projector::lens_shift(): (0, 0.5): the axis at the bottom edge")
      .field("lumens", &analyze::DataSheet::lumens, "of a white picture")
      .field("f_number", &analyze::DataSheet::f_number, "for the depth of field, with")
      .field("focal_length", &analyze::DataSheet::focal_length, "metres");
  wall_rectangle.fields_init()
      .field("centre", &analyze::WallRectangle::centre, "metres")
      .field("size", &analyze::WallRectangle::size, "metres")
      .method("corners", &analyze::WallRectangle::corners, "Top left, top right, bottom right, bottom left.");
  wall_target.fields_init()
      .field("size", &analyze::WallTarget::size, "metres")
      .field("centre", &analyze::WallTarget::centre,
             "absent: wherever it fits best, at the centre of the largest rectangle");
  site.fields_init()
      .field("projector_from_wall", &analyze::Site::projector_from_wall, "")
      .field("target", &analyze::Site::target, "")
      .field("viewer_distance", &analyze::Site::viewer_distance, "metres from the reader's eyes to the wall")
      .field("text_height", &analyze::Site::text_height, "of the capitals that are to be read, metres");
  light_on_wall.fields_init()
      .field("on_wall", &analyze::LightOnWall::on_wall, "metres")
      .field("depth", &analyze::LightOnWall::depth, "metres along the optical axis")
      .field("incidence_deg", &analyze::LightOnWall::incidence_deg,
             "angle between the light and the wall's normal")
      .field("mm_per_pixel_min", &analyze::LightOnWall::mm_per_pixel_min,
             "size of the pixel on the wall: finest")
      .field("mm_per_pixel_max", &analyze::LightOnWall::mm_per_pixel_max, "and coarsest direction")
      .field("lux_per_lumen", &analyze::LightOnWall::lux_per_lumen,
             "illuminance for a projector of one lumen");
  depth_of_field.fields_init()
      .field("focus", &analyze::DepthOfField::focus, "depth of the picture's middle")
      .field("near", &analyze::DepthOfField::near,
             "blur is at most one pixel between them; far may be infinite")
      .field("far", &analyze::DepthOfField::far,
             "blur is at most one pixel between them; far may be infinite")
      .field("nearest", &analyze::DepthOfField::nearest,
             "what the picture reaches from, to: opposite corners")
      .field("farthest", &analyze::DepthOfField::farthest,
             "what the picture reaches from, to: opposite corners")
      .field("blur_max_px", &analyze::DepthOfField::blur_max_px, "at those corners");
  projection_plan.fields_init()
      .field("projector", &analyze::ProjectionPlan::projector, "")
      .field("projector_from_wall", &analyze::ProjectionPlan::projector_from_wall, "")
      .field("corners", &analyze::ProjectionPlan::corners,
             "of the lit area on the wall: the picture's top left, top right, bottom right, bottom\n"
             "left")
      .field("middle", &analyze::ProjectionPlan::middle, "where the light of the picture's middle lands")
      .field("mm_per_pixel_min", &analyze::ProjectionPlan::mm_per_pixel_min, "over the picture")
      .field("mm_per_pixel_max", &analyze::ProjectionPlan::mm_per_pixel_max, "over the picture")
      .field("incidence_deg", &analyze::ProjectionPlan::incidence_deg,
             "at the picture's middle and at its worst corner")
      .field("incidence_max_deg", &analyze::ProjectionPlan::incidence_max_deg,
             "at the picture's middle and at its worst corner")
      .field("lux", &analyze::ProjectionPlan::lux, "")
      .field("depth_of_field", &analyze::ProjectionPlan::depth_of_field, "")
      .field("text_height_by_pixels", &analyze::ProjectionPlan::text_height_by_pixels,
             "metres: nine of the coarsest pixels in the target's lit part, or of the picture\n"
             "where there is none")
      .field("text_height_by_eye", &analyze::ProjectionPlan::text_height_by_eye,
             "metres: 16 minutes of arc for the viewer")
      .field("undistorted", &analyze::ProjectionPlan::undistorted,
             "the largest in the lit area, of the target's aspect or else the picture's")
      .field("undistorted_pixel_share", &analyze::ProjectionPlan::undistorted_pixel_share,
             "of the projector's pixels that light it")
      .field("target", &analyze::ProjectionPlan::target, "")
      .field("diagnostics", &analyze::ProjectionPlan::diagnostics, "")
      .method("readable_text_height", &analyze::ProjectionPlan::readable_text_height,
              "The smallest capitals that can be read everywhere in the target, or else in the\n"
              "picture; metres.");
  target_coverage.fields_init()
      .field("rectangle", &analyze::ProjectionPlan::TargetCoverage::rectangle, "")
      .field("covered_share", &analyze::ProjectionPlan::TargetCoverage::covered_share, "of its area, 0..1")
      .field("whole", &analyze::ProjectionPlan::TargetCoverage::whole, "");
  illuminance.fields_init()
      .field("middle", &analyze::ProjectionPlan::Illuminance::middle, "")
      .field("darkest", &analyze::ProjectionPlan::Illuminance::darkest, "")
      .field("brightest", &analyze::ProjectionPlan::Illuminance::brightest, "");
  plan_figure.fields_init()
      .field("name", &analyze::PlanFigure::name, "")
      .field("value", &analyze::PlanFigure::value, "");
  cause.fields_init()
      .field("name", &analyze::Cause::name, "\"rig pose: rotation\", \"delay\", \"calibration\", ...")
      .field("rms_mm", &analyze::Cause::rms_mm, "of this cause alone, over the lit points")
      .field("without_mm", &analyze::Cause::without_mm, "what the surface's rms would be without it");
  sweep.fields_init()
      .field("name", &analyze::Sweep::name, "\"distance\", \"m\"")
      .field("unit", &analyze::Sweep::unit, "\"distance\", \"m\"")
      .field("here", &analyze::Sweep::here, "the value as it is")
      .field("values", &analyze::Sweep::values, "a curve; points without light are omitted")
      .field("rms_mm", &analyze::Sweep::rms_mm, "a curve; points without light are omitted");
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
      .field("grid", &analyze::SurfacePrediction::grid, "nullopt: not lit by the projector's picture")
      .field("corners", &analyze::SurfacePrediction::corners, "(0,0) (1,0) (1,1) (0,1); nullopt: not lit")
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
      .field("drawn_rms_mm", &analyze::SurfacePrediction::drawn_rms_mm, "")
      .field("diagnostics", &analyze::SurfacePrediction::diagnostics,
             "\"grazing\", \"not_lit\", \"first_order\"");
  stated_surface.fields_init()
      .field("name", &analyze::StatedSurface::name, "")
      .field("rig_from_surface", &analyze::StatedSurface::rig_from_surface,
             "left increments, in the rig's frame")
      .field("jacobian_camera", &analyze::StatedSurface::jacobian_camera,
             "A pose that the rig's own camera measured (markers on the surface) errs with the\n"
             "camera's lens and place: d increment / d (parameter_names(camera), six of\n"
             "rig_from_camera), 6 rows. The covariance above is then what comes on top. Empty: the\n"
             "pose comes from elsewhere.")
      .field("tangents", &analyze::StatedSurface::tangents,
             "Of a curved surface: rig_from_tangent for each mark, the plane z = 0 that touches it\n"
             "where the camera sees the mark. They move with the surface. Empty: it is flat.");
  verify_options.fields_init()
      .field("correct", &analyze::VerifyOptions::correct, "")
      .field("bump_rotation_sigma", &analyze::VerifyOptions::bump_rotation_sigma,
             "How far a thing moves when it is bumped, one standard deviation an axis, about its\n"
             "own origin: radians, metres. Movements beyond some five of these are taken for\n"
             "another mistake.")
      .field("bump_position_sigma", &analyze::VerifyOptions::bump_position_sigma,
             "How far a thing moves when it is bumped, one standard deviation an axis, about its\n"
             "own origin: radians, metres. Movements beyond some five of these are taken for\n"
             "another mistake.")
      .field("false_alarm_rate", &analyze::VerifyOptions::false_alarm_rate,
             "Of the alarm, and of naming any mark of a session by mistake.");
  verified_mark.fields_init()
      .field("seen", &analyze::VerifiedMark::seen, "")
      .field("intended", &analyze::VerifiedMark::intended,
             "on the surface, by rig and surface as stated, metres")
      .field("error", &analyze::VerifiedMark::error, "where the light is minus where it was to be, metres")
      .field("covariance", &analyze::VerifiedMark::covariance,
             "of the error when nothing has moved: noise, rig, surface")
      .field("chi2", &analyze::VerifiedMark::chi2, "of the error, two degrees of freedom")
      .field("beyond", &analyze::VerifiedMark::beyond,
             "chi2 beyond what the rate allows for any of the marks")
      .field("error_after", &analyze::VerifiedMark::error_after, "after the correction (or as it is)")
      .field("rejection", &analyze::VerifiedMark::rejection, "why it takes no part; empty when it does");
  movement.fields_init()
      .field("what", &analyze::Movement::what, "the projector's or the surface's name")
      .field("moved", &analyze::Movement::moved,
             "Of the right increment in the thing's own frame, [rotation, translation]: true\n"
             "rig_from_thing = rig_from_thing * exp(moved).")
      .field("covariance", &analyze::Movement::covariance, "")
      .field("rms_after", &analyze::Movement::rms_after, "of the marks' errors when it is undone, metres")
      .field("log_evidence", &analyze::Movement::log_evidence,
             "differences count: the log of the odds between explanations")
      .method("angle", &analyze::Movement::angle, "")
      .method("angle_sigma", &analyze::Movement::angle_sigma, "")
      .method("shift", &analyze::Movement::shift, "")
      .method("shift_sigma", &analyze::Movement::shift_sigma, "");
  verify_result.fields_init()
      .field("surface", &analyze::VerifyResult::surface, "")
      .field("marks", &analyze::VerifyResult::marks, "")
      .field("used", &analyze::VerifyResult::used, "")
      .field("rms", &analyze::VerifyResult::rms, "of the used marks' errors, metres")
      .field("worst", &analyze::VerifyResult::worst, "of the used marks' errors, metres")
      .field("rms_after", &analyze::VerifyResult::rms_after, "with the correction; as above without one")
      .field("worst_after", &analyze::VerifyResult::worst_after, "with the correction; as above without one")
      .field("chi2", &analyze::VerifyResult::chi2, "of the common movement")
      .field("limit", &analyze::VerifyResult::limit, "of the common movement")
      .field("false_alarm_rate", &analyze::VerifyResult::false_alarm_rate,
             "of `limit`, as VerifyOptions gives it")
      .field("degrees_of_freedom", &analyze::VerifyResult::degrees_of_freedom, "")
      .field("alarm", &analyze::VerifyResult::alarm, "chi2 > limit")
      .field("scatter", &analyze::VerifyResult::scatter,
             "Residuals of the marks over their detection sigma, at least 1, and the RMS of what\n"
             "no rigid movement explains, metres.")
      .field("scatter_rms", &analyze::VerifyResult::scatter_rms,
             "Residuals of the marks over their detection sigma, at least 1, and the RMS of what\n"
             "no rigid movement explains, metres.")
      .field("projector_moved", &analyze::VerifyResult::projector_moved, "")
      .field("surface_moved", &analyze::VerifyResult::surface_moved,
             "unless the camera measured the surface in this very view")
      .field("rig", &analyze::VerifyResult::rig,
             "The corrected thing, when that was asked for and the alarm fired. The rig has its\n"
             "covariance brought up to date (a rig without any keeps none).")
      .field("rig_from_surface", &analyze::VerifyResult::rig_from_surface, "")
      .field("diagnostics", &analyze::VerifyResult::diagnostics,
             "Failure \"drift\"; warnings \"cannot_tell_apart\", \"beyond_bump\", \"not_seen\",\n"
             "\"marks_scatter\", \"marks_left_out\", \"marks_beyond\", \"rig_taken_as_exact\",\n"
             "\"surface_taken_as_exact\".");

  function(m, "to_string", &analyze::to_string, "\"externally\", \"by camera\"", py::arg("located"));
  function(m, "predicted_light_errors", &analyze::predicted_light_errors,
           "What the rig's covariance means on the wall. Parameters without a covariance (a\n"
           "camera whose lens was given) are taken as exact. Throws Error(kInput) when the rig\n"
           "carries no covariance of that projector, std::invalid_argument unless distance > 0.",
           py::arg("rig"), py::arg("distance"), py::arg("projector") = "");
  function(m, "true_light_errors", &analyze::true_light_errors,
           "The errors of an estimated rig against the true one, without approximation. The\n"
           "first kind needs both rigs in the same rig frame. Throws Error(kInput) when the two\n"
           "have different devices.",
           py::arg("estimated"), py::arg("truth"), py::arg("distance"), py::arg("projector") = "");
  function(m, "parameters_within_truth", &analyze::parameters_within_truth, "", py::arg("estimated"),
           py::arg("truth"));
  function(m, "predicted_light_error", &analyze::predicted_light_error,
           "Of a surface that is located externally.", py::arg("rig"), py::arg("distance"),
           py::arg("projector") = "");
  function(m, "true_light_error", &analyze::true_light_error, "", py::arg("estimated"), py::arg("truth"),
           py::arg("distance"), py::arg("projector") = "");
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
  function(m, "advise_next_view", &analyze::advise_next_view,
           "Of some four hundred poses (five distances from 0.7 times the nearest so far to 1.3\n"
           "times the farthest, nine positions in the projector's frame, untilted and tilted 35\n"
           "degrees in eight directions) that all devices can use, the one with the smallest\n"
           "predicted error of the given kind on a wall at `wall` metres\n"
           "(calibrate/next_view.hpp). nullopt when none can be used or none reduces the error.",
           py::arg("result"), py::arg("wall"), py::arg("projector") = "",
           py::arg_v("located", analyze::SurfaceLocated::kExternally, "SurfaceLocated.kExternally"));
  function(m, "view_verdicts", &analyze::view_verdicts,
           "A line a view: \"fine\", or what is wrong with it: few points, all points near the\n"
           "image centre, parallel to another view, contributes little.",
           py::arg("result"));
  function(m, "isotropic_pose_covariance", &analyze::isotropic_pose_covariance,
           "Position and rotation each alike in all directions and independent: sigma_position\n"
           "metres, sigma_rotation radians, about the thing's own origin. Throws\n"
           "std::invalid_argument for a negative sigma or NaN.",
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
  function(
      m, "light_path",
      py::overload_cast<const RigProjector&, const std::string&, const Pose&, const std::optional<Pose>&>(
          &analyze::light_path),
      "`frame` is the surface's: \"world\", \"rig\" or \"projector\" (core/surface/surface.hpp).\n"
      "Throws Error(kInput) for another frame, or \"world\" without the rig's pose.",
      py::arg("projector"), py::arg("frame"), py::arg("frame_from_surface"),
      py::arg("world_from_rig") = py::none());
  function(m, "light_path", py::overload_cast<const RigProjector&, const Plane&>(&analyze::light_path),
           "A wall in the rig's frame. The surface's origin is the wall's point nearest to the\n"
           "rig's; its axes lie in the wall, z into it.",
           py::arg("projector"), py::arg("wall_in_rig"));
  function(m, "landing_place", &analyze::landing_place,
           "Where the light of a pixel lands on the surface, metres along its x and y; nullopt\n"
           "when it misses.",
           py::arg("path"), py::arg("pixel"));
  function(m, "landing_error", &analyze::landing_error,
           "nullopt where no light of the projector can reach the point, or the drive takes it\n"
           "away from the surface. Throws Error(kInput) when the calibration's covariance lacks\n"
           "the projector, std::invalid_argument for covariances that are not symmetric,\n"
           "positive semidefinite and finite, or a negative sigma.",
           py::arg("path"), py::arg("sources"), py::arg("on_surface"));
  function(m, "region95", &analyze::region95, "", py::arg("covariance"));
  function(m, "monte_carlo_landing", &analyze::monte_carlo_landing,
           "One spread a point of the surface, from the same draws: they correlate as they do in\n"
           "the room. nullopt for a point that no light reaches in the chain as it is believed\n"
           "to be. Throws as landing_error() does, and std::invalid_argument unless draws >= 2.",
           py::arg("path"), py::arg("sources"), py::arg("on_surface"),
           py::arg_v("options", analyze::MonteCarloOptions{}, "MonteCarloOptions()"));
  function(m, "projector_of", &analyze::projector_of,
           "The projector that the data sheet describes. Throws Error(kInput) for values that no\n"
           "projector has.",
           py::arg("sheet"));
  function(m, "pose_before_wall", &analyze::pose_before_wall,
           "projector_from_wall of a projector whose lens is `distance` metres from the wall.\n"
           "The wall's origin is then the foot of the lens, where a plumb line from the lens\n"
           "meets the wall. Turned from looking straight at the wall, radians: first `yaw` to\n"
           "its right, then `pitch` upwards, then `roll` clockwise as seen from behind it.\n"
           "Throws Error(kInput) unless the distance is positive and the angles are finite.",
           py::arg("distance"), py::arg("yaw") = 0, py::arg("pitch") = 0, py::arg("roll") = 0);
  function(m, "light_on_wall", &analyze::light_on_wall,
           "nullopt where the light misses the wall. The projector's lens must have no\n"
           "distortion and no skew, as projector_of() makes it.",
           py::arg("projector"), py::arg("projector_from_wall"), py::arg("pixel"));
  function(m, "plan_projection", &analyze::plan_projection,
           "Diagnostics, all warnings: \"grazing\" (incidence above 70 degrees somewhere),\n"
           "\"target_not_covered\", \"text_unreadable\", \"out_of_focus\" (a corner outside the depth\n"
           "of field); note \"depth_of_field_unknown\" when only one of f-number and focal length\n"
           "is given.\n"
           "\n"
           "Throws Error(kInput) for values that are not finite or not positive and for a lens\n"
           "in or behind the wall, Error(kDegenerate) when the light of the picture or of a\n"
           "corner never meets the wall.",
           py::arg("sheet"), py::arg("site"));
  function(m, "figures_of", &analyze::figures_of, "", py::arg("plan"));
  function(m, "predict_surface", &analyze::predict_surface,
           "`plane_from_content` takes (u, v, 1) to metres on the surface (PlacedPlane). `draws`\n"
           "> 0 asks for Monte Carlo beside the closed form. Throws as landing_error() does, and\n"
           "Error(kDegenerate) when the projector's picture lights no point of the content.",
           py::arg("name"), py::arg("path"), py::arg("plane_from_content"), py::arg("sources"),
           py::arg("draws") = py::none());
  function(m, "verify", &analyze::verify,
           "Throws Error: kInput when no light of projector or camera can reach the surface as\n"
           "it is stated (behind them, parallel), and for a correction far beyond the bump's\n"
           "sigmas (another pattern, a scaled picture); kNotEnoughData for fewer than eight\n"
           "marks; kDegenerate when the marks contradict each other, when they lie on one line,\n"
           "and when the marks say that the other thing has moved (odds above 1000 to 1);\n"
           "kNotConverged. std::invalid_argument for sigmas and rates out of range, and\n"
           "covariances that are none.",
           py::arg("rig"), py::arg("camera"), py::arg("projector"), py::arg("surface"), py::arg("marks"),
           py::arg_v("options", analyze::VerifyOptions{}, "VerifyOptions()"));

  function(
      m, "rank_causes",
      [](const std::vector<analyze::LandingError>& points) {
        std::vector<const analyze::LandingError*> pointers;
        for (const analyze::LandingError& point : points) pointers.push_back(&point);
        return analyze::rank_causes(pointers);
      },
      "Every source, or its parts, over the points: largest first. Throws\n"
      "std::invalid_argument without points, and for points of different sources.",
      py::arg("points"));
}

}  // namespace procam::python
