#pragma once
/// The equations of one point of a room, linearised.
#include <vector>

#include "adjust.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::room {

using RayByLens = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 16>;

/// A point on the ray d of its anchor, z = 1, and its inverse depth w along it: U = R d + w t, the anchor's pose being
/// (R, t), is w times the point in the rig's frame.
struct AnchoredPoint {
  int position = 0;  ///< the anchor's
  double w = 0;
  Vec3 u;
  Mat3 rotation;
  Vec3 translation;
  /// d by the anchor's lens, whose columns these are; no columns: the lens is fixed.
  RayByLens ray_by_lens;
  const std::vector<int>* lens_columns = nullptr;
};

/// What one device adds to a reading's derivatives.
struct DeviceTerm {
  int pose, lens;
  Mat23 by_rig_direction;  ///< the weighted derivative by U
  Mat2 weight;
  const ProjectedPoint& projected;
};

/// A point's equations: columns of the parameters in use, the depth's column, the residuals; whitened.
struct Adjustment::Rows {
  std::vector<int> columns;  ///< in the system
  MatX by_parameters;
  VecX by_depth, residual;
  int count = 0;
  std::vector<int> local;  ///< by system column; -1: not in use

  /// `layout` null: the depth's column alone.
  void add(int row, const AnchoredPoint& point, const RoomState& state, const Layout* layout,
           const DeviceTerm& term) {
    const Pose& place = state.rig_from_device[std::size_t(term.pose)];
    by_depth.segment<2>(row) += term.by_rig_direction * (point.translation - place.translation);
    if (layout == nullptr) return;
    const Mat23 rotated = term.by_rig_direction * hat(point.u);
    add_pose(row, layout->pose[std::size_t(point.position)], -rotated, point.w * term.by_rig_direction);
    add_pose(row, layout->pose[std::size_t(term.pose)], rotated, -point.w * term.by_rig_direction);
    if (point.lens_columns != nullptr) {
      const Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 16> by_lens =
          term.by_rig_direction * point.rotation * point.ray_by_lens;
      for (std::size_t i = 0; i < point.lens_columns->size(); ++i)
        if ((*point.lens_columns)[i] >= 0)
          by_parameters.block<2, 1>(row, local[std::size_t((*point.lens_columns)[i])]) +=
              by_lens.col(Eigen::Index(i));
    }
    const std::vector<int>& own = layout->lens[std::size_t(term.lens)];
    for (std::size_t i = 0; i < own.size(); ++i)
      if (own[i] >= 0)
        by_parameters.block<2, 1>(row, local[std::size_t(own[i])]) +=
            term.weight * term.projected.by_lens.col(Eigen::Index(i));
  }

 private:
  void add_pose(int row, int first, const Mat23& rotation, const Mat23& translation) {
    if (first < 0) return;
    const int at = local[std::size_t(first)];
    by_parameters.block<2, 3>(row, at) += rotation;
    by_parameters.block<2, 3>(row, at + 3) += translation;
  }
};

}  // namespace procam::room
