#include "procam/calibrate/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "joined.hpp"
#include "normal_equations.hpp"
#include "place_camera.hpp"
#include "procam/core/geometry/mirror.hpp"
#include "procam/core/geometry/se3.hpp"
#include "solve.hpp"

namespace procam::calibrate {
namespace {

constexpr double kStep = 1e-6;  ///< radians and metres, for central differences

Plane mirror_of(const Pose& camera_from_mirror, double depth) {
  // The board's z points into the sheet, so the reflecting plane lies at z = depth.
  Plane mirror = Plane::of_xy(camera_from_mirror);
  mirror.offset -= depth;
  return mirror;
}

/// Derivative of the left increment of S F by that of the mirror board's pose.
Mat6 motion_by_mirror(const Pose& camera_from_mirror, double depth) {
  const Pose mirrored_from_camera =
      camera_from_mirrored_camera(mirror_of(camera_from_mirror, depth)).inverse();
  const auto moved = [&](int axis, double by) {
    const Pose pose = se3_exp<double>(Vec6(by * Vec6::Unit(axis))) * camera_from_mirror;
    return Vec6(se3_log(camera_from_mirrored_camera(mirror_of(pose, depth)) * mirrored_from_camera));
  };
  Mat6 derivative;
  for (int i = 0; i < 6; ++i) derivative.col(i) = (moved(i, kStep) - moved(i, -kStep)) / (2 * kStep);
  return derivative;
}

/// The mirror board's pose before the camera, its covariance at a known lens, and how the lens moves it.
struct MirrorPose {
  Pose camera_from_mirror;
  Mat6 covariance;
  MatX by_lens;  ///< 6 rows; columns are lens parameters
  double rms_px = 0;
};

MirrorPose measure_mirror(const Camera& lens, const std::string& camera, const MirrorView& view) {
  if (int(view.detections.observations.size()) < kMinPointsPerView)
    throw Error(ErrorKind::kNotEnoughData, "mirror",
                std::to_string(view.detections.observations.size()) + " points of its board were found, " +
                    std::to_string(kMinPointsPerView) + " are needed",
                "take a picture in which the whole board on the mirror is sharp, and check --mirror-board");
  const Points3 board = points_in_board(view.board);
  const auto start = board_pose(lens, board, view.detections.observations);
  if (!start)
    throw Error(ErrorKind::kDegenerate, "mirror", "no pose of its board explains its corners",
                "check --mirror-board, and that the picture was not turned left to right");
  Correspondences data{view.board, {{camera, DeviceKind::kCamera, lens.size}}, {}, {}};
  data.views.push_back({"mirror", {view.detections.observations}});
  BundleState state{{lens}, {Pose()}, {*start}, board};
  const UsedMask used = use_all(data);
  BundleOptions options;
  options.held = {parameter_names(lens)};
  options.noise.resize(1);
  options.hold_pose = {true};
  state = bundle_adjust(data, used, state, options).state;

  MirrorPose mirror;
  mirror.camera_from_mirror = state.rig_from_board[0];
  mirror.rms_px = spread_of(data, state, used).rms_px;
  // chi^2 per degree of freedom, where the residuals exceed the detector's sigma.
  double chi2 = 0;
  for (const Measurement& m : measurements_of(data, 0, 0))
    if (const auto r = reprojection_residual(state, m))
      chi2 += r->dot(m.observation->covariance.ldlt().solve(*r));
  const double freedom = 2.0 * double(view.detections.observations.size()) - 6;
  options.held = {{}};
  const CommonParameters common(data, used, state, options);
  const NormalEquations equations = normal_equations(data, used, state, options, common);
  mirror.covariance = std::max(1.0, chi2 / freedom) * equations.views[0].pose_covariance();
  mirror.by_lens = -equations.views[0].own_by_common;
  return mirror;
}

/// That of the rig as told: the mirrored rig's, and that of the board in the mirror.
MatX covariance_through_mirror(const Rig& mirrored, const MirrorPose& mirror, double depth,
                               const Pose& camera_from_mirrored) {
  // Rows: the rig's parameters as told; columns: the mirrored rig's, then the mirror board's pose.
  const RigCamera& virtual_camera = mirrored.cameras.front();
  const NamedCovariance& before = mirrored.covariance;
  const Eigen::Index n = before.matrix.rows();
  MatX derivative = MatX::Zero(n, n + 6);
  derivative.leftCols(n).setIdentity();
  const std::vector<std::string> names = parameter_names(virtual_camera.camera);
  const VecX signs = turned_signs(virtual_camera.camera);
  MatX mirror_by_all = MatX::Zero(6, n + 6);
  mirror_by_all.rightCols<6>().setIdentity();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto at = before.index_of(virtual_camera.name + "." + names[i])) {
      const auto column = Eigen::Index(*at);
      derivative(column, column) = signs[Eigen::Index(i)];
      mirror_by_all.col(column) = signs[Eigen::Index(i)] * mirror.by_lens.col(Eigen::Index(i));
    }
  const MatX motion = motion_by_mirror(mirror.camera_from_mirror, depth) * mirror_by_all;
  for (const RigProjector& projector : mirrored.projectors) {
    const auto at = before.index_of("rig_from_" + projector.name + ".rx");
    if (!at) continue;
    const auto row = Eigen::Index(*at);
    derivative.block(row, 0, 6, n).setZero();
    derivative.block<6, 6>(row, row) = adjoint(camera_from_mirrored);
    derivative.block(row, 0, 6, n + 6) += motion;
  }
  MatX known = MatX::Zero(n + 6, n + 6);
  known.topLeftCorner(n, n) = before.matrix;
  known.bottomRightCorner<6, 6>() = mirror.covariance;
  const MatX told = derivative * known * derivative.transpose();
  return 0.5 * (told + told.transpose());
}

Gate side_gate(const CalibrationResult& result, const Plane& mirror_in_camera) {
  // The camera stands on one side of the mirror, and so do the boards that it reflects.
  const double side = mirror_in_camera.signed_distance(Vec3::Zero());
  int beyond = 0;
  for (const ViewResult& v : result.views)
    beyond += v.used && mirror_in_camera.signed_distance(v.rig_from_board.translation) * side <= 0;
  Gate gate{"boards in the mirror", beyond == 0, "all"};
  if (beyond > 0)
    gate.detail =
        std::to_string(beyond) +
        " stand behind the mirror: it, or the camera, was moved after its picture was taken, or the "
        "session was not captured through it";
  return gate;
}

}  // namespace

MirrorSolution through_mirror(const CalibrationResult& mirrored, const MirrorView& view) {
  require(mirrored.rig.cameras.size() == 1, "through_mirror: the session must have one camera");
  const RigCamera& virtual_camera = mirrored.rig.cameras.front();
  require(view.detections.image_size == virtual_camera.camera.size,
          "through_mirror: the mirror's picture has another size than the session's");
  MirrorSolution solution{mirrored, {}, 0};
  CalibrationResult& result = solution.result;
  Rig& rig = result.rig;
  const std::string& camera = virtual_camera.name;
  rig.cameras.front().camera = turned_left_to_right(virtual_camera.camera);
  const MirrorPose mirror = measure_mirror(rig.cameras.front().camera, camera, view);
  solution.mirror_in_camera = mirror_of(mirror.camera_from_mirror, view.depth);
  solution.rms_px = mirror.rms_px;
  const Pose camera_from_mirrored = camera_from_mirrored_camera(solution.mirror_in_camera);
  for (RigProjector& projector : rig.projectors)
    projector.rig_from_projector = camera_from_mirrored * projector.rig_from_projector;
  for (ViewResult& v : result.views) {
    v.rig_from_board = camera_from_mirrored * v.rig_from_board;
    const Mat6 turn = adjoint(camera_from_mirrored);
    v.rig_from_board_covariance = turn * v.rig_from_board_covariance * turn.transpose();
  }

  rig.covariance.matrix = covariance_through_mirror(mirrored.rig, mirror, view.depth, camera_from_mirrored);
  const Gate gate = side_gate(result, solution.mirror_in_camera);
  rig.quality.gates.push_back(gate);
  if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  return solution;
}

}  // namespace procam::calibrate
