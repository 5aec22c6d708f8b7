#include "result_gates.hpp"

#include <map>
#include <optional>
#include <string>

#include "joined.hpp"
#include "lens_models.hpp"
#include "procam/core/base/words.hpp"
#include "rig_checks.hpp"
#include "solve.hpp"

namespace procam::calibrate {
namespace {

/// Fails when half of a device's views or more were rejected: there is no majority.
Gate agreement_gate(const Correspondences& data, const Start& start, const Solution& solution) {
  Gate gate{"views agree", true, "all"};
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    int rejected = 0, views = 0;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      if (count_used(start.used, v, d) == 0) continue;
      ++views;
      rejected += count_used(solution.used, v, d) == 0;
    }
    if (rejected == 0) continue;
    const std::string count = std::to_string(rejected) + " of " + std::to_string(views) +
                              " views disagree about " + data.devices[d].name;
    gate.passed = gate.passed && 2 * rejected < views;
    gate.detail = gate.detail == "all" ? count : gate.detail + ", " + count;
  }
  if (!gate.passed) gate.detail += ": capture again what the remarks name";
  return gate;
}

/// A device that few views read is calibrated by few views, however many the other devices have.
Gate views_gate(const Correspondences& data, const Solution& solution) {
  Gate gate{"views read", true, ""};
  int views = 0;
  std::vector<int> of_device(data.devices.size());
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    bool any = false;
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      const bool used = count_used(solution.used, v, d) > 0;
      of_device[d] += used, any = any || used;
    }
    views += any;
  }
  std::string few;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    gate.detail += (d > 0 ? ", " : "") + data.devices[d].name + " " + std::to_string(of_device[d]) + " of " +
                   std::to_string(views);
    if (2 * of_device[d] >= views) continue;
    few += (few.empty() ? "" : " and ") + data.devices[d].name;
  }
  gate.passed = few.empty();
  if (!gate.passed)
    gate.detail += ": fewer than half of the views hold points of " + few +
                   "; the views' remarks give the cause, capture them again";
  return gate;
}

/// A board that is bent by more than a few sigmas of what a printed sheet does is no board to calibrate with.
constexpr double kLargestBend = 5;

Gate shape_gate(const Correspondences& data, const EstimatedShape& shape) {
  const double limit = kLargestBend * board_sigma(points_in_board(data.board));
  const bool passed = shape.largest <= limit;
  return {
      "board's shape", passed,
      "largest offset " + mm(shape.largest) +
          (passed ? ""
                  : ", limit " + mm(limit) +
                        ": mount the sheet on a stiff flat plate, and check the square's size both ways")};
}

/// Failures of the captures are failures of the rig that was made from them: the file is marked, and no
/// summary says that all checks passed. Nothing where there are none.
std::optional<Gate> captures_gate(const Diagnostics& of_captures) {
  int failures = 0;
  for (const Diagnostic& remark : of_captures.items) failures += remark.severity == Severity::kFailure;
  if (failures == 0) return std::nullopt;
  return Gate{"captures", false,
              std::to_string(failures) + (failures == 1 ? " failure" : " failures") +
                  " in the captures: the remarks name view and cause; capture these views again"};
}

/// The board's printed side faces away from the camera: a mirrored order of corners.
Gate facing_gate(const std::vector<ViewResult>& views) {
  int behind = 0;
  for (const ViewResult& view : views)
    if (view.used && view.rig_from_board.rotate(Vec3::UnitZ()).dot(view.rig_from_board.translation) <= 0)
      ++behind;
  return {"boards face the camera", behind == 0,
          behind == 0 ? "all"
                      : std::to_string(behind) +
                            " seen from behind: the order of their corners is mirrored; do not flip images"};
}

}  // namespace

void check_result(const Correspondences& data, const Start& start, const Solution& solution,
                  const EstimatedShape& shape, CalibrationResult& result) {
  std::map<std::string, double> reach;
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    if (data.devices[d].kind == DeviceKind::kCamera)
      reach[data.devices[d].name] = reach_of(data, solution.used, d, solution.state().lenses[d]);
  std::vector<Gate>& gates = result.rig.quality.gates;
  gates = check_rig(result.rig, {}, reach);
  gates.push_back(facing_gate(result.views));
  gates.push_back(views_gate(data, solution));
  gates.push_back(agreement_gate(data, start, solution));
  if (shape.free) gates.push_back(shape_gate(data, shape));
  if (const auto gate = captures_gate(data.diagnostics)) gates.push_back(*gate);
  for (const Gate& gate : gates)
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
}

}  // namespace procam::calibrate
