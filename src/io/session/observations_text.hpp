#pragma once
/// Tables of correspondences from and to text.
#include "procam/io/session/observations_file.hpp"

namespace procam::io {

/// As load_observations(), from CSV text; `name` stands in messages.
Correspondences parse_observations(const std::string& text, const std::string& name,
                                   const ObservationsContext& context = {});

/// The CSV text that save_observations() writes.
std::string format_observations(const Correspondences& correspondences);

}  // namespace procam::io
