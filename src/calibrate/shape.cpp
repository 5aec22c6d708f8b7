#include "shape.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "residual_blocks.hpp"
#include "start.hpp"
#include "uncertainty.hpp"

namespace procam::calibrate {
namespace {

constexpr double kSigmaShare = 0.01;
constexpr double kSheetShare =
    1e-4;  ///< of 35 mm it is 3.5 um: more than the solve's own accuracy, less than noise shows
constexpr std::size_t kViewsThatShape = 8;  ///< enough to know the shape by; the order of the rest follows

void turn_view(Correspondences& data, BundleState& state, std::size_t view) {
  const Points3 printed = points_in_board(data.board);
  for (auto& observations : data.views[view].observations)
    for (Observation& o : observations) o.point = int(printed.size()) - 1 - o.point;
  // The first point takes the last one's place: p -> first + last - p in the plane.
  state.rig_from_board[view] =
      state.rig_from_board[view] * Pose(Eigen::Quaterniond(0, 0, 0, 1), printed.front() + printed.back());
}

double spacing_of(const Points3& printed) {
  double spacing = 1e300;
  for (std::size_t i = 1; i < printed.size(); ++i)
    spacing = std::min(spacing, (printed[i] - printed[i - 1]).norm());
  return spacing;
}

}  // namespace

double board_sigma(const Points3& printed) {
  return kSigmaShare * spacing_of(printed);
}

double sheet_sigma(const Points3& printed) {
  return kSheetShare * spacing_of(printed);
}

bool flexes_visibly(const EstimatedShape& shape, const Points3& printed) {
  return shape.flex_rms > 3 * sheet_sigma(printed);
}

bool bends_visibly(const EstimatedShape& shape, const Points3& printed) {
  return shape.free && (shape.free_points || shape.flex_rms == 0 ||
                        shape.out_of_plane_rms > std::max(3 * sheet_sigma(printed), shape.flex_rms));
}

std::vector<int> settle_order_by_shape(Correspondences& data, const UsedMask& used, BundleState& state,
                                       const BundleOptions& options) {
  std::vector<int> turned;
  if (!is_symmetric_180(data.board)) return turned;
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

std::vector<std::optional<BundleState>> views_held_out(const Correspondences& data, const UsedMask& used,
                                                       const UsedMask& judged, const BundleState& solution,
                                                       const BundleOptions& options) {
  auto without = leave_one_view_out(data, used, solution, options);
  const BundleOptions pose_only = hold_devices(options, solution);
  for (std::size_t v = 0; v < without.size(); ++v) {
    if (!without[v]) continue;
    const int camera = posing_camera(data, judged, v);
    try {
      if (camera < 0)
        without[v].reset();
      else
        without[v] = bundle_adjust(data, only_view(judged, v, camera), *without[v], pose_only).state;
    } catch (const Error&) {  // a lens that without this view cannot project its points
      without[v].reset();
    }
  }
  return without;
}

std::optional<double> predicted_holdout(const Correspondences& data, const UsedMask& used,
                                        const UsedMask& judged, const BundleState& solution,
                                        const BundleOptions& options) {
  const auto without = views_held_out(data, used, judged, solution, options);
  const std::vector<double> weights = view_weights(used, options);
  double sum = 0, views = 0;
  for (std::size_t v = 0; v < without.size(); ++v) {
    if (!without[v]) continue;
    const Spread spread = spread_of(data, *without[v], judged, -1, int(v));
    if (spread.count == 0) continue;
    sum += weights[v] * spread.rms_px;
    views += weights[v];
  }
  if (!(views > 0)) return std::nullopt;
  return sum / views;
}

double explained_by_shape(const Correspondences& simple_data, const Solution& simple,
                          const Correspondences& general_data, const Solution& general, double freedom,
                          double freedom_of_general) {
  const std::vector<double> weights = view_weights(simple.used, simple.options);
  double simple_squares = 0, general_squares = 0, count = 0, views = 0;
  for (std::size_t v = 0; v < simple_data.views.size(); ++v) {
    bool counts = false;
    for (std::size_t d = 0; d < simple_data.devices.size(); ++d) {
      const auto simple_all = measurements_of(simple_data, int(v), int(d)),
                 general_all = measurements_of(general_data, int(v), int(d));
      for (std::size_t i = 0; i < simple_all.size(); ++i) {
        if (!simple.used[v][d][i] || !general.used[v][d][i]) continue;
        const auto a = judged_residual(simple.state(), simple_all[i]),
                   b = judged_residual(general.state(), general_all[i]);
        if (!a || !b) continue;
        const Mat2 information = simple.options.noise[d].covariance(a->covariance).inverse();
        simple_squares += weights[v] * a->residual.dot(information * a->residual);
        general_squares += weights[v] * b->residual.dot(information * b->residual);
        count += weights[v];
        counts = true;
      }
    }
    if (counts) views += weights[v];
  }
  const double rest = 2.0 * count - 6.0 * views - freedom_of_general;
  if (freedom < 1 || rest < 1) return 0;
  const double ratio =
      ((simple_squares - general_squares) / freedom) / (std::max(general_squares, 1e-12) / rest);
  return (ratio - 1) / std::sqrt(2 / freedom + 2 / rest);
}

EstimatedShape measure_shape(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  const Points3 printed = points_in_board(data.board);
  EstimatedShape shape;
  shape.free = true;
  shape.sheet = state.sheet;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (m.light == nullptr || !solution.used[v][d][std::size_t(m.index)]) continue;
        const auto place = place_in_rig(state, int(v), *m.light);
        if (!place) continue;
        const Vec3 in_board = state.rig_from_board[v].inverse() * *place;
        shape.largest_of_light = std::max(shape.largest_of_light, std::abs(in_board.z()));
      }
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : printed) middle += p / double(printed.size());
  Vec2 moved = Vec2::Zero(), spread = Vec2::Constant(1e-300);
  for (std::size_t i = 0; i < printed.size(); ++i) {
    const Vec3 offset = state.points_in_board[i] - printed[i];
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
