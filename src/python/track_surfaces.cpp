// procam.track: surfaces that move
#include "bind.hpp"
#include "components.hpp"
#include "procam/track/sight_plane.hpp"
#include "procam/track/sight_surface.hpp"

namespace procam::python {

namespace {

void bind_sight_plane(py::module_& m) {
  Record<track::SightPlaneOptions>(m, "SightPlaneOptions", "What counts as one plane.")
      .fields_init()
      .field("min_share", &track::SightPlaneOptions::min_share,
             "of the points that must be on the plane, 0.5 .. 1")
      .field("max_noise_px", &track::SightPlaneOptions::max_noise_px,
             "standard deviation of the residuals above which the surface is no plane")
      .field("max_tilt_sigma", &track::SightPlaneOptions::max_tilt_sigma,
             "of the normal's direction, radians, above which the points do not determine the plane")
      .field("min_points", &track::SightPlaneOptions::min_points,
             "of sight_planes(): points on each plane, 4 at least");
  Record<track::PlaneSighting>(m, "PlaneSighting", "A wall or a floor by the light of the rig's projector.")
      .fields_init()
      .field("plane_from_rig", &track::PlaneSighting::plane_from_rig,
             "z the normal, towards the camera. Tilt about x and y, and z, count with their part of\n"
             "the covariance; the other variances are 1.")
      .field("chi2_per_dof", &track::PlaneSighting::chi2_per_dof, "two residuals a point, three unknowns")
      .field("across_px", &track::PlaneSighting::across_px,
             "RMS of the residuals across the epipolar lines, pixels")
      .field("used", &track::PlaneSighting::used, "points")
      .field("rejected", &track::PlaneSighting::rejected, "indices into the points");
  function(m, "sight_plane", &track::sight_plane,
           "The plane that the light falls on, from one image: of each point the projector pixel,\n"
           "the camera pixel and its covariance count. Raises Error(kNotEnoughData), and\n"
           "Error(kDegenerate) for a view that shows no plane or does not determine it.",
           py::arg("points"), py::arg("camera"), py::arg("projector"),
           py::arg_v("options", track::SightPlaneOptions{}, "SightPlaneOptions()"));
  function(m, "sight_planes", &track::sight_planes,
           "Light on several planes, the one with the most points first: a corner of a room,\n"
           "furniture. Raises the errors of sight_plane().",
           py::arg("points"), py::arg("camera"), py::arg("projector"),
           py::arg_v("options", track::SightPlaneOptions{}, "SightPlaneOptions()"));
}

}  // namespace

void bind_track_surfaces(py::module_& m) {
  bind_sight_plane(m);
  Record<track::SightOptions>(m, "SightOptions", "How the pose of a surface is found by its markers.")
      .fields_init()
      .field("locate", &track::SightOptions::locate,
             "`largest_odds`: of a second pose from which on it is given.")
      .field("max_chi2_per_dof", &track::SightOptions::max_chi2_per_dof,
             "A fit worse than this is refused: light across the edges, another print, or a marker\n"
             "that is no marker.");
  Record<track::PoseCandidate>(m, "PoseCandidate", "One of the poses that fit an image.")
      .fields_init()
      .field("pose", &track::PoseCandidate::pose, "")
      .field("chi2", &track::PoseCandidate::chi2, "above that of the best candidate");
  Record<track::ChosenPose>(m, "ChosenPose",
                            "Which candidate was chosen, and how likely another one is the true one.")
      .fields_init()
      .field("index", &track::ChosenPose::index, "of the candidate")
      .field("odds", &track::ChosenPose::odds, "that another one is the true one, 0 .. 1");
  Record<track::PoseChooserOptions>(m, "PoseChooserOptions", "How evidence of several images is added up.")
      .fields_init()
      .field("forget_after", &track::PoseChooserOptions::forget_after,
             "seconds without an image, after which all is open again")
      .field("independent_after", &track::PoseChooserOptions::independent_after,
             "seconds between images whose errors are independent")
      .field("max_evidence", &track::PoseChooserOptions::max_evidence, "largest chi-square of one image")
      .field("acceleration", &track::PoseChooserOptions::acceleration,
             "what the plane can do, one sigma, m/s^2")
      .field("turn_acceleration", &track::PoseChooserOptions::turn_acceleration, "the same, rad/s^2");
  Record<track::PoseChooser>(
      m, "PoseChooser", "Which of two similar poses of a plane is the true one, from a sequence of images.")
      .init([](const track::PoseChooserOptions& options) { return track::PoseChooser(options); }, "",
            py::arg_v("options", track::PoseChooserOptions{}, "PoseChooserOptions()"))
      .method("choose", &track::PoseChooser::choose, "The most probable of an image's candidates.",
              py::arg("time"), py::arg("candidates"));
  Record<track::SurfaceSighting>(m, "SurfaceSighting",
                                 "A surface's pose in one image, by its markers: one or two candidates.")
      .fields_init()
      .field("poses", &track::SurfaceSighting::poses,
             "rig_from_surface of one or two poses that fit, the best first")
      .field("row", &track::SurfaceSighting::row,
             "mean image row of the corners of the markers used, pixels: a rolling shutter's time")
      .field("markers", &track::SurfaceSighting::markers, "used")
      .field("chi2_per_dof", &track::SurfaceSighting::chi2_per_dof, "of the fit");
  Record<track::Hinge>(m, "Hinge", "A surface that rotates about a fixed axis: a door.")
      .fields_init()
      .field("rig_from_closed", &track::Hinge::rig_from_closed, "the surface at the angle 0")
      .field("point", &track::Hinge::point, "of the axis, in the surface's frame")
      .field("direction", &track::Hinge::direction, "of the axis, in the surface's frame: a unit vector")
      .field("position_sigma", &track::Hinge::position_sigma,
             "how well the axis is known, one standard deviation, metres")
      .field("angle_sigma", &track::Hinge::angle_sigma, "the same, radians");
  Record<track::HingedPose>(m, "HingedPose",
                            "The pose on a hinge that is nearest to the one seen, and its angle.")
      .fields_init()
      .field("rig_from_surface", &track::HingedPose::rig_from_surface, "")
      .field("angle", &track::HingedPose::angle, "radians, -pi .. pi")
      .field("chi2", &track::HingedPose::chi2,
             "Of what the hinge does not permit, 5 degrees of freedom: large where the axis is wrong,\n"
             "or the surface another one.");
  function(m, "sight_surface", &track::sight_surface,
           "The poses of a surface that carries markers, from one image. Raises what locate() throws,\n"
           "but for a second pose; Error(kDegenerate) for a fit beyond `max_chi2_per_dof`.",
           py::arg("detections"), py::arg("camera"), py::arg("map"),
           py::arg_v("options", track::SightOptions{}, "SightOptions()"));
  function(m, "on_hinge", &track::on_hinge, "The pose on the hinge that is nearest to the one seen.",
           py::arg("rig_from_seen"), py::arg("hinge"));
}

}  // namespace procam::python
