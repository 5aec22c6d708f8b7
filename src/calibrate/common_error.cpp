#include "common_error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace procam::calibrate {
namespace {

constexpr int kMinPoints = 6;  // of a board: three are always in one plane, and five often nearly
constexpr int kMinBoards = 3;
constexpr double kFlatness = 0.005;  // of its extent: sheets bend by less, corners of a room miss by more
constexpr int kMotions = 7;          // translation, rotation, scale

using MatB = Eigen::Matrix<double, Eigen::Dynamic, kMotions>;
using Mat7 = Eigen::Matrix<double, kMotions, kMotions>;
using Vec7 = Eigen::Matrix<double, kMotions, 1>;

/// Sums of a run of points, as they come.
struct PlaneSums {
  double count = 0;
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();

  void add(const Vec3& p) {
    ++count;
    sum += p;
    squares += p * p.transpose();
  }
  /// Is a further point in the plane of these? Points on one line leave the plane open.
  bool holds(const Vec3& p) const {
    if (count < 3) return true;
    const Vec3 mean = sum / count;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(squares / count - mean * mean.transpose());
    const double extent = std::sqrt(12 * std::max(eigen.eigenvalues()[2], 0.0));
    const double width = std::sqrt(12 * std::max(eigen.eigenvalues()[1], 0.0));
    if (!(width > kFlatness * extent)) return true;
    return std::abs(eigen.eigenvectors().col(0).dot(p - mean)) <= kFlatness * extent;
  }
};

/// What one block of rows with common variance contributes: the sums that every trial of s and f needs.
struct BoardBlock {
  double rows = 0;
  MatX jj;
  Eigen::Matrix<double, Eigen::Dynamic, kMotions> jb;
  Mat7 bb = Mat7::Zero();
  VecX jr;
  Vec7 br = Vec7::Zero();
  double rr = 0;
  bool is_board = false;
};

/// Normal equations of the unknowns and -2 ln of the restricted likelihood.
struct VarianceTrial {
  MatX information;
  VecX gradient;
  double cost = std::numeric_limits<double>::infinity();
};

/// One block's share, its variance f^2 I + s^2 B B^T inverted by Woodbury's identity.
void add_block(const BoardBlock& block, double f, double s, VarianceTrial& trial, double& cost) {
  const double w = 1 / (f * f);
  trial.information += w * block.jj;
  trial.gradient += w * block.jr;
  cost += w * block.rr + 2 * block.rows * std::log(f);
  if (!block.is_board || !(s > 0)) return;
  const Mat7 inner = Mat7::Identity() + (s * s * w) * block.bb;
  const Eigen::LLT<Mat7> llt(inner);
  const Mat7 m = (s * s * w) * llt.solve(Mat7::Identity());
  trial.information -= w * block.jb * m * block.jb.transpose();
  trial.gradient -= w * block.jb * (m * block.br);
  cost += -w * block.br.dot(m * block.br) + 2 * Mat7(llt.matrixL()).diagonal().array().log().sum();
}

VarianceTrial try_variances(const std::vector<BoardBlock>& blocks, const BoardBlock& priors, double f,
                            double s) {
  const Eigen::Index n = priors.jj.rows();
  VarianceTrial trial{MatX::Zero(n, n), VecX::Zero(n)};
  double cost = 0;
  for (const BoardBlock& block : blocks) add_block(block, f, s, trial, cost);
  add_block(priors, 1, 0, trial, cost);
  const VecX scale = trial.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatX> llt(MatX(scale.asDiagonal() * trial.information * scale.asDiagonal()));
  if (llt.info() != Eigen::Success) return trial;
  const VecX g = scale.cwiseProduct(trial.gradient);
  cost += 2 * MatX(llt.matrixL()).diagonal().array().log().sum() - 2 * scale.array().log().sum();
  trial.cost = cost - g.dot(llt.solve(g));
  return trial;
}

/// Rows of one pair moved with its board about `centre`, in metres of rms displacement (`radius`).
MatB motions_of(const MatX& by_point, const Vec3& offset, double radius) {
  Mat3 turn;  // column i: e_i x offset
  for (int i = 0; i < 3; ++i) turn.col(i) = Vec3(Vec3::Unit(i)).cross(offset);
  MatB out(by_point.rows(), kMotions);
  out.leftCols<3>() = by_point;
  out.middleCols<3>(3) = by_point * turn / radius;
  out.col(6) = by_point * offset / radius;
  return out;
}

struct BoardBlocks {
  std::vector<BoardBlock> measured;
  std::vector<std::vector<std::size_t>> pairs;  ///< of each block
  std::vector<MatB> motions;                    ///< of each block, pair by pair; empty for a single pair
  BoardBlock priors;
};

BoardBlock empty_block(Eigen::Index unknowns) {
  BoardBlock block;
  block.jj = MatX::Zero(unknowns, unknowns);
  block.jb = MatX::Zero(unknowns, kMotions);
  block.jr = VecX::Zero(unknowns);
  return block;
}

void add_rows(const MatX& j, const VecX& r, BoardBlock& block) {
  block.rows += double(r.size());
  block.jj += j.transpose() * j;
  block.jr += j.transpose() * r;
  block.rr += r.squaredNorm();
}

BoardBlocks split_by_board(const SharedErrorEquations& e) {
  BoardBlocks out;
  const auto unknowns = e.by_unknowns.cols();
  const auto pair_rows = Eigen::Index(2 * e.points.size());
  out.priors = empty_block(unknowns);
  const Eigen::Index rest = e.by_unknowns.rows() - pair_rows;
  add_rows(e.by_unknowns.bottomRows(rest), e.residuals.tail(rest), out.priors);
  const int boards = 1 + *std::max_element(e.boards.begin(), e.boards.end());
  out.pairs.resize(std::size_t(boards));
  for (std::size_t i = 0; i < e.points.size(); ++i) {
    if (e.boards[i] >= 0)
      out.pairs[std::size_t(e.boards[i])].push_back(i);
    else
      out.pairs.push_back({i});
  }
  for (std::size_t b = 0; b < out.pairs.size(); ++b) {
    BoardBlock block = empty_block(unknowns);
    block.is_board = int(b) < boards && !out.pairs[b].empty();
    Vec3 centre = Vec3::Zero();
    double square = 0;
    for (const std::size_t i : out.pairs[b]) centre += e.points[i] / double(out.pairs[b].size());
    for (const std::size_t i : out.pairs[b])
      square += (e.points[i] - centre).squaredNorm() / double(out.pairs[b].size());
    const double radius = std::max(std::sqrt(square), 1e-9);
    MatB motions(Eigen::Index(2 * out.pairs[b].size()), kMotions);
    for (std::size_t k = 0; k < out.pairs[b].size(); ++k) {
      const std::size_t i = out.pairs[b][k];
      const MatX j = e.by_unknowns.middleRows(Eigen::Index(2 * i), 2);
      const VecX r = e.residuals.segment(Eigen::Index(2 * i), 2);
      const MatB moved =
          motions_of(e.by_point.middleRows(Eigen::Index(2 * i), 2), e.points[i] - centre, radius);
      motions.middleRows(Eigen::Index(2 * k), 2) = moved;
      add_rows(j, r, block);
      block.jb += j.transpose() * moved;
      block.bb += moved.transpose() * moved;
      block.br += moved.transpose() * r;
    }
    out.measured.push_back(block);
    out.motions.push_back(motions);
  }
  return out;
}

/// Largest restricted likelihood over a grid that is refined: f about `f0`, s over seven decades of metres.
struct Variances {
  double f = 1, s = 0, cost = std::numeric_limits<double>::infinity();
};
Variances most_likely(const BoardBlocks& blocks, bool with_boards) {
  Variances best;
  const auto consider = [&](double f, double s) {
    const double cost = try_variances(blocks.measured, blocks.priors, f, s).cost;
    if (cost < best.cost) best = {f, s, cost};
  };
  for (double f = 1e-2; f < 20; f *= 1.5) {
    consider(f, 0);
    for (double s = 1e-6; s < 1 && with_boards; s *= 2) consider(f, s);
  }
  for (double step = 1.25; step > 1.005; step = std::sqrt(step)) {
    const Variances centre = best;
    for (const double a : {1 / step, 1.0, step})
      for (const double b : {1 / step, 1.0, step}) consider(centre.f * a, centre.s * b);
  }
  return best;
}

}  // namespace

std::vector<int> boards_of(const std::vector<PointPair>& pairs) {
  std::vector<int> boards(pairs.size(), -1);
  int found = 0;
  for (std::size_t begin = 0; begin < pairs.size();) {
    PlaneSums run;
    std::size_t end = begin;
    const Vec3 origin = pairs[begin].point_in_world;  // the sums stay small however far the room's origin is
    while (end < pairs.size() && run.holds(pairs[end].point_in_world - origin))
      run.add(pairs[end++].point_in_world - origin);
    if (end - begin >= std::size_t(kMinPoints)) {
      std::fill(boards.begin() + long(begin), boards.begin() + long(end), found);
      ++found;
      begin = end;
    } else {
      ++begin;
    }
  }
  return found >= kMinBoards ? boards : std::vector<int>();
}

std::optional<SharedError> estimate_shared_error(const SharedErrorEquations& equations) {
  const BoardBlocks blocks = split_by_board(equations);
  const Variances independent = most_likely(blocks, false), shared = most_likely(blocks, true);
  const VarianceTrial solution = try_variances(blocks.measured, blocks.priors, shared.f, shared.s);
  if (!std::isfinite(solution.cost)) return std::nullopt;
  SharedError out;
  out.board_sigma = shared.s;
  out.pixel_sigma = shared.f;
  out.likelihood_gain = independent.cost - shared.cost;
  const Eigen::LDLT<MatX> ldlt(solution.information);
  out.step = -ldlt.solve(solution.gradient);
  const MatX inverse = ldlt.solve(MatX::Identity(solution.information.rows(), solution.information.cols()));
  out.covariance = 0.5 * (inverse + inverse.transpose());
  out.loo_residuals.resize(equations.points.size());
  for (std::size_t b = 0; b < blocks.measured.size(); ++b) {
    if (blocks.pairs[b].empty()) continue;
    VarianceTrial own{MatX::Zero(out.step.size(), out.step.size()), VecX::Zero(out.step.size())};
    double ignored = 0;
    add_block(blocks.measured[b], shared.f, shared.s, own, ignored);
    const MatX rest = solution.information - own.information;
    const VecX scale = solution.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<MatX> eigen(MatX(scale.asDiagonal() * rest * scale.asDiagonal()));
    if (!(eigen.eigenvalues()[0] > 1e-8)) continue;
    const VecX g = scale.cwiseProduct(VecX(solution.gradient - own.gradient));
    const VecX without = -scale.cwiseProduct(VecX(
        eigen.eigenvectors() * (eigen.eigenvectors().transpose() * g).cwiseQuotient(eigen.eigenvalues())));
    for (const std::size_t i : blocks.pairs[b])
      out.loo_residuals[i] = Vec2(equations.residuals.segment<2>(Eigen::Index(2 * i)) +
                                  equations.by_unknowns.middleRows(Eigen::Index(2 * i), 2) * without);
  }
  return out;
}

}  // namespace procam::calibrate
