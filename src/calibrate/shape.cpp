#include "shape.hpp"

#include <algorithm>
#include <cmath>

#include "procam/calibrate/uncertainty.hpp"
#include "solve.hpp"
#include "start.hpp"

namespace procam::calibrate {
namespace {

constexpr double kSigmaShare = 0.01;
constexpr std::size_t kViewsThatShape = 8;  ///< enough to know the shape by; the order of the rest follows

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
  const BundleOptions poses_only = hold_devices(options, state);
  BundleOptions shape_and_poses = poses_only;
  shape_and_poses.board_sigma = board_sigma(state.points_in_board);

  UsedMask seen = only_view(used, used.size());  // no view yet
  std::size_t views = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (spread_of(data, state, used, -1, int(v)).count == 0) continue;
    if (views > 0) {
      const UsedMask only = only_view(used, v);
      const BundleState as_given = bundle_adjust(data, only, state, poses_only).state;
      Correspondences other = data;
      BundleState other_state = state;
      turn_view(other, other_state, v);
      other_state = bundle_adjust(other, only, other_state, poses_only).state;
      if (spread_of(other, other_state, used, -1, int(v)).rms_px <
          spread_of(data, as_given, used, -1, int(v)).rms_px) {
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

std::vector<std::optional<BundleState>> views_left_out(const Correspondences& data, const UsedMask& used,
                                                       const UsedMask& judged, const BundleState& solution,
                                                       const BundleOptions& options) {
  auto without = leave_one_view_out(data, used, solution, options);
  const BundleOptions pose_only = hold_devices(options, solution);
  for (std::size_t v = 0; v < without.size(); ++v) {
    if (!without[v]) continue;
    const int camera = posing_camera(data, judged, v);
    if (camera < 0)
      without[v].reset();
    else
      without[v] = bundle_adjust(data, only_view(judged, v, camera), *without[v], pose_only).state;
  }
  return without;
}

std::vector<std::optional<double>> predicted_holdout(const Correspondences& data, const UsedMask& used,
                                                     const UsedMask& judged, const BundleState& solution,
                                                     const BundleOptions& options) {
  const auto without = views_left_out(data, used, judged, solution, options);
  std::vector<std::optional<double>> by_view(without.size());
  for (std::size_t v = 0; v < without.size(); ++v) {
    if (!without[v]) continue;
    const Spread spread = spread_of(data, *without[v], judged, -1, int(v));
    if (spread.count > 0) by_view[v] = spread.rms_px;
  }
  return by_view;
}

HoldoutGain compare_holdout(const std::vector<std::optional<double>>& flat,
                            const std::vector<std::optional<double>>& free) {
  HoldoutGain gain;
  std::vector<double> ratios;
  for (std::size_t v = 0; v < flat.size(); ++v) {
    if (!flat[v] || !free[v]) continue;
    gain.flat_px += *flat[v], gain.free_px += *free[v];
    ratios.push_back(*free[v] / std::max(*flat[v], 1e-12));
  }
  if (ratios.empty()) return gain;
  gain.flat_px /= double(ratios.size()), gain.free_px /= double(ratios.size());
  const auto middle = ratios.begin() + long(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  gain.usual_ratio = *middle;
  return gain;
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
