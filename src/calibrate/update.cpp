#include "procam/calibrate/update.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "joined.hpp"
#include "normal_equations.hpp"
#include "place_camera.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "residual_blocks.hpp"
#include "rig_covariance.hpp"
#include "solve.hpp"

namespace procam::calibrate {
namespace {

constexpr double kRobustSigmas = 3;
/// A view contradicts the rig where fewer than this share of a device's points lies within the outlier limit, or where
/// the residuals of those that do are this many times as long as the rig's own.
constexpr double kAgreeingPoints = 0.5, kLongResiduals = 2;
/// With fewer than this share of the views in agreement, nothing tells which views are right.
constexpr double kAgreeingViews = 0.5;

/// Standard deviations of a change; shares of the parameter, of the picture's sides, or of what is known of any lens.
struct ChangeSize {
  double focal = 0, centre = 0, distortion = 0;
};
constexpr ChangeSize kZoomed{0.3, 0.1, 0.15}, kFocused{0.02, 0.01, 0.03};
constexpr double kTurned = 10 * kDegree, kShifted = 0.2;

/// The views' observations with all devices of the rig, in its order; a device that no view shows has none.
Correspondences of_whole_rig(const Rig& rig, const Correspondences& views) {
  Correspondences data;
  data.board = views.board;
  data.diagnostics = views.diagnostics;
  for (const RigCamera& c : rig.cameras) data.devices.push_back({c.name, DeviceKind::kCamera, c.camera.size});
  for (const RigProjector& p : rig.projectors)
    data.devices.push_back({p.name, DeviceKind::kProjector, p.projector.size()});
  std::vector<int> number;
  for (const Device& device : views.devices) {
    const auto found = std::find_if(data.devices.begin(), data.devices.end(), [&](const Device& d) {
      return d.name == device.name && d.kind == device.kind;
    });
    if (found == data.devices.end())
      throw Error(ErrorKind::kInput, device.name, "the rig has no device of this name and kind",
                  "name the session's folders as the rig's devices");
    if (!(found->size == device.size))
      throw Error(ErrorKind::kInput, device.name, "its size is not that in the rig",
                  "capture with the sizes of the first calibration");
    number.push_back(int(found - data.devices.begin()));
  }
  for (const View& view : views.views) {
    View out{view.name, std::vector<std::vector<Observation>>(data.devices.size()), view.light_points};
    for (std::size_t d = 0; d < view.observations.size(); ++d) {
      std::vector<Observation>& of_device = out.observations[std::size_t(number[d])];
      of_device = view.observations[d];
      for (Observation& o : of_device)
        if (views.devices[d].kind == DeviceKind::kProjector) o.camera = number[std::size_t(o.camera)];
    }
    for (LightPoint& light : out.light_points) {
      light.projector = number[std::size_t(light.projector)];
      light.camera = number[std::size_t(light.camera)];
    }
    data.views.push_back(std::move(out));
  }
  return data;
}

BundleState state_of(const Rig& rig, const Correspondences& data) {
  BundleState state;
  for (const RigCamera& c : rig.cameras) {
    state.lenses.push_back(c.camera);
    state.device_from_rig.push_back(c.rig_from_camera.inverse());
  }
  for (const RigProjector& p : rig.projectors) {
    state.lenses.push_back(p.projector.inverse_camera);
    state.device_from_rig.push_back(p.rig_from_projector.inverse());
  }
  state.rig_from_board.resize(data.views.size());
  state.points_in_board = points_in_board(data.board);
  return state;
}

/// All free parameters of the rig as one vector, whether views show their devices or not.
class Parameters {
 public:
  Parameters(const Rig& rig, const Correspondences& data, BundleState start) : start_(std::move(start)) {
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      const std::string& device = data.devices[d].name;
      lenses_.emplace_back();
      lens_at_.push_back(size());
      held_.emplace_back();
      const std::vector<std::string> lens = parameter_names(start_.lenses[d]);
      for (std::size_t i = 0; i < lens.size(); ++i) {
        if (!rig.covariance.index_of(device + "." + lens[i])) {
          held_.back().push_back(lens[i]);
          continue;
        }
        lenses_.back().push_back(int(i));
        names_.push_back(device + "." + lens[i]);
      }
      const bool is_free = rig.covariance.index_of("rig_from_" + device + ".rx").has_value();
      if (d == 0 && is_free)
        throw Error(ErrorKind::kUnsupported, "rig", "its frame is not fixed to its first camera",
                    "give the rig as calibrate-projector wrote it");
      pose_at_.push_back(is_free ? size() : -1);
      if (!is_free) continue;
      const auto pose = pose_increment_names(device + "_from_rig");
      names_.insert(names_.end(), pose.begin(), pose.end());
    }
    const RigTurn turn = rig_turn(names_, data, start_);
    require(turn.bundle_names == names_, "update_rig: parameters in an unexpected order");
    const MatX back = turn.turn.inverse();
    const MatX covariance = back * rig.covariance.block(turn.rig_names) * back.transpose();
    covariance_ = 0.5 * (covariance + covariance.transpose());
  }

  int size() const { return int(names_.size()); }
  const std::vector<std::string>& names() const { return names_; }
  const MatX& covariance() const { return covariance_; }
  const BundleState& start() const { return start_; }
  const std::vector<std::vector<std::string>>& held() const { return held_; }
  bool holds_pose(std::size_t d) const { return pose_at_[d] < 0; }
  int pose_at(std::size_t d) const { return pose_at_[d]; }
  std::optional<int> lens_at(std::size_t d, const std::string& parameter) const {
    const std::vector<std::string> all = parameter_names(start_.lenses[d]);
    for (std::size_t i = 0; i < lenses_[d].size(); ++i)
      if (all[std::size_t(lenses_[d][i])] == parameter) return lens_at_[d] + int(i);
    return std::nullopt;
  }

  BundleState moved(const BundleState& state, const VecX& step) const {
    BundleState out = state;
    for (std::size_t d = 0; d < state.lenses.size(); ++d) {
      VecX lens = parameters_of(state.lenses[d]);
      for (std::size_t i = 0; i < lenses_[d].size(); ++i) lens[lenses_[d][i]] += step[lens_at_[d] + int(i)];
      out.lenses[d] = with_parameters(state.lenses[d], lens);
      if (pose_at_[d] >= 0)
        out.device_from_rig[d] =
            (se3_exp<double>(step.segment<6>(pose_at_[d])) * state.device_from_rig[d]).normalized();
    }
    return out;
  }

  /// The state's parameters minus the start's.
  VecX difference(const BundleState& state) const {
    VecX out = VecX::Zero(size());
    for (std::size_t d = 0; d < state.lenses.size(); ++d) {
      const VecX change = parameters_of(state.lenses[d]) - parameters_of(start_.lenses[d]);
      for (std::size_t i = 0; i < lenses_[d].size(); ++i) out[lens_at_[d] + int(i)] = change[lenses_[d][i]];
      if (pose_at_[d] >= 0)
        out.segment<6>(pose_at_[d]) = se3_log(state.device_from_rig[d] * start_.device_from_rig[d].inverse());
    }
    return out;
  }

 private:
  BundleState start_;
  std::vector<std::string> names_;
  std::vector<std::vector<int>> lenses_;  ///< by device: positions of the free ones in parameters_of(lens)
  std::vector<std::vector<std::string>> held_;
  std::vector<int> lens_at_, pose_at_;  ///< by device: first row; -1: held
  MatX covariance_;
};

std::size_t device_of(const Correspondences& data, const RigChange& change) {
  const auto found = std::find_if(data.devices.begin(), data.devices.end(),
                                  [&](const Device& d) { return d.name == change.device; });
  if (found == data.devices.end()) {
    std::string known;
    for (const Device& d : data.devices) known += (known.empty() ? "" : ", ") + d.name;
    throw Error(ErrorKind::kInput, "changed device '" + change.device + "'",
                "the rig has no device of this name", "name one of: " + known);
  }
  return std::size_t(found - data.devices.begin());
}

void add_pose_change(const Parameters& all, std::size_t device, MatX& variance) {
  Vec6 square;
  square << Vec3::Constant(kTurned * kTurned), Vec3::Constant(kShifted * kShifted);
  const std::size_t devices = all.start().lenses.size();
  if (device > 0) {
    if (all.holds_pose(device)) return;
    variance.diagonal().segment<6>(all.pose_at(device)) += square;
    return;
  }
  // The first camera carries the rig's frame: all others move against it together.
  MatX by_motion = MatX::Zero(variance.rows(), 6);
  for (std::size_t d = 1; d < devices; ++d)
    if (!all.holds_pose(d)) by_motion.middleRows<6>(all.pose_at(d)) = adjoint(all.start().device_from_rig[d]);
  variance += by_motion * square.asDiagonal() * by_motion.transpose();
}

void add_lens_change(const Parameters& all, std::size_t device, const ChangeSize& size, MatX& variance) {
  const Camera& lens = all.start().lenses[device];
  VecX focal = VecX::Zero(variance.rows());
  if (const auto at = all.lens_at(device, "fx")) focal[*at] = size.focal * lens.intrinsics.fx;
  if (const auto at = all.lens_at(device, "fy")) focal[*at] = size.focal * lens.intrinsics.fy;
  variance += focal * focal.transpose();
  const auto add = [&](const std::string& name, double sigma) {
    if (const auto at = all.lens_at(device, name)) variance(*at, *at) += sigma * sigma;
  };
  add("cx", size.centre * lens.size.width);
  add("cy", size.centre * lens.size.height);
  for (const LensPrior& prior : known_of_any_lens(lens))
    if (prior.terms.front().first != "skew") add(prior.terms.front().first, size.distortion * prior.sigma);
}

MatX variance_of(const std::vector<RigChange>& changes, const Correspondences& data, const Parameters& all) {
  MatX variance = MatX::Zero(all.size(), all.size());
  for (const RigChange& change : changes) {
    const std::size_t device = device_of(data, change);
    if (change.kind == RigChange::Kind::kPose)
      add_pose_change(all, device, variance);
    else
      add_lens_change(all, device, change.kind == RigChange::Kind::kZoom ? kZoomed : kFocused, variance);
  }
  return variance;
}

/// The inverse of a covariance whose parameters differ by many powers of ten.
std::optional<MatX> scaled_inverse(const MatX& covariance) {
  const VecX scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Eigen::LLT<MatX> factors(MatX(scale.asDiagonal() * covariance * scale.asDiagonal()));
  if (factors.info() != Eigen::Success) return std::nullopt;
  const MatX inverse = scale.asDiagonal() *
                       factors.solve(MatX::Identity(covariance.rows(), covariance.cols())) *
                       scale.asDiagonal();
  return MatX(0.5 * (inverse + inverse.transpose()));
}

double sigmas_squared(const JudgedResidual& judged, const ResidualNoise& noise) {
  return judged.residual.dot(noise.covariance(judged.covariance).inverse() * judged.residual);
}

/// The maximum of the posterior, by Gauss-Newton with the boards' poses eliminated.
class Update {
 public:
  Update(const Correspondences& data, const Parameters& all, const UpdateOptions& options, const Rig& rig)
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

  void solve() {
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

  int count_used() const {
    return int(
        std::count_if(notes_.begin(), notes_.end(), [](const std::string& note) { return note.empty(); }));
  }
  bool any_used() const { return count_used() > 0; }
  /// More than half of the views that could be used at the start.
  bool most_agree() const { return count_used() > kAgreeingViews * usable_; }
  bool all_used() const { return count_used() == usable_; }

  const BundleState& state() const { return state_; }
  const UsedMask& used() const { return used_; }
  const std::vector<std::string>& notes() const { return notes_; }
  /// Of the start's prior and the views together.
  MatX covariance() const { return *inverse_of_information(information()); }
  /// (theta - theta_0)^T (P + Q)^-1 (theta - theta_0)
  double prior_cost() const {
    const VecX d = all_.difference(state_);
    return d.dot(prior_ * d);
  }
  double cost() const { return cost_of(state_); }

  /// The change itself, and its covariance: with K = Q (P + Q)^-1 and C the covariance of theta,
  ///   q = K (theta - theta_0),   cov(q) = K P + K C K^T
  /// K P = Q - K Q without the difference of large numbers.
  std::pair<VecX, MatX> change() const {
    const MatX gain = variance_ * prior_;
    const MatX known = gain * all_.covariance();
    return {gain * all_.difference(state_),
            0.5 * (known + known.transpose()) + gain * covariance() * gain.transpose()};
  }

  /// Sigma of a device's fx over fx, if `also` had changed too.
  double focal_sigma_with(const RigChange& also, std::size_t device) const {
    const auto at = all_.lens_at(device, "fx");
    MatX variance = variance_;
    variance += variance_of({also}, data_, all_);
    const auto prior = scaled_inverse(all_.covariance() + variance);
    if (!at || !prior) return 0;
    const auto covariance = inverse_of_information(*prior + information() - prior_);
    return covariance ? std::sqrt((*covariance)(*at, *at)) / state_.lenses[device].intrinsics.fx : 1;
  }

 private:
  static std::optional<MatX> inverse_of_information(const MatX& information) {
    return scaled_inverse(information);
  }

  void leave_out(std::size_t view, const std::string& why) {
    for (auto& of_device : used_[view]) std::fill(of_device.begin(), of_device.end(), char(0));
    notes_[view] = why;
  }

  /// Each board by the first camera that sees enough of it.
  void pose_boards() {
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

  /// Residuals as long as the first calibration left them: the views' own would hide a contradiction.
  void set_noise(const Rig& rig) {
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

  /// Board poses that fit a state's devices best.
  BundleState with_boards(const BundleState& state) const {
    return bundle_adjust(data_, used_, state, hold_devices(bundle_, state)).state;
  }

  double cost_of(const BundleState& state) const {
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

  struct Equations {
    MatX information;  ///< of prior and views
    VecX gradient;
  };
  Equations equations() const {
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
  MatX information() const { return equations().information; }

  void converge() {
    if (!any_used()) return;
    state_ = with_boards(state_);
    double cost = cost_of(state_);
    constexpr int kSteps = 60, kHalvings = 12;
    constexpr double kStill = 1e-9;
    for (int step = 0; step < kSteps; ++step) {
      const Equations at = equations();
      const auto covariance = inverse_of_information(at.information);
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

  /// How a view's points of one device agree with the state; marks those within the limit as used.
  struct Agreement {
    int count = 0, within = 0;
    double squared_px = 0;      ///< over all points
    double squared_sigmas = 0;  ///< over the points within, two components each
    bool changed = false;       ///< a point was rejected, or accepted again

    bool contradicts() const {
      if (count == 0) return false;
      return within < kAgreeingPoints * count ||
             squared_sigmas > 2 * within * kLongResiduals * kLongResiduals;
    }
  };
  Agreement judge_points(std::size_t v, std::size_t d) {
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

  /// Points beyond the outlier limit, and views that contradict the rig in one device. True when anything changed.
  bool reject() {
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

  const Correspondences& data_;
  const Parameters& all_;
  const UpdateOptions& options_;
  UsedMask used_;
  BundleState state_;
  BundleOptions bundle_;
  MatX variance_, prior_;           ///< Q, (P + Q)^-1
  std::vector<std::string> notes_;  ///< by view: why it was rejected
  int usable_ = 0;                  ///< views with enough of the board
};

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
std::vector<RigChange> explanation(const Correspondences& data, const Parameters& all,
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
      Update update(data, all, trial, rig);
      update.solve();
      if (!update.all_used()) continue;
      const double cost = update.cost() + kCostOfChange * double(trial.changed.size());
      if (cost < least) least = cost, best = trial.changed;
    }
  return best;
}

std::vector<DeviceChange> changes_of(const Update& update, const Correspondences& data, const Parameters& all,
                                     const UpdateOptions& options) {
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

/// Parameters that were said to be unchanged, and moved further than their covariance allows.
void remark_on_unchanged(const Update& update, const Parameters& all, Diagnostics& diagnostics) {
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
void remark_on_hidden_zoom(const Update& update, const Correspondences& data, const UpdateOptions& options,
                           Diagnostics& diagnostics) {
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

UpdateResult result_of(const Update& update, const Correspondences& data, const Parameters& all,
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

[[noreturn]] void throw_contradiction(const Update& update, const Correspondences& data,
                                      const Parameters& all, const UpdateOptions& options,
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
  const Parameters all(before, data, state_of(before, data));
  Update update(data, all, options, before);
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
