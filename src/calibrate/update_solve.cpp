#include "update_solve.hpp"

#include <algorithm>
#include <cmath>

#include "joined.hpp"
#include "normal_equations.hpp"
#include "place_camera.hpp"
#include "procam/core/base/words.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

constexpr double kRobustSigmas = 3;
/// A view contradicts the rig where fewer than this share of a device's points lies within the outlier limit, or where
/// the residuals of those that do are this many times as long as the rig's own.
constexpr double kAgreeingPoints = 0.5, kLongResiduals = 2;
/// With fewer than this share of the views in agreement, nothing tells which views are right.
constexpr double kAgreeingViews = 0.5;

double sigmas_squared(const JudgedResidual& judged, const ResidualNoise& noise) {
  return judged.residual.dot(noise.covariance(judged.covariance).inverse() * judged.residual);
}

}  // namespace

UpdateSolve::UpdateSolve(const Correspondences& data, const RigParameters& all, const UpdateOptions& options,
                         const Rig& rig)
    : data_(data), all_(all), options_(options), used_(use_all(data)), state_(all.start()) {
  variance_ = variance_of(options.changed, data, all);
  const auto information = scaled_inverse(all.covariance() + variance_);
  if (!information)
    throw Error(ErrorKind::kInput, "rig", "its covariance is not positive definite",
                "give the rig as calibrate-projector wrote it");
  prior_ = *information;
  bundle_.held = all.held();
  bundle_.noise.resize(data.devices.size());
  for (std::size_t d = 0; d < data.devices.size(); ++d) bundle_.hold_pose.push_back(all.holds_pose(d));
  notes_.resize(data.views.size());
  pose_boards();
  usable_ = count_used();
  set_noise(rig);
}

void UpdateSolve::solve() {
  bundle_.huber_sigmas = 0;  // from far away, Huber's weights would trust the rig against the views
  converge();
  bundle_.huber_sigmas = kRobustSigmas;
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    converge();
    if (!reject()) return;
  }
  converge();
}

double UpdateSolve::focal_sigma_with(const RigChange& also, std::size_t device) const {
  const auto at = all_.lens_at(device, "fx");
  MatX variance = variance_;
  variance += variance_of({also}, data_, all_);
  const auto prior = scaled_inverse(all_.covariance() + variance);
  if (!at || !prior) return 0;
  const auto covariance = scaled_inverse(*prior + information() - prior_);
  return covariance ? std::sqrt((*covariance)(*at, *at)) / state_.lenses[device].intrinsics.fx : 1;
}

void UpdateSolve::pose_boards() {
  for (std::size_t v = 0; v < data_.views.size(); ++v) {
    std::optional<Pose> pose;
    std::size_t camera = 0;
    for (std::size_t d = 0; d < data_.devices.size() && !pose; ++d) {
      const auto& corners = data_.views[v].observations[d];
      if (data_.devices[d].kind != DeviceKind::kCamera || int(corners.size()) < kMinPointsPerView) continue;
      pose = board_pose(state_.lenses[d], state_.points_in_board, corners);
      camera = d;
    }
    if (!pose) {
      leave_out(v, "no camera sees enough of the board");
      continue;
    }
    state_.rig_from_board[v] = state_.device_from_rig[camera].inverse() * *pose;
    const UsedMask only = only_view(used_, v, int(camera));
    state_.rig_from_board[v] =
        bundle_adjust(data_, only, state_, hold_devices(bundle_, state_)).state.rig_from_board[v];
  }
}

void UpdateSolve::set_noise(const Rig& rig) {
  for (std::size_t d = 0; d < data_.devices.size(); ++d) {
    const auto rms = rig.quality.rms_px.find(data_.devices[d].name);
    double trace = 0;
    int count = 0;
    for (std::size_t v = 0; v < data_.views.size(); ++v)
      for (const Measurement& m : measurements_of(data_, int(v), int(d)))
        if (used_[v][d][std::size_t(m.index)])
          if (const auto judged = judged_residual(state_, m)) trace += judged->covariance.trace(), ++count;
    if (rms == rig.quality.rms_px.end() || count == 0) continue;
    const double beyond = 0.5 * (rms->second * rms->second - trace / count);
    if (beyond > 0) bundle_.noise[d].floor_px = std::sqrt(beyond);
  }
}

double UpdateSolve::cost_of(const BundleState& state) const {
  const VecX difference = all_.difference(state);
  double sum = difference.dot(prior_ * difference);
  for (std::size_t v = 0; v < data_.views.size(); ++v)
    for (std::size_t d = 0; d < data_.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data_, int(v), int(d))) {
        if (!used_[v][d][std::size_t(m.index)]) continue;
        const auto judged = judged_residual(state, m);
        if (!judged) return 1e300;
        const double square = sigmas_squared(*judged, bundle_.noise[d]), k = bundle_.huber_sigmas;
        sum += k > 0 && square > k * k ? 2 * k * std::sqrt(square) - k * k : square;
      }
  return sum;
}

UpdateSolve::Equations UpdateSolve::equations() const {
  const CommonParameters common(data_, used_, state_, bundle_);
  const NormalEquations normal = normal_equations(data_, used_, state_, bundle_, common);
  std::vector<int> row;
  for (const std::string& name : common.names)
    row.push_back(int(std::find(all_.names().begin(), all_.names().end(), name) - all_.names().begin()));
  Equations out{prior_, prior_ * all_.difference(state_)};
  for (const ViewEquations& view : normal.views)
    for (std::size_t i = 0; view.used && i < row.size(); ++i) {
      out.gradient[row[i]] += view.gradient[Eigen::Index(i)];
      for (std::size_t j = 0; j < row.size(); ++j)
        out.information(row[i], row[j]) += view.information(Eigen::Index(i), Eigen::Index(j));
    }
  return out;
}

void UpdateSolve::converge() {
  if (!any_used()) return;
  state_ = with_boards(state_);
  double cost = cost_of(state_);
  constexpr int kSteps = 60, kHalvings = 12;
  constexpr double kStill = 1e-9;
  for (int step = 0; step < kSteps; ++step) {
    const Equations at = equations();
    const auto covariance = scaled_inverse(at.information);
    if (!covariance) return;
    const VecX full = -(*covariance * at.gradient);
    double share = 1, next = 1e300;
    BundleState trial;
    for (int halving = 0; halving < kHalvings; ++halving, share *= 0.5) {
      try {
        trial = with_boards(all_.moved(state_, share * full));
        next = cost_of(trial);
      } catch (const Error&) {  // a step too far: a point behind a lens
        continue;
      }
      if (next < cost) break;
    }
    if (!(next < cost)) return;
    const double fell = cost - next;
    state_ = std::move(trial);
    cost = next;
    if (fell < kStill * (1 + cost)) return;
  }
}

UpdateSolve::Agreement UpdateSolve::judge_points(std::size_t v, std::size_t d) {
  const double limit = options_.outlier_sigmas * options_.outlier_sigmas;
  Agreement out;
  for (const Measurement& m : measurements_of(data_, int(v), int(d))) {
    char& used = used_[v][d][std::size_t(m.index)];
    const auto judged = judged_residual(state_, m);
    ++out.count;
    if (judged) out.squared_px += judged->residual.squaredNorm();
    const double squared = judged ? sigmas_squared(*judged, bundle_.noise[d]) : 1e300;
    const bool within = squared <= limit;
    if (within) ++out.within, out.squared_sigmas += squared;
    out.changed |= bool(used) != within;
    used = within;
  }
  return out;
}

bool UpdateSolve::reject() {
  if (!(options_.outlier_sigmas > 0)) return false;
  bool changed = false;
  for (std::size_t v = 0; v < data_.views.size(); ++v) {
    if (!notes_[v].empty()) continue;
    std::string why;
    for (std::size_t d = 0; d < data_.devices.size(); ++d) {
      const Agreement agreement = judge_points(v, d);
      changed |= agreement.changed;
      if (!agreement.contradicts()) continue;
      why += (why.empty() ? "" : "; ") + data_.devices[d].name + "'s points lie " +
             px(std::sqrt(agreement.squared_px / agreement.count)) +
             " from the places where the rig has them";
    }
    if (!why.empty()) leave_out(v, why), changed = true;
  }
  return changed;
}

bool UpdateSolve::most_agree() const {
  return count_used() > kAgreeingViews * usable_;
}

bool UpdateSolve::Agreement::contradicts() const {
  if (count == 0) return false;
  return within < kAgreeingPoints * count || squared_sigmas > 2 * within * kLongResiduals * kLongResiduals;
}

}  // namespace procam::calibrate
