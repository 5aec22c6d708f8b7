// procam.scan
#include "procam/scan.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_measure(py::module_& m) {
  Record<scan::ScanOptions> scan_options(m, "ScanOptions", "");
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
      .field("measured", &scan::ScanCounts::measured, "")
      .field("inconsistent", &scan::ScanCounts::inconsistent, "column and row do not meet the ray")
      .field("out_of_range", &scan::ScanCounts::out_of_range, "")
      .field("isolated", &scan::ScanCounts::isolated, "");

  Record<scan::Scan> scan(m, "Scan", "What one camera measured by one projector's light.");
  scan.fields_init()
      .field("camera", &scan::Scan::camera, "")
      .field("projector", &scan::Scan::projector, "its name")
      .field("depth", &scan::Scan::depth, "float32 (h, w): z in the camera's frame, metres; 0: not measured")
      .field("sigma", &scan::Scan::sigma, "float32 (h, w): of the depth, by the light's noise, metres")
      .field("rig_sigma", &scan::Scan::rig_sigma,
             "float32 (h, w): of the depth, by the rig's covariance, metres")
      .field("counts", &scan::Scan::counts, "")
      .field("consistency", &scan::Scan::consistency, "1 when rig and light agree")
      .field("consistency_px", &scan::Scan::consistency_px, "RMS of the disagreement, projector pixels")
      .field("diagnostics", &scan::Scan::diagnostics, "");
  scan.type
      .def(
          "measured",
          [](const scan::Scan& self, int x, int y) {
            require_pixel(self.depth.size(), x, y, "Scan.measured");
            return self.measured(x, y);
          },
          "", py::arg("x"), py::arg("y"))
      .def(
          "total_sigma",
          [](const scan::Scan& self, int x, int y) {
            require_pixel(self.sigma.size(), x, y, "Scan.total_sigma");
            require_pixel(self.rig_sigma.size(), x, y, "Scan.total_sigma");
            return self.total_sigma(x, y);
          },
          "Of both parts, metres.", py::arg("x"), py::arg("y"));

  function(m, "pixel_rays", &scan::pixel_rays,
           "float32 (h, w, 2): each camera pixel's (a, b) with the ray (a, b, 1).", py::arg("camera"),
           py::arg("threads") = 0);
  function(m, "measure_depth", &scan::measure_depth,
           "The depth of what each camera pixel sees, with its standard deviation. Throws\n"
           "Error(kInput), Error(kDegenerate), Error(kNotEnoughData).",
           py::arg("light"), py::arg("rig"), py::arg("camera") = "", py::arg("projector") = "",
           py::arg_v("options", scan::ScanOptions{}, "ScanOptions()"));
  function(m, "point_cloud", &scan::point_cloud, "The measured points in the rig's frame, with normals.",
           py::arg("scan"));
}

void bind_mesh(py::module_& m) {
  Record<scan::MeshOptions> mesh_options(m, "MeshOptions", "");
  mesh_options.fields_init()
      .field("max_deviation", &scan::MeshOptions::max_deviation, "metres")
      .field("max_sigmas", &scan::MeshOptions::max_sigmas, "")
      .field("min_angle", &scan::MeshOptions::min_angle, "radians")
      .field("max_hole", &scan::MeshOptions::max_hole, "pixels along x or y that are bridged; 0: none");

  function(m, "mesh_of", &scan::mesh_of,
           "A mesh in the rig's frame that keeps edges and holes. Throws Error(kNotEnoughData).",
           py::arg("scan"), py::arg_v("options", scan::MeshOptions{}, "MeshOptions()"));
}

void bind_error(py::module_& m) {
  Record<scan::ScanError> scan_error(m, "ScanError",
                                     "How far a scan is off where the truth is known, metres.");
  scan_error.fields_init()
      .field("compared", &scan::ScanError::compared, "")
      .field("rms", &scan::ScanError::rms, "along the true surface's normal, without outliers")
      .field("median", &scan::ScanError::median, "of its absolute value")
      .field("expected_rms", &scan::ScanError::expected_rms, "")
      .field("noise_rms", &scan::ScanError::noise_rms, "")
      .field("inside_3_sigma", &scan::ScanError::inside_3_sigma, "")
      .field("outliers", &scan::ScanError::outliers, "");

  function(m, "compare", &scan::compare, "Depths against the true ones, float32 (h, w), metres.",
           py::arg("scan"), py::arg("true_depth"));
}

}  // namespace

void bind_scan(py::module_& m) {
  bind_measure(m);
  bind_mesh(m);
  bind_error(m);
}

}  // namespace procam::python
