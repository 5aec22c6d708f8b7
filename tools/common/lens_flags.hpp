#pragma once
/// --camera-model, --projector-model, --free and --fix: which lens a calibration estimates.
#include <string>
#include <vector>

#include "procam/calibrate/options.hpp"

namespace procam::tools {

/// Of --camera-model and --projector-model: which names there are.
extern const char* const kLensModelHelp;
inline constexpr char kAutoModel[] = "auto";

/// The lens to estimate: the named one, or with "auto" the one that predicts held-out views best. Parameters
/// in `fixed` ("skew", "k3") stay zero. Throws Error as calibrate::lens_model_named.
void set_lens_model(const std::string& name, const std::vector<std::string>& fixed,
                    calibrate::LensOptions& lens);

}  // namespace procam::tools
