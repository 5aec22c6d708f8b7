// A rig refreshed by new views: parts of calibrate and report.
#include "procam/calibrate/update.hpp"

#include "bind.hpp"
#include "components.hpp"

#include "procam/report/calibration.hpp"

namespace procam::python {
namespace {

using calibrate::DeviceChange;
using calibrate::RigChange;
using calibrate::UpdatedView;
using calibrate::UpdateOptions;
using calibrate::UpdateResult;

void bind_update_options(py::module_& m) {
  Record<RigChange> change(m, "RigChange",
                           "A possible change of one device. Its variance is added to the rig's covariance.");
  Enum<RigChange::Kind>(change.type, "Kind", "What changed: a pose, zoom, or focus.")
      .value("kPose", RigChange::Kind::kPose)
      .value("kZoom", RigChange::Kind::kZoom)
      .value("kFocus", RigChange::Kind::kFocus);
  Record<UpdateOptions> options(m, "UpdateOptions", "Which changes update_rig() considers.");
  change.fields_init().field("device", &RigChange::device, "").field("kind", &RigChange::kind, "");
  options.fields_init()
      .field("changed", &UpdateOptions::changed,
             "empty: the views are checked against the rig, and refine it within its sigmas")
      .field("outlier_sigmas", &UpdateOptions::outlier_sigmas,
             "As Options.outlier_sigmas. A view is rejected where fewer than half of a device's\n"
             "points lie within, or where the residuals of those are twice as long as the rig's own.");
}

void bind_update_result(py::module_& m) {
  Record<DeviceChange> device_change(
      m, "DeviceChange",
      "The difference of one device between the rig and the refreshed rig. Sigmas are those of\n"
      "the difference.");
  Record<UpdatedView> updated_view(m, "UpdatedView",
                                   "One of the new views: how well the old and the new rig explain it.");
  Record<UpdateResult> result(m, "UpdateResult", "The rig after a change, and what changed.");
  device_change.fields_init()
      .field("device", &DeviceChange::device, "")
      .field("rotation", &DeviceChange::rotation, "radians, of the device about any axis")
      .field("rotation_sigma", &DeviceChange::rotation_sigma, "standard deviation, radians")
      .field("translation", &DeviceChange::translation, "metres, of the device's centre in the rig")
      .field("translation_sigma", &DeviceChange::translation_sigma, "standard deviation, metres")
      .field("focal_ratio", &DeviceChange::focal_ratio, "new fx over old fx")
      .field("focal_ratio_sigma", &DeviceChange::focal_ratio_sigma, "standard deviation, without unit");
  updated_view.fields_init()
      .field("name", &UpdatedView::name, "")
      .field("rig_from_board", &UpdatedView::rig_from_board, "")
      .field("rms_px", &UpdatedView::rms_px, "by device, over the used points; 0 where there are none")
      .field("used", &UpdatedView::used, "")
      .field("note", &UpdatedView::note, "why it was rejected");
  result.fields_init()
      .field("rig", &UpdateResult::rig,
             "As given, with new lenses, poses and covariance. quality.rms_px is that of the new\n"
             "views where they have any, quality.views_used counts both.")
      .field("devices", &UpdateResult::devices, "of the rig: cameras, then projectors")
      .field("changes", &UpdateResult::changes, "of every device that was stated to have changed")
      .field("views", &UpdateResult::views, "")
      .field("diagnostics", &UpdateResult::diagnostics, "");
}

void bind_texts(py::module_& m) {
  function(m, "to_json", py::overload_cast<const UpdateResult&, const report::ReportInput&>(&report::to_json),
           "Of a rig that was refreshed.", py::arg("result"), py::arg("input"));
  function(m, "lines", py::overload_cast<const UpdateResult&, const report::ReportInput&>(&report::lines),
           "Of a rig that was refreshed.", py::arg("result"), py::arg("input"));
}

}  // namespace

void bind_update(py::module_& package) {
  py::module_ module = package.attr("calibrate"), report = package.attr("report");
  bind_update_options(module);
  bind_update_result(module);
  function(
      module, "to_string", [](RigChange::Kind kind) { return std::string(calibrate::to_string(kind)); },
      "As in options: \"pose\", \"zoom\", \"focus\".", py::arg("kind"));
  function(module, "update_rig", &calibrate::update_rig,
           "The rig refreshed by one or two new views, when something was bumped, zoomed or focused\n"
           "since its calibration. Raises Error(kInput) for devices that the rig lacks and for a rig\n"
           "without covariance; kNotEnoughData when no view is usable; kDegenerate when half of the\n"
           "views or more contradict the rig, naming the further change that would explain the views,\n"
           "if one does.",
           py::arg("before"), py::arg("views"), py::arg_v("options", UpdateOptions{}, "UpdateOptions()"));
  bind_texts(report);
}

}  // namespace procam::python
