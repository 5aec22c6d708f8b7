#include "procam/report/calibration.hpp"

#include "html.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "style.hpp"
#include "tables.hpp"

namespace procam::report {
namespace {

using calibrate::CalibrationResult;

void require_matching(const CalibrationResult& result, const Correspondences& data) {
  require(!result.devices.empty(), "calibration_report: the result has no device");
  require(data.views.size() == result.views.size(),
          "calibration_report: result and correspondences have different views");
  for (std::size_t v = 0; v < data.views.size(); ++v)
    require(
        data.views[v].name == result.views[v].name && result.views[v].rms_px.size() == result.devices.size(),
        "calibration_report: view '" + data.views[v].name + "' is not that of the result");
  for (const calibrate::Residual& r : result.residuals)
    require(r.view >= 0 && r.view < int(result.views.size()) && r.device >= 0 &&
                r.device < int(result.devices.size()),
            "calibration_report: a residual of no view or device");
}

std::string numbers(const CalibrationResult& result, const ReportInput& input) {
  std::string devices;
  for (const Device& device : result.devices) devices += device_numbers(result, device);
  return element("div", "class=\"pair\"", "\n" + devices) + "\n" +
         element("p", "class=\"hint\"",
                 "Sigma: one standard deviation; “fixed”: kept at its initial value, not estimated. "
                 "Rotation: rotation "
                 "vector. " +
                     escaped(result.size_to_measure)) +
         "\n" + element("h3", "", "Fit") + "\n" + residual_numbers(result) + wall_errors(input);
}

std::string distortion(const CalibrationResult& result, int device) {
  const Device& about = result.devices[std::size_t(device)];
  return lens_distortion(about.kind == DeviceKind::kCamera
                             ? result.rig.camera(about.name).camera
                             : result.rig.projector(about.name).projector.inverse_camera,
                         about.name);
}

/// One picture a device, side by side; nothing when there is none.
template <typename Picture>
std::string each_device(const CalibrationResult& result, Picture picture) {
  std::string pictures;
  for (int d = 0; d < int(result.devices.size()); ++d) pictures += picture(d);
  if (pictures.empty()) return "";
  return element("div", "class=\"pair\"", "\n" + pictures) + "\n";
}

}  // namespace

std::string calibration_report(const CalibrationResult& result, const Correspondences& correspondences,
                               const ReportInput& input) {
  require_matching(result, correspondences);
  std::string quivers;
  for (int d = 0; d < int(result.devices.size()); ++d) quivers += residual_quivers(result, d);

  const std::string sections =
      section("Rig in space", rig_in_space(result, correspondences.board, input.next_view)) +
      section("Predicted error over the frame", error_maps(result.rig, input.predicted)) +
      section("Change from the earlier rig",
              input.earlier ? rig_change(result.rig, *input.earlier, input.wall) : "") +
      section(
          "Coverage",
          each_device(result, [&](int d) { return coverage(result, correspondences, d, input.next_view); })) +
      section("Quality checks", gate_table(result.rig.quality)) +
      section("Warnings and notes", diagnostic_list(result.diagnostics)) +
      section("Numbers", numbers(result, input)) +
      section("Views",
              each_device(result, [&](int d) { return view_bars(result, d); }) + view_table(result)) +
      section("Captures", view_captures(result, correspondences, input.images)) +
      section("Lens models", lens_alternatives(result)) +
      section("Lens distortion", each_device(result, [&](int d) { return distortion(result, d); })) +
      section("Correlation of the parameters", correlation_matrix(result.rig.covariance)) +
      section("Residuals", each_device(result, [&](int d) { return residual_scatter(result, d); }) +
                               each_device(result, [&](int d) { return residual_histogram(result, d); })) +
      section("The board's shape", board_shape(result, correspondences.board)) +
      section("Residuals in the image", quivers) +
      section("Where this comes from", provenance_section(result.rig.provenance));
  const std::string body = element("p", "class=\"kicker\"", "Calibration report") + "\n" +
                           element("h1", "", escaped(input.title)) + "\n" + verdict(result, input) +
                           key_figures(result, input) + next_view(input.next_view, input.accepted.located) +
                           table_of_contents(sections) + sections;
  return page(input.title, body + data(to_json(result, input)) + element("script", "", kReportScript) + "\n");
}

}  // namespace procam::report
