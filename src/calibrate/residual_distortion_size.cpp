#include "residual_distortion_size.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace procam::calibrate {
namespace {

constexpr double kMinGain = 16;
/// Of t, pixels, over the factor by which the noise is larger than the solution has it.
constexpr double kSmallest = 1e-3, kLargest = 30, kGrowth = 1.6;

/// The equations of `count` coefficients from `first` on, the others eliminated with their prior. Their determinant, which the
/// sizes of the remaining ones do not change, is not kept.
CoefficientEquations of_device(const CoefficientEquations& all, const VecX& variances, Eigen::Index first,
                               Eigen::Index count) {
  CoefficientEquations out{all.information.block(first, first, count, count), all.right.segment(first, count),
                           all.squares, all.rows};
  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < variances.size(); ++i)
    if ((i < first || i >= first + count) && variances[i] > 0) others.push_back(i);
  if (others.empty()) return out;
  const VecX sigma = variances(others).cwiseSqrt();
  MatX inner = sigma.asDiagonal() * all.information(others, others) * sigma.asDiagonal();
  inner.diagonal().array() += 1;
  const Eigen::LLT<MatX> factors(inner);
  const MatX across = factors.matrixL().solve(
      MatX(sigma.asDiagonal() * MatX(all.information(others, Eigen::seqN(first, count)))));
  const VecX right = factors.matrixL().solve(VecX(sigma.cwiseProduct(VecX(all.right(others)))));
  out.information.noalias() -= across.transpose() * across;
  out.right.noalias() -= across.transpose() * right;
  out.squares -= right.squaredNorm();
  return out;
}

/// Trials of c ~ N(0, t^2 diag(shape)) for many t: with S = diag(shape)^(1/2), S information S is made tridiagonal once, and then
/// I + t^2 S information S is factored in time proportional to the number of coefficients.
class SizesOfShape {
 public:
  SizesOfShape(const CoefficientEquations& equations, const VecX& shape)
      : squares_(equations.squares), rows_(equations.rows) {
    const VecX scale = shape.cwiseSqrt();
    const Eigen::Tridiagonalization<MatX> turned(
        MatX(scale.asDiagonal() * equations.information * scale.asDiagonal()));
    diagonal_ = turned.diagonal();
    below_ = turned.subDiagonal();
    right_ = turned.matrixQ().adjoint() * VecX(scale.cwiseProduct(equations.right));
  }

  /// But for a constant, as that of try_sizes().
  double cost(double t) const {
    const double t2 = t * t;
    double squares = squares_, log_determinant = 0, pivot = 1, reduced = 0;
    for (Eigen::Index i = 0; i < diagonal_.size(); ++i) {
      const double factor = i > 0 ? t2 * below_[i - 1] / pivot : 0;
      reduced = t * right_[i] - factor * reduced;
      pivot = 1 + t2 * diagonal_[i] - (i > 0 ? factor * t2 * below_[i - 1] : 0);
      if (!(pivot > 0)) return std::numeric_limits<double>::infinity();
      squares -= reduced * reduced / pivot;
      log_determinant += std::log(pivot);
    }
    if (!(squares > 0)) return std::numeric_limits<double>::infinity();
    return rows_ * std::log(squares) + log_determinant;
  }

 private:
  double squares_, rows_;
  VecX diagonal_, below_, right_;
};

}  // namespace

SizeTrial try_sizes(const CoefficientEquations& equations, const VecX& variances) {
  // Scaled by the prior's sigmas: I + D H D, D = diag(sigma).
  const VecX sigma = variances.cwiseSqrt();
  MatX inner = sigma.asDiagonal() * equations.information * sigma.asDiagonal();
  inner.diagonal().array() += 1;
  const Eigen::LLT<MatX> factors(inner);
  if (factors.info() != Eigen::Success) return {};
  const VecX right = sigma.cwiseProduct(equations.right);
  const double squares = equations.squares - right.dot(factors.solve(right));
  if (!(squares > 0)) return {};
  SizeTrial trial;
  trial.noise = std::sqrt(squares / equations.rows);
  trial.cost =
      equations.rows * std::log(squares) + 2 * MatX(factors.matrixL()).diagonal().array().log().sum();
  return trial;
}

DistortionSizes most_likely_sizes(const CoefficientEquations& equations, const std::vector<int>& at,
                                  const std::vector<VecX>& shapes) {
  DistortionSizes sizes{VecX::Zero(equations.right.size()), std::vector<double>(at.size(), 0)};
  const Eigen::Index each = shapes.front().size();
  for (int round = 0; round < 2; ++round)  // the sizes depend little on each other
    for (std::size_t d = 0; d < at.size(); ++d) {
      if (at[d] < 0) continue;
      const CoefficientEquations own = of_device(equations, sizes.variances, at[d], each);
      VecX chosen = VecX::Zero(each);
      sizes.gain[d] = 0;
      for (const VecX& shape : shapes) {
        const SizesOfShape tried(own, shape);
        const double without = tried.cost(0);
        double least = without - std::max(kMinGain, sizes.gain[d]);
        for (double t = kSmallest; t < kLargest; t *= kGrowth) {
          const double cost = tried.cost(t);
          if (!(cost < least)) continue;
          least = cost, chosen = t * t * shape;
          sizes.gain[d] = without - cost;
        }
      }
      sizes.variances.segment(at[d], each) = chosen;
    }
  return sizes;
}

}  // namespace procam::calibrate
