#include "mount_model.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

#include "quiet_log.hpp"

namespace procam::calibrate::mount {

double Model::knot_time(std::size_t knot) const {
  return stations.empty() ? start + double(knot) * spacing : stations[knot];
}

std::optional<Model::At> Model::at(double time) const {
  if (!stations.empty()) {
    const auto after = std::lower_bound(stations.begin(), stations.end(), time);
    auto found = std::size_t(after - stations.begin());
    if (after == stations.end() || (found > 0 && time - stations[found - 1] < *after - time)) --found;
    if (std::abs(stations[found] - time) > options->station_time) return std::nullopt;
    return At{found, found == 0 ? 1 : found - 1, 0};
  }
  const double steps = (time - start) / spacing, last = double(knots.size() - 1);
  if (!(steps >= 0 && steps <= last)) return std::nullopt;
  const double knot = std::min(std::floor(steps), last - 1);
  return At{std::size_t(knot), std::size_t(knot) + 1, steps - knot};
}

Pose Model::path(double time) const {
  const std::size_t last = knots.size() - 1;
  const At found = at(time).value_or(time < knot_time(0) ? At{0, 1, 0} : At{last, last - 1, 0});
  return between_knots(pose_of(knots[found.knot].data()), pose_of(knots[found.next].data()), found.alpha)
      .pose;
}

std::size_t Model::epoch(const std::vector<Epoch>& epochs, double time) const {
  std::size_t found = 0;
  for (std::size_t i = 1; i < epochs.size(); ++i)
    if (time >= epochs[i].from) found = i;
  return found;
}

namespace {

constexpr double kHuberNorm = 4.5;  // of six whitened residuals: 0.2 % of good ones lie beyond

Mat6 whitening_of(const Mat6& covariance) {
  const Eigen::LLT<Mat6> root(covariance);
  return root.matrixL().solve(Mat6::Identity());
}

/// Of a plane: tilt about x and y, and z.
Mat3 whitening_off_plane(const Mat6& covariance) {
  constexpr std::array<int, 3> kOff{0, 1, 5};
  Mat3 own;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) own(i, j) = covariance(kOff[std::size_t(i)], kOff[std::size_t(j)]);
  return own.llt().matrixL().solve(Mat3::Identity());
}

}  // namespace

struct MountProblem::Impl {
  Model& model;
  bool robust;
  // Before the problem, which refers to them until its end.
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds;
  ceres::HuberLoss huber{kHuberNorm};
  ceres::Problem problem;
  std::vector<ceres::ResidualBlockId> blocks;
  std::vector<std::array<Group, 6>> groups;  ///< by block
  std::vector<int> sizes, base_block, sighting_block;
  std::vector<std::pair<const ceres::CostFunction*, std::vector<double*>>> stated;  ///< of the last mount

  Impl(Model& the_model, bool is_robust) : model(the_model), robust(is_robust), problem(options()) {
    build();
  }

  static ceres::Problem::Options options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  ceres::Manifold* manifold(std::vector<int> free, PoseManifold::Side side = PoseManifold::Side::kRight) {
    manifolds.push_back(std::make_unique<PoseManifold>(std::move(free), side));
    return manifolds.back().get();
  }

  void add(ceres::CostFunction* cost, bool robustly, std::array<Group, 6> rows,
           const std::vector<double*>& parameters) {
    blocks.push_back(problem.AddResidualBlock(cost, robust && robustly ? &huber : nullptr, parameters));
    groups.push_back(rows);
    sizes.push_back(cost->num_residuals());
  }
  static std::array<Group, 6> all(Group group) { return {group, group, group, group, group, group}; }

  void build() {
    const std::vector<int> every{0, 1, 2, 3, 4, 5}, off_plane{0, 1, 5};
    ceres::Manifold* const free = manifold(every);
    for (PoseBlock& knot : model.knots) problem.AddParameterBlock(knot.data(), 7, free);
    for (std::size_t i = 0; i < model.frames.size(); ++i)
      problem.AddParameterBlock(model.frames[i].pose.data(), 7,
                                i == 0 && model.planar ? manifold(off_plane) : free);
    if (!model.planar) problem.SetParameterBlockConstant(model.frames[0].pose.data());
    for (std::size_t m = 0; m < model.markers.size(); ++m)
      problem.AddParameterBlock(model.markers[m].data(), 7, model.is_plane[m] ? manifold(off_plane) : free);
    if (model.world) problem.AddParameterBlock(model.world->data(), 7, free);
    for (Epoch& mount : model.mounts)
      problem.AddParameterBlock(mount.pose.data(), 7, manifold(every, PoseManifold::Side::kMount));
    problem.AddParameterBlock(&model.offset, 1);
    if (model.options->estimate_time_offset) {
      problem.SetParameterLowerBound(&model.offset, 0,
                                     model.options->time_offset - model.options->max_time_offset);
      problem.SetParameterUpperBound(&model.offset, 0,
                                     model.options->time_offset + model.options->max_time_offset);
    } else {
      problem.SetParameterBlockConstant(&model.offset);
    }
    if (model.axes) {
      problem.AddParameterBlock(model.axes->data(), 2);
      add_angles();
    } else {
      problem.AddParameterBlock(&model.scale, 1);
      if (!model.estimates_scale) problem.SetParameterBlockConstant(&model.scale);
      add_base();
    }
    add_sensor();
    add_sightings();
    add_motion();
    if (model.planar) add_floor();
    add_markers();
    add_floor_plane();
    hold_unseen();
    add_stated();
  }

  /// Markers and planes of which no sighting is left.
  void hold_unseen() {
    for (PoseBlock& marker : model.markers) {
      std::vector<ceres::ResidualBlockId> of_marker;
      problem.GetResidualBlocksForParameterBlock(marker.data(), &of_marker);
      if (of_marker.empty()) problem.SetParameterBlockConstant(marker.data());
    }
  }

  void add_base() {
    base_block.assign(model.data->base.size(), -1);
    const Noise& noise = model.noise;
    Vec6 sigma;
    sigma << noise.tilt, noise.tilt, noise.turn, noise.position, noise.position, noise.height;
    sigma *= std::sqrt(noise.correlation);
    std::array<Group, 6> rows{kBaseTilt, kBaseTilt, kBaseTurn, kBasePosition, kBasePosition, kBaseHeight};
    if (!model.planar) rows = {kBaseTurn, kBaseTurn, kBaseTurn, kBasePosition, kBasePosition, kBasePosition};
    for (std::size_t i = 0; i < model.data->base.size(); ++i) {
      const BasePose& pose = model.data->base[i];
      const auto at = model.at(pose.time - model.offset);
      if (!model.use_base[i] || !at) continue;
      auto* cost = new BaseCost;
      cost->measured = pose.world_from_base;
      cost->inverse_sigma = sigma.cwiseInverse();
      cost->time = pose.time;
      cost->knot_time = model.knot_time(at->knot);
      cost->spacing = model.spacing;
      cost->planar = model.planar;
      base_block[i] = int(blocks.size());
      Epoch& frame = model.frames[model.epoch(model.frames, pose.time)];
      add(cost, true, rows,
          {model.knots[at->knot].data(), model.knots[at->next].data(), frame.pose.data(), &model.offset,
           &model.scale});
    }
  }

  void add_angles() {
    base_block.assign(model.data->angles.size(), -1);
    const Noise& noise = model.noise;
    const double turn = std::sqrt(noise.correlation) * noise.turn;
    for (std::size_t i = 0; i < model.data->angles.size(); ++i) {
      const HeadAngles& angles = model.data->angles[i];
      const auto at = model.at(angles.time - model.offset);
      if (!model.use_base[i] || !at) continue;
      auto* cost = new HeadCost;
      cost->pan = angles.pan;
      cost->tilt = angles.tilt;
      cost->whiten = head_whitening(head_pose({(*model.axes)[0], (*model.axes)[1]}, angles.pan, angles.tilt),
                                    turn, noise.position);
      cost->time = angles.time;
      cost->knot_time = model.knot_time(at->knot);
      cost->spacing = model.spacing;
      base_block[i] = int(blocks.size());
      Epoch& frame = model.frames[model.epoch(model.frames, angles.time)];
      add(cost, true, {kBaseTurn, kBaseTurn, kBasePosition, kBasePosition, kBasePosition, kBasePosition},
          {model.knots[at->knot].data(), model.knots[at->next].data(), frame.pose.data(), model.axes->data(),
           &model.offset});
    }
    auto* weak = new WeakAxesCost;
    weak->offset = (*model.axes)[0];
    weak->angle = (*model.axes)[1];
    weak->inverse_sigma = 1e-3;
    add(weak, false, all(kOther), {model.axes->data()});
  }

  void add_sensor() {
    problem.AddParameterBlock(model.sensor.data(), 4);
    const bool has_planes =
        std::any_of(model.is_plane.begin(), model.is_plane.end(), [](char is) { return is != 0; });
    if (!has_planes) {
      problem.SetParameterBlockConstant(model.sensor.data());
      return;
    }
    constexpr double kExact = 1e-6;  // the equations stay solvable
    const MountPlaneSensor& sensor = model.options->plane_sensor;
    auto* cost = new SensorPriorCost;
    cost->inverse_sigma << 1 / std::max(sensor.scale_sigma, kExact),
        Vec3::Constant(1 / std::max(sensor.turn_sigma, kExact));
    add(cost, false, all(kOther), {model.sensor.data()});
  }

  void add_sightings() {
    sighting_block.assign(model.data->sightings.size(), -1);
    Vec6 doubt = Vec6::Zero();  // of the base, besides its path
    if (model.coarse)
      doubt << Vec3::Constant(std::pow(2 * std::max(model.noise.turn, model.options->rotation_sigma), 2)),
          Vec3::Constant(std::pow(2 * std::max(model.noise.position, model.options->position_sigma), 2));
    for (std::size_t i = 0; i < model.data->sightings.size(); ++i) {
      const MarkerSighting& seen = model.data->sightings[i];
      const auto at = model.at(seen.time);
      if (!model.use_sighting[i] || !at) continue;
      Epoch& mount = model.mounts[model.epoch(model.mounts, seen.time)];
      const Mat6 from_base = adjoint(seen.marker_from_rig.pose * pose_of(mount.pose.data()).inverse());
      const double factor = seen.is_plane ? model.noise.plane : model.noise.sighting;
      const Mat6 covariance = std::pow(factor, 2) * seen.marker_from_rig.covariance +
                              from_base * doubt.asDiagonal() * from_base.transpose();
      sighting_block[i] = int(blocks.size());
      const std::vector<double*> parameters{model.knots[at->knot].data(), model.knots[at->next].data(),
                                            mount.pose.data(),
                                            model.markers[std::size_t(model.marker_of[i])].data()};
      if (seen.is_plane) {
        auto* cost = new PlaneCost;
        cost->rig_from_plane = seen.marker_from_rig.pose.inverse();
        cost->whiten = whitening_off_plane(covariance);
        cost->alpha = at->alpha;
        std::vector<double*> with_sensor = parameters;
        with_sensor.push_back(model.sensor.data());
        add(cost, true, {kPlane, kPlane, kPlane, kOther, kOther, kOther}, with_sensor);
      } else {
        auto* cost = new SightingCost;
        cost->rig_from_marker = seen.marker_from_rig.pose.inverse();
        cost->whiten = whitening_of(covariance);
        cost->alpha = at->alpha;
        add(cost, true, all(kSighting), parameters);
      }
    }
  }

  void add_motion() {
    if (!model.stations.empty()) return;
    const double root = model.noise.motion * std::pow(model.spacing, 1.5);
    Vec6 sigma;
    sigma << Vec3::Constant(root * model.options->turn_acceleration),
        Vec3::Constant(root * model.options->acceleration);
    std::array<Group, 6> rows = all(kMotion);
    Vec6 inverse_sigma = sigma.cwiseInverse();
    if (model.planar)
      for (const int i : {0, 1, 5}) inverse_sigma[i] = 0, rows[std::size_t(i)] = kOther;  // the floor's
    for (std::size_t k = 1; k + 1 < model.knots.size(); ++k) {
      auto* cost = new MotionCost;
      cost->inverse_sigma = inverse_sigma;
      add(cost, false, rows, {model.knots[k - 1].data(), model.knots[k].data(), model.knots[k + 1].data()});
    }
  }

  void add_floor() {
    constexpr double kCorrelation = 1;  // s
    const double share = std::exp(-model.spacing / kCorrelation);
    const Vec3 sigma(model.noise.floor_tilt, model.noise.floor_tilt, model.noise.floor);
    const std::array<Group, 6> rows{kFloorTilt, kFloorTilt, kFloorHeight, kOther, kOther, kOther};
    for (std::size_t k = 0; k + 1 < model.knots.size(); ++k) {
      auto* cost = new FloorCost;
      cost->share = share;
      cost->inverse_sigma = (std::sqrt(1 - share * share) * sigma).cwiseInverse();
      add(cost, false, rows, {model.knots[k].data(), model.knots[k + 1].data()});
    }
    auto* first = new FirstFloorCost;
    first->inverse_sigma = sigma.cwiseInverse();
    add(first, false, rows, {model.knots.front().data()});
  }

  void add_markers() {
    for (const MountMarker& known : model.options->markers) {
      const auto name = std::lower_bound(model.marker_names.begin(), model.marker_names.end(), known.name);
      if (name == model.marker_names.end() || *name != known.name) continue;
      if (model.is_plane[std::size_t(name - model.marker_names.begin())]) continue;
      const PoseWithCovariance inverse_of = inverse(known.world_from_marker);
      auto* cost = new MarkerPriorCost;
      cost->marker_from_world = inverse_of.pose;
      // Exactly known is a hundredth of a millimetre: the equations stay solvable.
      cost->whiten = whitening_of(inverse_of.covariance + 1e-10 * Mat6::Identity());
      add(cost, false, all(kOther),
          {model.markers[std::size_t(name - model.marker_names.begin())].data(),
           model.world ? model.world->data() : model.frames[0].pose.data()});
    }
  }

  void add_floor_plane() {
    if (!model.options->floor) return;
    const auto name =
        std::lower_bound(model.marker_names.begin(), model.marker_names.end(), model.options->floor->plane);
    auto* cost = new FloorPlaneCost;
    cost->below = model.options->floor->below;
    cost->inverse_sigma = 1 / model.options->floor->sigma;
    add(cost, false, all(kOther), {model.markers[std::size_t(name - model.marker_names.begin())].data()});
  }

  void add_stated() {
    double* const last = model.mounts.back().pose.data();
    const auto state = [&](ceres::CostFunction* cost, const std::vector<double*>& parameters) {
      add(cost, false, all(kOther), parameters);
      stated.push_back({cost, parameters});
    };
    if (const auto& height = model.options->height) {
      auto* cost = new HeightCost;
      cost->height = height->value;
      cost->sigma = height->sigma;
      state(cost, {last});
    }
    if (const auto& prior = model.options->prior) {
      auto* cost = new MountPriorCost;
      cost->rig_from_base = prior->pose.inverse();
      cost->whiten = whitening_of(prior->covariance);
      state(cost, {last});
    }
    // A hundred metres: no information, but equations that can be solved.
    for (Epoch& mount : model.mounts) {
      auto* weak = new MountPriorCost;
      weak->rig_from_base = pose_of(mount.pose.data()).inverse();
      weak->whiten = 1e-2 * Mat6::Identity();
      if (mount.pose.data() == last)
        state(weak, {last});
      else
        add(weak, false, all(kOther), {mount.pose.data()});
    }
    auto* time = new WeakTimeCost;
    time->start = model.offset;
    time->sigma = model.options->max_time_offset;
    add(time, false, all(kOther), {&model.offset});
  }

  /// The derivative of a block's residuals by one parameter of `columns` numbers, with the robust weight.
  template <int columns>
  Eigen::Matrix<double, 6, columns> derivative(int block, int parameter) const {
    const ceres::CostFunction* cost = problem.GetCostFunctionForResidualBlock(blocks[std::size_t(block)]);
    std::vector<double*> parameters;
    problem.GetParameterBlocksForResidualBlock(blocks[std::size_t(block)], &parameters);
    // Eigen keeps a single column by columns: the same order.
    Eigen::Matrix<double, 6, columns, columns == 1 ? Eigen::ColMajor : Eigen::RowMajor> by;
    std::vector<double*> jacobians(parameters.size(), nullptr);
    jacobians[std::size_t(parameter)] = by.data();
    Vec6 residuals = Vec6::Zero();
    cost->Evaluate(parameters.data(), residuals.data(), jacobians.data());
    const double norm = residuals.norm();
    const double weight = robust && norm > kHuberNorm ? std::sqrt(kHuberNorm / norm) : 1;
    return weight * by;
  }
};

MountProblem::MountProblem(Model& model, bool robust) : impl_(std::make_unique<Impl>(model, robust)) {}
MountProblem::~MountProblem() = default;

void MountProblem::solve(double tolerance) {
  const QuietLog quiet;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 60;
  options.function_tolerance = tolerance;
  options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &impl_->problem, &summary);
  if (!summary.IsSolutionUsable())
    throw Error(
        ErrorKind::kNotConverged, "mount", "the solve failed: " + summary.message,
        "check that the times of poses and sightings belong to one drive and the markers did not move");
}

Mat6 MountProblem::by_frame(std::size_t base) const {
  return impl_->derivative<7>(impl_->base_block[base], 2).leftCols<6>();
}
Vec6 MountProblem::by_scale(std::size_t base) const {
  return impl_->derivative<1>(impl_->base_block[base], 4);
}
Mat6 MountProblem::by_mount(std::size_t sighting) const {
  return impl_->derivative<7>(impl_->sighting_block[sighting], 2).leftCols<6>();
}

Linear MountProblem::linearise() {
  Impl& impl = *impl_;
  Model& model = impl.model;
  Linear linear;
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = true;
  options.residual_blocks = impl.blocks;
  options.num_threads = 1;
  Eigen::Index column = 0;
  const auto take = [&](double* block) {
    if (impl.problem.IsParameterBlockConstant(block)) return Eigen::Index(-1);
    options.parameter_blocks.push_back(block);
    const Eigen::Index first = column;
    column += impl.problem.ParameterBlockTangentSize(block);
    return first;
  };
  for (PoseBlock& knot : model.knots) take(knot.data());
  for (Epoch& frame : model.frames) take(frame.pose.data());
  for (PoseBlock& marker : model.markers) linear.marker_column.push_back(take(marker.data()));
  linear.after_markers = column;
  if (model.world) linear.world_column = take(model.world->data());
  if (!model.axes) linear.scale_column = take(&model.scale);
  linear.sensor_column = take(model.sensor.data());
  for (Epoch& mount : model.mounts) linear.mount_column = take(mount.pose.data());
  if (model.axes) take(model.axes->data());
  take(&model.offset);
  linear.columns = column;

  std::vector<double> residuals;
  ceres::CRSMatrix rows;
  double cost = 0;
  impl.problem.Evaluate(options, &cost, &residuals, nullptr, &rows);
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor, int>> jacobian(
      rows.num_rows, rows.num_cols, Eigen::Index(rows.values.size()), rows.rows.data(), rows.cols.data(),
      rows.values.data());
  linear.jacobian = jacobian;
  linear.residuals = Eigen::Map<const VecX>(residuals.data(), Eigen::Index(residuals.size()));

  std::vector<int> first_row(impl.blocks.size());
  for (std::size_t b = 0; b < impl.blocks.size(); ++b) {
    first_row[b] = int(linear.group.size());
    for (int r = 0; r < impl.sizes[b]; ++r) linear.group.push_back(impl.groups[b][std::size_t(r)]);
  }
  const auto rows_of = [&](const std::vector<int>& of_blocks) {
    std::vector<int> first;
    for (const int block : of_blocks) first.push_back(block < 0 ? -1 : first_row[std::size_t(block)]);
    return first;
  };
  linear.base_row = rows_of(impl.base_block);
  linear.sighting_row = rows_of(impl.sighting_block);

  linear.prior_information = MatX::Zero(6, 6);
  linear.prior_gradient = VecX::Zero(6);
  for (const auto& [stated, parameters] : impl.stated) {
    std::array<double, 42> by{};
    std::array<double, 6> value{};
    double* jacobians[] = {by.data()};
    stated->Evaluate(parameters.data(), value.data(), jacobians);
    const int n = stated->num_residuals();
    const MatX j =
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>>(by.data(), n, 7).leftCols(6);
    linear.prior_information += j.transpose() * j;
    linear.prior_gradient += j.transpose() * Eigen::Map<VecX>(value.data(), n);
  }
  return linear;
}

}  // namespace procam::calibrate::mount
