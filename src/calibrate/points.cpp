#include "procam/calibrate/points.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "common_error.hpp"
#include "points_start.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/costs/lens_prior.hpp"
#include "procam/calibrate/costs/se3_manifold.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "residual_blocks.hpp"
#include "rig_checks.hpp"

namespace procam::calibrate {
namespace {

std::string describe_pair(const PointsProblem& problem, std::size_t i) {
  const std::string& name = problem.pairs[i].name;
  return name.empty() ? "pair " + std::to_string(i + 1) : "'" + name + "'";
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

/// The start whose refinement misses the pairs near it by the smallest distance; nullopt where none leads anywhere.
std::optional<PointsFit> best_of(const PointsProblem& problem, const std::vector<PointsFit>& candidates) {
  std::optional<PointsFit> best;
  constexpr std::size_t kTried = 12;
  constexpr double kNear = 8;  // what a start misses by so many times as much may be a blunder
  for (std::size_t i = 0; i < std::min(candidates.size(), kTried); ++i) {
    const double sigma = std::max(problem.options.sigma_px, candidates[i].within_px);
    std::vector<char> near(problem.pairs.size(), 0);
    for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
      const auto r = residual_of(candidates[i], problem.pairs[k]);
      near[k] = r && r->norm() <= kNear * sigma;
    }
    const auto fit = refine_points(problem, candidates[i], near, std::min(sigma, 1e3), false);
    if (fit && (!best || fit->within_px < best->within_px)) best = fit;
  }
  return best;
}

/// Of RMS residuals, share of the picture's width: people measure with a tape and click by hand.
constexpr double kMaxRms = 0.01;

/// Whether the points fit when the picture is mirrored.
bool fit_mirrored(const PointsProblem& problem) {
  std::vector<PointPair> mirrored = problem.pairs;
  for (PointPair& pair : mirrored) pair.pixel.x() = problem.device.size.width - 1 - pair.pixel.x();
  PointsOptions options = problem.options;
  options.lens.priors.clear();  // a lens shift to the other side
  const PointsProblem other{problem.device, mirrored, options};
  std::string why;
  const std::optional<PointsFit> fit = best_of(other, points_starts(other, why));
  return fit && fit->within_px < kMaxRms * problem.device.size.width;
}

[[noreturn]] void refuse_points(const PointsProblem& problem, const std::string& why) {
  if (fit_mirrored(problem))
    throw Error(
        ErrorKind::kNotConverged, problem.device.name, why + ", and they fit when the picture is mirrored",
        "x, y, z are right-handed, u runs to the right and v downwards: check the order and the signs of the "
        "numbers, and that the picture is not mirrored (rear projection)");
  throw Error(
      ErrorKind::kNotConverged, problem.device.name, why,
      "check the order of the numbers (x, y, z in metres, then the pixel), and that each pixel is that of its "
      "point");
}

/// Refines with the pairs that agree, and returns which ones they are.
std::vector<char> reject_outliers(const PointsProblem& problem, std::size_t free, PointsFit& best) {
  const std::size_t n = problem.pairs.size();
  const PointsOptions& options = problem.options;
  std::vector<char> used(n, 1);
  double sigma = options.sigma_px;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    const bool telling = redundancy(problem, std::vector<char>(n, 1), free) >= kTellingRedundancy;
    if (telling) sigma = robust_sigma(problem, best, used, free);
    std::vector<char> now(n, 1);
    for (std::size_t i = 0; i < n && options.outlier_sigmas > 0 && telling; ++i) {
      const auto r = residual_of(best, problem.pairs[i]);
      now[i] = r && r->norm() <= options.outlier_sigmas * sigma;
    }
    const bool settled = now == used && round > 0;
    if (redundancy(problem, now, free) < 0) break;
    used = now;
    const auto fit = refine_points(problem, best, used, sigma, false);
    if (!fit) break;
    best = *fit;
    if (settled) break;
  }
  return used;
}

/// Sets the result's pairs, rms_px and the remarks on rejected pairs; returns the sum of squares of those in use.
double list_pairs(const PointsProblem& problem, const PointsFit& best, const std::vector<char>& used,
                  PointsResult& result) {
  double sum2 = 0;
  int count = 0;
  for (std::size_t i = 0; i < problem.pairs.size(); ++i) {
    PairResidual pair;
    const auto r = residual_of(best, problem.pairs[i]);
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
  return sum2;
}

/// The residual of a held-out pair is (I - H)^-1 r, H its block of the hat matrix (Cook and Weisberg, 1982).
void hold_out_pairs(const PointsEquations& linear, const MatX& covariance,
                    const std::optional<SharedFit>& shared, PointsResult& result) {
  double left2 = 0;
  int left = 0;
  for (std::size_t row = 0; row < linear.pair_of_row.size(); row += 2) {
    PairResidual& pair = result.pairs[linear.pair_of_row[row]];
    if (shared) {  // without its whole board
      pair.loo_residual = shared->error.loo_residuals[row / 2];
      if (!pair.loo_residual) continue;
    } else {
      const MatX j = linear.by_unknowns.middleRows(Eigen::Index(row), 2);
      const Mat2 rest = Mat2::Identity() - j * covariance * j.transpose();
      if (!(rest.determinant() > 1e-6)) continue;
      pair.loo_residual = Vec2(rest.inverse() * pair.residual);
    }
    left2 += pair.loo_residual->squaredNorm();
    ++left;
  }
  if (left > 0) result.loo_rms_px = std::sqrt(left2 / left);
}

/// The device in the world, with the covariance of its pose by the increment of world_from_device:
/// xi' = -Ad(world_from_device) xi.
void write_rig(const Device& device, const PointsFit& best, NamedCovariance covariance,
               PointsResult& result) {
  const Pose world_from_device = best.device_from_world.inverse();
  MatX turn = MatX::Identity(covariance.matrix.rows(), covariance.matrix.rows());
  turn.bottomRightCorner<6, 6>() = -adjoint(world_from_device);
  const MatX turned = turn * covariance.matrix * turn.transpose();
  covariance.matrix = 0.5 * (turned + turned.transpose());
  const auto pose_names = pose_increment_names("rig_from_" + device.name);
  std::copy(pose_names.begin(), pose_names.end(), covariance.names.end() - 6);

  Rig& rig = result.rig;
  if (device.kind == DeviceKind::kCamera)
    rig.cameras.push_back({device.name, best.lens, world_from_device});
  else
    rig.projectors.push_back({device.name, Projector{best.lens}, world_from_device});
  rig.covariance = std::move(covariance);
  rig.quality.views_used = 1;
  rig.quality.rms_px[device.name] = result.rms_px;
  if (result.loo_rms_px > 0) rig.quality.holdout_px[device.name] = result.loo_rms_px;
}

void check_points(const Device& device, PointsResult& result) {
  GateLimits limits;
  // What is limited is the light, by its sigmas.
  limits.max_rms_px = kMaxRms * device.size.width;
  std::vector<Gate>& gates = result.rig.quality.gates;
  gates = check_rig(result.rig, limits);
  const auto rejected = std::size_t(std::count_if(result.pairs.begin(), result.pairs.end(),
                                                  [](const PairResidual& pair) { return !pair.used; }));
  gates.push_back({device.name + " points agree", 4 * rejected <= result.pairs.size(),
                   std::to_string(rejected) + " of " + std::to_string(result.pairs.size()) + " rejected"});
  for (const Gate& gate : gates)
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
}

/// Millimetres that were taken for metres.
void warn_if_far(const PointsProblem& problem, const PointsFit& best, PointsResult& result) {
  constexpr double kFar = 100;  // metres
  std::vector<double> distances;
  for (const PointPair& pair : problem.pairs)
    distances.push_back((best.device_from_world * pair.point_in_world).norm());
  const double usual = median(std::move(distances));
  if (usual > kFar)
    result.diagnostics.warn("far_points",
                            format("its points are %.0f m away (median): x, y and z are metres; if they "
                                   "are millimetres, divide them by 1000",
                                   usual));
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
  const std::vector<PointsFit> candidates = points_starts(problem, why);
  if (candidates.empty()) {
    if (fit_mirrored(problem)) refuse_points(problem, "no lens and place explain its points");
    throw Error(
        ErrorKind::kNotEnoughData, device.name, why,
        "measure at least six points that are not all on one wall, or state the data sheet's throw ratio "
        "and lens shift");
  }
  const std::optional<PointsFit> first = best_of(problem, candidates);
  if (!first) refuse_points(problem, "no lens and place explain its points");
  PointsFit best = *first;
  const std::size_t free =
      parameter_names(best.lens).size() - held_parameters(best.lens, options.lens.held).size();
  const std::vector<char> used = reject_outliers(problem, free, best);
  const int redundant = redundancy(problem, used, free);
  const std::optional<SharedFit> shared =
      redundant >= kTellingRedundancy ? fit_with_boards(problem, best, used) : std::nullopt;
  if (shared) best = shared->fit;

  PointsResult result;
  const double sum2 = list_pairs(problem, best, used, result);
  const auto agreeing = std::count(used.begin(), used.end(), char(1));
  constexpr double kNonsense = 3;  // times what is accepted
  if (2 * std::size_t(agreeing) < pairs.size())
    refuse_points(problem, "only " + std::to_string(agreeing) + " of " + std::to_string(pairs.size()) +
                               " points agree on a lens and a place");
  const bool keeps_outliers = !(options.outlier_sigmas > 0);
  if (!keeps_outliers && result.rms_px > kNonsense * kMaxRms * device.size.width)
    refuse_points(problem,
                  format("no lens and place bring its points nearer than %.0f px (RMS)", result.rms_px));
  result.sigma_px = shared                            ? shared->error.pixel_sigma
                    : redundant >= kTellingRedundancy ? std::sqrt(sum2 / redundant)
                                                      : options.sigma_px;
  const PointsEquations linear = linearise(problem, best, used, result.sigma_px);
  NamedCovariance covariance{unknown_names(problem, best.lens, linear.free), {}};
  covariance.matrix =
      shared ? shared->error.covariance : covariance_of(linear, covariance.names, device.name);
  if (shared) {
    result.board_error = shared->error.board_sigma;
    result.diagnostics.note(
        "board_error", format("points that lie on one board share an error of its pose and scale, %.1f mm "
                              "(rms displacement a motion): they count as one measurement of the board",
                              1e3 * result.board_error));
  }
  hold_out_pairs(linear, covariance.matrix, shared, result);
  write_rig(device, best, std::move(covariance), result);
  check_points(device, result);
  warn_if_far(problem, best, result);
  if (redundant < kTellingRedundancy)
    result.diagnostics.warn("unchecked",
                            "there are few more points than unknowns: nothing checks them, and "
                            "the sigmas rest on the stated " +
                                std::to_string(options.sigma_px).substr(0, 4) + " px; measure more points");
  return result;
}

}  // namespace procam::calibrate
