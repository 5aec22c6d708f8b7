/// The fields of calibrations: what --json prints and the page carries.
#include <algorithm>
#include <map>

#include "fields.hpp"
#include "procam/report/calibration.hpp"

namespace procam::report {
namespace {

using calibrate::CalibrationResult;

/// A projector's own fields: in the group itself, or under its name where the rig has several.
template <typename Write>
void of_projector(Fields& f, const Rig& rig, const std::string& projector, const Write& write) {
  if (rig.projectors.size() > 1)
    f.object(projector, write);
  else
    write(f);
}

void wall_fields(Fields& f, const Rig& rig, const ReportInput& input) {
  if (input.predicted.empty()) return;
  f.object("wall", [&](Fields& wall) {
    wall.field("distance_m", input.predicted.front().of(input.accepted.located).distance);
    wall.field("accepted_mm", input.accepted.rms_mm);
    wall.field("surface_located", analyze::to_string(input.accepted.located));
    for (std::size_t i = 0; i < input.predicted.size(); ++i)
      of_projector(wall, rig, rig.projectors[i].name, [&](Fields& errors) {
        const analyze::LightErrors& predicted = input.predicted[i];
        errors.field("rms_mm", predicted.externally.rms_mm);
        errors.field("rms95_mm", predicted.externally.rms95_mm);
        errors.field("worst_mm", predicted.externally.worst_mm);
        if (!predicted.by_camera) return;
        errors.object("by_camera", [&](Fields& located) {
          located.field("rms_mm", predicted.by_camera->rms_mm);
          located.field("rms95_mm", predicted.by_camera->rms95_mm);
          located.field("worst_mm", predicted.by_camera->worst_mm);
          located.field("camera", predicted.by_camera->camera);
          located.field("share", predicted.by_camera->share);
        });
      });
  });
}

void lens_fields(Fields& f, const std::string& device, const Camera& lens,
                 const NamedCovariance& covariance) {
  const VecX values = parameters_of(lens);
  const std::vector<std::string> names = parameter_names(lens);
  f.object(device, [&](Fields& fields) {
    for (std::size_t i = 0; i < names.size(); ++i) fields.field(names[i], values[Eigen::Index(i)]);
    fields.object("sigma", [&](Fields& sigmas) {
      for (const std::string& name : names) sigmas.field(name, covariance.sigma(device + "." + name));
    });
  });
}

void truth_fields(Fields& f, const Rig& rig, const ReportInput& input) {
  if (input.truth.empty()) return;
  const auto error_fields = [](Fields& errors, const analyze::LightError& error) {
    errors.field("mean_mm", error.mean_mm);
    errors.field("rms_mm", error.rms_mm);
    errors.field("worst_mm", error.worst_mm);
  };
  f.object("truth", [&](Fields& truth) {
    for (const analyze::LightErrors& errors : input.truth)
      of_projector(truth, rig, errors.externally.projector, [&](Fields& of_one) {
        error_fields(of_one, errors.externally);
        if (errors.by_camera)
          of_one.object("by_camera", [&](Fields& located) { error_fields(located, *errors.by_camera); });
      });
    truth.field("parameters_inside_3_sigma", input.within_truth.inside_3_sigma);
    truth.field("parameters", input.within_truth.parameters);
  });
}

/// What every rig has, however it was calibrated.
void rig_fields(Fields& f, const Rig& rig, const RigQuality& quality, const ReportInput& input) {
  f.field("result", quality.passed()                                ? "passed"
                    : analyze::only_predicted_error_failed(quality) ? "imprecise"
                                                                    : "failed");
  wall_fields(f, rig, input);
  for (const RigCamera& camera : rig.cameras) lens_fields(f, camera.name, camera.camera, rig.covariance);
  for (const RigProjector& projector : rig.projectors)
    lens_fields(f, projector.name, projector.projector.inverse_camera, rig.covariance);
  truth_fields(f, rig, input);
  f.object("gates", [&](Fields& gates) {
    int failed = 0;
    for (const Gate& gate : quality.gates) failed += !gate.passed;
    gates.field("failed", failed);
    gates.field("total", int(quality.gates.size()));
  });
}

/// A figure of every device.
template <typename T>
void by_device(Fields& f, const std::string& name, const CalibrationResult& result,
               const std::vector<T>& values) {
  if (values.empty()) return;
  f.object(name, [&](Fields& of_devices) {
    for (std::size_t d = 0; d < result.devices.size(); ++d)
      of_devices.field(result.devices[d].name, values[d]);
  });
}

void residual_fields(Fields& f, const CalibrationResult& result, const ReportInput& input) {
  f.field("views_used", result.rig.quality.views_used);
  f.field("views", input.views > 0 ? input.views : int(result.views.size()));
  by_device(f, "holdout_px", result, result.holdout_px);
  if (result.rig.projectors.empty()) {
    f.field("rms_px", result.joint_rms_px);
    f.field("rms_all_px", result.joint_rms_all_px);
    return;
  }
  by_device(f, "holdout_all_px", result, result.holdout_all_px);
  std::vector<int> views, found, used;
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    const DeviceCounts counts = device_counts(result, int(d));
    views.push_back(counts.views_used);
    found.push_back(counts.points_found);
    used.push_back(counts.points_used);
  }
  by_device(f, "views_used_by", result, views);
  by_device(f, "points_found", result, found);
  by_device(f, "points_used", result, used);
  by_device(f, "rms_px", result, result.rms_px);
  by_device(f, "rms_all_px", result, result.rms_all_px);
  f.object("rms_px", [&](Fields& rms) { rms.field("joint", result.joint_rms_px); });
  f.object("rms_all_px", [&](Fields& rms) { rms.field("joint", result.joint_rms_all_px); });
}

void board_fields(Fields& f, const CalibrationResult& result) {
  f.object("board", [&](Fields& board) {
    board.field("free_shape", result.shape.free);
    if (result.shape.free) {
      board.field("in_plane_rms_mm", 1e3 * result.shape.in_plane_rms);
      board.field("out_of_plane_rms_mm", 1e3 * result.shape.out_of_plane_rms);
      board.field("largest_mm", 1e3 * result.shape.largest);
      board.field("free_points", result.shape.free_points);
      board.field("stretch_x_over_y", result.shape.stretch_x_over_y);
      board.field("largest_of_light_mm", 1e3 * result.shape.largest_of_light);
      board.field("flex_rms_mm", 1e3 * result.shape.flex_rms);
    }
    board.field("size_to_measure", result.size_to_measure);
  });
}

/// By camera whose image changes from view to view.
void image_change_fields(Fields& f, const CalibrationResult& result) {
  const auto changes = [](const calibrate::ImageChange& of) {
    return of.focus_rms > 0 || of.shift_rms_px > 0;
  };
  if (std::none_of(result.image_changes.begin(), result.image_changes.end(), changes)) return;
  f.object("image_changes", [&](Fields& all) {
    for (std::size_t d = 0; d < result.image_changes.size(); ++d) {
      const calibrate::ImageChange& change = result.image_changes[d];
      if (!changes(change)) continue;
      all.object(result.devices[d].name, [&](Fields& camera) {
        camera.field("focus_rms", change.focus_rms);
        camera.field("shift_rms_px", change.shift_rms_px);
      });
    }
  });
}

/// One row of the table of lens models, with the predicted error of the projector that it serves worst.
struct LensRow {
  const calibrate::LensAlternative& lens;
  std::optional<double> wall_rms_mm;
};

void fields(Fields& f, const LensRow& row) {
  f.field("model", row.lens.model);
  f.field("terms", row.lens.terms);
  if (!row.lens.by_view.empty()) {
    f.field("holdout_px", row.lens.holdout_px);
    f.field("holdout_error", row.lens.error());
    f.optional("wall_rms_mm", row.wall_rms_mm);
  }
  f.optional("ruled_out", row.lens.ruled_out);
  f.field("chosen", row.lens.chosen);
}

void lens_model_fields(Fields& f, const CalibrationResult& result, const ReportInput& input) {
  std::map<std::string, std::vector<LensRow>> tables;
  for (const calibrate::LensAlternative& one : result.lens_alternatives) {
    LensRow row{one, std::nullopt};
    if (!one.by_view.empty())
      for (const RigProjector& projector : one.rig.projectors)
        row.wall_rms_mm =
            std::max(row.wall_rms_mm.value_or(0),
                     analyze::predicted_light_error(one.rig, input.wall, projector.name).rms_mm);
    tables[result.devices[std::size_t(one.device)].name].push_back(row);
  }
  if (tables.empty()) return;
  f.object("lens_models", [&](Fields& models) {
    for (const auto& [device, rows] : tables) models.field(device, rows);
  });
}

struct ViewVerdict {
  const calibrate::ViewResult& view;
  std::string verdict;
};

void fields(Fields& f, const ViewVerdict& verdict) {
  f.field("view", verdict.view.name);
  f.field("share", verdict.view.share);
  f.field("verdict", verdict.verdict);
}

void view_fields(Fields& f, const CalibrationResult& result, const ReportInput& input) {
  if (result.rig.projectors.empty()) return;
  const std::vector<std::string> verdicts = analyze::view_verdicts(result);
  std::vector<ViewVerdict> views;
  for (std::size_t v = 0; v < verdicts.size(); ++v) views.push_back({result.views[v], verdicts[v]});
  f.field("view_verdicts", views);
  if (!input.next_view) return;
  f.object("next_view", [&](Fields& next) {
    const analyze::LightErrors& then = input.next_view->then;
    next.field("words", input.next_view->words);
    next.field("surface_located", analyze::to_string(then.of(input.accepted.located).located));
    next.field("rms_mm", then.of(input.accepted.located).rms_mm);
    if (!then.by_camera) return;
    next.field("externally_rms_mm", then.externally.rms_mm);
    next.field("by_camera_rms_mm", then.by_camera->rms_mm);
  });
}

struct UpdatedViewRow {
  const calibrate::UpdatedView& view;
  const std::vector<Device>& devices;
};

void fields(Fields& f, const UpdatedViewRow& row) {
  f.field("view", row.view.name);
  f.field("used", row.view.used);
  f.optional("note", row.view.note);
  f.object("rms_px", [&](Fields& rms) {
    for (std::size_t d = 0; d < row.devices.size(); ++d) rms.field(row.devices[d].name, row.view.rms_px[d]);
  });
}

}  // namespace
}  // namespace procam::report

namespace procam::calibrate {

static void fields(report::Fields& f, const DeviceChange& change) {
  f.field("device", change.device);
  f.field("rotation_deg", change.rotation / kDegree);
  f.field("rotation_sigma_deg", change.rotation_sigma / kDegree);
  f.field("translation_mm", 1e3 * change.translation);
  f.field("translation_sigma_mm", 1e3 * change.translation_sigma);
  f.field("focal_ratio", change.focal_ratio);
  f.field("focal_ratio_sigma", change.focal_ratio_sigma);
}

}  // namespace procam::calibrate

namespace procam::report {

std::string to_json(const CalibrationResult& result, const ReportInput& input) {
  Json object = Json::object();
  Fields f(object);
  rig_fields(f, result.rig, result.rig.quality, input);
  residual_fields(f, result, input);
  for (const RigProjector& device : result.rig.projectors)
    of_projector(f, result.rig, device.name, [&](Fields& optics) {
      optics.field("throw_ratio", device.projector.throw_ratio());
      optics.field("lens_shift", device.projector.lens_shift());
    });
  board_fields(f, result);
  image_change_fields(f, result);
  lens_model_fields(f, result, input);
  view_fields(f, result, input);
  return text(object);
}

std::string to_json(const calibrate::PointsResult& result, const ReportInput& input) {
  Json object = Json::object();
  Fields f(object);
  rig_fields(f, result.rig, result.rig.quality, input);
  f.field("rms_px", result.rms_px);
  f.field("sigma_px", result.sigma_px);
  f.field("left_out_px", result.loo_rms_px);
  f.field("pairs", int(result.pairs.size()));
  f.field("place_m", result.rig.projector().rig_from_projector.translation);
  return text(object);
}

std::string to_json(const calibrate::UpdateResult& result, const ReportInput& input) {
  Json object = Json::object();
  Fields f(object);
  rig_fields(f, result.rig, result.rig.quality, input);
  f.field("changes", result.changes);
  std::vector<UpdatedViewRow> views;
  for (const calibrate::UpdatedView& view : result.views) views.push_back({view, result.devices});
  f.field("views", views);
  return text(object);
}

std::string to_json(const Rig& rig, const RigQuality& quality, const ReportInput& input) {
  Json object = Json::object();
  Fields f(object);
  rig_fields(f, rig, quality, input);
  return text(object);
}

}  // namespace procam::report
