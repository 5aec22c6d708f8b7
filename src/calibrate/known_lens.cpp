#include "known_lens.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::calibrate {
namespace {

/// Derivatives of the pixels of some bearings, two rows a bearing, by central differences.
template <typename Pixel>
void add_column(const std::vector<Vec3>& bearings, Eigen::Index column, double step, const Pixel& pixel,
                MatX& derivatives) {
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    const std::optional<Vec2> plus = pixel(bearings[i], step), minus = pixel(bearings[i], -step);
    if (plus && minus) derivatives.block<2, 1>(Eigen::Index(2 * i), column) = (*plus - *minus) / (2 * step);
  }
}

MatX by_rotation(const Camera& lens, const std::vector<Vec3>& bearings) {
  MatX derivatives = MatX::Zero(Eigen::Index(2 * bearings.size()), 3);
  for (int axis = 0; axis < 3; ++axis)
    add_column(
        bearings, axis, 1e-5,
        [&](const Vec3& bearing, double angle) {
          return lens.project(so3_exp<double>(Vec3(angle * Vec3::Unit(axis))) * bearing);
        },
        derivatives);
  return derivatives;
}

MatX by_parameters(const Camera& lens, const std::vector<Vec3>& bearings) {
  const VecX parameters = parameters_of(lens);
  MatX derivatives = MatX::Zero(Eigen::Index(2 * bearings.size()), parameters.size());
  for (Eigen::Index k = 0; k < parameters.size(); ++k)
    add_column(
        bearings, k, k < Intrinsics::kNumParameters ? 0.1 : 1e-5,  // pixels; a coefficient
        [&](const Vec3& bearing, double change) {
          VecX changed = parameters;
          changed[k] += change;
          return with_parameters(lens, changed).project(bearing);
        },
        derivatives);
  return derivatives;
}

}  // namespace

LensDifference lens_difference(const Points2& pixels, const KnownLens& known, const Camera& estimated,
                               const NamedCovariance& devices, const std::string& device) {
  constexpr std::size_t kEnough = 500;
  std::vector<Vec3> bearings;
  std::vector<Vec2> differences;
  const std::size_t step = std::max<std::size_t>(1, pixels.size() / kEnough);
  for (std::size_t i = 0; i < pixels.size(); i += step) {
    const std::optional<Vec3> bearing = known.lens.unproject(pixels[i]);
    const std::optional<Vec2> pixel = bearing ? estimated.project(*bearing) : std::nullopt;
    if (!pixel) continue;
    bearings.push_back(*bearing);
    differences.push_back(*pixel - pixels[i]);
  }
  if (bearings.size() < 6) return {};
  VecX difference(Eigen::Index(2 * bearings.size()));
  for (std::size_t i = 0; i < differences.size(); ++i)
    difference.segment<2>(Eigen::Index(2 * i)) = differences[i];

  const Eigen::ColPivHouseholderQR<MatX> rotation(by_rotation(estimated, bearings));
  const MatX turns = by_rotation(estimated, bearings);
  const auto without_rotation = [&](const MatX& columns) {
    return MatX(columns - turns * rotation.solve(columns));
  };
  const auto mean_square = [&](const Camera& lens, const MatX& covariance) {
    const MatX by_lens = without_rotation(by_parameters(lens, bearings));
    return (by_lens * covariance).cwiseProduct(by_lens).sum() / double(bearings.size());
  };
  std::vector<std::string> names = parameter_names(estimated);
  for (std::string& name : names) name = device + "." + name;
  double expected = mean_square(estimated, devices.block(names));
  if (!known.covariance.empty())
    expected += mean_square(known.lens, known.covariance.block(parameter_names(known.lens)));
  return {std::sqrt(without_rotation(difference).squaredNorm() / double(bearings.size())),
          std::sqrt(std::max(0.0, expected))};
}

Gate known_lens_gate(const LensDifference& difference, const std::string& device, double rms_px) {
  constexpr double kSigmas = 6, kMinPx = 0.3, kNoise = 2;
  const bool passed =
      difference.rms_px <= std::max({kMinPx, kNoise * rms_px, kSigmas * difference.expected_px});
  return {
      device + " as known", passed,
      "it differs by " + px(difference.rms_px) +
          " (RMS) from the camera that these views determine, of which the sigmas "
          "explain " +
          px(difference.expected_px) +
          (passed
               ? ""
               : ": its lens was zoomed or refocused since, the images were scaled, cut or rectified, or the file is of "
                 "another camera; calibrate the camera again, or leave out --known-camera")};
}

}  // namespace procam::calibrate
