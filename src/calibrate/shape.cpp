#include "shape.hpp"

#include <algorithm>
#include <cmath>

#include "procam/calibrate/uncertainty.hpp"
#include "start.hpp"

namespace procam::calibrate {
namespace {

constexpr double kSigmaShare = 0.01;
constexpr std::size_t kViewsThatShape = 8;  ///< enough to know the shape by; the order of the rest follows

UsedMask only_view(const UsedMask& used, std::size_t view) {
  UsedMask only = used;
  for (std::size_t v = 0; v < only.size(); ++v)
    for (auto& of_device : only[v])
      if (v != view) std::fill(of_device.begin(), of_device.end(), char(0));
  return only;
}

/// Everything held that views share but, perhaps, the board's points.
BundleOptions hold_devices(BundleOptions options, const BundleState& state) {
  for (std::size_t d = 0; d < state.lenses.size(); ++d) {
    options.held[d] = parameter_names(state.lenses[d]);
    options.hold_pose[d] = true;
  }
  return options;
}

struct Sum {
  double squares = 0;
  int count = 0;
  double rms() const { return count > 0 ? std::sqrt(squares / count) : 0; }
};

Sum residuals_of_view(const Correspondences& data, const UsedMask& used, const BundleState& state,
                      std::size_t view) {
  Sum sum;
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    for (const Measurement& m : measurements_of(data, int(view), int(d))) {
      if (!used[view][d][std::size_t(m.index)]) continue;
      const auto r = reprojection_residual(state, m);
      if (!r) continue;
      sum.squares += r->squaredNorm();
      ++sum.count;
    }
  return sum;
}

void turn_view(Correspondences& data, BundleState& state, std::size_t view) {
  const Points3 printed = points_in_board(data.board);
  for (auto& observations : data.views[view].observations)
    for (Observation& o : observations) o.point = int(printed.size()) - 1 - o.point;
  // The first point takes the last one's place: p -> first + last - p in the plane.
  state.rig_from_board[view] =
      state.rig_from_board[view] * Pose(Eigen::Quaterniond(0, 0, 0, 1), printed.front() + printed.back());
}

}  // namespace

double board_sigma(const Points3& printed) {
  double spacing = 1e300;
  for (std::size_t i = 1; i < printed.size(); ++i)
    spacing = std::min(spacing, (printed[i] - printed[i - 1]).norm());
  return kSigmaShare * spacing;
}

std::vector<int> settle_order_by_shape(Correspondences& data, const UsedMask& used, BundleState& state,
                                       const BundleOptions& options) {
  std::vector<int> turned;
  if (!looks_same_turned(data.board)) return turned;
  BundleOptions poses_only = hold_devices(options, state);
  poses_only.board_sigma = 0;
  BundleOptions shape_and_poses = poses_only;
  shape_and_poses.board_sigma = board_sigma(state.points_in_board);

  UsedMask seen = only_view(used, used.size());  // no view yet
  std::size_t views = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (residuals_of_view(data, used, state, v).count == 0) continue;
    if (views > 0) {
      const UsedMask only = only_view(used, v);
      const BundleState as_given = bundle_adjust(data, only, state, poses_only).state;
      Correspondences other = data;
      BundleState other_state = state;
      turn_view(other, other_state, v);
      other_state = bundle_adjust(other, only, other_state, poses_only).state;
      if (residuals_of_view(other, used, other_state, v).rms() <
          residuals_of_view(data, used, as_given, v).rms()) {
        data = other;
        state = other_state;
        turned.push_back(int(v));
      }
    }
    seen[v] = used[v];
    if (++views <= kViewsThatShape) state = bundle_adjust(data, seen, state, shape_and_poses).state;
  }
  return turned;
}

std::optional<double> predicted_holdout(const Correspondences& data, const UsedMask& used,
                                        const UsedMask& judged, const BundleState& solution,
                                        const BundleOptions& options) {
  const auto without = leave_one_view_out(data, used, solution, options);
  BundleOptions pose_only = hold_devices(options, solution);
  pose_only.board_sigma = 0;
  double sum = 0;
  int views = 0;
  for (std::size_t v = 0; v < without.size(); ++v) {
    if (!without[v]) continue;
    UsedMask camera = only_view(judged, v);
    for (std::size_t d = 1; d < camera[v].size(); ++d)
      std::fill(camera[v][d].begin(), camera[v][d].end(), char(0));
    const BundleState state = bundle_adjust(data, camera, *without[v], pose_only).state;
    const Sum residuals = residuals_of_view(data, judged, state, v);
    if (residuals.count == 0) continue;
    sum += residuals.rms();
    ++views;
  }
  if (views == 0) return std::nullopt;
  return sum / views;
}

EstimatedShape measure_shape(const Points3& printed, const Points3& points_in_board) {
  EstimatedShape shape;
  shape.free = true;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : printed) middle += p / double(printed.size());
  Vec2 moved = Vec2::Zero(), spread = Vec2::Constant(1e-300);
  for (std::size_t i = 0; i < printed.size(); ++i) {
    const Vec3 offset = points_in_board[i] - printed[i];
    shape.offsets.push_back(offset);
    shape.in_plane_rms += offset.head<2>().squaredNorm() / double(printed.size());
    shape.out_of_plane_rms += offset.z() * offset.z() / double(printed.size());
    shape.largest = std::max(shape.largest, offset.norm());
    const Vec2 arm = (printed[i] - middle).head<2>();
    moved += arm.cwiseProduct(offset.head<2>());
    spread += arm.cwiseProduct(arm);
  }
  shape.in_plane_rms = std::sqrt(shape.in_plane_rms);
  shape.out_of_plane_rms = std::sqrt(shape.out_of_plane_rms);
  shape.stretch_x_over_y = moved.x() / spread.x() - moved.y() / spread.y();
  return shape;
}

}  // namespace procam::calibrate
