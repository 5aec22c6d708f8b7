#include "procam/calibrate/costs/light_point.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "procam/core/geometry/bent_sheet.hpp"

namespace procam::calibrate {

namespace {

using Block = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
struct Jacobians {
  explicit Jacobians(int lens_size) : lens(2, lens_size) {}
  Block lens;
  Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor> device, board;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> point;
  std::array<double*, 4> pointers = {lens.data(), device.data(), board.data(), point.data()};
};

}  // namespace

bool LightPointCost::Evaluate(double const* const* parameters, double* residual, double** jacobians) const {
  const double *camera = parameters[0], *camera_from_rig = parameters[1], *projector = parameters[2],
               *projector_from_rig = parameters[3], *rig_from_board = parameters[4];
  const std::optional<Vec3> direction = direction_of_(camera);
  if (!direction) return false;
  const Pose board_from_camera =
      (pose_from_block(camera_from_rig) * pose_from_block(rig_from_board)).inverse();
  const BentSheet sheet{Eigen::Map<const Vec3>(parameters[5]), centre_};
  const std::optional<Vec3> on_sheet = intersect(board_from_camera * Ray{Vec3::Zero(), *direction}, sheet);
  if (!on_sheet) return false;

  const double* lit_blocks[] = {projector, projector_from_rig, rig_from_board, on_sheet->data()};
  if (jacobians == nullptr) return lit_->Evaluate(lit_blocks, residual, nullptr);

  const double* seen_blocks[] = {camera, camera_from_rig, rig_from_board, on_sheet->data()};
  Jacobians lit(parameter_block_sizes()[2]), seen(parameter_block_sizes()[0]);
  Vec2 nothing;
  if (!lit_->Evaluate(lit_blocks, residual, lit.pointers.data()) ||
      !seen_->Evaluate(seen_blocks, nothing.data(), seen.pointers.data()))
    return false;
  const Vec2 place = on_sheet->head<2>(), slope = sheet.slope(place);
  Eigen::Matrix<double, 3, 2> along;  // the point by the sheet's two coordinates
  along << 1, 0, 0, 1, slope.x(), slope.y();
  const Mat2 seen_by_sheet = seen.point * along;
  if (!(std::abs(seen_by_sheet.determinant()) > 1e-12)) return false;  // the camera sees the sheet edge on
  const Mat2 carry = lit.point * along * seen_by_sheet.inverse();
  if (jacobians[0] != nullptr) Eigen::Map<Block>(jacobians[0], 2, seen.lens.cols()) = -carry * seen.lens;
  if (jacobians[1] != nullptr) Eigen::Map<Block>(jacobians[1], 2, kPoseBlockSize) = -carry * seen.device;
  if (jacobians[2] != nullptr) Eigen::Map<Block>(jacobians[2], 2, lit.lens.cols()) = lit.lens;
  if (jacobians[3] != nullptr) Eigen::Map<Block>(jacobians[3], 2, kPoseBlockSize) = lit.device;
  if (jacobians[4] != nullptr)
    Eigen::Map<Block>(jacobians[4], 2, kPoseBlockSize) = lit.board - carry * seen.board;
  if (jacobians[5] != nullptr)
    Eigen::Map<Block>(jacobians[5], 2, 3) =
        (lit.point - carry * seen.point).col(2) * sheet.height_by_curvature(place).transpose();
  return true;
}

}  // namespace procam::calibrate
