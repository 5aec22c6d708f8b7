#pragma once
/// Lens distortion: a closed set of models. To add one: write core/lens/distortion/x.hpp with the members below
/// and add it to the variant; round trip, Jacobian and file laws then run over it.
///
///   kName, kNumCoefficients, kCoefficientNames, coefficients
///   distort<T>(coefficients, point in optical frame) -> distorted normalised image point, or nullopt
///   undistort(coefficients, distorted point) -> direction in optical frame, or nullopt
///   formula<T>(coefficients, x, y, distorted_x, distorted_y)   optional: distort() on z = 1 without its checks, for many points
///                                                             at once. Points of a model without it are computed one by one.
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/lens/distortion/brown_conrady.hpp"
#include "procam/core/lens/distortion/fisheye.hpp"
#include "procam/core/lens/distortion/none.hpp"
#include "procam/core/lens/distortion/rational.hpp"

namespace procam {

using Distortion = std::variant<NoDistortion, BrownConrady, RationalDistortion, FisheyeDistortion>;

namespace internal {
template <typename Model, typename = void>
struct HasFormula : std::false_type {};
template <typename Model>
struct HasFormula<Model,
                  std::void_t<decltype(Model::formula(
                      std::declval<const double*>(), std::declval<const double&>(),
                      std::declval<const double&>(), std::declval<double&>(), std::declval<double&>()))>>
    : std::true_type {};
}  // namespace internal

PROCAM_EXPORT const char* name_of(const Distortion& distortion);

PROCAM_EXPORT std::vector<std::string> coefficient_names(const Distortion& distortion);

PROCAM_EXPORT std::vector<double> coefficients_of(const Distortion& distortion);

/// The model of that name, all coefficients zero. Throws Error(kUnsupported) for an unknown name.
PROCAM_EXPORT Distortion distortion_named(const std::string& name);

/// The same model with other coefficients; their number must be the model's.
PROCAM_EXPORT Distortion with_coefficients(Distortion distortion, const std::vector<double>& values);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/detail/distortion_body.hpp"
#endif
