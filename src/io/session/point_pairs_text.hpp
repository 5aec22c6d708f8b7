#pragma once
/// Point pairs from text.
#include "procam/io/session/point_pairs_file.hpp"

namespace procam::io {

/// As load_point_pairs(), from a text; `name` stands in messages.
std::vector<PointPair> parse_point_pairs(const std::string& text, const std::string& name);

}  // namespace procam::io
