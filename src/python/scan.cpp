// procam.scan
#include "procam/scan.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_measure(py::module_& m) {
  Record<scan::ScanOptions> scan_options(m, "ScanOptions",
                                         "How light becomes depth, and which pixels are kept.");
  scan_options.fields_init()
      .field("consistency_sigmas", &scan::ScanOptions::consistency_sigmas,
             "limit for columns and rows that disagree")
      .field("nearest", &scan::ScanOptions::nearest, "metres")
      .field("farthest", &scan::ScanOptions::farthest, "metres")
      .field("max_sigma", &scan::ScanOptions::max_sigma, "metres")
      .field("min_patch", &scan::ScanOptions::min_patch, "pixels")
      .field("threads", &scan::ScanOptions::threads, "0: as many as the machine has");

  Record<scan::ScanCounts> scan_counts(
      m, "ScanCounts", "Pixels that have light of both axes, and why some of them have no depth.");
  scan_counts.fields_init()
      .field("lit", &scan::ScanCounts::lit, "")
      .field("measured", &scan::ScanCounts::measured, "with a depth")
      .field("inconsistent", &scan::ScanCounts::inconsistent, "column and row do not meet the ray")
      .field("out_of_range", &scan::ScanCounts::out_of_range, "")
      .field("isolated", &scan::ScanCounts::isolated, "");

  Record<scan::RigModes> rig_modes(m, "RigModes",
                                   "How the points of a scan move with the rig, to first order.");
  rig_modes.fields_init()
      .field("names", &scan::RigModes::names, "of the rig's parameters, the rows of root")
      .field("root", &scan::RigModes::root, "root root^T is the rig's covariance")
      .field("columns", &scan::RigModes::columns, "cells")
      .field("rows", &scan::RigModes::rows, "cells")
      .field("nodes", &scan::RigModes::nodes, "by cell: depth, then 4 numbers for each column of root");
  rig_modes.type.def("count", &scan::RigModes::count, "Columns of root.");

  Record<scan::Scan> scan(m, "Scan", "What one camera measured by one projector's light.");
  scan.fields_init()
      .field("camera", &scan::Scan::camera, "")
      .field("projector", &scan::Scan::projector, "its name")
      .field("depth", &scan::Scan::depth, "float32 (h, w): z in the camera's frame, metres; 0: not measured")
      .field("sigma", &scan::Scan::sigma, "float32 (h, w): of the depth, by the light's noise, metres")
      .field("rig_sigma", &scan::Scan::rig_sigma,
             "float32 (h, w): of the depth, by the rig's covariance, metres")
      .field("rig_modes", &scan::Scan::rig_modes, "the same for each parameter of the rig")
      .field("counts", &scan::Scan::counts, "")
      .field("consistency", &scan::Scan::consistency, "1 when rig and light agree")
      .field("consistency_px", &scan::Scan::consistency_px, "RMS of the disagreement, projector pixels")
      .field("consistency_px_of_rig", &scan::Scan::consistency_px_of_rig,
             "the part of it that the rig's covariance predicts")
      .field("misfit_sigma", &scan::Scan::misfit_sigma,
             "float32 (h, w): of the depth, by the unexplained part of it, metres; empty: none")
      .field("diagnostics", &scan::Scan::diagnostics, "");
  scan.type
      .def(
          "measured",
          [](const scan::Scan& self, int x, int y) {
            require_pixel(self.depth.size(), x, y, "Scan.measured");
            return self.measured(x, y);
          },
          "Has camera pixel (x, y) a depth?", py::arg("x"), py::arg("y"))
      .def(
          "total_sigma",
          [](const scan::Scan& self, int x, int y) {
            require_pixel(self.sigma.size(), x, y, "Scan.total_sigma");
            require_pixel(self.rig_sigma.size(), x, y, "Scan.total_sigma");
            if (!self.misfit_sigma.empty()) require_pixel(self.misfit_sigma.size(), x, y, "Scan.total_sigma");
            return self.total_sigma(x, y);
          },
          "Of all parts, metres.", py::arg("x"), py::arg("y"));

  function(m, "pixel_rays", &scan::pixel_rays,
           "float32 (h, w, 2): each camera pixel's (a, b) with the ray (a, b, 1).", py::arg("camera"),
           py::arg("threads") = 0);
  function(m, "measure_depth", &scan::measure_depth,
           "The depth of what each camera pixel sees, with its standard deviation. Raises\n"
           "Error(kInput), Error(kDegenerate), Error(kNotEnoughData).",
           py::arg("light"), py::arg("rig"), py::arg("camera") = "", py::arg("projector") = "",
           py::arg_v("options", scan::ScanOptions{}, "ScanOptions()"));
  function(m, "point_cloud", &scan::point_cloud, "The measured points in the rig's frame, with normals.",
           py::arg("scan"));
}

void bind_mesh(py::module_& m) {
  Record<scan::MeshOptions> mesh_options(m, "MeshOptions", "How depths become triangles.");
  mesh_options.fields_init()
      .field("max_deviation", &scan::MeshOptions::max_deviation, "metres")
      .field("max_sigmas", &scan::MeshOptions::max_sigmas,
             "largest step between neighbours, standard deviations")
      .field("min_angle", &scan::MeshOptions::min_angle, "radians")
      .field("max_hole", &scan::MeshOptions::max_hole, "pixels along x or y that are bridged; 0: none");

  function(m, "mesh_of", &scan::mesh_of,
           "A mesh in the rig's frame that keeps edges and holes. Raises Error(kNotEnoughData).",
           py::arg("scan"), py::arg_v("options", scan::MeshOptions{}, "MeshOptions()"));
}

void bind_scan_error(py::module_& m) {
  Record<scan::ScanError> scan_error(m, "ScanError",
                                     "How far a scan is off where the truth is known, metres.");
  scan_error.fields_init()
      .field("compared", &scan::ScanError::compared, "")
      .field("rms", &scan::ScanError::rms, "along the true surface's normal, without outliers")
      .field("median", &scan::ScanError::median, "of its absolute value")
      .field("expected_rms", &scan::ScanError::expected_rms, "as the standard deviations predict it, metres")
      .field("noise_rms", &scan::ScanError::noise_rms, "the part of the light's noise in it, metres")
      .field("inside_3_sigma", &scan::ScanError::inside_3_sigma,
             "share of the pixels within three standard deviations, 0 .. 1")
      .field("outliers", &scan::ScanError::outliers, "share of the pixels, 0 .. 1");

  Record<scan::TrueView> true_view(m, "TrueView", "Depths that a camera would measure without error.");
  true_view.fields_init()
      .field("camera", &scan::TrueView::camera, "")
      .field("world_from_camera", &scan::TrueView::world_from_camera, "")
      .field("depth", &scan::TrueView::depth, "float32 (h, w), metres; 0: unknown");

  Record<scan::ViewerAngle> viewer_angle(m, "ViewerAngle",
                                         "The angle that 95 % of the points are within, radians.");
  viewer_angle.fields_init()
      .field("median", &scan::ViewerAngle::median, "half of the rigs with this covariance are within")
      .field("of_95", &scan::ViewerAngle::of_95, "95 % of the rigs are within");

  Record<scan::ViewerError> viewer_error(
      m, "ViewerError", "How far content is off for a viewer's eye, as the rig's covariance predicts it.");
  viewer_error.fields_init()
      .field("points", &scan::ViewerError::points, "0: the rig has no covariance")
      .field("given", &scan::ViewerError::given, "for positions that are given in the rig's frame")
      .field("placed", &scan::ViewerError::placed,
             "for an eye and content that were placed by the scan: without the common rigid motion")
      .field("diagnostics", &scan::ViewerError::diagnostics,
             "viewer_off: more than a pixel of a viewer's image in more than 5 % of the rigs");
  function(m, "viewer_error", &scan::viewer_error,
           "By 400 rigs drawn from the covariance, always the same ones. Raises\n"
           "ValueError for an eye that is not finite.",
           py::arg("scan"), py::arg("eye_in_rig"));

  function(m, "compare", py::overload_cast<const scan::Scan&, ViewF>(&scan::compare),
           "Depths against the true ones, float32 (h, w), metres.", py::arg("scan"), py::arg("true_depth"));
  function(m, "compare",
           py::overload_cast<const PointCloud&, const std::vector<scan::TrueView>&>(&scan::compare),
           "Points in the world against the true surfaces, along their normals.", py::arg("cloud"),
           py::arg("truth"));
}

void bind_stations(py::module_& m) {
  Record<scan::Station> station(m, "Station", "The scans of one rig at one position.");
  station.fields_init()
      .field("name", &scan::Station::name, "")
      .field("scans", &scan::Station::scans, "")
      .field("world_from_rig", &scan::Station::world_from_rig, "where the rig is known to be, or None");

  Record<scan::RegistrationOptions> options(m, "RegistrationOptions", "How stations are aligned.");
  options.fields_init()
      .field("refine", &scan::RegistrationOptions::refine, "False: the known poses are kept")
      .field("max_turn", &scan::RegistrationOptions::max_turn, "radians, without known poses")
      .field("max_move", &scan::RegistrationOptions::max_move, "metres, without known poses")
      .field("min_overlap", &scan::RegistrationOptions::min_overlap, "share of the points")
      .field("min_normal_motion", &scan::RegistrationOptions::min_normal_motion,
             "motion along the normals for a unit motion, below which a direction is unobservable")
      .field("max_position_sigma", &scan::RegistrationOptions::max_position_sigma, "metres")
      .field("max_angle_sigma", &scan::RegistrationOptions::max_angle_sigma, "radians")
      .field("max_points", &scan::RegistrationOptions::max_points, "of each pair of stations")
      .field("threads", &scan::RegistrationOptions::threads, "0: as many as the machine has");

  Record<scan::RegisteredStation> registered(m, "RegisteredStation", "One station's pose, with covariance.");
  registered.fields_init()
      .field("name", &scan::RegisteredStation::name, "")
      .field("pose", &scan::RegisteredStation::pose, "world_from_rig")
      .field("unobservable", &scan::RegisteredStation::unobservable,
             "directions that only the known pose fixes");

  Record<scan::StationPair> pair(m, "StationPair", "Two stations that see surfaces in common.");
  pair.fields_init()
      .field("first", &scan::StationPair::first, "")
      .field("second", &scan::StationPair::second, "")
      .field("points", &scan::StationPair::points, "common points in the solve")
      .field("overlap", &scan::StationPair::overlap, "share of the points")
      .field("rms", &scan::StationPair::rms, "of the residuals, metres");

  Record<scan::Registration> registration(m, "Registration", "All stations' poses, and how well they fit.");
  registration.fields_init()
      .field("stations", &scan::Registration::stations, "")
      .field("pairs", &scan::Registration::pairs, "")
      .field("rig_error", &scan::Registration::rig_error, "c of RigModes")
      .field("covariance", &scan::Registration::covariance, "of all poses (6 each), then of c")
      .field("noise_factor", &scan::Registration::noise_factor, "residuals over their expected size")
      .field("has_known_poses", &scan::Registration::has_known_poses, "")
      .field("diagnostics", &scan::Registration::diagnostics, "");

  function(m, "register_stations", &scan::register_stations,
           "The poses of all stations by the surfaces that they see in common. Raises\n"
           "Error(kNotEnoughData), Error(kDegenerate), Error(kNotConverged).",
           py::arg("stations"), py::arg_v("options", scan::RegistrationOptions{}, "RegistrationOptions()"));
}

void bind_merge(py::module_& m) {
  Record<scan::MergeOptions> options(m, "MergeOptions",
                                     "How the points of several stations become one mesh.");
  options.fields_init()
      .field("mesh", &scan::MergeOptions::mesh, "")
      .field("max_sigmas", &scan::MergeOptions::max_sigmas,
             "points of one surface: standard deviations apart")
      .field("max_distance", &scan::MergeOptions::max_distance, "or metres apart")
      .field("threads", &scan::MergeOptions::threads, "0: as many as the machine has");

  Record<scan::FusedScan> fused(m, "FusedScan", "One scan of one station, in the world.");
  fused.fields_init()
      .field("station", &scan::FusedScan::station, "")
      .field("scan", &scan::FusedScan::scan, "all measured pixels, fused")
      .field("kept", &scan::FusedScan::kept, "of the surfaces that no other station sees better");

  Record<scan::MergedStations> merged(m, "MergedStations", "The mesh of all stations; metres.");
  merged.fields_init()
      .field("scans", &scan::MergedStations::scans, "")
      .field("cloud", &scan::MergedStations::cloud, "sigma is along the normal")
      .field("cloud_station", &scan::MergedStations::cloud_station, "of each point")
      .field("mesh", &scan::MergedStations::mesh, "")
      .field("fused_share", &scan::MergedStations::fused_share,
             "share of the pixels that two stations or more see, 0 .. 1")
      .field("gap_before", &scan::MergedStations::gap_before, "metres")
      .field("gap_expected", &scan::MergedStations::gap_expected, "metres")
      .field("contradictions", &scan::MergedStations::contradictions, "pixels")
      .field("diagnostics", &scan::MergedStations::diagnostics, "");

  function(m, "merge_stations", &scan::merge_stations, "One cloud and one mesh of all stations.",
           py::arg("stations"), py::arg("registration"),
           py::arg_v("options", scan::MergeOptions{}, "MergeOptions()"));
}

}  // namespace

void bind_scan(py::module_& m) {
  bind_measure(m);
  bind_mesh(m);
  bind_scan_error(m);
  bind_stations(m);
  bind_merge(m);
}

}  // namespace procam::python
