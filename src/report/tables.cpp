#include "tables.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "html.hpp"
#include "pictures.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::report {

using analyze::in_words;
using analyze::LightError;
using analyze::LightErrors;
using analyze::NextView;
using analyze::only_predicted_error_failed;
using analyze::SurfaceLocated;
using analyze::view_verdicts;
namespace {

using calibrate::CalibrationResult;
using calibrate::Residual;
using calibrate::ViewResult;

constexpr double kDegrees = 1 / kDegree;

std::string cell(const std::string& html) {
  return element("td", "", html);
}

std::string number_cell(const std::string& text) {
  return element("td", "class=\"n\"", text);
}

std::string row(const std::string& cells) {
  return element("tr", "", cells) + "\n";
}

struct Column {
  std::string title;
  bool number = false;
};

std::string table(const std::vector<Column>& columns, const std::string& rows) {
  std::string head;
  for (const Column& column : columns)
    head += element("th", column.number ? "class=\"n\"" : "", escaped(column.title));
  return element("div", "class=\"scroll\"",
                 element("table", "",
                         "\n" + element("thead", "", row(head)) + "\n" + element("tbody", "", "\n" + rows))) +
         "\n";
}

std::string hint(const std::string& text) {
  return element("p", "class=\"hint\"", text) + "\n";
}

/// The element, or NaN (printed as "-") where the list was left empty.
double at_or_nan(const std::vector<double>& values, std::size_t index) {
  return index < values.size() ? values[index] : std::nan("");
}

struct Count {
  int used = 0, rejected = 0;
};

/// Observations of a device, of one view or (negative) of all.
Count count_of(const CalibrationResult& result, std::size_t device, int view = -1) {
  Count count;
  for (const Residual& r : result.residuals)
    if (r.device == int(device) && (view < 0 || r.view == view)) ++(r.used ? count.used : count.rejected);
  return count;
}

std::string plural(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

/// " Predicted error: 29 mm RMS at 2 m, surface located externally (accepted: 5 mm)."
std::string predicted_in_words(const Rig& rig, const ReportInput& input) {
  std::string words;
  for (const LightErrors& errors : input.predicted) {
    const LightError& error = errors.of(input.accepted.located);
    words += " Predicted error" + (rig.projectors.size() > 1 ? " of " + escaped(error.projector) : "") +
             ": " + element("b", "", in_words(error)) + " (accepted: " + shortest(input.accepted.rms_mm) +
             " mm).";
  }
  return words;
}

}  // namespace

std::string verdict(const CalibrationResult& result, const ReportInput& input) {
  std::string problems;
  std::size_t failed = 0;
  for (const Gate& gate : result.rig.quality.gates)
    if (!gate.passed) {
      ++failed;
      problems +=
          element("li", "", element("b", "", escaped(gate.name)) + ": " + escaped(gate.detail)) + "\n";
    }
  for (const Diagnostic& d : result.diagnostics.items)
    if (d.severity == Severity::kFailure && d.code != "gate_failed")
      problems += element("li", "", escaped(d.message)) + "\n";
  if (!result.converged)
    problems += element("li", "",
                        "The solve did not converge: look for a view of another board or swapped frames, or "
                        "allow more iterations.") +
                "\n";
  const std::size_t gates = result.rig.quality.gates.size();
  const auto box = [](const std::string& frame, const std::string& color, const std::string& word,
                      const std::string& words, const std::string& list) {
    return element("section", "class=\"verdict" + frame + "\"",
                   element("p", "", element("strong", "class=\"" + color + "\"", word) + " " + words) +
                       (list.empty() ? "" : "\n" + element("ul", "", "\n" + list))) +
           "\n";
  };
  const std::string headline = predicted_in_words(result.rig, input);
  if (problems.empty())
    return box("", "pass", "Passed.",
               (gates == 0 ? "The solve converged; no quality checks were made."
                           : "All " + plural(gates, "quality check") + " passed, and the solve converged.") +
                   headline,
               "");
  const bool other_failures = std::any_of(
      result.diagnostics.items.begin(), result.diagnostics.items.end(),
      [](const Diagnostic& d) { return d.severity == Severity::kFailure && d.code != "gate_failed"; });
  if (result.converged && !other_failures && only_predicted_error_failed(result.rig.quality))
    return box(" imprecise", "warning", "Usable, but imprecise.",
               "The other " + plural(gates - failed, "quality check") + " passed." + headline + " " +
                   (input.next_view ? "Add the view below." : "Add views."),
               "");
  std::string words = "The solve did not end well.";
  if (failed > 0) words = std::to_string(failed) + " of " + plural(gates, "quality check") + " failed.";
  return box(" failed", "fail", "Failed.",
             words + " Do not rely on this rig before this is fixed:", problems);
}

std::string key_figures(const CalibrationResult& result, const ReportInput& input) {
  std::string out;
  const auto tile = [&](const std::string& figure, const std::string& words) {
    out += element("div", "", element("b", "", figure) + element("span", "", escaped(words))) + "\n";
  };
  const auto of = [&](const LightError& error) {
    return result.rig.projectors.size() > 1 ? " of " + error.projector : std::string();
  };
  const auto error_tiles = [&](const std::string& kind, const LightErrors& errors) {
    const auto add = [&](const LightError& error) {
      tile(significant(error.rms_mm, 2) + " mm",
           kind + " error" + of(error) + " at " + shortest(error.distance) +
               "\u00a0m (RMS), surface located " + to_string(error.located));
    };
    const LightError& selected = errors.of(input.accepted.located);
    add(selected);
    if (selected.located == SurfaceLocated::kByCamera)
      add(errors.externally);
    else if (errors.by_camera)
      add(*errors.by_camera);
  };
  for (const LightErrors& errors : input.predicted) error_tiles("predicted", errors);
  for (const LightErrors& errors : input.truth) error_tiles("true", errors);
  tile(std::to_string(result.rig.quality.views_used) + " of " + std::to_string(result.views.size()),
       "views used");
  tile(pixels(result.joint_rms_px) + " px", "RMS over all devices");
  if (!result.holdout_px.empty()) {
    const auto worst = std::max_element(result.holdout_px.begin(), result.holdout_px.end());
    const std::size_t device = std::size_t(worst - result.holdout_px.begin());
    tile(pixels(*worst) + " px", "error on held-out views, " + result.devices[device].name + " (the worst)");
  }
  return element("div", "class=\"key\"", "\n" + out) + "\n";
}

namespace {

/// Rows "name | value | sigma | unit" of one device.
class NumberRows {
 public:
  explicit NumberRows(const NamedCovariance& covariance) : covariance_(covariance) {}

  /// Sigma of a named parameter; zero when it was fixed.
  double sigma(const std::string& name) const { return covariance_.sigma(name); }

  /// A value without digits beyond its sigma's second.
  void add(const std::string& name, double value, double sigma, int decimals, const std::string& unit) {
    const int shown = decimals_for(sigma, decimals);
    std::string spread = "fixed";
    if (covariance_.empty() || !std::isfinite(sigma))
      spread = "-";
    else if (sigma > 0)
      spread = fixed(sigma, shown);
    add_text(name, fixed(value, shown), spread, unit);
  }
  /// A value that follows from others, without a sigma of its own.
  void add_text(const std::string& name, const std::string& value, const std::string& spread,
                const std::string& unit) {
    rows_ += row(cell(escaped(name)) + number_cell(value) + number_cell(spread) +
                 element("td", "class=\"u\"", unit));
  }
  std::string finish() const {
    return table({{"", false}, {"value", true}, {"sigma", true}, {"unit", false}}, rows_);
  }

 private:
  const NamedCovariance& covariance_;
  std::string rows_;
};

void add_lens(NumberRows& rows, const std::string& device, const Camera& lens) {
  const std::vector<std::string> names = parameter_names(lens);
  const VecX values = parameters_of(lens);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool in_pixels = i < std::size_t(Intrinsics::kNumParameters);
    rows.add(names[i], values[Eigen::Index(i)], rows.sigma(device + "." + names[i]), in_pixels ? 2 : 5,
             in_pixels ? "px" : "");
  }
}

void add_optics(NumberRows& rows, const std::string& device, const Projector& projector) {
  const double w = projector.size().width, h = projector.size().height;
  const Vec2 shift = projector.lens_shift();
  rows.add("throw ratio", projector.throw_ratio(), rows.sigma(device + ".fx") / w, 3, "distance / width");
  rows.add("lens shift right", 100 * shift.x(), 100 * rows.sigma(device + ".cx") / w, 1, "% of width");
  rows.add("lens shift down", 100 * shift.y(), 100 * rows.sigma(device + ".cy") / h, 1, "% of height");
}

/// The covariance is of the left increment xi. For the rotation vector w, exp(xi_r) exp(w) = exp(w + J^-1
/// xi_r) with the left Jacobian J; the origin's own covariance is core's point_covariance of the zero point.
void add_pose(NumberRows& rows, const NamedCovariance& covariance, const std::string& device,
              const Pose& rig_from_device, const std::string& origin_name) {
  const Mat6 c = covariance.block(pose_increment_names("rig_from_" + device));
  const Vec3 turn = so3_log(rig_from_device.rotation);
  const Mat3 from_increment = so3_left_jacobian(turn).inverse();
  const Mat3 of_turn = from_increment * c.topLeftCorner<3, 3>() * from_increment.transpose();
  const Mat3 of_origin = point_covariance({rig_from_device, c}, Vec3::Zero());
  const Vec3& origin = rig_from_device.translation;
  const std::string axes[] = {"x", "y", "z"};
  const auto root = [](double variance) {  // this order of max() lets NaN through
    return std::sqrt(std::max(variance, 0.0));
  };
  for (int i = 0; i < 3; ++i)
    rows.add("rotation about " + axes[i], kDegrees * turn[i], kDegrees * root(of_turn(i, i)), 3, "°");
  for (int i = 0; i < 3; ++i)
    rows.add("position " + axes[i], 1e3 * origin[i], 1e3 * root(of_origin(i, i)), 1, "mm");
  if (const double distance = origin.norm(); distance > 0) {
    const Vec3 along = origin / distance;
    rows.add("distance to " + origin_name, 1e3 * distance, 1e3 * root(along.dot(of_origin * along)), 1, "mm");
  }
}

}  // namespace

std::string device_numbers(const CalibrationResult& result, const Device& device) {
  const Rig& rig = result.rig;
  const bool projects = device.kind == DeviceKind::kProjector;
  const Camera& lens =
      projects ? rig.projector(device.name).projector.inverse_camera : rig.camera(device.name).camera;
  const Pose& pose =
      projects ? rig.projector(device.name).rig_from_projector : rig.camera(device.name).rig_from_camera;
  const auto block = [](const std::string& title, const std::string& words, const NumberRows& rows) {
    return element("div", "",
                   "\n" + element("h3", "", escaped(title)) + "\n" + hint(escaped(words)) + rows.finish()) +
           "\n";
  };
  NumberRows of_lens(rig.covariance);
  add_lens(of_lens, device.name, lens);
  std::string out =
      block(device.name,
            (projects ? "Projector, " : "Camera, ") + std::to_string(device.size.width) + " × " +
                std::to_string(device.size.height) + " px, lens model " + name_of(lens.distortion),
            of_lens);
  if (projects) {
    NumberRows of_optics(rig.covariance);
    add_optics(of_optics, device.name, rig.projector(device.name).projector);
    out += block("Optics of " + device.name,
                 "As on a data sheet; the axis leaves the picture's centre by the shift", of_optics);
  }
  const std::string& first = result.devices.front().name;
  if (device.name == first) return out;  // it carries the rig's frame
  NumberRows of_pose(rig.covariance);
  add_pose(of_pose, rig.covariance, device.name, pose, first);
  return out + block("Position of " + device.name,
                     "In the frame of " + first + " (x right, y down, z forward)", of_pose);
}

std::string residual_numbers(const CalibrationResult& result) {
  std::string rows;
  Count all;
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    const Count count = count_of(result, d);
    all.used += count.used;
    all.rejected += count.rejected;
    const bool noisy = d < result.noise.size();
    rows +=
        row(cell(escaped(result.devices[d].name)) + number_cell(std::to_string(count.used)) +
            number_cell(std::to_string(count.rejected)) + number_cell(pixels(at_or_nan(result.rms_px, d))) +
            number_cell(pixels(at_or_nan(result.holdout_px, d))) +
            number_cell(noisy ? significant(result.noise[d].scale, 3) : "-") +
            number_cell(noisy ? pixels(result.noise[d].floor_px) : "-"));
  }
  rows += row(cell(element("b", "", "all")) + number_cell(std::to_string(all.used)) +
              number_cell(std::to_string(all.rejected)) + number_cell(pixels(result.joint_rms_px)) +
              number_cell("-") + number_cell("-") + number_cell("-"));
  return table({{"device", false},
                {"points used", true},
                {"rejected", true},
                {"RMS, px", true},
                {"held-out, px", true},
                {"noise scale", true},
                {"noise floor, px", true}},
               rows) +
         hint(
             "RMS: root of the mean squared length of the residuals used. Held-out: the same on each view, "
             "predicted by a solve without it. Noise scale: observed over stated corner noise (1: as "
             "stated). Noise floor: additional error from board, lens model and light. " +
             plural(std::size_t(std::max(result.iterations, 0)), "iteration") + ".");
}

std::string wall_errors(const ReportInput& input) {
  std::string rows;
  std::set<std::string> projectors;
  for (const LightErrors& errors : input.predicted) projectors.insert(errors.externally.projector);
  const auto add = [&](const std::string& kind, const LightErrors& errors, bool mean) {
    const auto add_row = [&](const LightError& error) {
      const std::string whose = projectors.size() > 1 ? ", " + escaped(error.projector) : "";
      const bool by_camera = error.located == SurfaceLocated::kByCamera;
      rows +=
          row(cell(kind + whose) + cell(to_string(error.located)) + number_cell(fixed(error.distance, 2)) +
              number_cell(by_camera ? fixed(100 * error.share, 0) : "-") +
              number_cell(significant(error.rms_mm, 2)) +
              number_cell(mean ? significant(error.mean_mm, 2) : "-") +
              number_cell(significant(error.worst_mm, 2)));
    };
    add_row(errors.externally);
    if (errors.by_camera) add_row(*errors.by_camera);
  };
  for (const LightErrors& errors : input.predicted) add("predicted", errors, false);
  for (const LightErrors& errors : input.truth) add("true", errors, true);
  if (rows.empty()) return "";
  return element("h3", "", "Error on a wall") + "\n" +
         table({{"error", false},
                {"surface located", false},
                {"wall at, m", true},
                {"seen by camera, %", true},
                {"RMS, mm", true},
                {"mean, mm", true},
                {"max, mm", true}},
               rows) +
         hint(
             "Distance between projected and intended point on a wall across the projector's axis, over a "
             "grid that spans the frame. Located externally: the wall is known in the rig's frame, e.g. "
             "from a map and a localiser. Located by camera: the rig's camera measures the wall's pose from "
             "points of known geometry (markers, a board); errors "
             "shared by camera and projector cancel, and only "
             "what the camera sees counts. Detection noise and errors of map or localiser are not included. "
             "Predicted: one sigma, from the covariance of the rig" +
             std::string(!input.truth.empty() ? "; true: against the true rig." : "."));
}

std::string gate_table(const RigQuality& quality) {
  if (quality.gates.empty()) return hint("No quality checks were made.");
  std::string failed, passed;
  for (const Gate& gate : quality.gates)
    (gate.passed ? passed : failed) += row(element("td", gate.passed ? "class=\"pass\"" : "class=\"fail\"",
                                                   gate.passed ? "✓ passed" : "✗ failed") +
                                           cell(escaped(gate.name)) + cell(escaped(gate.detail)));
  return table({{"", false}, {"quality check", false}, {"measured", false}}, failed + passed);
}

std::string diagnostic_list(const Diagnostics& diagnostics) {
  const char* classes[] = {"note", "warning", "fail"};
  const char* words[] = {"note", "warning", "failure"};
  std::string by_severity[3];
  std::size_t notes = 0;
  for (const Diagnostic& d : diagnostics.items) {
    if (d.code == "gate_failed") continue;  // in the table of quality checks
    const auto severity = std::size_t(d.severity);
    notes += d.severity == Severity::kNote;
    by_severity[severity] +=
        row(element("td", std::string("class=\"") + classes[severity] + "\"", words[severity]) +
            cell(escaped(d.message)) + element("td", "class=\"mono\"", escaped(d.code)));
  }
  const std::vector<Column> columns = {{"", false}, {"message", false}, {"code", false}};
  const std::string urgent = by_severity[2] + by_severity[1];
  std::string out = urgent.empty() ? hint("No warnings.") : table(columns, urgent);
  if (notes > 0)
    out += element("details", "",
                   element("summary", "", plural(notes, "note")) + "\n" + table(columns, by_severity[0])) +
           "\n";
  return out;
}

std::string view_table(const CalibrationResult& result) {
  std::vector<Column> columns = {{"view", false}, {"used", false}};
  const bool held_out = !result.holdout_px.empty();
  for (const Device& device : result.devices) {
    columns.push_back({device.name + " points", true});
    columns.push_back({"RMS, px", true});
    if (held_out) columns.push_back({"held-out, px", true});
  }
  columns.push_back({"share, %", true});
  columns.push_back({"verdict", false});
  columns.push_back({"note", false});
  const std::vector<std::string> verdicts = view_verdicts(result);
  std::string rows;
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const ViewResult& view = result.views[v];
    std::string cells = cell("<span class=\"swatch\" style=\"background:" + view_color(int(v)) +
                             "\"></span>" + escaped(view.name)) +
                        element("td", view.used ? "" : "class=\"fail\"", view.used ? "yes" : "no");
    for (std::size_t d = 0; d < result.devices.size(); ++d) {
      const Count count = count_of(result, d, int(v));
      cells += number_cell(std::to_string(count.used) +
                           (count.rejected > 0 ? " (" + std::to_string(count.rejected) + " rejected)" : ""));
      cells += number_cell(count.used > 0 ? pixels(at_or_nan(view.rms_px, d)) : "-");
      if (held_out) cells += number_cell(pixels(at_or_nan(view.holdout_px, d)));
    }
    cells += number_cell(view.used ? fixed(100 * view.share, 1) : "-");
    rows += row(cells + cell(escaped(verdicts[v])) + cell(escaped(view.note)));
  }
  return table(columns, rows) + hint("Share: fraction of the total information contributed by this view.");
}

std::string next_view(const std::optional<NextView>& next, SurfaceLocated located) {
  if (!next) return "";
  const LightError &now = next->now.of(located), &then = next->then.of(located);
  std::string words = "predicted error at " + shortest(now.distance) + "\u00a0m, surface located " +
                      to_string(now.located) + ": " + significant(now.rms_mm, 2) + " → " +
                      significant(then.rms_mm, 2) + "\u00a0mm RMS";
  if (next->now.by_camera && next->then.by_camera) {
    const bool by_camera = now.located == SurfaceLocated::kByCamera;
    words += std::string(" (located ") + (by_camera ? "externally" : "by camera") + ": " +
             significant((by_camera ? next->now.externally : *next->now.by_camera).rms_mm, 2) + " → " +
             significant((by_camera ? next->then.externally : *next->then.by_camera).rms_mm, 2) + ")";
  }
  return element("p", "",
                 element("b", "", "Add next") + ": the board " + escaped(next->words) + "; " + words + ".") +
         "\n";
}

std::string provenance_section(const Provenance& p) {
  std::string rows;
  const auto add = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) rows += row(cell(escaped(name)) + cell(escaped(value)));
  };
  add("tool", p.tool + (p.version.empty() ? "" : " " + p.version));
  add("created", p.created);
  for (const auto& [name, value] : p.options) add("--" + name, value);
  std::string out = rows.empty() ? hint("Not stated.") : table({{"", false}, {"", false}}, rows);
  if (p.inputs.empty()) return out;
  std::string files;
  for (const InputFile& file : p.inputs)
    files += row(element("td", "class=\"mono\"", escaped(file.path)) +
                 element("td", "class=\"mono\"", escaped(file.sha256)));
  return out +
         element("details", "",
                 element("summary", "", plural(p.inputs.size(), "input file") + ", with SHA-256") + "\n" +
                     table({{"file", false}, {"SHA-256", false}}, files)) +
         "\n";
}

}  // namespace procam::report
