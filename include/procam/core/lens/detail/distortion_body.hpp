#pragma once
/// The bodies of distortion.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <type_traits>

#include "procam/core/base/error.hpp"
#include "procam/core/lens/distortion.hpp"

namespace procam {

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

PROCAM_CORE_INLINE const char* name_of(const Distortion& distortion) {
  return std::visit([](const auto& model) { return std::decay_t<decltype(model)>::kName; }, distortion);
}

PROCAM_CORE_INLINE std::vector<std::string> coefficient_names(const Distortion& distortion) {
  return std::visit(
      [](const auto& model) {
        const auto& names = std::decay_t<decltype(model)>::kCoefficientNames;
        return std::vector<std::string>(names.begin(), names.end());
      },
      distortion);
}

PROCAM_CORE_INLINE std::vector<double> coefficients_of(const Distortion& distortion) {
  return std::visit(
      [](const auto& model) {
        return std::vector<double>(model.coefficients.begin(), model.coefficients.end());
      },
      distortion);
}

PROCAM_CORE_INLINE Distortion distortion_named(const std::string& name) {
  return internal::distortion_named<>(name);
}

PROCAM_CORE_INLINE Distortion with_coefficients(Distortion distortion, const std::vector<double>& values) {
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
// NOLINTEND(misc-definitions-in-headers)
