#pragma once
/// Lens distortion: a closed set of models. To add one: write core/distortion/x.hpp with the members below
/// and add it to the variant; round trip, Jacobian and file laws then run over it.
///
///   kName, kNumCoefficients, kCoefficientNames, coefficients
///   distort<T>(coefficients, point in optical frame) -> distorted normalised image point, or nullopt
///   undistort(coefficients, distorted point) -> direction in optical frame, or nullopt
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/lens/distortion/brown_conrady.hpp"
#include "procam/core/lens/distortion/fisheye.hpp"
#include "procam/core/lens/distortion/none.hpp"
#include "procam/core/lens/distortion/rational.hpp"

namespace procam {

using Distortion = std::variant<NoDistortion, BrownConrady, RationalDistortion, FisheyeDistortion>;

inline const char* name_of(const Distortion& distortion) {
  return std::visit([](const auto& model) { return std::decay_t<decltype(model)>::kName; }, distortion);
}

inline std::vector<std::string> coefficient_names(const Distortion& distortion) {
  return std::visit(
      [](const auto& model) {
        const auto& names = std::decay_t<decltype(model)>::kCoefficientNames;
        return std::vector<std::string>(names.begin(), names.end());
      },
      distortion);
}

inline std::vector<double> coefficients_of(const Distortion& distortion) {
  return std::visit(
      [](const auto& model) {
        return std::vector<double>(model.coefficients.begin(), model.coefficients.end());
      },
      distortion);
}

namespace internal {
/// `known` gathers the names that did not match, for the message.
template <std::size_t Index = 0>
Distortion distortion_named(const std::string& name, const std::string& known = "") {
  if constexpr (Index < std::variant_size_v<Distortion>) {
    using Model = std::variant_alternative_t<Index, Distortion>;
    if (name == Model::kName) return Model{};
    return distortion_named<Index + 1>(name, known + (known.empty() ? "" : ", ") + Model::kName);
  } else {
    throw Error(ErrorKind::kUnsupported, "distortion model '" + name + "'", "there is no such model",
                "use one of: " + known);
  }
}
}  // namespace internal

/// The model of that name, all coefficients zero. Throws Error(kUnsupported) for an unknown name.
inline Distortion distortion_named(const std::string& name) {
  return internal::distortion_named<>(name);
}

/// The same model with other coefficients; their number must be the model's.
inline Distortion with_coefficients(Distortion distortion, const std::vector<double>& values) {
  std::visit(
      [&](auto& model) {
        require(values.size() == model.coefficients.size(),
                "with_coefficients: " + std::string(std::decay_t<decltype(model)>::kName) + " takes " +
                    std::to_string(model.coefficients.size()) + " coefficients, not " +
                    std::to_string(values.size()));
        for (std::size_t i = 0; i < values.size(); ++i) model.coefficients[i] = values[i];
      },
      distortion);
  return distortion;
}

}  // namespace procam
