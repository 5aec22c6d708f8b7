// procam.report
#include "procam/report.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_input(py::module_& m) {
  Record<report::ReportInput> report_input(m, "ReportInput",
                                           "What a report may hold beyond the calibration itself.");
  report_input.fields_init()
      .field("title", &report::ReportInput::title, "")
      .field("predicted", &report::ReportInput::predicted,
             "from the covariance, one a distance and projector")
      .field("accepted", &report::ReportInput::accepted,
             "the kind of error that leads the page, and its limit")
      .field("next_view", &report::ReportInput::next_view, "drawn and described")
      .field("truth", &report::ReportInput::truth,
             "Where the true rig is known (a simulated session): the errors by projector, and the\n"
             "parameters.")
      .field("within_truth", &report::ReportInput::within_truth, "")
      .field("wall", &report::ReportInput::wall, "metres, for which lens models are compared")
      .field("views", &report::ReportInput::views, "that were given; 0: as many as the result has")
      .field("images", &report::ReportInput::images,
             "of the session's views (SessionContents.view_images); none: no captures drawn")
      .field("earlier", &report::ReportInput::earlier,
             "A rig of the same devices from before: what differs is drawn, the light on the wall and\n"
             "each lens.");

  Record<report::DeviceCounts> device_counts(m, "DeviceCounts", "What was found and used of a device.");
  device_counts.fields_init()
      .field("views_used", &report::DeviceCounts::views_used, "")
      .field("points_found", &report::DeviceCounts::points_found, "")
      .field("points_used", &report::DeviceCounts::points_used, "");

  function(m, "judge",
           py::overload_cast<calibrate::CalibrationResult&, double, const analyze::AcceptedError&,
                             const std::optional<Rig>&>(&report::judge),
           "What a report about a fresh calibration holds: predicts the errors on a wall, adds\n"
           "their checks to result.rig.quality (a failed one to result.diagnostics), finds the\n"
           "view that reduces the error most, and compares with the true rig where one is given.\n"
           "A rig without projectors gets none of it.",
           py::arg("result"), py::arg("wall"), py::arg("accepted"), py::arg("truth") = py::none());
  function(m, "add_truth", &report::add_truth, "Compares with the true rig, on the wall of `input`.",
           py::arg("rig"), py::arg("truth"), py::arg("input"));
  function(m, "device_counts", &report::device_counts,
           "Views and points of device number `device`: found, used.", py::arg("result"), py::arg("device"));
}

void bind_report_files(py::module_& m) {
  Record<report::TextFile> text_file(m, "TextFile", "A file in memory: its name and its text.");
  text_file.fields_init()
      .field("name", &report::TextFile::name, "residuals_of_camera.svg")
      .field("text", &report::TextFile::text, "");

  function(m, "figures", &report::figures,
           "The figures of a report page as SVG files without CSS variables, in the page's order.",
           py::arg("page"));
  function(m, "calibration_tables", &report::calibration_tables,
           "parameters.csv, covariance.csv, views.csv and residuals.csv of a calibration.",
           py::arg("result"));
  function(m, "require_folder", &report::require_folder,
           "Raises an error if the folder may not be written, or if its parent does not exist.",
           py::arg("folder"));
  function(m, "save_files", &report::save_files,
           "Writes files into the folder, which is made where it does not exist.", py::arg("folder"),
           py::arg("files"));
}

void bind_calibration(py::module_& m) {
  function(
      m, "to_json",
      py::overload_cast<const calibrate::CalibrationResult&, const report::ReportInput&>(&report::to_json),
      "The fields of a calibration as JSON text. Figures of one projector stand in \"wall\",\n"
      "\"truth\" and at the top; of several, each under its name.",
      py::arg("result"), py::arg("input"));
  function(m, "to_json",
           py::overload_cast<const calibrate::PointsResult&, const report::ReportInput&>(&report::to_json),
           "Of a projector alone, calibrated from points.", py::arg("result"), py::arg("input"));
  function(m, "to_json",
           py::overload_cast<const Rig&, const RigQuality&, const report::ReportInput&>(&report::to_json),
           "Of a rig whose stored numbers were checked.", py::arg("rig"), py::arg("quality"),
           py::arg("input"));
  function(
      m, "headline",
      py::overload_cast<const calibrate::CalibrationResult&, const report::ReportInput&>(&report::headline),
      "The first lines of a console: may the rig be used, and its predicted errors.", py::arg("result"),
      py::arg("input"));
  function(m, "headline",
           py::overload_cast<const Rig&, const RigQuality&, const report::ReportInput&>(&report::headline),
           "Of a rig file.", py::arg("rig"), py::arg("quality"), py::arg("input"));
  function(m, "lines",
           py::overload_cast<const calibrate::CalibrationResult&, const report::ReportInput&>(&report::lines),
           "The lines below it.", py::arg("result"), py::arg("input"));
  function(m, "lines",
           py::overload_cast<const calibrate::PointsResult&, const std::vector<PointPair>&,
                             const report::ReportInput&>(&report::lines),
           "", py::arg("result"), py::arg("pairs"), py::arg("input"));
  function(m, "lines", py::overload_cast<const Rig&, const RigQuality&>(&report::lines), "Of a rig file.",
           py::arg("rig"), py::arg("quality"));
  function(m, "calibration_report", &report::calibration_report,
           "The page as UTF-8 text. The same input gives the same text, byte by byte, in every\n"
           "locale; a number that is not finite reads \"-\". The correspondences are those the\n"
           "result was made from: their board and the views that were rejected are drawn. Raises\n"
           "ValueError when the two do not belong together.",
           py::arg("result"), py::arg("correspondences"),
           py::arg_v("input", report::ReportInput{}, "ReportInput()"));
}

void bind_plan_page(py::module_& m) {
  function(m, "to_json", py::overload_cast<const analyze::ProjectionPlan&>(&report::to_json),
           "The plan's fields as JSON text; metres unless a name ends otherwise.", py::arg("plan"));
  function(m, "lines", py::overload_cast<const analyze::ProjectionPlan&>(&report::lines),
           "The figures as lines of a console.", py::arg("plan"));
  function(m, "plan_picture", &report::plan_picture,
           "The plan as one SVG file, complete in itself: the wall seen straight on, with the\n"
           "lit area, its pixels' size as colours, the target and the largest undistorted\n"
           "rectangle; the projector and its light from above and from the side; the figures.\n"
           "The same plan gives the same text, byte by byte, in every locale.",
           py::arg("plan"));
}

void bind_prediction_page(py::module_& m) {
  function(m, "to_json", py::overload_cast<const std::vector<analyze::SurfacePrediction>&>(&report::to_json),
           "The fields of every surface as JSON text: {\"surfaces\": [{\"name\", \"rms_mm\",\n"
           "\"worst_mm\", \"causes\": [...], ...}]}.",
           py::arg("surfaces"));
  function(m, "lines", py::overload_cast<const analyze::SurfacePrediction&>(&report::lines),
           "The lines of a console.", py::arg("prediction"));
  function(m, "prediction_report", &report::prediction_report,
           "One self-contained page: verdict, numbers, heat maps, causes, sweeps, rig and\n"
           "surfaces in space (as calibration_report()).",
           py::arg("surfaces"), py::arg("rig"), py::arg("title"));
  function(m, "draws_to_json", &report::draws_to_json,
           "What these options drew for the surfaces, as the text of a file for merge_draws().",
           py::arg("surfaces"), py::arg("options"));
  function(
      m, "merge_draws",
      [](const std::vector<std::filesystem::path>& files, std::vector<analyze::SurfacePrediction> surfaces) {
        report::merge_draws(files, surfaces);
        return surfaces;
      },
      "The surfaces with the draws of all parts. Raises Error kInput for a file that is no such part or\n"
      "of other inputs, and for a part that is missing or given twice.",
      py::arg("files"), py::arg("surfaces"));
  function(m, "prediction_tables", &report::prediction_tables,
           "The numbers of the page's figures: points.csv, causes.csv and sweeps.csv.", py::arg("surfaces"));
}

void bind_room_surfaces_page(py::module_& m) {
  function(m, "to_json",
           py::overload_cast<const depth::Planes&, const depth::RoomSurfaces&, const depth::SensorKind&,
                             const depth::SensorCheck&>(&report::to_json),
           "\"surfaces\", \"planes\" (every plane, also one without a surface) and \"sensor\"; metres.",
           py::arg("planes"), py::arg("room"), py::arg("sensor"), py::arg("check"));
  function(m, "lines", py::overload_cast<const depth::Planes&, const depth::RoomSurfaces&>(&report::lines),
           "A table of the surfaces, then of the planes without one.", py::arg("planes"), py::arg("room"));
  function(m, "room_picture", &report::room_picture,
           "The depth image shaded by its slopes, every surface in its colour with outline, free\n"
           "rectangle, name and size, corners of the room, and a legend at the right. RGB.",
           py::arg("planes"), py::arg("room"), py::arg("image"), py::arg("rays"));
}

void bind_verify(py::module_& m) {
  function(m, "to_json", py::overload_cast<const analyze::VerifyResult&>(&report::to_json),
           "The result's fields as JSON text, every mark included.", py::arg("result"));
  function(m, "lines", py::overload_cast<const analyze::VerifyResult&>(&report::lines),
           "The lines of a console: the verdict, the two possible causes with their odds, the error\n"
           "after the correction, the noise.",
           py::arg("result"));
  function(m, "description", &report::description,
           "\"projector rotated by 0.210 +- 0.0040 deg and translated by ...\"", py::arg("movement"));
  function(m, "verify_tables", &report::verify_tables,
           "marks.csv: of each mark its pixels, its intended point and error on the surface (mm),\n"
           "sigma, chi-square (two degrees of freedom), whether it was used, and why not.",
           py::arg("result"));
  function(m, "verify_picture", &report::verify_picture,
           "The surface as its content is read, with every mark's error as an arrow, magnified,\n"
           "before (and after, when something was corrected), and the 95 % region in which an\n"
           "error would be no surprise. `content` is the outline of what is shown there, on the\n"
           "surface; it may be empty. A complete SVG file.",
           py::arg("result"), py::arg_v("content", Points2{}, "Points2()"));
}

void bind_scans(py::module_& m) {
  Record<report::StationError> station_error(
      m, "StationError", "A station's pose against the true one (scan-surfaces --truth).");
  station_error.fields_init()
      .field("position", &report::StationError::position, "metres, of the rig's origin")
      .field("angle", &report::StationError::angle, "radians")
      .field("in_sigmas", &report::StationError::in_sigmas,
             "Square root of e^T C^-1 e / 6 with the stated covariance: about 1. 0 for a fixed pose.")
      .field("largest_in_sigmas", &report::StationError::largest_in_sigmas,
             "of the six elements of e, each by its own standard deviation")
      .field("single_rms", &report::StationError::single_rms,
             "of this station's points alone, by its true pose, along the true normals, metres");
  function(m, "pose_error", &report::pose_error, "The estimated pose against the true one.",
           py::arg("world_from_rig"), py::arg("true_world_from_rig"));
  function(m, "stations_picture", &report::stations_picture,
           "The merged points as seen from behind the stations, with a colour for each, beside\n"
           "their standard deviation: uint8 (h, w, 3), RGB.",
           py::arg("merged"));
  Record<report::StationsReport> stations(
      m, "StationsReport", "Several stations of a rig, and how far they are off where the truth is known.");
  stations.fields_init()
      .field("registration", &report::StationsReport::registration, "poses of the stations")
      .field("merged", &report::StationsReport::merged, "their points in one")
      .field("true_pose_errors", &report::StationsReport::true_pose_errors, "by station, or none")
      .field("true_error", &report::StationsReport::true_error, "of the merged points");
  function(m, "to_json", py::overload_cast<const report::StationsReport&>(&report::to_json),
           "Stations, pairs, merged points and true errors as JSON text; metres, radians.",
           py::arg("report"));
  function(m, "lines", py::overload_cast<const report::StationsReport&>(&report::lines),
           "The lines of a console.", py::arg("report"));
  Record<report::ScannedSurface> scanned(m, "ScannedSurface",
                                         "A scan, its mesh, and how far it is off where the truth is known.");
  scanned.fields_init()
      .field("name", &report::ScannedSurface::name, "of the surface")
      .field("scan", &report::ScannedSurface::scan, "depths; metres")
      .field("mesh", &report::ScannedSurface::mesh, "metres")
      .field("error", &report::ScannedSurface::error, "None where the truth is not known")
      .field("viewer", &report::ScannedSurface::viewer, "None where the truth is not known");
  function(m, "to_json", py::overload_cast<const std::vector<report::ScannedSurface>&>(&report::to_json),
           "Pixels, standard deviations, mesh and true error as JSON text; metres.", py::arg("surfaces"));
  function(m, "lines", py::overload_cast<const std::vector<report::ScannedSurface>&>(&report::lines),
           "The lines of a console.", py::arg("surfaces"));
  function(m, "scan_picture", &report::scan_picture,
           "Left the surface shaded by its slopes, right the depths' standard deviation in colours. RGB.",
           py::arg("scan"));
}

void bind_room_calibration(py::module_& m) {
  Record<report::RoomReport> room_report(m, "RoomReport",
                                         "A rig by a room's light, with what is known of its truth.");
  room_report.fields_init()
      .field("result", &report::RoomReport::result, "")
      .field("deviations", &report::RoomReport::deviations, "from a true rig; none: unknown")
      .field("seconds", &report::RoomReport::seconds, "of solving");
  function(m, "to_json", py::overload_cast<const report::RoomReport&>(&report::to_json),
           "Of a room, as text in JSON.", py::arg("report"));
  function(m, "lines", py::overload_cast<const report::RoomReport&>(&report::lines), "Of a room.",
           py::arg("report"));
  function(m, "room_calibration_picture", &report::room_calibration_picture,
           "The room from above and from the side: its points in the colours of their standard\n"
           "deviation, cameras and projectors. RGB.",
           py::arg("result"));
}

}  // namespace

void bind_report(py::module_& m) {
  bind_input(m);
  bind_report_files(m);
  bind_calibration(m);
  bind_plan_page(m);
  bind_prediction_page(m);
  bind_room_surfaces_page(m);
  bind_verify(m);
  bind_scans(m);
  bind_room_calibration(m);
}

}  // namespace procam::python
