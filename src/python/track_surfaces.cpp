// procam.track: surfaces that move
#include "bind.hpp"
#include "components.hpp"
#include "procam/track/sight_surface.hpp"

namespace procam::python {

void bind_track_surfaces(py::module_& m) {
  Record<track::SightOptions>(m, "SightOptions", "")
      .fields_init()
      .field("locate", &track::SightOptions::locate,
             "`largest_odds`: odds of the second pose above which the previous sighting decides.")
      .field("max_chi2_per_dof", &track::SightOptions::max_chi2_per_dof,
             "A fit worse than this is refused: light across the edges, another print, or a marker\n"
             "that is no marker.");
  Record<track::SurfaceSighting>(m, "SurfaceSighting", "")
      .fields_init()
      .field("rig_from_surface", &track::SurfaceSighting::rig_from_surface, "")
      .field("row", &track::SurfaceSighting::row,
             "mean image row of the corners of the markers used, pixels: a rolling shutter's time")
      .field("markers", &track::SurfaceSighting::markers, "used")
      .field("by_previous", &track::SurfaceSighting::by_previous, "the image alone left two poses")
      .field("chi2_per_dof", &track::SurfaceSighting::chi2_per_dof, "of the fit");
  Record<track::Hinge>(m, "Hinge", "A surface that rotates about a fixed axis: a door.")
      .fields_init()
      .field("rig_from_closed", &track::Hinge::rig_from_closed, "the surface at the angle 0")
      .field("point", &track::Hinge::point, "of the axis, in the surface's frame")
      .field("direction", &track::Hinge::direction, "of the axis, in the surface's frame: a unit vector")
      .field("position_sigma", &track::Hinge::position_sigma,
             "how well the axis is known, one standard deviation, metres")
      .field("angle_sigma", &track::Hinge::angle_sigma, "the same, radians");
  Record<track::HingedPose>(m, "HingedPose", "")
      .fields_init()
      .field("rig_from_surface", &track::HingedPose::rig_from_surface, "")
      .field("angle", &track::HingedPose::angle, "radians, -pi .. pi")
      .field("chi2", &track::HingedPose::chi2,
             "Of what the hinge does not permit, 5 degrees of freedom: large where the axis is wrong,\n"
             "or the surface another one.");
  function(m, "sight_surface", &track::sight_surface,
           "The pose of a surface that carries markers, from one image. Throws what locate() throws;\n"
           "Error(kDegenerate) as well where two poses fit and the previous one does not decide, and\n"
           "for a fit beyond `max_chi2_per_dof`.",
           py::arg("detections"), py::arg("camera"), py::arg("map"), py::arg("previous") = py::none(),
           py::arg_v("options", track::SightOptions{}, "SightOptions()"));
  function(m, "on_hinge", &track::on_hinge, "The pose on the hinge that is nearest to the one seen.",
           py::arg("rig_from_seen"), py::arg("hinge"));
}

}  // namespace procam::python
