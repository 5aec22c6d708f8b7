#include "procam/calibrate/update.hpp"

#include <algorithm>
#include <cmath>

#include "joined.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/base/words.hpp"
#include "rig_covariance.hpp"
#include "update_solve.hpp"

namespace procam::calibrate {
namespace {

std::string in_words(const RigChange& change) {
  return change.device + ":" + to_string(change.kind);
}

std::string in_words(const std::vector<RigChange>& changes) {
  std::string out;
  for (const RigChange& change : changes) out += (out.empty() ? "" : ",") + in_words(change);
  return out;
}

/// The changes that one could state further: of each device, but the pose of only one of two.
std::vector<RigChange> further_changes(const std::vector<Device>& devices,
                                       const std::vector<RigChange>& stated) {
  const bool is_pair = devices.size() == 2;
  std::vector<RigChange> out;
  for (std::size_t d = 0; d < devices.size(); ++d)
    for (const RigChange::Kind kind :
         {RigChange::Kind::kFocus, RigChange::Kind::kZoom, RigChange::Kind::kPose}) {
      const bool is_pose = kind == RigChange::Kind::kPose;
      if (is_pose && is_pair && d == 0) continue;  // seen from the other device, the same
      if (std::none_of(stated.begin(), stated.end(), [&](const RigChange& one) {
            return one.kind == kind && (one.device == devices[d].name || (is_pose && is_pair));
          }))
        out.push_back({devices[d].name, kind});
    }
  return out;
}

/// By which changes every view would agree with the rig: one instead of the stated, or one beside them, of least cost.
/// Empty: by none.
std::vector<RigChange> explanation(const Correspondences& data, const RigParameters& all,
                                   const UpdateOptions& options, const Rig& rig) {
  std::vector<RigChange> best;
  constexpr double kCostOfChange = 16;  // four sigmas for a change more
  double least = 1e300;
  for (const bool beside : {false, true})
    for (const RigChange& further : further_changes(data.devices, options.changed)) {
      if (beside && options.changed.empty()) continue;
      UpdateOptions trial = options;
      if (!beside) trial.changed.clear();
      trial.changed.push_back(further);
      UpdateSolve update(data, all, trial, rig);
      update.solve();
      if (!update.all_used()) continue;
      const double cost = update.cost() + kCostOfChange * double(trial.changed.size());
      if (cost < least) least = cost, best = trial.changed;
    }
  return best;
}

std::vector<DeviceChange> changes_of(const UpdateSolve& update, const Correspondences& data,
                                     const RigParameters& all, const UpdateOptions& options) {
  std::vector<DeviceChange> out;
  const std::pair<VecX, MatX> estimate = update.change();
  const VecX& change = estimate.first;
  const MatX& covariance = estimate.second;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const std::string& name = data.devices[d].name;
    if (std::none_of(options.changed.begin(), options.changed.end(),
                     [&](const RigChange& stated) { return device_of(data, stated) == d; }))
      continue;
    DeviceChange one{name};
    // Of the first camera: the motion that all others have in common, as seen from any of them.
    std::size_t shown = d;
    while (shown < data.devices.size() && all.holds_pose(shown)) ++shown;
    if (shown < data.devices.size() && (shown == d || d == 0)) {
      const int at = all.pose_at(shown);
      const auto size_along = [&](const Vec3& part, int row, double& size, double& sigma) {
        size = part.norm();
        const Vec3 along = size > 0 ? Vec3(part / size) : Vec3(Vec3::UnitX());
        sigma = std::sqrt(std::max(0.0, along.dot(covariance.block<3, 3>(row, row) * along)));
      };
      size_along(change.segment<3>(at), at, one.rotation, one.rotation_sigma);
      size_along(change.segment<3>(at + 3), at + 3, one.translation, one.translation_sigma);
    }
    if (const auto at = all.lens_at(d, "fx")) {
      const double fx = all.start().lenses[d].intrinsics.fx;
      one.focal_ratio = 1 + change[*at] / fx;
      one.focal_ratio_sigma = std::sqrt(std::max(0.0, covariance(*at, *at))) / fx;
    }
    out.push_back(one);
  }
  return out;
}

/// RigParameters that were said to be unchanged, and moved further than their covariance allows.
void remark_on_unchanged(const UpdateSolve& update, const RigParameters& all, Diagnostics& diagnostics) {
  constexpr double kRate = 1e-4;
  constexpr double kModest = 4;  // sigmas of a calibration may be too small by two
  if (update.prior_cost() < kModest * procam::internal::chi_square_limit(kRate, all.size())) return;
  const VecX difference = all.difference(update.state());
  Eigen::Index worst = 0;
  const VecX sigmas = difference.cwiseAbs().cwiseQuotient(all.covariance().diagonal().cwiseSqrt());
  sigmas.maxCoeff(&worst);
  diagnostics.warn("rig_contradicted",
                   "parameters that were stated as unchanged moved further than their sigmas allow (most " +
                       all.names()[std::size_t(worst)] +
                       "): another change is likely; calibrate again if in doubt");
}

/// A bump and a zoom look alike on one board that faces the projector.
void remark_on_hidden_zoom(const UpdateSolve& update, const Correspondences& data,
                           const UpdateOptions& options, Diagnostics& diagnostics) {
  constexpr double kHidden = 0.005;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const auto stated = [&](RigChange::Kind kind) {
      return std::any_of(options.changed.begin(), options.changed.end(), [&](const RigChange& change) {
        return change.device == data.devices[d].name && change.kind == kind;
      });
    };
    if (!stated(RigChange::Kind::kPose) || stated(RigChange::Kind::kZoom)) continue;
    const double sigma = update.focal_sigma_with({data.devices[d].name, RigChange::Kind::kZoom}, d);
    if (sigma > kHidden)
      diagnostics.note(
          "zoom_not_tested",
          "these views cannot tell a changed zoom of " + data.devices[d].name +
              " from its motion (its focal length would be known to " + format("%.1f %%", 100 * sigma) +
              "): if its zoom may have changed, add a view at another distance, with the board tilted");
  }
}

UpdateResult result_of(const UpdateSolve& update, const Correspondences& data, const RigParameters& all,
                       const Rig& before, const UpdateOptions& options) {
  UpdateResult result;
  result.devices = data.devices;
  result.diagnostics = data.diagnostics;
  const BundleState& state = update.state();
  result.rig = rig_of(data, state);
  result.rig.covariance = rig_covariance({all.names(), update.covariance()}, data, state);
  RigQuality& quality = result.rig.quality = before.quality;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    UpdatedView view{
        data.views[v].name, state.rig_from_board[v], {}, update.notes()[v].empty(), update.notes()[v]};
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      view.rms_px.push_back(spread_of(data, state, update.used(), int(d), int(v)).rms_px);
    quality.views_used += view.used;
    if (!view.used) result.diagnostics.warn("view_rejected", "view " + view.name + " rejected: " + view.note);
    result.views.push_back(std::move(view));
  }
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    if (const Spread spread = spread_of(data, state, update.used(), int(d)); spread.count > 0)
      quality.rms_px[data.devices[d].name] = spread.rms_px;
  result.changes = changes_of(update, data, all, options);
  remark_on_unchanged(update, all, result.diagnostics);
  remark_on_hidden_zoom(update, data, options, result.diagnostics);
  quality.gates = check_stored_rig(result.rig);
  for (const Gate& gate : quality.gates)
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  return result;
}

[[noreturn]] void throw_contradiction(const UpdateSolve& update, const Correspondences& data,
                                      const RigParameters& all, const UpdateOptions& options,
                                      const Rig& before) {
  std::size_t first = 0;
  while (first + 1 < data.views.size() && update.notes()[first].empty()) ++first;
  const std::vector<RigChange> explained_by = explanation(data, all, options, before);
  const std::string stated = in_words(options.changed);
  throw Error(
      ErrorKind::kDegenerate, "view " + data.views[first].name,
      "it contradicts the rig" + (stated.empty() ? "" : ", also with the changes " + stated) + ": " +
          update.notes()[first],
      explained_by.empty()
          ? "check that board and pattern are those stated and that nothing moved during the view; no "
            "single further change explains the views: calibrate again if in doubt"
          : "the views agree with the rig if these changed: " + in_words(explained_by) +
                "; state --changed " + in_words(explained_by) + " if it is true");
}

/// What no view shows stays as uncertain as the change made it.
void require_seen(const std::vector<RigChange>& changed, const Correspondences& data) {
  for (const RigChange& change : changed) {
    const std::size_t device = device_of(data, change);
    std::size_t points = 0;
    for (std::size_t v = 0; v < data.views.size(); ++v)
      points += measurements_of(data, int(v), int(device)).size();
    if (points < std::size_t(kMinPointsPerView))
      throw Error(ErrorKind::kNotEnoughData, change.device,
                  "it is stated as changed, and the views have " + counted(points, "point") + " of it",
                  "capture the board where the device sees it or lights it");
  }
}

}  // namespace

const char* to_string(RigChange::Kind kind) {
  constexpr const char* kNames[] = {"pose", "zoom", "focus"};
  return kNames[int(kind)];
}

UpdateResult update_rig(const Rig& before, const Correspondences& views, const UpdateOptions& options) {
  if (before.cameras.empty() || before.covariance.empty())
    throw Error(ErrorKind::kInput, "rig",
                before.cameras.empty() ? "it has no camera"
                                       : "it has no covariance, which says what its values are worth",
                "give a rig that calibrate-projector wrote");
  const Correspondences data = of_whole_rig(before, views);
  require_seen(options.changed, data);
  const RigParameters all(before, data, state_of(before, data));
  UpdateSolve update(data, all, options, before);
  if (!update.any_used())
    throw Error(ErrorKind::kNotEnoughData, "views",
                data.views.empty() ? "there is none"
                                   : "in view " + data.views.front().name + " " + update.notes().front(),
                "capture the board where camera and projector see all of it");
  update.solve();
  if (!update.most_agree()) throw_contradiction(update, data, all, options, before);
  return result_of(update, data, all, before, options);
}

}  // namespace procam::calibrate
