// procam.analyze: a projection planned, and one verified
#include "procam/analyze.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_site(py::module_& m) {
  Record<analyze::DataSheet> data_sheet(
      m, "DataSheet", "As printed by the maker; of a zoom lens, the values at the zoom that is meant.");
  data_sheet.fields_init()
      .field("resolution", &analyze::DataSheet::resolution, "")
      .field("throw_ratio", &analyze::DataSheet::throw_ratio, "distance over picture width")
      .field("lens_shift", &analyze::DataSheet::lens_shift,
             "as Projector::lens_shift(): (0, 0.5): the axis at the bottom edge")
      .field("lumens", &analyze::DataSheet::lumens, "of a white picture")
      .field("f_number", &analyze::DataSheet::f_number, "for the depth of field, with")
      .field("focal_length", &analyze::DataSheet::focal_length, "metres");

  Record<analyze::WallRectangle> wall_rectangle(m, "WallRectangle",
                                                "A rectangle parallel to the wall's axes.");
  wall_rectangle.fields_init()
      .field("centre", &analyze::WallRectangle::centre, "metres")
      .field("size", &analyze::WallRectangle::size, "metres")
      .method("corners", &analyze::WallRectangle::corners, "Top left, top right, bottom right, bottom left.");

  Record<analyze::WallTarget> wall_target(m, "WallTarget", "What shall be covered.");
  wall_target.fields_init()
      .field("size", &analyze::WallTarget::size, "metres")
      .field("centre", &analyze::WallTarget::centre,
             "absent: wherever it fits best, at the centre of the largest rectangle");

  Record<analyze::Site> site(m, "Site", "Where the projector stands, and what for.");
  site.fields_init()
      .field("projector_from_wall", &analyze::Site::projector_from_wall, "")
      .field("target", &analyze::Site::target, "")
      .field("viewer_distance", &analyze::Site::viewer_distance, "metres from the reader's eyes to the wall")
      .field("text_height", &analyze::Site::text_height, "of the capitals that are to be read, metres");

  function(m, "projector_of", &analyze::projector_of,
           "The projector that the data sheet describes. Raises Error(kInput) for values that no\n"
           "projector has.",
           py::arg("sheet"));
  function(m, "pose_before_wall", &analyze::pose_before_wall,
           "projector_from_wall of a projector whose lens is `distance` metres from the wall.\n"
           "The wall's origin is then the foot of the lens, where a plumb line from the lens\n"
           "meets the wall. Turned from looking straight at the wall, radians: first `yaw` to\n"
           "its right, then `pitch` upwards, then `roll` clockwise as seen from behind it.\n"
           "Raises Error(kInput) unless the distance is positive and the angles are finite.",
           py::arg("distance"), py::arg("yaw") = 0, py::arg("pitch") = 0, py::arg("roll") = 0);
}

void bind_plan_parts(py::module_& m) {
  Record<analyze::LightOnWall> light_on_wall(m, "LightOnWall", "Where one pixel's light lands, and how.");
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

  Record<analyze::DepthOfField> depth_of_field(
      m, "DepthOfField",
      "The lens focused on the middle of the picture. That is the best place: 1 / depth\n"
      "changes evenly over the picture, so the nearest and the farthest corner are blurred\n"
      "alike. Depths along the optical axis, metres.");
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

  Record<analyze::PlanFigure> plan_figure(
      m, "PlanFigure", "The figures as people read them: a name and a value a line, ASCII.");
  plan_figure.fields_init()
      .field("name", &analyze::PlanFigure::name, "")
      .field("value", &analyze::PlanFigure::value, "");

  function(m, "light_on_wall", &analyze::light_on_wall,
           "None where the light misses the wall. The projector's lens must have no\n"
           "distortion and no skew, as projector_of() makes it.",
           py::arg("projector"), py::arg("projector_from_wall"), py::arg("pixel"));
}

void bind_projection_plan(py::module_& m) {
  Record<analyze::ProjectionPlan> projection_plan(
      m, "ProjectionPlan", "What a projector covers from one place: pixels, light, targets.");
  Record<analyze::ProjectionPlan::TargetCoverage> target_coverage(projection_plan.type, "TargetCoverage",
                                                                  "How much of a target is covered.");
  Record<analyze::ProjectionPlan::Illuminance> illuminance(
      projection_plan.type, "Illuminance", "Lux, on the wall. The extremes lie at corners of the picture.");
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
      .field("middle", &analyze::ProjectionPlan::Illuminance::middle, "lux")
      .field("darkest", &analyze::ProjectionPlan::Illuminance::darkest, "lux")
      .field("brightest", &analyze::ProjectionPlan::Illuminance::brightest, "lux");

  function(m, "plan_projection", &analyze::plan_projection,
           "Diagnostics, all warnings: \"grazing\" (incidence above 70 degrees somewhere),\n"
           "\"target_not_covered\", \"text_unreadable\", \"out_of_focus\" (a corner outside the depth\n"
           "of field); note \"depth_of_field_unknown\" when only one of f-number and focal length\n"
           "is given.\n"
           "\n"
           "Raises Error(kInput) for values that are not finite or not positive and for a lens\n"
           "in or behind the wall, Error(kDegenerate) when the light of the picture or of a\n"
           "corner never meets the wall.",
           py::arg("sheet"), py::arg("site"));
  function(m, "figures_of", &analyze::figures_of, "The figures as people read them: a name and a value each.",
           py::arg("plan"));
}

void bind_verify_input(py::module_& m) {
  Enum<analyze::Correct>(m, "Correct", "What verify() corrects.")
      .value("kNothing", analyze::Correct::kNothing)
      .value("kProjector", analyze::Correct::kProjector)
      .value("kSurface", analyze::Correct::kSurface);

  Record<analyze::StatedSurface> stated_surface(
      m, "StatedSurface",
      "Where the surface stands (x, y on it, z into the wall) and how well that is known.");
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

  Record<analyze::VerifyOptions> verify_options(m, "VerifyOptions",
                                                "What verify() assumes, and which limits it checks.");
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
}

void bind_verified_marks(py::module_& m) {
  Record<analyze::VerifiedMark> verified_mark(m, "VerifiedMark",
                                              "One mark: where it is and where it should be.");
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

  Record<analyze::Movement> movement(m, "Movement", "One explanation: this thing alone has moved.");
  movement.fields_init()
      .field("what", &analyze::Movement::what, "the projector's or the surface's name")
      .field("moved", &analyze::Movement::moved,
             "Of the right increment in the thing's own frame, [rotation, translation]: true\n"
             "rig_from_thing = rig_from_thing * exp(moved).")
      .field("covariance", &analyze::Movement::covariance, "rotation (radians), translation (metres)")
      .field("rms_after", &analyze::Movement::rms_after, "of the marks' errors when it is undone, metres")
      .field("log_evidence", &analyze::Movement::log_evidence,
             "differences count: the log of the odds between explanations")
      .method("angle", &analyze::Movement::angle, "Radians.")
      .method("angle_sigma", &analyze::Movement::angle_sigma, "Standard deviation, radians.")
      .method("shift", &analyze::Movement::shift, "Metres.")
      .method("shift_sigma", &analyze::Movement::shift_sigma, "Standard deviation, metres.");
}

void bind_verify_result(py::module_& m) {
  Record<analyze::VerifyResult> verify_result(
      m, "VerifyResult", "The error of marks on a surface, and the movement that explains it.");
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

  function(m, "verify", &analyze::verify,
           "Raises Error: kInput when no light of projector or camera can reach the surface as\n"
           "it is stated (behind them, parallel), and for a correction far beyond the bump's\n"
           "sigmas (another pattern, a scaled picture); kNotEnoughData for fewer than eight\n"
           "marks; kDegenerate when the marks contradict each other, when they lie on one line,\n"
           "and when the marks say that the other thing has moved (odds above 1000 to 1);\n"
           "kNotConverged. ValueError for sigmas and rates out of range, and\n"
           "covariances that are none.",
           py::arg("rig"), py::arg("camera"), py::arg("projector"), py::arg("surface"), py::arg("marks"),
           py::arg_v("options", analyze::VerifyOptions{}, "VerifyOptions()"));
}

}  // namespace

void bind_analyze_projection(py::module_& m) {
  bind_site(m);
  bind_plan_parts(m);
  bind_projection_plan(m);
  bind_verify_input(m);
  bind_verified_marks(m);
  bind_verify_result(m);
}

}  // namespace procam::python
