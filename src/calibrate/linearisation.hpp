#pragma once
/// Private to calibrate: one measurement's residual and its derivatives at a solution.
#include <optional>
#include <utility>
#include <vector>

#include "normal_equations.hpp"

namespace procam::calibrate {

constexpr int kCx = 2;  ///< of a lens's parameters: fx fy cx cy ...

/// The derivative of one whitened residual by the parameters that it depends on, weighed as the robust loss has it.
struct Linearised {
  Vec2 residual;
  std::vector<int> columns;  ///< of the common vector
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> by_common;
  /// By what the view has of its own (own_of_view()).
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> by_view;
  /// By a shift of all that a device projects, pixels: by its cx and cy, also where these are held. First the camera that
  /// read the light, if it takes part.
  std::vector<std::pair<int, Mat2>> by_shift;
};

class Linearisation {
 public:
  /// Both outlive this.
  Linearisation(const BundleState& state, const CommonParameters& common);

  /// nullopt where the measurement cannot be projected.
  std::optional<Linearised> operator()(const Measurement& measurement, const BundleOptions& options) const;

 private:
  struct Part;
  void add_device(std::size_t device, std::vector<Part>& parts) const;

  const BundleState& state_;
  const CommonParameters& common_;
  std::vector<VecX> lenses_;
  std::vector<std::vector<double>> devices_, boards_;
};

}  // namespace procam::calibrate
