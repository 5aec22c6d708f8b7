#pragma once
/// The most probable errors behind marks of light, and the metric in which they are judged.
#include <Eigen/Cholesky>
#include <vector>

#include "mark_chain.hpp"

namespace procam::analyze {

/// Marks by their number in the chain.
using Which = std::vector<std::size_t>;

/// L with C = L L^T for a covariance, which may be singular. Throws std::invalid_argument for what is none.
MatX root_of(const MatX& covariance);

/// In units of the noise: each mark's two rows times the inverse root of its noise, and of 1 / weight.
void whiten(LinearMarks& linear, double scatter, const VecX& weights);

/// From the median of squares of two unit normal coordinates, 2 ln 2; at least 1.
double scatter2_of(const VecX& squares);

/// S = 1 + G G^T with G = A L (whitened marks, L the root of the state's covariance), by its inverse
/// 1 - G (1 + G^T G)^-1 G^T.
class Marginal {
 public:
  Marginal(const MatX& by_state, const MatX& root)
      : by_root_(by_state * root),
        factors_(MatX(MatX::Identity(root.cols(), root.cols()) + by_root_.transpose() * by_root_)) {}

  double product(const VecX& a, const VecX& b) const {
    return a.dot(b) - VecX(by_root_.transpose() * a).dot(factors_.solve(VecX(by_root_.transpose() * b)));
  }
  /// The state's most probable value in units of its root, given z = A x + noise.
  VecX most_probable(const VecX& z) const { return factors_.solve(VecX(by_root_.transpose() * z)); }
  const MatX& by_root() const { return by_root_; }
  MatX covariance(const MatX& root) const { return root * factors_.solve(MatX(root.transpose())); }
  double log_determinant() const { return 2 * MatX(factors_.matrixL()).diagonal().array().log().sum(); }

 private:
  MatX by_root_;
  Eigen::LLT<MatX> factors_;
};

/// What may have moved beyond what rig and surface state.
struct Free {
  bool projector = false, surface = false;
};

/// How far things move when they are bumped, as covariances of left increments in the rig's frame.
struct Bumps {
  Mat6 projector, surface;
};

struct Fit {
  Moved moved;
  VecX squares;     ///< of each mark's distance from the fit, in units of its detected noise
  MatX covariance;  ///< of the state
  double log_evidence = 0;
  bool settled = false;
};

/// The most probable state y, in units of its covariance's root: minimises |rest|^2 + |y|^2 with
/// rest = -(error with what is free moved, and the other errors to first order), in units of the noise. By
/// Gauss-Newton; a step that makes things worse is halved.
///
/// With `robust`, marks far from the fit weigh less (Cauchy's weights), measured by their median: all count
/// little while the fit is far off.
Fit most_probable(const MarkChain& chain, const Which& marks, const Free& free, const Bumps& bumps,
                  double scatter, bool robust = false);

}  // namespace procam::analyze
