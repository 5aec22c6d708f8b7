#include "common/lens_flags.hpp"

#include <algorithm>

namespace procam::tools {

const char* const kLensModelHelp =
    "auto (by the prediction of held-out views), none, brown-conrady, brown-conrady:k1,k2 (those terms "
    "alone), rational";

void set_lens_model(const std::string& name, const std::vector<std::string>& fixed,
                    calibrate::LensOptions& lens) {
  const auto is_fixed = [&](const char* parameter) {
    return std::find(fixed.begin(), fixed.end(), parameter) != fixed.end();
  };
  if (is_fixed("skew")) lens.held.push_back("skew");
  if (name != kAutoModel)
    lens.use(calibrate::lens_model_named(name));
  else if (is_fixed("k3"))
    lens.use(calibrate::lens_model_named("brown-conrady"));
  else
    lens.choose = true;
}

}  // namespace procam::tools
