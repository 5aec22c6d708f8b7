#pragma once
/// What people know of their devices before they calibrate.
#include <filesystem>
#include <optional>
#include <vector>

#include "procam/calibrate/lens_prior.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {

/// A projector's, as value and sigma.
struct DataSheet {
  std::optional<io::Uncertain> throw_ratio;
  std::vector<io::Uncertain> lens_shift;  ///< x and y, or none
  bool square_pixels = false;
};

/// Without a sigma: 2 % of the ratio (sheets round), 2 % of the picture. Throws Error(kInput).
std::vector<calibrate::LensPrior> priors_of(const DataSheet& sheet, ImageSize picture);

/// The camera of a rig file, with what the file knows of its lens; for a session of one camera. Throws
/// Error(kInput) when its images are of another size than the session's.
calibrate::KnownLens read_known_camera(const std::filesystem::path& file, const std::vector<Device>& devices);

}  // namespace procam::tools
