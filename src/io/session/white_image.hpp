#pragma once
/// The white image of a decoded view.
#include "procam/io/session/decoded_view.hpp"

namespace procam::io {

/// The view's image; `white` by name, else the only one. Throws Error(kInput) where there is none or which
/// one is not clear.
std::filesystem::path white_image(const std::filesystem::path& folder);

}  // namespace procam::io
