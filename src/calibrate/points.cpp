#include "procam/calibrate/points.hpp"

#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "common_error.hpp"
#include "initial.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/costs/lens_prior.hpp"
#include "procam/calibrate/costs/se3_manifold.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/se3.hpp"
#include "quiet_log.hpp"
#include "residual_blocks.hpp"
#include "rig_checks.hpp"

namespace procam::calibrate {
namespace {

struct PointsFit {
  Camera lens;
  Pose device_from_world;
  double within_px = 1e300;  ///< as many pairs as must agree (agreeing_pairs) lie within this
};

/// What the solve is about, once.
struct PointsProblem {
  const Device& device;
  const std::vector<PointPair>& pairs;
  const PointsOptions& options;
};

std::string describe_pair(const PointsProblem& problem, std::size_t i) {
  const std::string& name = problem.pairs[i].name;
  return name.empty() ? "pair " + std::to_string(i + 1) : "'" + name + "'";
}

std::optional<Vec2> residual_of(const PointsFit& fit, const PointPair& pair) {
  const auto pixel = fit.lens.project(fit.device_from_world * pair.point_in_world);
  if (!pixel) return std::nullopt;
  return Vec2(*pixel - pair.pixel);
}

/// How many of the pairs must agree before a fit is believed: half of them and half of those that any wrong
/// fit can run through, [n / 2] + [(p + 1) / 2] with p = ceil(unknowns / 2) (Rousseeuw and Leroy, "Robust
/// regression and outlier detection", 1987). The plain median of five pairs is zero for any place that
/// explains three.
std::size_t agreeing_pairs(const PointsProblem& problem) {
  const LensOptions& lens = problem.options.lens;
  const Camera model{problem.device.size, {1, 1, 0, 0, 0}, lens.model};
  const std::size_t free = parameter_names(model).size() - held_parameters(model, lens.held).size();
  const std::size_t unknowns = free + 6 - std::min(lens.priors.size(), free), fitted = (unknowns + 1) / 2;
  const std::size_t count = problem.pairs.size();
  return std::min(count, count / 2 + (fitted + 1) / 2);
}

double within_px(const PointsProblem& problem, const PointsFit& fit) {
  std::vector<double> lengths;
  for (const PointPair& pair : problem.pairs) {
    const auto r = residual_of(fit, pair);
    lengths.push_back(r ? r->norm() : 1e300);
  }
  return at_rank(lengths, agreeing_pairs(problem) - 1);
}

/// Least squares from a start, the residuals in units of `sigma_px`; nullopt when it leads nowhere.
std::optional<PointsFit> refine(const PointsProblem& problem, const PointsFit& start,
                                const std::vector<char>& used, double sigma_px, bool lens_known) {
  const VecX parameters = parameters_of(start.lens);
  std::vector<double> lens(parameters.data(), parameters.data() + parameters.size());
  std::array<double, kPoseBlockSize> pose, identity;
  pose_to_block(start.device_from_world, pose.data());
  pose_to_block(Pose(), identity.data());
  Points3 points;
  for (const PointPair& pair : problem.pairs) points.push_back(pair.point_in_world);

  ceres::Problem solver_problem;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used[i]) continue;
    solver_problem.AddResidualBlock(
        reprojection_cost(start.lens.distortion, problem.pairs[i].pixel, Mat2::Identity() / sigma_px)
            .release(),
        new ceres::HuberLoss(3), lens.data(), pose.data(), identity.data(), points[i].data());
    solver_problem.SetParameterBlockConstant(points[i].data());
  }
  solver_problem.SetParameterBlockConstant(identity.data());
  solver_problem.SetManifold(pose.data(), new Se3Manifold);
  const LensOptions& options = problem.options.lens;
  const std::vector<int> held = held_parameters(start.lens, options.held);
  if (lens_known || held.size() == lens.size()) {
    solver_problem.SetParameterBlockConstant(lens.data());
  } else {
    for (const LensPrior& prior : options.priors)
      solver_problem.AddResidualBlock(
          new LensPriorCost(prior_weights(prior, start.lens), prior.value, prior.sigma), nullptr,
          lens.data());
    if (!held.empty())
      solver_problem.SetManifold(lens.data(), new ceres::SubsetManifold(int(lens.size()), held));
  }
  ceres::Solver::Options solver;
  solver.max_num_iterations = 200;
  solver.function_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-12;
  solver.gradient_tolerance = 1e-12;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const QuietLog quiet;
  ceres::Solve(solver, &solver_problem, &summary);
  if (summary.termination_type != ceres::CONVERGENCE) return std::nullopt;

  PointsFit fit;
  fit.lens = with_parameters(start.lens, Eigen::Map<const VecX>(lens.data(), Eigen::Index(lens.size())));
  fit.device_from_world = pose_from_block(pose.data()).normalized();
  if (!(fit.lens.intrinsics.fx > 0) || !(fit.lens.intrinsics.fy > 0)) return std::nullopt;
  fit.within_px = within_px(problem, fit);
  return fit;
}

/// The lens that the priors describe, principal point at the centre where they say nothing; nullopt when
/// they leave the focal length open.
std::optional<Camera> lens_of_priors(const PointsProblem& problem) {
  const ImageSize size = problem.device.size;
  Camera lens{size, {1, 1, 0.5 * (size.width - 1), 0.5 * (size.height - 1), 0}, problem.options.lens.model};
  // Least squares over the priors, weakly tied to a centred lens of square pixels and any length.
  const VecX centred = parameters_of(lens);
  MatX normal = MatX::Zero(centred.size(), centred.size());
  VecX right = VecX::Zero(centred.size());
  for (const LensPrior& prior : problem.options.lens.priors) {
    const VecX weights = prior_weights(prior, lens) / prior.sigma;
    normal += weights * weights.transpose();
    right += weights * (prior.value / prior.sigma);
  }
  constexpr double kLengthKnown = 1e-9;  // a sigma of 30 000 pixels has no information
  if (!(normal(0, 0) + normal(1, 1) - 2 * std::abs(normal(0, 1)) > kLengthKnown)) return std::nullopt;
  const LensPrior square = square_pixels();
  const VecX squareness = prior_weights(square, lens) / size.width;
  normal += squareness * squareness.transpose();
  for (Eigen::Index i = 2; i < centred.size(); ++i) {
    const double weak = i < 5 ? 1.0 / (double(size.width) * size.width) : 1.0;
    normal(i, i) += weak;
    right[i] += weak * centred[i];
  }
  lens = with_parameters(lens, normal.ldlt().solve(right));
  if (!(lens.intrinsics.fx > 0) || !(lens.intrinsics.fy > 0) || !parameters_of(lens).allFinite())
    return std::nullopt;
  return lens;
}

/// The 24 turns that carry a cube's axes onto each other: some turn is within 62 degrees of any.
std::vector<Mat3> turns_of_a_cube() {
  std::vector<Mat3> turns;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int signs = 0; signs < 4; ++signs) {
        if (i == j) continue;
        Mat3 turn;
        turn.row(0) = (signs & 1 ? -1 : 1) * Vec3(Vec3::Unit(i)).transpose();
        turn.row(1) = (signs & 2 ? -1 : 1) * Vec3(Vec3::Unit(j)).transpose();
        turn.row(2) = turn.row(0).cross(turn.row(1));
        turns.push_back(turn);
      }
  return turns;
}

/// Given the rotation, the points' distances off the pixels' rays are linear in the translation.
std::optional<Pose> place_turned(const PointsProblem& problem, const Camera& lens, const Mat3& rotation) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const PointPair& pair : problem.pairs) {
    const auto bearing = lens.unproject(pair.pixel);
    if (!bearing) return std::nullopt;
    const Mat3 across = Mat3::Identity() - *bearing * bearing->transpose();
    normal += across;
    right -= across * (rotation * pair.point_in_world);
  }
  if (!(std::abs(normal.determinant()) > 1e-12)) return std::nullopt;
  Vec3 translation = normal.inverse() * right;
  // All in front of the device, if need be by moving off.
  double nearest = 1e300, extent = 0;
  for (const PointPair& pair : problem.pairs) {
    const Vec3 turned = rotation * pair.point_in_world;
    nearest = std::min(nearest, turned.z() + translation.z());
    extent = std::max(extent, (pair.point_in_world - problem.pairs.front().point_in_world).norm());
  }
  if (nearest < 0.05 * extent) translation.z() += 0.05 * extent - nearest;
  return Pose(rotation, translation);
}

/// All starts worth refining.
std::vector<PointsFit> starts(const PointsProblem& problem, std::string& why) {
  std::vector<PointsFit> all;
  const std::size_t count = problem.pairs.size();
  const auto resect_these = [&](const std::vector<std::size_t>& which) {
    Points3 points;
    Points2 pixels;
    for (const std::size_t i : which) {
      points.push_back(problem.pairs[i].point_in_world);
      pixels.push_back(problem.pairs[i].pixel);
    }
    try {
      const Resection resection = resect(points, pixels, problem.device.name);
      PointsFit start{{problem.device.size, resection.intrinsics, problem.options.lens.model},
                      resection.device_from_points};
      const auto& held = problem.options.lens.held;
      if (std::count(held.begin(), held.end(), "skew") > 0) start.lens.intrinsics.skew = 0;
      start.within_px = within_px(problem, start);
      all.push_back(start);
    } catch (const Error& error) {
      why = error.why();
    }
  };
  std::vector<std::size_t> everyone(count);
  for (std::size_t i = 0; i < count; ++i) everyone[i] = i;
  resect_these(everyone);
  // Sixes drawn at random: a single blunder in the data ruins the solve of all.
  constexpr std::size_t kMinimal = 6, kCheckable = 8;
  constexpr int kDraws =
      150;  // 99 % for one good six when three in ten pairs are blunders: ln .01 / ln(1 - .7^6) = 37
  std::mt19937 random(1);
  for (int draw = 0; draw < kDraws && count >= kCheckable; ++draw) {
    std::shuffle(everyone.begin(), everyone.end(), random);
    resect_these({everyone.begin(), everyone.begin() + kMinimal});
  }
  if (const auto known = lens_of_priors(problem))
    for (const Mat3& turn : turns_of_a_cube())
      if (const auto pose = place_turned(problem, *known, turn)) {
        const std::vector<char> everything(count, 1);
        const auto posed = refine(problem, {*known, *pose}, everything, problem.options.sigma_px, true);
        if (posed) all.push_back(*posed);
      }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.within_px < b.within_px; });
  return all;
}

/// Rows of the whitened derivative: two a used pair, one a prior; columns: free lens parameters, pose.
struct PointsEquations {
  std::vector<int> free;  ///< positions in parameters_of(lens)
  MatX by_unknowns;
  MatX by_point;                         ///< of the pairs' rows
  std::vector<std::size_t> pair_of_row;  ///< of the first 2 * used rows
  int priors = 0;
};

PointsEquations linearise(const PointsProblem& problem, const PointsFit& fit, const std::vector<char>& used,
                          double sigma_px) {
  PointsEquations out;
  const VecX lens = parameters_of(fit.lens);
  const std::vector<int> held = held_parameters(fit.lens, problem.options.lens.held);
  for (int i = 0; i < int(lens.size()); ++i)
    if (!std::binary_search(held.begin(), held.end(), i)) out.free.push_back(i);
  const auto free = Eigen::Index(out.free.size());
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) out.pair_of_row.insert(out.pair_of_row.end(), {i, i});
  out.priors = int(problem.options.lens.priors.size());
  out.by_unknowns = MatX::Zero(Eigen::Index(out.pair_of_row.size()) + out.priors, free + 6);
  std::array<double, kPoseBlockSize> pose, identity;
  pose_to_block(fit.device_from_world, pose.data());
  pose_to_block(Pose(), identity.data());
  using TwoRows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  TwoRows by_lens(2, lens.size()), by_pose(2, kPoseBlockSize), by_point(2, 3);
  out.by_point = MatX::Zero(Eigen::Index(out.pair_of_row.size()), 3);
  for (std::size_t row = 0; row < out.pair_of_row.size(); row += 2) {
    const PointPair& pair = problem.pairs[out.pair_of_row[row]];
    const double* parameters[] = {lens.data(), pose.data(), identity.data(), pair.point_in_world.data()};
    double* derivatives[] = {by_lens.data(), by_pose.data(), nullptr, by_point.data()};
    Vec2 residual;
    if (!reprojection_cost(fit.lens.distortion, pair.pixel, Mat2::Identity() / sigma_px)
             ->Evaluate(parameters, residual.data(), derivatives))
      continue;
    for (Eigen::Index k = 0; k < free; ++k)
      out.by_unknowns.block<2, 1>(Eigen::Index(row), k) = by_lens.col(out.free[std::size_t(k)]);
    out.by_unknowns.block<2, 6>(Eigen::Index(row), free) = by_pose.leftCols<6>();
    out.by_point.middleRows<2>(Eigen::Index(row)) = by_point;
  }
  for (int p = 0; p < out.priors; ++p) {
    const LensPrior& prior = problem.options.lens.priors[std::size_t(p)];
    const VecX weights = prior_weights(prior, fit.lens) / prior.sigma;
    for (Eigen::Index k = 0; k < free; ++k)
      out.by_unknowns(Eigen::Index(out.pair_of_row.size()) + p, k) = weights[out.free[std::size_t(k)]];
  }
  return out;
}

std::vector<std::string> unknown_names(const PointsProblem& problem, const Camera& lens,
                                       const std::vector<int>& free) {
  std::vector<std::string> names;
  const std::vector<std::string> of_lens = parameter_names(lens);
  for (const int i : free) names.push_back(problem.device.name + "." + of_lens[std::size_t(i)]);
  const auto pose = pose_increment_names(problem.device.name + "_from_rig");
  names.insert(names.end(), pose.begin(), pose.end());
  return names;
}

/// (J^T J)^-1. Throws Error(kDegenerate) with the names of what J leaves open.
MatX covariance_of(const PointsEquations& linear, const std::vector<std::string>& names,
                   const std::string& device) {
  const MatX information = linear.by_unknowns.transpose() * linear.by_unknowns;
  const VecX scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(
      MatX(scale.asDiagonal() * information * scale.asDiagonal()));
  constexpr double kOpen = 1e-10;
  if (!(eigen.eigenvalues()[0] > kOpen)) {
    const VecX open = eigen.eigenvectors().col(0).cwiseAbs();
    std::string which;
    for (Eigen::Index i = 0; i < open.size(); ++i)
      if (open[i] > 0.2) which += (which.empty() ? "" : ", ") + names[std::size_t(i)];
    throw Error(ErrorKind::kDegenerate, device, "the points do not determine " + which,
                "measure points in more depth (not all on one wall), or give the data sheet's values: throw "
                "ratio and lens shift");
  }
  const MatX inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                       eigen.eigenvectors().transpose();
  const MatX covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  return 0.5 * (covariance + covariance.transpose());
}

/// Redundant equations: measured ones and priors, less unknowns.
int redundancy(const PointsProblem& problem, const std::vector<char>& used, std::size_t free) {
  return 2 * int(std::count(used.begin(), used.end(), 1)) + int(problem.options.lens.priors.size()) -
         int(free) - 6;
}
constexpr int kTellingRedundancy = 3;

/// One coordinate's sigma from the pairs' residuals: the median of |r|^2 / (2 ln 2), which blunders do not
/// move, with the unknowns' share put back.
double robust_sigma(const PointsProblem& problem, const PointsFit& fit, const std::vector<char>& used,
                    std::size_t free) {
  std::vector<double> squares;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (const auto r = residual_of(fit, problem.pairs[i])) squares.push_back(r->squaredNorm());
  if (squares.empty()) return problem.options.sigma_px;
  const double equations = 2.0 * double(used.size());
  const double share = std::max(equations - double(free) - 6, 1.0) / equations;
  return std::max(std::sqrt(median(std::move(squares)) / (2 * std::log(2.0)) / share), 1e-6);
}

/// The fit and what is known of it when points share their board's error.
struct SharedFit {
  PointsFit fit;
  SharedError error;
};

/// Least squares with the boards' errors allowed for, from `start`; nullopt where there are no boards, or
/// where their errors explain no more than chance does.
std::optional<SharedFit> fit_with_boards(const PointsProblem& problem, const PointsFit& start,
                                         const std::vector<char>& used) {
  constexpr double kSignificant = 9;  // three sigma: once in 700 sets of independent points
  constexpr int kSteps = 8;
  const std::vector<int> boards = boards_of(problem.pairs);
  if (boards.empty()) return std::nullopt;
  std::optional<SharedFit> shared;
  PointsFit fit = start;
  for (int step = 0; step < kSteps; ++step) {
    const PointsEquations linear = linearise(problem, fit, used, 1);
    SharedErrorEquations equations{
        linear.by_unknowns, VecX::Zero(linear.by_unknowns.rows()), linear.by_point, {}, {}};
    for (std::size_t row = 0; row < linear.pair_of_row.size(); row += 2) {
      const std::size_t i = linear.pair_of_row[row];
      const auto r = residual_of(fit, problem.pairs[i]);
      if (!r) return std::nullopt;
      equations.residuals.segment<2>(Eigen::Index(row)) = *r;
      equations.points.push_back(problem.pairs[i].point_in_world);
      equations.boards.push_back(boards[i]);
    }
    VecX lens = parameters_of(fit.lens);
    for (int p = 0; p < linear.priors; ++p) {
      const LensPrior& prior = problem.options.lens.priors[std::size_t(p)];
      equations.residuals[Eigen::Index(linear.pair_of_row.size()) + p] =
          (prior_weights(prior, fit.lens).dot(lens) - prior.value) / prior.sigma;
    }
    const auto error = estimate_shared_error(equations);
    if (!error || !(error->likelihood_gain > kSignificant) || !error->step.allFinite()) return std::nullopt;
    shared = SharedFit{fit, *error};
    if (error->step.cwiseAbs().cwiseQuotient(error->covariance.diagonal().cwiseSqrt()).maxCoeff() < 1e-3)
      return shared;
    for (std::size_t k = 0; k < linear.free.size(); ++k) lens[linear.free[k]] += error->step[Eigen::Index(k)];
    fit.lens = with_parameters(fit.lens, lens);
    fit.device_from_world = (se3_exp(Vec6(error->step.tail<6>())) * fit.device_from_world).normalized();
    if (!(fit.lens.intrinsics.fx > 0) || !(fit.lens.intrinsics.fy > 0)) return std::nullopt;
  }
  return shared;
}

}  // namespace

PointsResult calibrate_from_points(const Device& device, const std::vector<PointPair>& pairs,
                                   const PointsOptions& options) {
  for (const PointPair& pair : pairs)
    require(pair.point_in_world.allFinite() && pair.pixel.allFinite(),
            "calibrate_from_points: a pair is not finite");
  require(device.size.width > 0 && device.size.height > 0, "calibrate_from_points: the device has no size");
  require(options.sigma_px > 0, "calibrate_from_points: sigma_px must be positive");
  const PointsProblem problem{device, pairs, options};
  std::string why = std::to_string(pairs.size()) + " points";
  if (pairs.size() < 4)
    throw Error(
        ErrorKind::kNotEnoughData, device.name, why + " are too few for its place",
        "measure at least six points that are not all on one wall, or four with the data sheet's throw "
        "ratio and lens shift");
  const std::vector<PointsFit> candidates = starts(problem, why);
  if (candidates.empty())
    throw Error(
        ErrorKind::kNotEnoughData, device.name, why,
        "measure at least six points that are not all on one wall, or state the data sheet's throw ratio "
        "and lens shift");

  std::vector<char> used(pairs.size(), 1);
  std::optional<PointsFit> best;
  constexpr std::size_t kTried = 12;
  constexpr double kNear = 8;  // what a start misses by so many times as much may be a blunder
  for (std::size_t i = 0; i < std::min(candidates.size(), kTried); ++i) {
    const double sigma = std::max(options.sigma_px, candidates[i].within_px);
    std::vector<char> near(pairs.size(), 0);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto r = residual_of(candidates[i], pairs[k]);
      near[k] = r && r->norm() <= kNear * sigma;
    }
    const auto fit = refine(problem, candidates[i], near, std::min(sigma, 1e3), false);
    if (fit && (!best || fit->within_px < best->within_px)) best = fit;
  }
  if (!best)
    throw Error(
        ErrorKind::kNotConverged, device.name, "no lens and place explain its points",
        "check the order of the numbers (x, y, z in metres, then the pixel), and that the picture is not "
        "mirrored");

  const std::size_t free =
      parameter_names(best->lens).size() - held_parameters(best->lens, options.lens.held).size();
  double sigma = options.sigma_px;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    const bool telling = redundancy(problem, std::vector<char>(pairs.size(), 1), free) >= kTellingRedundancy;
    if (telling) sigma = robust_sigma(problem, *best, used, free);
    std::vector<char> now(pairs.size(), 1);
    for (std::size_t i = 0; i < pairs.size() && options.outlier_sigmas > 0 && telling; ++i) {
      const auto r = residual_of(*best, pairs[i]);
      now[i] = r && r->norm() <= options.outlier_sigmas * sigma;
    }
    const bool settled = now == used && round > 0;
    if (redundancy(problem, now, free) < 0) break;
    used = now;
    const auto fit = refine(problem, *best, used, sigma, false);
    if (!fit) break;
    best = fit;
    if (settled) break;
  }

  const int redundant = redundancy(problem, used, free);
  const std::optional<SharedFit> shared =
      redundant >= kTellingRedundancy ? fit_with_boards(problem, *best, used) : std::nullopt;
  if (shared) best = shared->fit;

  PointsResult result;
  double sum2 = 0;
  int count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    PairResidual pair;
    const auto r = residual_of(*best, pairs[i]);
    pair.used = used[i] && r;
    if (r) pair.residual = *r;
    if (pair.used) sum2 += r->squaredNorm(), ++count;
    if (!pair.used)
      result.diagnostics.warn("pair_left_out",
                              describe_pair(problem, i) + " is rejected: " +
                                  (r ? std::to_string(int(std::lround(r->norm()))) + " px off"
                                     : std::string("it lies behind the device")) +
                                  "; check its numbers");
    result.pairs.push_back(pair);
  }
  result.rms_px = std::sqrt(sum2 / std::max(count, 1));
  result.sigma_px = shared                            ? shared->error.pixel_sigma
                    : redundant >= kTellingRedundancy ? std::sqrt(sum2 / redundant)
                                                      : options.sigma_px;

  const PointsEquations linear = linearise(problem, *best, used, result.sigma_px);
  NamedCovariance covariance{unknown_names(problem, best->lens, linear.free), {}};
  covariance.matrix =
      shared ? shared->error.covariance : covariance_of(linear, covariance.names, device.name);
  if (shared) {
    result.board_error = shared->error.board_sigma;
    char millimetres[32];
    std::snprintf(millimetres, sizeof millimetres, "%.1f mm", 1e3 * result.board_error);
    result.diagnostics.note("board_error",
                            "points that lie on one board share an error of its pose and scale, " +
                                std::string(millimetres) +
                                " (rms displacement a motion): they count as one measurement of the board");
  }
  // The residual of a held-out pair is (I - H)^-1 r, H its block of the hat matrix (Cook and Weisberg, 1982).
  double left2 = 0;
  int left = 0;
  for (std::size_t row = 0; row < linear.pair_of_row.size(); row += 2) {
    PairResidual& pair = result.pairs[linear.pair_of_row[row]];
    if (shared) {  // without its whole board
      pair.loo_residual = shared->error.loo_residuals[row / 2];
      if (!pair.loo_residual) continue;
    } else {
      const MatX j = linear.by_unknowns.middleRows(Eigen::Index(row), 2);
      const Mat2 rest = Mat2::Identity() - j * covariance.matrix * j.transpose();
      if (!(rest.determinant() > 1e-6)) continue;
      pair.loo_residual = Vec2(rest.inverse() * pair.residual);
    }
    left2 += pair.loo_residual->squaredNorm();
    ++left;
  }
  if (left > 0) result.loo_rms_px = std::sqrt(left2 / left);

  // world_from_device: xi' = -Ad(world_from_device) xi.
  const Pose world_from_device = best->device_from_world.inverse();
  MatX turn = MatX::Identity(covariance.matrix.rows(), covariance.matrix.rows());
  turn.bottomRightCorner<6, 6>() = -adjoint(world_from_device);
  const MatX turned = turn * covariance.matrix * turn.transpose();
  covariance.matrix = 0.5 * (turned + turned.transpose());
  const auto pose_names = pose_increment_names("rig_from_" + device.name);
  std::copy(pose_names.begin(), pose_names.end(), covariance.names.end() - 6);

  Rig& rig = result.rig;
  if (device.kind == DeviceKind::kCamera)
    rig.cameras.push_back({device.name, best->lens, world_from_device});
  else
    rig.projectors.push_back({device.name, Projector{best->lens}, world_from_device});
  rig.covariance = covariance;
  rig.quality.views_used = 1;
  rig.quality.rms_px[device.name] = result.rms_px;
  if (result.loo_rms_px > 0) rig.quality.holdout_px[device.name] = result.loo_rms_px;
  GateLimits limits;
  // People measure with a tape and click by hand: what is limited is the light, by its sigmas.
  limits.max_rms_px = 0.01 * device.size.width;
  rig.quality.gates = check_rig(rig, limits);
  const int out = int(pairs.size()) - count;
  rig.quality.gates.push_back({device.name + " points agree", 4 * out <= int(pairs.size()),
                               std::to_string(out) + " of " + std::to_string(pairs.size()) + " rejected"});
  for (const Gate& gate : rig.quality.gates)
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  if (redundant < kTellingRedundancy)
    result.diagnostics.warn("unchecked",
                            "there are few more points than unknowns: nothing checks them, and "
                            "the sigmas rest on the stated " +
                                std::to_string(options.sigma_px).substr(0, 4) + " px; measure more points");
  return result;
}

}  // namespace procam::calibrate
