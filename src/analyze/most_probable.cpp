#include "most_probable.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::analyze {

MatX root_of(const MatX& covariance) {
  const VecX sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const VecX scale = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::LDLT<MatX> factors(MatX(scale.asDiagonal() * covariance * scale.asDiagonal()));
  const VecX pivots = factors.vectorD();
  require(covariance.allFinite() && covariance.diagonal().minCoeff() >= 0 && pivots.minCoeff() > -1e-6,
          "verify: the covariance of rig or surface is not positive semidefinite");
  const MatX lower = factors.matrixL();
  const MatX root =
      factors.transpositionsP().transpose() * MatX(lower * pivots.cwiseMax(0).cwiseSqrt().asDiagonal());
  return sigma.asDiagonal() * root;
}

void whiten(LinearMarks& linear, double scatter, const VecX& weights) {
  for (std::size_t i = 0; i < linear.noise.size(); ++i) {
    const Mat2 root = scatter / std::sqrt(weights[Eigen::Index(i)]) * cholesky_lower(linear.noise[i]);
    const auto row = Eigen::Index(2 * i);
    const auto divide = [&](auto&& first, auto&& second) {
      first /= root(0, 0);
      second = (second - root(1, 0) * first) / root(1, 1);
    };
    divide(linear.error[row], linear.error[row + 1]);
    divide(linear.by_state.row(row), linear.by_state.row(row + 1));
  }
}

double scatter2_of(const VecX& squares) {
  const double typical = median(std::vector<double>(squares.data(), squares.data() + squares.size()));
  return std::max(1.0, typical / (2 * std::log(2.0)));
}

namespace {

constexpr int kMaxNewtonSteps = 40;
constexpr double kSmallestStep = 1e-8;  ///< radians, metres

class MostProbable {
 public:
  MostProbable(const MarkChain& chain, const Which& marks, const Free& free, const Bumps& bumps,
               double scatter)
      : chain_(chain),
        marks_(marks),
        free_(free),
        scatter_(scatter),
        weights_(VecX::Ones(Eigen::Index(marks.size()))) {
    MatX prior = chain.stated();
    const Eigen::Index at_projector = chain.projector_place(), at_surface = chain.surface_place();
    if (free.projector) prior.block<6, 6>(at_projector, at_projector) += bumps.projector;
    if (free.surface) prior.block<6, 6>(at_surface, at_surface) += bumps.surface;
    root_ = root_of(prior);
  }

  Fit fit(bool robust) {
    Trial now = *at(VecX::Zero(root_.cols()));
    if (robust) weigh_by_distance(now);
    Fit result;
    for (int step = 0; step < kMaxNewtonSteps && !result.settled; ++step) {
      const VecX aim = Marginal(now.linear.by_state, root_)
                           .most_probable(now.linear.by_state * free_part(root_ * now.y) - now.linear.error);
      std::optional<Trial> next;
      double share = 1;
      for (; share > 1e-3; share *= 0.5) {
        next = at(now.y + share * (aim - now.y));
        if (next && next->cost <= now.cost + 1e-9 * (1 + now.cost)) break;
      }
      if (share <= 1e-3) break;
      result.settled = free_part(root_ * (next->y - now.y)).norm() < kSmallestStep;
      now = *next;
      if (robust) weigh_by_distance(now);
    }
    const Marginal marginal(now.linear.by_state, root_);
    result.moved = moved_by(now.y);
    result.squares = squares_of(now);
    result.covariance = marginal.covariance(root_);
    result.log_evidence = -0.5 * (now.cost + marginal.log_determinant());
    return result;
  }

 private:
  struct Trial {
    VecX y;
    LinearMarks linear;  ///< in units of the noise
    VecX rest;
    double cost = 0;
  };

  VecX free_part(const VecX& state) const {
    VecX part = VecX::Zero(state.size());
    const Eigen::Index at_projector = chain_.projector_place(), at_surface = chain_.surface_place();
    if (free_.projector) part.segment<6>(at_projector) = state.segment<6>(at_projector);
    if (free_.surface) part.segment<6>(at_surface) = state.segment<6>(at_surface);
    return part;
  }
  Moved moved_by(const VecX& y) const {
    const VecX part = free_part(root_ * y);
    return {part.segment<6>(chain_.projector_place()), part.segment<6>(chain_.surface_place())};
  }
  /// nullopt where the light would miss the surface.
  std::optional<Trial> at(const VecX& y) const {
    std::optional<LinearMarks> linear = chain_.linearise(marks_, moved_by(y));
    if (!linear) return std::nullopt;
    whiten(*linear, scatter_, weights_);
    const VecX state = root_ * y;
    Trial trial{y, *linear, -linear->error - linear->by_state * (state - free_part(state)), 0};
    trial.cost = trial.rest.squaredNorm() + y.squaredNorm();
    return trial;
  }
  void weigh_by_distance(Trial& trial) {
    const VecX squares = squares_of(trial);
    const double usual = scatter2_of(squares);
    weights_ = (usual + squares.array() / 5.8).inverse();
    trial = *at(trial.y);
  }
  VecX squares_of(const Trial& trial) const {
    VecX squares(weights_.size());
    for (Eigen::Index i = 0; i < squares.size(); ++i)
      squares[i] = trial.rest.segment<2>(2 * i).squaredNorm() * scatter_ * scatter_ / weights_[i];
    return squares;
  }

  const MarkChain& chain_;
  const Which& marks_;
  Free free_;
  double scatter_;
  VecX weights_;
  MatX root_;
};

}  // namespace

Fit most_probable(const MarkChain& chain, const Which& marks, const Free& free, const Bumps& bumps,
                  double scatter, bool robust) {
  return MostProbable(chain, marks, free, bumps, scatter).fit(robust);
}

}  // namespace procam::analyze
