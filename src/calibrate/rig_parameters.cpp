#include "rig_parameters.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "prior_terms.hpp"
#include "procam/core/geometry/se3.hpp"
#include "residual_blocks.hpp"
#include "rig_covariance.hpp"

namespace procam::calibrate {
namespace {

/// Standard deviations of a change; shares of the parameter, of the picture's sides, or of what is known of any lens.
struct ChangeSize {
  double focal = 0, centre = 0, distortion = 0;
};
constexpr ChangeSize kZoomed{0.3, 0.1, 0.15}, kFocused{0.02, 0.01, 0.03};
constexpr double kTurned = 10 * kDegree, kShifted = 0.2;

void add_pose_change(const RigParameters& all, std::size_t device, MatX& variance) {
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

void add_lens_change(const RigParameters& all, std::size_t device, const ChangeSize& size, MatX& variance) {
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

}  // namespace

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
  state.sheet = flat_sheet(state.points_in_board);
  return state;
}

RigParameters::RigParameters(const Rig& rig, const Correspondences& data, BundleState start)
    : start_(std::move(start)) {
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

BundleState RigParameters::moved(const BundleState& state, const VecX& step) const {
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

VecX RigParameters::difference(const BundleState& state) const {
  VecX out = VecX::Zero(size());
  for (std::size_t d = 0; d < state.lenses.size(); ++d) {
    const VecX change = parameters_of(state.lenses[d]) - parameters_of(start_.lenses[d]);
    for (std::size_t i = 0; i < lenses_[d].size(); ++i) out[lens_at_[d] + int(i)] = change[lenses_[d][i]];
    if (pose_at_[d] >= 0)
      out.segment<6>(pose_at_[d]) = se3_log(state.device_from_rig[d] * start_.device_from_rig[d].inverse());
  }
  return out;
}

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

MatX variance_of(const std::vector<RigChange>& changes, const Correspondences& data,
                 const RigParameters& all) {
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

}  // namespace procam::calibrate
