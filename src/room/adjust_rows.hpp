#pragma once
/// The equations of one point of a room, linearised. A reading depends on few of the system's parameters: its rows hold
/// these alone, in runs of neighbouring columns.
#include <array>
#include <vector>

#include "adjust.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::room {

constexpr int kMaxLensParameters = 16;
using RayByLens = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxLensParameters>;
using PixelByLens = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxLensParameters>;

/// A point on the ray d of its anchor, z = 1, and its inverse depth w along it: U = R d + w t, the anchor's pose being
/// (R, t), is w times the point in the rig's frame.
struct AnchoredPoint {
  int position = 0;  ///< the anchor's
  int lens = 0;      ///< its camera's
  double w = 0;
  Vec3 u;
  Mat3 rotation;
  Vec3 translation;
  /// d by the anchor's lens; no columns: the lens is fixed.
  RayByLens ray_by_lens;
};

/// What one device adds to a reading's derivatives.
struct DeviceTerm {
  int pose, lens;
  Mat23 by_rig_direction;  ///< the weighted derivative by U
  Mat2 weight;
  const ProjectedPoint& projected;
};

/// The two whitened equations of a reading.
struct ReadingRows {
  static constexpr int kMaxColumns = 3 * (6 + kMaxLensParameters), kMaxRuns = 6;
  /// Neighbouring columns: `first` in the system, `at` in the rows.
  struct Run {
    int first = 0, at = 0, count = 0;
  };

  std::array<std::array<double, kMaxColumns>, 2> by_parameters;
  std::array<Run, kMaxRuns> runs;
  int run_count = 0, columns = 0;
  int region = 0;  ///< of the light maps: Adjustment::region()
  Vec2 by_depth = Vec2::Zero(), residual = Vec2::Zero();

  void clear() {
    run_count = columns = 0;
    by_depth.setZero();
    residual.setZero();
  }

  void add(const AnchoredPoint& point, const RoomState& state, const Layout& layout, const DeviceTerm& term) {
    by_depth += term.by_rig_direction *
                (point.translation - state.rig_from_device[std::size_t(term.pose)].translation);
    const Mat23 rotated = term.by_rig_direction * hat(point.u), moved = point.w * term.by_rig_direction;
    add_pose(layout.pose[std::size_t(point.position)], -rotated, -moved, -1);
    add_pose(layout.pose[std::size_t(term.pose)], rotated, -moved, 1);
    if (point.ray_by_lens.cols() > 0)
      add_lens(layout.lens[std::size_t(point.lens)],
               PixelByLens(term.by_rig_direction * point.rotation * point.ray_by_lens));
    add_lens(layout.lens[std::size_t(term.lens)], PixelByLens(term.weight * term.projected.by_lens));
  }

  /// out += J^T right, J by the parameters.
  void add_product(Eigen::Ref<VecX> out, const Vec2& right) const {
    for (int r = 0; r < run_count; ++r) {
      const Run& run = runs[std::size_t(r)];
      for (int c = 0; c < run.count; ++c)
        out[run.first + c] += by_parameters[0][std::size_t(run.at + c)] * right[0] +
                              by_parameters[1][std::size_t(run.at + c)] * right[1];
    }
  }

 private:
  /// Where these columns are in the rows: as before, or new ones of zeros.
  int take(int first, int count) {
    for (int i = 0; i < run_count; ++i)
      if (runs[std::size_t(i)].first == first) return runs[std::size_t(i)].at;
    runs[std::size_t(run_count++)] = {first, columns, count};
    for (auto& row : by_parameters)
      for (int c = 0; c < count; ++c) row[std::size_t(columns + c)] = 0;
    columns += count;
    return columns - count;
  }

  void add_pose(int first, const Mat23& rotation, const Mat23& translation, double sign) {
    if (first < 0) return;
    const auto at = std::size_t(take(first, 6));
    for (std::size_t row = 0; row < 2; ++row)
      for (std::size_t i = 0; i < 3; ++i) {
        by_parameters[row][at + i] += rotation(Eigen::Index(row), Eigen::Index(i));
        by_parameters[row][at + 3 + i] += sign * translation(Eigen::Index(row), Eigen::Index(i));
      }
  }

  /// `columns_of` are neighbours, but for the fixed parameters among them.
  void add_lens(const std::vector<int>& columns_of, const PixelByLens& by_lens) {
    int first = -1, count = 0;
    for (const int column : columns_of)
      if (column >= 0) first = count++ == 0 ? column : first;
    if (count == 0) return;
    const int at = take(first, count);
    for (std::size_t i = 0; i < columns_of.size(); ++i)
      if (columns_of[i] >= 0)
        for (int row = 0; row < 2; ++row)
          by_parameters[std::size_t(row)][std::size_t(at + columns_of[i] - first)] +=
              by_lens(row, Eigen::Index(i));
  }
};

/// All equations of a point.
struct Adjustment::Rows {
  std::vector<ReadingRows> readings;
  int count = 0;  ///< of `readings` that are in use

  void start() { count = 0; }
  ReadingRows& next() {
    if (count == int(readings.size())) readings.emplace_back();
    readings[std::size_t(count)].clear();
    return readings[std::size_t(count++)];
  }

  DepthRows by_depth() const {
    DepthRows out;
    for (int i = 0; i < count; ++i)
      out.add(readings[std::size_t(i)].by_depth, readings[std::size_t(i)].residual);
    return out;
  }

  /// out += J^T right, `right` by reading: Vec2.
  template <typename Right>
  void add_product(Eigen::Ref<VecX> out, const Right& right) const {
    for (int i = 0; i < count; ++i)
      readings[std::size_t(i)].add_product(out, right(readings[std::size_t(i)]));
  }
  /// out += weight J^T r, r the residuals less what the depth can take away.
  void add_gradient(Eigen::Ref<VecX> out, const DepthRows& depth, double weight) const {
    const double along = depth.slope / depth.curvature;
    add_product(
        out, [&](const ReadingRows& rows) { return Vec2(weight * (rows.residual - along * rows.by_depth)); });
  }
  /// The same by regions of the light maps, pulls.col(region): with k = b^T J / b^T b, b the derivatives by the depth, reading i
  /// has the part weight (J_i - b_i k)^T r_i.
  void add_gradient_by_region(MatX& pulls, const DepthRows& depth, double weight) const {
    VecX k = VecX::Zero(pulls.rows());
    add_product(k, [](const ReadingRows& rows) { return rows.by_depth; });
    k *= weight / depth.curvature;
    for (int i = 0; i < count; ++i) {
      const ReadingRows& rows = readings[std::size_t(i)];
      rows.add_product(pulls.col(rows.region), weight * rows.residual);
      pulls.col(rows.region) -= k * rows.by_depth.dot(rows.residual);
    }
  }
  /// The lower triangle of out += weight J^T J.
  void add_information(MatX& out, double weight) const {
    for (int i = 0; i < count; ++i) {
      const ReadingRows& rows = readings[std::size_t(i)];
      for (int a = 0; a < rows.run_count; ++a)
        for (int b = 0; b < rows.run_count; ++b)
          if (rows.runs[std::size_t(a)].first >= rows.runs[std::size_t(b)].first)
            add_block(out, rows, rows.runs[std::size_t(a)], rows.runs[std::size_t(b)], weight);
    }
  }

 private:
  static void add_block(MatX& out, const ReadingRows& rows, const ReadingRows::Run& a,
                        const ReadingRows::Run& b, double weight) {
    const double *first = &rows.by_parameters[0][std::size_t(a.at)],
                 *second = &rows.by_parameters[1][std::size_t(a.at)];
    for (int c = 0; c < b.count; ++c) {
      const double x = weight * rows.by_parameters[0][std::size_t(b.at + c)],
                   y = weight * rows.by_parameters[1][std::size_t(b.at + c)];
      double* to = &out(a.first, b.first + c);
      for (int r = 0; r < a.count; ++r) to[r] += first[r] * x + second[r] * y;
    }
  }
};

}  // namespace procam::room
